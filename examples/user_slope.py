"""The paper's flight on boards of your own, up to one that leans the other way.

    python examples/user_slope.py

Leaning the other way, the board's push turns into a side force that the paper's controller feeds back, and
the flight is lost. Compensating that leak (docs/errata.md) is an option of the preset.

Every value of an experiment can be changed like this; `skylimb show paper` lists the keys. To keep a change,
write it to a TOML file and fly that: skylimb run my_board.toml
"""

import math

import skylimb


def main() -> None:
    for degrees, compensate in ((20, False), (10, False), (0, False), (-10, False), (-10, True)):
        settings = {
            "surface.slope": math.radians(degrees),
            "controller.allocation.leak.compensate": compensate,
        }
        run = skylimb.run("paper", controller="hybrid", set=settings)
        leak = "compensated" if compensate else "as in the paper"
        line = f"{degrees:4d} degrees, leak {leak}: {run.status}"
        if run.failed:
            print(f"{line}, {run.cause}")
        else:
            moved, touch = run.metrics["displacement_median"], run.metrics["contact_fraction"]
            print(f"{line}, moved {moved:.3f} m in x, in touch {touch:.0%} of the time")


if __name__ == "__main__":
    main()
