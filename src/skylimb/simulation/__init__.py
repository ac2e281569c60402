"""The simulated world: a robot, what it touches, its sensors and actuators, stepped by MuJoCo.

What it is for: any controller flies here as it would on a real robot, and everything that the analysis asks
of a contact follows from the same geometry that the physics sees.

Where to start reading: `plant` (robot, surface and contact as one compiled model), then `tick` (a control
tick of sensors, controller and actuators as one function), `surfaces` (one class for each kind of surface,
all of them a `Surface`), `contact` (stiffness, damping and friction in physical units), `tool` (ball, foot
or peg), and `flight_truth` (what really happened, from the record of a flight).

It may import `control` and the wings below that one. Of `flight`, `studies` and `apps` it knows nothing: who
steps a plant, and what happens to it in flight, stands in `flight`.
"""
