"""What an environment flies, and all that can be set of one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Annotated, Any, Literal

from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys import Key, configuration
from skylimb.studies.campaign.reading import spec_from_mapping
from skylimb.studies.campaign.spec import CampaignSpec
from skylimb.studies.envs.rewards import REWARDS

SHORT = {
    "phases.hover": 0.5, "phases.tare": 1.0, "phases.settle": 0.5, "phases.hover_end": 0.1,
    "approach.standoff": 0.02, "approach.depth": 0.05, "approach.speed": 0.1,
}  # fmt: skip
"""An experiment's beginning cut short: an episode is about the contact."""


@dataclass(frozen=True)
class Task:
    """What is flown, and what it is paid by.

    Attributes:
        experiment: its name.
        controller: whose references or gains are changed.
        set: keys of the experiment and their values.
        rewards: terms and their weights.
    """

    experiment: str
    controller: str
    set: Mapping[str, Any]
    rewards: Mapping[str, float]


_WORTH = {"on_path": 1.0, "press": 1.0, "calm": 0.1, "effort": 0.1, "smooth": 0.05, "lost": 50.0}

TASKS = {
    "sliding": Task("paper", "following", {**SHORT, "trajectory.radius": 0.15}, _WORTH),
    "drawing": Task("writing", "drawing", SHORT, {**_WORTH, "on_path": 2.0}),
    "pushing": Task(
        "paper",
        "following",
        {**SHORT, "trajectory.shape": "hold", "trajectory.duration": 15.0},
        {**_WORTH, "press": 2.0},
    ),
}
"""Along a circle on a board that leans; letters; a push that stays where it is."""


@configuration
class EnvSettings:
    """All that can be set of an environment."""

    task: Annotated[str, Key("", "one of skylimb.envs.TASKS")] = "sliding"
    actions: Annotated[
        Literal["references", "gains", "commands"],
        Key(
            "",
            "what is acted on: the path, the controller's gains, or thrusts and joints without a controller",
        ),
    ] = "references"
    reach: Annotated[
        float, Key("m", "references: how far an action of 1 moves the path", above=0.0, high=0.2)
    ] = 0.02
    bend: Annotated[
        float, Key("rad", "commands: how far an action of 1 bends a joint", low=0.0, high=1.5)
    ] = 0.2
    gains: Annotated[
        dict[str, tuple[float, float]],
        Key("", "gains: dotted gain -> its value at -1 and at 1", low=-inf, high=inf),
    ] = field(default_factory=dict)
    observations: Annotated[
        Literal["measured", "privileged", "signals"],
        Key("", "what the robot measures; the truth and the draw as well; or `signals` and nothing else"),
    ] = "measured"
    signals: Annotated[tuple[str, ...], Key("", "signals of the flight that are shown besides")] = ()
    history: Annotated[
        int, Key("", "observations that are shown at once, the newest first", low=1, high=64)
    ] = 1
    ticks: Annotated[int, Key("", "control ticks of a step", low=1, high=100)] = 4
    duration: Annotated[float, Key("s", "longest episode", above=0.0, high=1e4)] = 30.0
    force: Annotated[
        float, Key("N", "press that is paid for where the path says none", low=0.0, high=50.0)
    ] = 1.0
    rewards: Annotated[
        dict[str, float], Key("", "term -> weight; the task's own where it is empty", low=-inf, high=inf)
    ] = field(default_factory=dict)
    controller: Annotated[str, Key("", "in place of the task's: a name or a file")] = ""
    set: Annotated[dict[str, Any], Key("", "dotted key of the experiment -> value")] = field(
        default_factory=dict
    )
    vary: Annotated[dict[str, Any], Key("", "what is drawn for an episode, as a campaign's [vary]")] = field(
        default_factory=dict
    )
    draws: Annotated[int, Key("", "different draws; an episode flies one of them", low=1, high=100_000)] = 64

    def check(self) -> None:
        """Refuse names that are none, and gains without ranges."""
        if self.task not in TASKS:
            raise unknown_name("task of an environment", self.task, TASKS)
        for name in self.rewards:
            if name not in REWARDS:
                raise unknown_name("reward", name, REWARDS)
        if (self.actions == "gains") != bool(self.gains):
            raise ConfigError(
                f"actions = '{self.actions}' and gains = {sorted(self.gains)} do not go together: gains that "
                "are acted on have a range each, as in gains={'translation.force': (0.5, 2.0)}"
            )
        if "stop_at" in self.set:
            raise ConfigError("set: stop_at is what duration says of an environment; set duration")
        if self.observations == "signals" and not self.signals:
            raise ConfigError(
                "observations = 'signals' shows nothing but signals, and signals is empty: name what is "
                "shown, as in signals=['contact_force']"
            )
        for name, (low, high) in self.gains.items():
            if not low < high:
                raise ConfigError(
                    f"gains: '{name}' = ({low:g}, {high:g}) must go from the lower to the higher number"
                )

    @property
    def weights(self) -> Mapping[str, float]:
        """Terms and their weights."""
        return self.rewards or TASKS[self.task].rewards

    def spec(self) -> CampaignSpec:
        """The campaign whose draws the episodes fly."""
        task = TASKS[self.task]
        tables = {
            "experiment": task.experiment,
            "controllers": [self.controller or task.controller],
            "draws": self.draws,
            "set": {**task.set, **self.set, "stop_at": self.duration},
            "vary": self.vary,
        }
        return spec_from_mapping(tables, "environment")
