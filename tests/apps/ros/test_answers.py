"""What an order is answered with: the truth about the flight, and once."""

from __future__ import annotations

import pytest

from skylimb.analysis.exchange.lab_topics import ORDERS
from skylimb.apps.ros.answers import ANSWER, answers
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.states import FlightState, Order
from wired import Wire


def asked(order: Order, token: int | None = 7) -> Arrived:
    return Arrived(f"teleop_command/{order}", token, "service", 0.0)


def test_each_order_is_answered_by_what_it_led_to() -> None:
    wire, said = Wire(), dict[Order, tuple[int, bool, str]]()
    wire.fly(0.15)
    for order, state in (
        (Order.TAKEOFF, FlightState.ARM_OFF),
        (Order.START, FlightState.ARM_ON),
        (Order.HALT, FlightState.ARM_OFF),
    ):
        wire.tick(f"teleop_command/{order}")
        ((topic, said[order]),) = answers([asked(order)], wire.pilot.last)
        assert topic is ANSWER
        wire.until(state, 1.0)
    assert said[Order.TAKEOFF] == (7, False, "takeoff is refused in ARM_OFF: start comes first")
    assert said[Order.START] == (7, True, "START")
    assert said[Order.HALT] == (7, True, "STOP")


def test_only_who_waits_is_answered() -> None:
    wire = Wire()
    wire.fly(0.15)
    others = [asked(Order.START, None), Arrived("joy", 1, "/joy", 0.0)]
    assert [*answers(others, wire.pilot.last)] == []
    assert [*answers([asked(Order.START)], None)] == []


@pytest.mark.parametrize("order", list(Order))
def test_every_order_has_an_answer(order: Order) -> None:
    wire = Wire()
    wire.fly(0.15)
    ((_, (token, _, words)),) = answers([asked(order, 3)], wire.pilot.last)
    assert token == 3
    assert words == "ARM_OFF"
    assert f"teleop_command/{order}" in {topic.name for topic in ORDERS}
