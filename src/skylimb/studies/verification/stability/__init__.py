"""The linearised closed loop in contact: where it is stable, and which mode says so."""

from skylimb.studies.verification.stability.closed_loop import ClosedLoop, linearise
from skylimb.studies.verification.stability.flown_growth import flown_growth
from skylimb.studies.verification.stability.maps import at, edge, stability_map
from skylimb.studies.verification.stability.modes import Mode
from skylimb.studies.verification.stability.point import OperatingPoint, operating_point
from skylimb.studies.verification.stability.port import TipPort, active_bands, real_part, tip_port

__all__ = [
    "ClosedLoop",
    "Mode",
    "OperatingPoint",
    "TipPort",
    "active_bands",
    "at",
    "edge",
    "flown_growth",
    "linearise",
    "operating_point",
    "real_part",
    "stability_map",
    "tip_port",
]
