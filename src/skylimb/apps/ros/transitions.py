"""How the lab's flight states follow each other, as one pure function.

    ARM_OFF -start-> START -acknowledged-> ARM_ON -takeoff-> TAKEOFF -settled-> HOVER -land-> LAND -stands->
    STOP -acknowledged-> ARM_OFF
    any -halt-> STOP        ARM_OFF, but the flight controller is armed -> LAND or HOVER, or STOP again

Numbers are those of the lab's navigator. Two of its transitions are refused here, as they drop a robot that
flies: `takeoff` in the air, which stops the motors there, and `start` in the air, which resets the
controller. Who begins anew knows nothing of a flight that is under way: so `halt` and `force_landing` act
in every state, and a flight controller that says that it is armed is believed.

A third one asks for more than the lab does. A landing that does not sink, or that sees nothing, may be one
that hovers. So it first takes thrust away, and no landing stops motors whose commands carry a robot.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.states import UNKNOWN_HEIGHT, Arming, FlightState, Flying, Order, Seen
from skylimb.flight.realtime.landing import STANDS, Standing

_FLIES = "it would reset the controller of this flight"
_WAITS = "the flight controller has not confirmed yet that the motors are off"
_STARTED = {
    FlightState.START: "it has begun already",
    FlightState.ARM_ON: "the robot is armed already; takeoff comes next",
    FlightState.TAKEOFF: _FLIES,
    FlightState.HOVER: _FLIES,
    FlightState.LAND: _FLIES,
    FlightState.STOP: _WAITS,
}
"""Why a flight cannot be started."""

_GROUNDED = {
    FlightState.ARM_OFF: "start comes first",
    FlightState.START: "the flight controller has not confirmed yet that it is armed",
    FlightState.STOP: _WAITS,
}
"""Why a robot on the ground cannot take off."""


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
    flying = replace(
        _placed(flying, seen),
        light=min(flying.light, seen.now) if seen.light else math.inf,
        left=flying.left and seen.armed is not False,
    )
    if seen.battery is not None:
        charge = flying.charge.after(seen.battery, limits.low_battery, seen.now)
        if charge.low and not flying.low_battery:
            said.append(f"low battery: {seen.battery:.0f} per cent")
        flying = replace(flying, charge=charge)
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
    """Somebody else armed it, or it did not hear that it is over.

    Two that command one robot lose it: it is left to who does so, as long as that one is there.
    """
    if seen.foreign:
        if not flying.left:
            said.append(f"the flight controller is armed, and left to who commands it: {seen.foreign[0]}")
        return replace(flying, left=True, standing=Standing())
    flying = replace(flying, left=False)
    known = flying.origin is not None
    if not known and seen.carried < limits.sinks:
        height = None if seen.position is None else float(seen.position[2])
        before, standing = flying.standing, flying.standing.after(height, True, seen.now)
        how = "idle" if seen.carried < limits.idle else "give too little to fly"
        if seen.carried < limits.idle or standing.stands(seen.now):
            said.append(
                f"the flight controller is armed, its motors {how}: the robot stands, and is disarmed"
            )
            return _enter(flying, FlightState.STOP, seen)
        begins = math.isnan(before.height) and seen.sinking < limits.start_speed
        if height is not None and (begins or standing == before):
            return replace(flying, standing=standing)
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
    settled = seen.now if state == FlightState.TAKEOFF else flying.settled
    return replace(flying, state=state, since=seen.now, settled=settled, standing=Standing(), eases=False)


def _halt(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    return replace(_enter(flying, FlightState.STOP, seen), force_landing=False)


def _force_landing(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    # Who has flown it knows that it is disarmed; who begins anew does not.
    rests = flying.state == FlightState.ARM_OFF and flying.origin is not None and not flying.left
    if rests or flying.state in (FlightState.START, FlightState.ARM_ON, FlightState.STOP):
        return _halt(flying, seen, limits, said)  # it stands
    return replace(_enter(flying, FlightState.LAND, seen), force_landing=True)


def _land(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if flying.state in (FlightState.LAND, FlightState.ARM_OFF, FlightState.STOP):
        return flying
    # On the ground the way down is no way.
    return _enter(flying, FlightState.LAND if flying.in_air else FlightState.STOP, seen)


def _start(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    if flying.state != FlightState.ARM_OFF:
        said.append(f"start is refused in {flying.state.name}: {_STARTED[flying.state]}")
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
    why = "the robot flies already" if flying.in_air else _GROUNDED.get(flying.state)
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
    if height is None:
        return _in_blind_land(flying, seen, limits, said)
    if seen.target is None:  # it is not led down yet
        return replace(flying, standing=Standing(), eases=False)
    leads = height - float(seen.target[2]) > limits.landed_lead
    standing = flying.standing.after(height, seen.light, seen.now)
    if leads and standing.stands(seen.now) and seen.sinking < limits.landed_speed:
        return _enter(flying, FlightState.STOP, seen)
    return replace(flying, standing=standing, eases=leads and seen.sinking < limits.landed_sinking)


def _in_blind_land(flying: Flying, seen: Seen, limits: FlightLimits, said: list[str]) -> Flying:
    """Down by what the accelerometer feels, else by the time that a fall with nearly the weight takes.

    It feels the same in steady flight as on the ground, and who flies by it need not fall: both count from
    when the rotors do not carry the robot. Where they still may after that time, or where the ground may be
    felt, thrust is taken away: what flies then falls, and feels it.
    """
    fall = math.sqrt(2.0 * max(flying.above, 0.0) / limits.blind_fall)
    longest = 1.5 * fall + limits.blind_margin
    blind, light = seen.now - flying.blind, seen.now - flying.light
    falls = min(blind, light)
    stands = falls > 0.5 * fall and min(seen.rest, light) > STANDS
    if stands or falls > longest:
        what = "the accelerometer feels the ground" if stands else f"it must be down after {falls:.1f} s"
        said.append(f"blind landing ends: {what}")
        return _enter(flying, FlightState.STOP, seen)
    eases = blind > longest or (blind > 0.5 * fall and seen.rest > STANDS)
    return replace(flying, standing=Standing(), eases=eases)


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
