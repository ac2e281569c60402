"""Gymnasium's two interfaces around a fleet: one environment, and many that step together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any

import numpy as np

from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError, of_extras
from skylimb.base.keys import Key, configuration
from skylimb.studies.envs.fleet import Fleet, Stepped

with of_extras():
    import gymnasium as gym
    from gymnasium.utils.seeding import np_random
    from gymnasium.vector import AutoresetMode
    from gymnasium.vector.utils import batch_space

Observation = np.ndarray
Info = dict[str, Any]


@configuration
class ResetOptions:
    """What `reset` takes in its `options`."""

    draw: Annotated[
        int | None, Key("", "which draw is flown, also one that no episode has drawn", low=0, high=2**31)
    ] = None


class FlightEnv(gym.Env[np.ndarray, np.ndarray]):
    """One flight at a time.

    An episode begins at take-off. It is terminated where the flight is lost, and truncated at the mission's
    end or after `duration`. `info` has each term of the reward by its name, `reward_NAME`, and the `draw`.

    Args:
        settings: keys of `EnvSettings`.
    """

    def __init__(self, **settings: Any) -> None:
        self.fleet = Fleet(1, **settings)
        self.observation_space, self.action_space = _spaces(self.fleet)
        self.metadata = {"render_modes": [], "render_fps": round(1.0 / self.fleet.step_time)}
        self._flies = False

    def reset(self, *, seed: int | None = None, options: Info | None = None) -> tuple[Observation, Info]:
        """Take off with a draw of the environment's own random numbers; `options={"draw": 3}` says which."""
        (asked,) = _asked(options, 1)
        super().reset(seed=seed)
        draw = int(self.np_random.integers(self.fleet.settings.draws)) if asked is None else asked
        self._flies = True
        return self.fleet.restart([0], [draw])[0].astype(np.float32), {"draw": draw}

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, Info]:
        """Fly a step.

        Raises:
            ConfigError: for an action of another shape, or that is no number, before the first `reset`, and
                after the end of an episode; nothing has flown then.
        """
        if not self._flies:
            raise ConfigError("step: no episode goes on; reset() begins one")
        done = self.fleet.step([0], [action])
        info = {"draw": int(self.fleet.draws[0]), **{k: v[0] for k, v in _terms(done).items()}}
        lost, over = bool(done.lost[0]), bool(done.over[0])
        self._flies = not (lost or over)
        return done.observations[0].astype(np.float32), float(done.rewards[0]), lost, over, info


class FlightVectorEnv(gym.vector.VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """Many flights that step together on the engine's own threads.

    An environment whose episode has ended takes off anew in the next step, whose action for it is ignored
    (`AutoresetMode.NEXT_STEP`). Environment i with seed s flies what `FlightEnv` flies with seed s + i.

    Args:
        num_envs: how many.
        threads: on which they fly; what they fly does not depend on it.
        settings: keys of `EnvSettings`.
    """

    def __init__(self, num_envs: int, threads: int = 1, **settings: Any) -> None:
        self.fleet = Fleet(num_envs, threads, **settings)
        self.num_envs = num_envs = self.fleet.count
        self.single_observation_space, self.single_action_space = _spaces(self.fleet)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        fps = round(1.0 / self.fleet.step_time)
        self.metadata = {"render_modes": [], "render_fps": fps, "autoreset_mode": AutoresetMode.NEXT_STEP}
        self._random = [np_random(None)[0] for _ in range(num_envs)]
        self._ended: np.ndarray | None = None

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: Info | None = None
    ) -> tuple[Observation, Info]:
        """Take off everywhere; an integer seeds environment i with seed + i.

        `options={"draw": 3}` says which draw all fly, `{"draw": [3, 5, ...]}` which each of them does.
        """
        asked = _asked(options, self.num_envs)
        if isinstance(seed, Iterable):
            seeds = _each("seed", seed, self.num_envs)
        else:
            seeds = [None if seed is None else seed + i for i in range(self.num_envs)]
        seeded = [None if given is None else np_random(given)[0] for given in seeds]
        self._random = [new or old for new, old in zip(seeded, self._random, strict=True)]
        self._ended = np.zeros(self.num_envs, bool)
        observations = self._restart(range(self.num_envs), asked)
        return observations, {"draw": self.fleet.draws.copy(), "_draw": np.ones(self.num_envs, bool)}

    def step(self, actions: np.ndarray) -> tuple[Observation, np.ndarray, np.ndarray, np.ndarray, Info]:
        """Fly a step everywhere, or take off where an episode had ended.

        Raises:
            ConfigError: for actions of another shape, or that are no numbers, and before the first `reset`;
                nothing has flown then.
        """
        if self._ended is None:
            raise ConfigError("step: no episode goes on; reset() begins one everywhere")
        places = np.arange(self.num_envs)
        fleet, anew, on = self.fleet, places[self._ended], places[~self._ended]
        actions = fleet.checked(places, actions)
        shown = np.zeros((self.num_envs, fleet.observed), np.float32)
        rewards, lost, over = np.zeros(self.num_envs), self._ended & False, self._ended & False
        info: Info = {}
        if len(on):
            done = fleet.step(on, actions[on])
            shown[on], rewards[on], lost[on], over[on] = done.observations, done.rewards, done.lost, done.over
            for name, term in _terms(done).items():
                info[name], info[f"_{name}"] = np.zeros(self.num_envs), ~self._ended
                info[name][on] = term
        if len(anew):
            shown[anew] = self._restart(anew, [None] * len(anew))
        info["draw"], info["_draw"] = fleet.draws.copy(), np.ones(self.num_envs, bool)
        self._ended = lost | over
        return shown, rewards, lost, over, info

    def _restart(self, places: Iterable[int], asked: list[int | None]) -> Observation:
        """Take off in some places with the draws that are asked for, or with each one's own random number."""
        draws = [
            int(self._random[place].integers(self.fleet.settings.draws)) if draw is None else draw
            for place, draw in zip(places, asked, strict=True)
        ]
        return self.fleet.restart(list(places), draws).astype(np.float32)


def _asked(options: Info | None, count: int) -> list[int | None]:
    """Which draw each of `count` environments is to fly; None for one of its own."""
    given = (options or {}).get("draw")
    draws = _each("draw", given, count) if isinstance(given, Iterable) else [given] * count
    options = options or {}
    return [from_mapping(ResetOptions, {**options, "draw": draw}, "reset").draw for draw in draws]


def _each(name: str, given: Iterable[Any], count: int) -> list[Any]:
    """One value for each of `count` environments."""
    each = list(given)
    if len(each) != count:
        raise ConfigError(f"reset: {name} has {len(each)} values; {count} are needed, one an environment")
    return each


def _spaces(fleet: Fleet) -> tuple[gym.spaces.Box, gym.spaces.Box]:
    size = len(fleet.actions.names)
    return (
        gym.spaces.Box(-np.inf, np.inf, (fleet.observed,), np.float32),
        gym.spaces.Box(-1.0, 1.0, (size,), np.float32),
    )


def _terms(done: Stepped) -> dict[str, np.ndarray]:
    return {f"reward_{name}": term for name, term in done.terms.items()}
