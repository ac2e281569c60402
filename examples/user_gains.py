"""The paper's hybrid controller with other gains: how soft the arm is decides how calm the body stays.

    python examples/user_gains.py

Keys that begin with `controller.` go to the preset; `skylimb show hybrid` lists them.
"""

import skylimb


def main() -> None:
    for stiffness in (8.0, 16.0, 32.0):
        run = skylimb.run("paper", controller="hybrid", set={"controller.shape.stiffness": stiffness})
        if run.failed:
            print(f"k_a = {stiffness:4.0f} N/m: {run.status}, {run.cause}")
        else:
            moved = run.metrics["displacement_median"]
            print(f"k_a = {stiffness:4.0f} N/m: {run.status}, centre of gravity moved {moved:.3f} m in x")


if __name__ == "__main__":
    main()
