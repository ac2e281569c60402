"""An environment of your own: what is drawn for an episode, what is paid for, and a term more.

python examples/environments/gentle.py
"""

import numpy as np

from skylimb import envs


@envs.reward
def gentle(seen: envs.Seen) -> np.ndarray:
    """Minus what presses beyond 1.5 N, one number for each environment."""
    return -np.maximum(np.linalg.norm(seen.signal("contact_force"), axis=1) - 1.5, 0.0)


SETTINGS = {
    "task": "sliding",
    "actions": "references",
    "rewards": {"on_path": 1.0, "press": 1.0, "gentle": 0.5, "lost": 50.0},
    "vary": {"surface.friction": {"uniform": [0.1, 0.4]}, "surface.slope": {"uniform": [-0.3, 0.3]}},
    "draws": 8,
}


def make(**more: object) -> envs.FlightEnv:
    """The environment, with other values of some settings."""
    return envs.FlightEnv(**{**SETTINGS, **more})


def main() -> None:
    env = make(duration=8.0)
    env.reset(seed=1)
    told, ended = [], False
    while not ended:
        _, reward, terminated, truncated, info = env.step(np.zeros(3))
        told.append((reward, info["reward_gentle"]))
        ended = terminated or truncated
    paid, worst = np.sum(told, axis=0)[0], np.min(told, axis=0)[1]
    print(f"without an action: {paid:.0f} in an episode; gentle is {worst:.2f} at worst")


if __name__ == "__main__":
    main()
