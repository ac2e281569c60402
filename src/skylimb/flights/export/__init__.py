"""A controller as C for a flight computer."""

from skylimb.flights.export.files import export_c

__all__ = ["export_c"]
