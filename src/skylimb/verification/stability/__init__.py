"""The linearised closed loop in contact: where it is stable, and which mode says so."""

from skylimb.verification.stability.closed_loop import ClosedLoop, linearise
from skylimb.verification.stability.flown_growth import flown_growth
from skylimb.verification.stability.maps import at, edge, stability_map
from skylimb.verification.stability.modes import Mode
from skylimb.verification.stability.point import OperatingPoint, operating_point

__all__ = [
    "ClosedLoop",
    "Mode",
    "OperatingPoint",
    "at",
    "edge",
    "flown_growth",
    "linearise",
    "operating_point",
    "stability_map",
]
