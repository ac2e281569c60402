"""What a node is asked to be: profile, robot, controller and missions, checked before anything begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from skylimb.analysis.exchange.lab_topics import NAMESPACE, require_namespace
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.profile import PROFILES
from skylimb.base.errors import ConfigError, choice_error

WARNING = (
    "controller: its thrusts go around the flight controller. When commands stop, that holds roll and pitch "
    "on ROS 1, by gains that no robot has flown with; on ROS 2 the robot falls as it is. docs/flying.md has "
    "the check list of a first flight."
)


@dataclass(frozen=True)
class NodeConfig:
    """What a node is asked to be.

    Attributes:
        profile: one of `PROFILES`.
        robot: in place of the experiment's.
        experiment: gives plant, surface and the first mission; "paper" by default, for `simulator`
            "free_flight", where nothing stands in a client's way.
        missions: further experiments whose missions may be flown, on the first one's surface.
        controller: as of `skylimb.run`.
        settings: dotted keys and new values.
        messages: folders of .msg files.
        namespace: of the lab's topics.
        link: whose pose is on them; the flight controller's by default.
        cells: of the battery; 0 where nobody tells its voltage.
        anywhere: whether master and node may be on a network.
        bare: whether the cost of `controller` is accepted.
        lab_files: the robot's own YAML files of motors and servos.
        calibration: as of `skylimb.run`.
        limits: of flight states and targets.
        check: whether it looks for some seconds, says what it found, and commands nothing.
        start: angles by name, rad, with which `simulator` stands; others are the experiment's.

    Raises:
        ConfigError: where one of them cannot be, or is not for this profile.
    """

    profile: str
    robot: str = ""
    experiment: str = ""
    missions: tuple[str, ...] = ()
    controller: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    messages: tuple[str, ...] = ()
    namespace: str = NAMESPACE
    link: str = ""
    cells: int = 6
    anywhere: bool = False
    bare: bool = False
    lab_files: tuple[str, ...] = ()
    calibration: str | None = None
    limits: FlightLimits = field(default_factory=FlightLimits)
    check: bool = False
    start: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.profile not in PROFILES:
            raise choice_error("PROFILE", self.profile, PROFILES)
        if self.profile == "controller" and not self.bare:
            raise ConfigError(f"{WARNING} --bare says that you know")
        if self.profile == "both" and self.lab_files:
            raise ConfigError("both has neither motors nor servos of the lab; --config is not for it")
        if self.check and self.profile != "controller":
            raise ConfigError("--check looks at a robot: it is for the profile controller")
        if self.start and self.profile != "simulator":
            raise ConfigError("--start says how the robot of simulator stands")
        require_namespace(self.namespace)

    @property
    def experiment_name(self) -> str:
        """The experiment that is flown in."""
        return self.experiment or ("free_flight" if self.profile == "simulator" else "paper")

    @property
    def keys(self) -> dict[str, Any]:
        """Dotted keys of that experiment: a robot on these topics has an IMU."""
        robot = {"robot": self.robot} if self.robot else {}
        return {"sensors.imu.on": True, **self.settings, **robot}
