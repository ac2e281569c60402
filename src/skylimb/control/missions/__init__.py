"""Missions: the references of the robot at every tick, on a clock that a controller may slow down.

No file here knows a simulator, so a flight program plans its missions with them too.
"""
