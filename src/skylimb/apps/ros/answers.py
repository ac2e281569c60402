"""What came of a user's order, for a middleware that lets its users ask."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.apps.ros.messages import Arrived, Outgoing
from skylimb.apps.ros.states import ORDERED, FlightState, Order
from skylimb.apps.ros.tick import Tick

ANSWER = Topic("skylimb/answer", "")
"""No topic: token of the order, whether it is obeyed, and words."""

END = "skylimb/end"
"""No topic: a user wants the node to land and to end."""

_LEADS_TO = {
    Order.START: (FlightState.START, FlightState.ARM_ON),
    Order.TAKEOFF: (FlightState.TAKEOFF, FlightState.HOVER),
    Order.LAND: (FlightState.LAND, FlightState.STOP, FlightState.ARM_OFF),
    Order.HALT: (FlightState.STOP, FlightState.ARM_OFF),
    Order.FORCE_LANDING: (FlightState.LAND, FlightState.STOP, FlightState.ARM_OFF),
}


def answers(arrived: Iterable[Arrived], tick: Tick | None) -> Iterator[Outgoing]:
    """The answer to each order whose sender waits for one.

    Args:
        arrived: at a tick; an order that waits has its token as its value.
        tick: what it came to.
    """
    for one in arrived:
        order = ORDERED.get(one.topic)
        if order is None or one.value is None or tick is None:
            continue
        state = tick.flying.state
        refusals = (f"{order} is refused", f"{order} stops")
        refused = [words for words in tick.said if words.startswith(refusals)]
        obeyed = state in _LEADS_TO[order] and not refused
        yield Outgoing(ANSWER, (one.value, obeyed, "; ".join(refused) or state.name))
