"""A controller as C for a flight computer."""

from skylimb.flight.export.files import export_c

__all__ = ["export_c"]
