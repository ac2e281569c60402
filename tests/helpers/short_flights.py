"""The paper's experiment cut short, for tests in which how long it takes does not matter."""

CIRCLE = {
    "phases.hover": 0.4,
    "phases.tare": 0.3,
    "phases.settle": 0.3,
    "phases.hover_end": 0.1,
    "approach.depth": 0.05,
    "approach.standoff": 0.02,
    "approach.speed": 0.2,
    "approach.retreat_speed": 0.3,
    "trajectory.radius": 0.05,
    "trajectory.period": 1.5,
}
"""Touch, draw a small circle, leave."""

HOLD = {
    "phases.hover": 0.4,
    "phases.tare": 0.3,
    "phases.settle": 0.2,
    "phases.hover_end": 0.1,
    "approach.standoff": 0.02,
    "approach.speed": 0.3,
    "approach.retreat_speed": 0.3,
    "trajectory.shape": "hold",
    "trajectory.duration": 0.3,
}
"""Touch, stay, leave."""
