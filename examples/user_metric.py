"""A metric and a figure of your own.

    python examples/user_metric.py
    skylimb run --use examples/user_metric.py          the figure is in the report, the metric in the table

In a campaign's file: use = ["user_metric.py"]. Then `score`, `success`, `stop` and `tune` know `overshoot`.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import skylimb


@skylimb.metric(unit="N", smaller_is_better=True)
def overshoot(run: skylimb.Run) -> float:
    """Largest normal force beyond its median while the pen touches."""
    touching = run.log.contact_force_normal.values[run.log.contact.values > 0]
    return float(touching.max() - np.median(touching)) if touching.size else float("nan")


@skylimb.metric(unit="rad", keys=("roll", "pitch"))
def tilt_spread(run: skylimb.Run) -> dict[str, float]:
    """Standard deviation of roll and pitch."""
    return {
        name: float(run.log.attitude.sel(axis=axis).std()) for name, axis in (("roll", "x"), ("pitch", "y"))
    }


@skylimb.figure
def thrusts(run: skylimb.Run) -> Figure:
    """Thrust of every rotor over the flight."""
    figure, axes = plt.subplots(figsize=(8.0, 3.0), layout="constrained")
    axes.plot(run.log.time, run.log.thrusts, label=run.log.rotor.values, linewidth=0.8)
    axes.set(xlabel="time in s", ylabel=f"thrust in {run.log.thrusts.attrs['units']}")
    axes.legend(ncols=4)
    return figure


def main() -> None:
    runs = skylimb.compare("paper", controllers=("pid", "hybrid"), use=(overshoot, tilt_spread))
    for name, run in runs.items():
        force, roll = run.metrics["overshoot"], run.metrics["tilt_spread_roll"]
        print(f"{name:>8}: overshoot {force:.2f} N, roll spread {roll:.4f} rad")


if __name__ == "__main__":
    main()
