"""Calibration: what a robot does not know of itself, found from a flight.

    import skylimb

    made = skylimb.calibrate("calibration", seed=3)
    print(made.verdict)

`docs/calibration.md` says what a flight can show, `docs/reports/calibration.md` how it is estimated.
"""
