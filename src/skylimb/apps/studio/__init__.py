"""Flights to see and to touch: live flights, what a page shows of them, and what people may do to them."""
