"""Fly the paper's experiment once and look at the numbers.

python examples/run.py
"""

import numpy as np

import skylimb


def main() -> None:
    run = skylimb.run("paper", controller="hybrid", seed=1)
    print(f"{run.controller}: {run.status}")
    for name, value in run.metrics.items():
        if isinstance(value, float):
            print(f"  {name:28} {value:.3f}")
    # The paper's controllers leave their path on purpose; the verdict says by how much.
    print(f"done as commanded: {run.done}", *run.missed, sep="\n  ")

    # The log is an xarray dataset: signals by name, axes by name, units as attributes.
    sliding = run.log.isel(time=np.flatnonzero(run.log.contact > 0))
    pushed = sliding.external_force_estimate.sel(axis="x")
    print(f"estimated force while in touch: {float(pushed.median()):.2f} {pushed.attrs['units']} (median)")


if __name__ == "__main__":
    main()
