"""A path of your own: a function of time.

    python examples/user_path.py
    skylimb run --set trajectory.shape=examples/user_path.py:heart trajectory.duration=30

The function gets the times in s, an array, and returns u and v in m about the middle of the task. Where it
jumps, or is faster than `trajectory.speed` and `trajectory.acceleration` allow, the flight is refused.
"""

import numpy as np

import skylimb

DURATION = 30.0


def heart(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A heart 0.3 m wide, drawn once; it starts and ends at rest."""
    part = t / DURATION
    angle = 2.0 * np.pi * (part - np.sin(2.0 * np.pi * part) / (2.0 * np.pi))
    u = 16.0 * np.sin(angle) ** 3
    v = 13.0 * np.cos(angle) - 5.0 * np.cos(2.0 * angle) - 2.0 * np.cos(3.0 * angle) - np.cos(4.0 * angle)
    return 0.3 / 32.0 * u, 0.3 / 32.0 * v


def main() -> None:
    settings = {"trajectory.shape": heart, "trajectory.duration": DURATION}
    run = skylimb.run("paper", controller="hybrid", set=settings)
    print(f"{run.status}: the pen is {run.metrics['pen_line_rms']:.3f} m off its line (root mean square)")


if __name__ == "__main__":
    main()
