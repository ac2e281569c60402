"""The lab's flight states as one pure function: what a robot is doing, and what it does next.

    ARM_OFF -start-> START -acknowledged-> ARM_ON -takeoff-> TAKEOFF -settled-> HOVER -land-> LAND -stands->
    STOP -acknowledged-> ARM_OFF
    any -halt-> STOP        ARM_OFF, but the flight controller is armed -> LAND or HOVER, or STOP again

Numbers are those of the lab's navigator. Two of its transitions are refused here, as they drop a robot that
flies: `takeoff` in the air, which stops the motors there, and `start` in the air, which resets the
controller. Who begins anew knows nothing of a flight that is under way: so `halt` and `force_landing` act
in every state, and a flight controller that says that it is armed is believed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum, StrEnum

import numpy as np

from skylimb.apps.ros.limits import FlightLimits


class FlightState(IntEnum):
    """As on the topic `flight_state`."""

    ARM_OFF = 0
    START = 1
    ARM_ON = 2
    TAKEOFF = 3
    LAND = 4
    HOVER = 5
    STOP = 6


LOW_BATTERY, FORCE_LANDING = 0x10, 0x11
"""Take the place of the state on that topic."""

UNKNOWN_HEIGHT = 2.0
"""That a robot is believed to fly at where nobody knows the ground, m."""

FLYING = (FlightState.TAKEOFF, FlightState.HOVER, FlightState.LAND)


class Order(StrEnum):
    """What a user orders, by the last word of its topic."""

    START = "start"
    TAKEOFF = "takeoff"
    LAND = "land"
    HALT = "halt"
    FORCE_LANDING = "force_landing"


class Arming(IntEnum):
    """What the flight controller is commanded, and acknowledges."""

    ON = 0
    OFF = 1
    FORCE_LANDING = 2


@dataclass(frozen=True)
class Seen:
    """What the flight states look at in a tick.

    Attributes:
        now: s.
        position: of the centre of gravity in W, m, (3,); None while nothing fresh is measured.
        sinking: its speed down, m/s.
        target: of that position, m, (3,); None while it is not led down.
        orders: that came since the last tick, in their order.
        acknowledged: the last command that the flight controller acknowledged since then; None without one.
        battery: charge, per cent; None where nobody says.
        broken: why the flight has to be broken off; empty while it has not.
        refused: why a flight must not begin; nothing where it may.
        armed: whether the flight controller says that it is armed; None where it has said nothing since.
        rest: for how long the accelerometer has felt nothing but the ground, s.
        cut: whether the supervisor has cut the rotors.
    """

    now: float
    position: np.ndarray | None
    sinking: float = 0.0
    target: np.ndarray | None = None
    orders: tuple[Order, ...] = ()
    acknowledged: int | None = None
    battery: float | None = None
    broken: str = ""
    refused: tuple[str, ...] = ()
    armed: bool | None = None
    rest: float = 0.0
    cut: bool = False


@dataclass(frozen=True)
class Flying:
    """The state, and what its transitions remember.

    Attributes:
        state: of the flight.
        since: when it began, s.
        origin: position at `start`, m, (3,).
        settled: since when a take-off has been near its target, s.
        looked: when a landing was last looked at, s.
        height: where it was then, m.
        blind: since when the position is not known, s.
        above: the height above the origin at which it was known last, m.
        force_landing: whether the landing is a forced one.
        low_battery: whether the battery is nearly empty.
    """

    state: FlightState = FlightState.ARM_OFF
    since: float = 0.0
    origin: np.ndarray | None = None
    settled: float = math.inf
    looked: float = 0.0
    height: float = math.inf
    blind: float = math.nan
    above: float = UNKNOWN_HEIGHT
    force_landing: bool = False
    low_battery: bool = False

    @property
    def shown(self) -> int:
        """The byte on the topic `flight_state`."""
        if self.force_landing:
            return FORCE_LANDING
        return LOW_BATTERY if self.low_battery else int(self.state)

    @property
    def in_air(self) -> bool:
        """Whether a controller flies the robot."""
        return self.state in FLYING

    @property
    def arming(self) -> Arming | None:
        """What the flight controller is commanded at this tick."""
        if self.force_landing and self.in_air:
            return Arming.FORCE_LANDING
        return {FlightState.START: Arming.ON, FlightState.STOP: Arming.OFF}.get(self.state)


def advance(flying: Flying, seen: Seen, limits: FlightLimits) -> tuple[Flying, tuple[str, ...]]:
    """One tick of the flight states.

    Args:
        flying: of the tick before.
        seen: what came and what was measured.
        limits: thresholds and time-outs.

    Returns:
        The new state, and what has to be said to people, one line each.
    """
    said: list[str] = []
    flying = _placed(flying, seen)
    if seen.battery is not None:
        low = seen.battery < limits.low_battery
        if low and not flying.low_battery:
            said.append(f"low battery: {seen.battery:.0f} per cent")
        flying = replace(flying, low_battery=low)
    for order in seen.orders:
        flying = _ORDERS[order](flying, seen, limits, said)
    if seen.armed and flying.state == FlightState.ARM_OFF:
        flying = _found_armed(flying, seen, limits, said)
    # Who is blind as well is brought down by the flight controller, and the end of that is found.
    if seen.cut and flying.in_air and seen.position is not None:
        said.append("the supervisor has cut the rotors: the flight controller is disarmed")
        flying = _halt(flying, seen, limits, said)
    by_board = seen.acknowledged == Arming.FORCE_LANDING
    why = "by the flight controller" if by_board else seen.broken
    if why and flying.in_air and not flying.force_landing:
        said.append(f"force landing: {why}")
        flying = replace(_enter(flying, FlightState.LAND, seen), force_landing=True)
    if flying.low_battery and flying.state in (FlightState.TAKEOFF, FlightState.HOVER):
        said.append("landing: low battery")
        flying = _enter(flying, FlightState.LAND, seen)
    elif flying.state in _STEPS:
        flying = _STEPS[flying.state](flying, seen, limits, said)
    return flying, tuple(said)


def _placed(flying: Flying, seen: Seen) -> Flying:
    """Where and when it was seen last."""
    if seen.position is None:
        return replace(flying, blind=seen.now) if math.isnan(flying.blind) else flying
    ground = seen.position[2] - UNKNOWN_HEIGHT if flying.origin is None else flying.origin[2]
    return replace(flying, blind=seen.now, above=float(seen.position[2] - ground))


def _found_armed(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    """Somebody else armed it, or it did not hear that it is over."""
    known = flying.origin is not None
    # What was disarmed says so a little late; a first position comes a little late.
    waits = known or seen.position is None
    if waits and seen.now - (flying.since if known else flying.blind) < limits.disarmed:
        return flying
    if known:
        said.append("the flight controller is armed still: it is stopped again")
        return _enter(flying, FlightState.STOP, seen)
    goes_on = limits.adopt == "hover" and seen.position is not None
    state = FlightState.HOVER if goes_on else FlightState.LAND
    said.append(
        f"the flight controller is armed, and nobody here armed it: {'hovering' if goes_on else 'landing'}"
    )
    return replace(_enter(flying, state, seen), force_landing=seen.position is None)


def _enter(flying: Flying, state: FlightState, seen: Seen) -> Flying:
    height = math.inf if seen.position is None else float(seen.position[2])
    settled = seen.now if state == FlightState.TAKEOFF else flying.settled
    return replace(flying, state=state, since=seen.now, settled=settled, looked=seen.now, height=height)


def _halt(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    return replace(_enter(flying, FlightState.STOP, seen), force_landing=False)


def _force_landing(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if flying.state in (FlightState.START, FlightState.ARM_ON, FlightState.STOP):
        return _halt(flying, seen, limits, said)  # it stands
    return replace(_enter(flying, FlightState.LAND, seen), force_landing=True)


def _land(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if flying.state in (FlightState.LAND, FlightState.ARM_OFF, FlightState.STOP):
        return flying
    # On the ground the way down is no way.
    return _enter(flying, FlightState.LAND if flying.in_air else FlightState.STOP, seen)


def _start(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if flying.state != FlightState.ARM_OFF:
        said.append(f"start is refused in {flying.state.name}: it would reset the controller of this flight")
    elif flying.low_battery:
        said.append("start is refused: low battery")
    elif seen.position is None or seen.refused:
        reasons = seen.refused or ("the robot's position is not known",)
        said.extend(f"start is refused: {why}" for why in reasons)
    else:
        begun = replace(flying, origin=np.array(seen.position), force_landing=False)
        return _enter(begun, FlightState.START, seen)
    return flying


def _take_off(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if flying.state == FlightState.TAKEOFF:
        return flying
    why = "the robot flies already" if flying.in_air else "start comes first"
    if flying.state != FlightState.ARM_ON:
        said.append(f"takeoff is refused in {flying.state.name}: {why}")
    elif seen.position is None or flying.origin is None:
        said.append("takeoff is refused: the robot's position is not known")
    else:
        way = seen.position - flying.origin
        moved = max(float(np.hypot(way[0], way[1])), abs(float(way[2]))) > limits.takeoff_drift
        drift = (f"the robot was moved by more than {limits.takeoff_drift:g} m since start",)
        reasons = seen.refused + drift * moved
        said.extend(f"takeoff stops: {why}" for why in reasons)
        return _enter(flying, FlightState.STOP if reasons else FlightState.TAKEOFF, seen)
    return flying


def _in_start(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if flying.low_battery:
        said.append("start is broken off: low battery")
        return _enter(flying, FlightState.ARM_OFF, seen)
    if seen.acknowledged == Arming.ON:
        return _enter(flying, FlightState.ARM_ON, seen)
    if seen.now - flying.since > limits.acknowledged:
        said.append(f"start is broken off: arming was not acknowledged within {limits.acknowledged:g} s")
        return _enter(flying, FlightState.STOP, seen)
    return flying


def _in_takeoff(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if seen.position is None or seen.target is None:
        return replace(flying, settled=seen.now)
    away = np.abs(seen.target - seen.position)
    if away[:2].max() > limits.settled_xy or away[2] > limits.settled_z:
        return replace(flying, settled=seen.now)
    if seen.now - flying.settled > limits.settled_time:
        return _enter(flying, FlightState.HOVER, seen)
    return flying


def _in_land(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    height = None if seen.position is None else float(seen.position[2])
    if height is not None and seen.target is None:  # it does not sink yet
        return replace(flying, looked=seen.now, height=height)
    if seen.now - flying.looked <= limits.landed_time:
        return flying
    if height is None or seen.target is None:
        return _in_blind_land(flying, seen, limits, said)
    leads = height - float(seen.target[2]) > limits.landed_lead
    still = abs(height - flying.height) < limits.landed_way and seen.sinking < limits.landed_speed
    if leads and still:
        return _enter(flying, FlightState.STOP, seen)
    return replace(flying, looked=seen.now, height=height)


def _in_blind_land(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    """Down by what the accelerometer feels, else by the time that a fall with nearly the weight takes."""
    fall = math.sqrt(2.0 * max(flying.above, 0.0) / limits.blind_fall)
    blind = seen.now - flying.blind
    stands = blind > 0.5 * fall and seen.rest > limits.landed_time
    if stands or blind > 1.5 * fall + limits.blind_margin:
        what = "the accelerometer feels the ground" if stands else f"it must be down after {blind:.1f} s"
        said.append(f"blind landing ends: {what}")
        return _enter(flying, FlightState.STOP, seen)
    return replace(flying, looked=seen.now, height=math.inf)


def _in_stop(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if seen.acknowledged == Arming.OFF:
        return replace(_enter(flying, FlightState.ARM_OFF, seen), force_landing=False)
    return flying


_ORDERS = {
    Order.HALT: _halt,
    Order.FORCE_LANDING: _force_landing,
    Order.LAND: _land,
    Order.START: _start,
    Order.TAKEOFF: _take_off,
}

_STEPS = {
    FlightState.START: _in_start,
    FlightState.TAKEOFF: _in_takeoff,
    FlightState.LAND: _in_land,
    FlightState.STOP: _in_stop,
}
