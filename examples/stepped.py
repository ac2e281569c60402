"""Step a flight by hand: let the robot touch the board, look at the force, and end when enough has been seen.

python examples/stepped.py
"""

import skylimb


def main() -> None:
    flight = skylimb.begin("paper", controller="hybrid", set={"surface.friction": 0.2})
    touched = None
    while flight.tick():
        force = -flight.signal("contact_force")[-1, 0]
        if touched is None and force > 0.5:
            touched = flight.time
            print(f"touched at {touched:.2f} s")
        if touched is not None and flight.time > touched + 5.0:
            break
    run = flight.finish()
    print(f"{run.status}: {run.cause}" if run.failed else run.status)
    print(f"pressed with up to {-float(run.log.contact_force.sel(axis='x').min()):.1f} N")


if __name__ == "__main__":
    main()
