"""When a supervised flight no longer believes, and what it does then."""

from __future__ import annotations

from typing import Annotated

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.delay import require_history
from skylimb.control.estimation.gates import Gates

_ORDER = (
    ("stale_after", "retreat_after"),
    ("frozen_after", "retreat_after"),
    ("hold_for", "retreat_after"),
    ("retreat_after", "cut_after"),
    ("lossy", "dead"),
)
"""Keys of which the first is not greater than the second."""


@configuration
class Limits(Gates):
    """Times and sizes at which the supervisor acts."""

    on: Annotated[
        bool | None,
        Key(
            "",
            "whether a simulated flight is supervised; where nothing is said, one of `following` or "
            "`drawing` is. One on a clock, a link or ROS always is",
        ),
    ] = None
    stale_after: Annotated[
        float,
        Key(
            "s",
            "without a pose that is believed, after which the model's is flown on; twice the usual time "
            "between poses where that is longer",
            low=0.0,
            high=10.0,
        ),
    ] = 0.02
    retreat_after: Annotated[
        float, Key("s", "without one, after which the robot descends", low=0.0, high=60.0)
    ] = 0.6
    cut_after: Annotated[
        float,
        Key("s", "without one, after which the attitude is unknown and the rotors stop", low=0.0, high=60.0),
    ] = 1.0
    imu_for: Annotated[
        float,
        Key(
            "s",
            "by which it sinks and stops later where the controller goes on by an IMU, and flies back first",
            low=0.0,
            high=60.0,
        ),
    ] = 5.0
    deaf_after: Annotated[
        float,
        Key(
            "s",
            "without anything new of an IMU that the controller goes by, after which the reserve flies",
            above=0.0,
            high=60.0,
        ),
    ] = 0.1
    frozen_after: Annotated[
        float,
        Key(
            "s",
            "of poses that do not differ by a bit, after which none has come since the first of them",
            low=0.0,
            high=60.0,
        ),
    ] = 0.05
    hold_for: Annotated[
        float,
        Key(
            "s",
            "without a command, for which the last one is repeated; then the reserve flies",
            low=0.0,
            high=0.2,
        ),
    ] = 0.05
    overruns: Annotated[
        int, Key("", "ticks in a row without a new command after which the robot retreats", low=1, high=10**6)
    ] = 100
    losses: Annotated[
        bool,
        Key(
            "",
            "whether lost rotors, joints astray and late measurements are looked for; tuned to "
            "hydrus_xi_quad with the noise that ships",
        ),
    ] = False
    lossy: Annotated[
        float,
        Key(
            "", "share of its thrust that a rotor has lost, from which the robot retreats", low=0.0, high=1.0
        ),
    ] = 0.3
    dead: Annotated[float, Key("", "the same, from which the reserve flies", low=0.0, high=1.0)] = 0.7
    upset_at: Annotated[
        float,
        Key(
            "rad",
            "tilt of the measured link against the vertical beyond which the robot has tipped over, and the "
            "rotors stop",
            above=0.0,
            high=1.57,
        ),
    ] = 0.7
    descend_for: Annotated[
        float,
        Key(
            "s",
            "by which a descent may take longer than its way to `floor` at 0.3 m/s; the rotors stop then",
            above=0.0,
            high=600.0,
        ),
    ] = 6.0
    floor: Annotated[
        float, Key("m", "height of the centre of gravity at which a retreat ends", low=-1e3, high=1e3)
    ] = 0.0
    latency: Annotated[float, Key("s", "assumed age of a measurement", low=0.0, high=0.07)] = 0.015
    rotor_lag: Annotated[float, Key("s", "assumed lag of the rotors", above=0.0, high=1.0)] = 0.05

    def check(self) -> None:
        """Raise a `ConfigError` where the supervisor would act in another order than its table does."""
        for first, then in _ORDER:
            if not getattr(self, first) <= getattr(self, then):
                raise ConfigError(
                    f"supervisor.{first} = {getattr(self, first):g} must be at most "
                    f"supervisor.{then} = {getattr(self, then):g}"
                )

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` unless the prediction reaches back to the latency at a period of `dt` s."""
        require_history("supervisor.latency", self.latency, dt)
