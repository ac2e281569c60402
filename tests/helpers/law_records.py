"""Records that laws are handed in tests."""

import numpy as np

from skylimb.control.records import ContactView, TipMove

IN_THE_AIR = ContactView(
    *(0.0,) * 7, 1.0, np.zeros(3), TipMove(*np.zeros((4, 3))), landing=0.0, own_speed=0.0
)
"""No contact, known in full."""
