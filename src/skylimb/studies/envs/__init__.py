"""Environments to learn in: the tasks of contact as Gymnasium knows environments, single and in lock-step.

    import skylimb

    env = skylimb.envs.FlightEnv(task="sliding", vary={"surface.friction": {"uniform": [0.1, 0.8]}})
    observation, info = env.reset(seed=1)

    tasks          what is flown, and every setting of an environment
    actions        what a policy may do: references, gains, or thrusts and joints
    observations   what it is shown
    rewards        what it is paid for: small functions with names
    fleet          flights in lock-step on the native batch; it knows no Gymnasium
    environment    Gymnasium's two interfaces around a fleet

What users name stands in `skylimb.envs`. Only `environment` needs the extra `learn`.
"""
