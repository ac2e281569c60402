"""The flight loop: a flight that can be stepped from outside, on any vehicle.

    takeoff -> Loop.tick, tick, tick, ... -> Loop.stop -> Flight

A `Driver` flies one tick. `Vehicle` is what a driver senses and commands: a simulated plant, the same in real
time, a log, a robot. No file here knows a simulator.
"""
