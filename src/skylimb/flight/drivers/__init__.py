"""The three ways to fly a tick, each named what it is.

- `compiled`: the traced tick on the engine's own memory, called from Python.
- `native`: the traced tick as machine code inside of the engine; many flights at once, no Python in the loop.
- `free`: any Python controller on any vehicle.

All three give the same flight.
"""
