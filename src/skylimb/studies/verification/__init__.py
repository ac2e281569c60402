"""The contact, proven against theory before any controller is judged on it."""

from skylimb.studies.verification.row import Row
from skylimb.studies.verification.suite import verify_contact

__all__ = ["Row", "verify_contact"]
