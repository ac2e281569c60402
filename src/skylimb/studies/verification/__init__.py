"""Contact and rotors, proven against theory before any controller is judged on them."""

from skylimb.studies.verification.row import Row
from skylimb.studies.verification.suite import verify_contact, verify_rotors

__all__ = ["Row", "verify_contact", "verify_rotors"]
