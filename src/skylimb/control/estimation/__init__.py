"""From measurements to what the controller believes: body state, external wrench, tare."""
