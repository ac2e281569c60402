"""A battery is low that has been low for some seconds."""

from __future__ import annotations

from skylimb.flight.realtime.charge import LASTS, Charge


def test_a_dip_is_no_empty_battery_and_one_that_stays_low_is() -> None:
    charge = Charge().after(9.0, 10.0, 0.0).after(0.0, 10.0, LASTS - 0.1)
    assert not charge.low
    assert not charge.after(11.0, 10.0, LASTS).after(9.0, 10.0, LASTS + 0.1).low
    assert charge.after(9.0, 10.0, LASTS).low
    assert charge.after(float("nan"), 10.0, LASTS).low
