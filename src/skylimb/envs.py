"""Environments to learn in, for Gymnasium; the extra `learn` brings it.

import skylimb

env = skylimb.envs.FlightEnv(task="sliding", vary={"surface.friction": {"uniform": [0.1, 0.8]}})
observation, info = env.reset(seed=1)
observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from skylimb.studies.envs.environment import FlightEnv, FlightVectorEnv
from skylimb.studies.envs.fleet import Fleet
from skylimb.studies.envs.rewards import REWARDS, Seen, reward
from skylimb.studies.envs.tasks import TASKS, EnvSettings

__all__ = ["REWARDS", "TASKS", "EnvSettings", "Fleet", "FlightEnv", "FlightVectorEnv", "Seen", "reward"]
