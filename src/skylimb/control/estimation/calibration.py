"""Calibration in flight: what the bias in a hover says about the sensors and the robot.

In free flight nothing pushes, so all that the observer sees is an error of the model. Its first order is
geometric, with F = m g the hover thrust along z of {C}:

- a measured body that is turned by a small e against the real one makes the rotors push sideways in the
  model's eyes, f = -e x F z, so e = (f_y, -f_x) / F about the level axes;
- a centre of gravity that lies d away from the modelled one makes the thrust turn the robot,
  tau = -d x F z, so d = (tau_y, -tau_x) / F.

A turn about the vertical and the height of the centre of gravity are invisible. Rotors that differ from the
model by 2 % each read as about 3 mm of d; a hover cannot tell the two apart.

From the tare's first tick on its mean counts as no disturbance, so no law resists it, and the rotors make it
up only once it is known. A torque beyond `LEVER` would turn the robot all that time: it is fed at once.

Rotors that all push more or less than commanded move the robot long before a tare is over. So up to the
tare it is trimmed: what is felt along its weight in free flight is fed at once, within `TRIM` of the weight.
With `thrust` the tare's bias along the weight becomes a scale then: in hover the rotors carry the weight, so
they give

    s = m g / (m g - f_z)

of what is commanded, and every wrench is commanded and felt by that scale. A mass that is off reads as
rotors that are. A robot that needs more than `SOUND`, or whose scale is off by more than `TRIM`, has
something wrong with it, and touches nothing.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rot_z, rpy_from_rotation
from skylimb.control.estimation.records import BodyState, Estimate, Sensed, Signals, Wrench
from skylimb.control.estimation.tare import TareState
from skylimb.robots.posed import RobotState
from skylimb.symbolic import Array, clip, cross, exp, low_pass, stack, vector, where

TRIM, SOUND = 0.25, 0.12
"""Shares of the weight: the most that is fed before the tare, or learnt as a scale of the thrusts; and the
bias with which a robot may still touch."""
TRIM_POLE = 30.0
"""1/s, of what is fed before the tare."""
LEVER = 0.012
"""m: by as much may a centre of gravity seem off without being fed while the tare is taken."""


@configuration
class Calibration:
    """What is done with the hover's bias."""

    feed: Annotated[bool, Key("", "whether the rotors make up the bias, so that no error has to")] = False
    attitude: Annotated[bool, Key("", "whether the measured attitude is corrected")] = False
    cog: Annotated[bool, Key("", "whether the modelled centre of gravity is corrected")] = False
    thrust: Annotated[
        bool, Key("", "whether the hover's bias along the weight is taken for a scale of all thrusts")
    ] = False
    rate: Annotated[
        float, Key("1/s", "rate at which corrections come in after the tare", above=0.0, high=100.0)
    ] = 1.0


class Correction(NamedTuple):
    """What is in force; nothing without arguments.

    Attributes:
        force: bias in the heading frame, N, (3,).
        torque: bias in C, N m, (3,).
        scale: of all thrusts, given over commanded.
        felt: force along the weight that the observer saw last, N.
    """

    force: Array = vector(0.0, 0.0, 0.0)
    torque: Array = vector(0.0, 0.0, 0.0)
    scale: Any = 1.0
    felt: Any = 0.0


def follow_bias(
    gains: Any, state: Correction, tare: TareState, weight: Any, collecting: Any, dt: float
) -> Correction:
    """Let the bias in once it is known and no longer averaged, and a great torque about level axes before."""
    step = (1.0 - exp(-gains.rate * dt)) * (1.0 - collecting)
    more, most = tare.torque - state.torque, LEVER * weight
    beyond = [collecting * (more[i] - clip(more[i], -most, most)) for i in range(2)]
    return state._replace(
        force=state.force + step * (tare.force - state.force),
        torque=state.torque + step * more + vector(*beyond, 0.0),
    )


def trimmed(
    state: Correction, felt: Wrench, model: RobotState, known: Any, pole: Any, dt: float
) -> Correction:
    """With what is felt along the weight in force at once, until the bias itself is known.

    The observer's low pass is undone by a lead, as a robot falls meanwhile.

    Args:
        state: what is in force.
        felt: the observer's wrench, bias and all.
        model: gives the weight.
        known: above 0 once a tare or a touch has begun.
        pole: of the observer along the weight, 1/s.
        dt: control period, s.
    """
    most = TRIM * model.mass * model.gravity[2]
    led = felt.force[2] + (felt.force[2] - state.felt) / (pole * dt)
    soon = clip(low_pass(state.force[2], led, TRIM_POLE, dt), -most, most)
    up = where(known > 0.5, state.force[2], soon)
    return state._replace(force=vector(state.force[0], state.force[1], up), felt=felt.force[2])


class Learnt(NamedTuple):
    """What is known of a tick's biases; after a new scale of the thrusts, what it leaves to be explained.

    Attributes:
        correction: with the scale, and no bias along the weight.
        tare: the same of the tare.
        observer: what holds the law's estimate of the wrench as `force` and `torque`, which have as much less
            as the known wrench has more.
        more: by which every known wrench of before is greater, force in W (N) and torque in C (N m), (6,);
            None where no scale is learnt.
    """

    correction: Correction
    tare: TareState
    observer: Any
    more: Array | None = None


def learn_scale(
    state: Correction, tare: TareState, observer: Any, body: BodyState, collecting: Any
) -> Learnt:
    """Take the tare's bias along the weight for a scale, once it is known.

    All jumps at one tick, by as much as a hovering robot's command explains, so nothing that is felt moves.

    Args:
        state: what is in force.
        tare: of this tick.
        observer: of this tick.
        body: gives weight and heading.
        collecting: 1 while the tare is taken, else 0.
    """
    weight = body.model.mass * body.model.gravity[2]
    bias = where(collecting > 0.5, 0.0, clip(tare.force[2], -TRIM * weight, TRIM * weight))
    ratio = weight / (weight - bias)
    # A hovering robot commands what makes up its bias.
    force, torque = (ratio - 1.0) * (vector(0.0, 0.0, weight) - tare.force), (1.0 - ratio) * tare.torque
    in_W = rot_z(rpy_from_rotation(body.R_WC)[2]) @ force
    up = where(abs(bias) > 0.0, tare.force[2] - force[2], state.force[2])
    return Learnt(
        state._replace(force=vector(state.force[0], state.force[1], up), scale=state.scale * ratio),
        tare._replace(force=tare.force - force, torque=tare.torque - torque),
        observer._replace(force=observer.force - in_W, torque=observer.torque - torque),
        stack(in_W, torque),
    )


def calibrate(
    gains: Any, known: Learnt, then: Estimate, now: BodyState, pole: Any, sensed: Sensed
) -> tuple[Learnt, Estimate, Signals]:
    """A tick of all this, for a law that estimates the wrench and takes a tare of it.

    Args:
        gains: a `Calibration`.
        known: the correction of the last tick, tare and observer of this one.
        then: the law's own estimate, at the time of what is measured.
        now: the body's state now.
        pole: of the estimated force along the weight, 1/s.
        sensed: of this tick.

    Returns:
        What is known, the estimate with all of it put right, and what is recorded.
    """
    dt, collecting = sensed.dt, sensed.reference.tare
    yaw = rpy_from_rotation(then.body.R_WC)[2]
    bias = fed_bias(gains, known.correction, yaw)
    body, arm = calibrated(gains, known.correction, now)
    weight = then.body.model.mass * then.body.model.gravity[2]
    correction = follow_bias(gains, known.correction, known.tare, weight, collecting, dt)
    begun = known.tare.ticks + sensed.reference.touch
    correction = trimmed(correction, then.raw, then.body.model, begun, pole, dt)
    scale = known.correction.scale
    estimate = then._replace(body=body, arm=arm, bias=bias, scale=scale)
    if not gains.thrust:
        return known._replace(correction=correction), estimate, {}
    learnt = learn_scale(correction, known.tare, known.observer, then.body, collecting)
    return learnt, estimate, {"thrust_scale_estimate": scale}


def as_scaled(gains: Any, state: Correction, rotors: Wrench) -> Wrench:
    """What the rotors make, with the scale of all thrusts where one is learnt."""
    if not gains.thrust:
        return rotors
    return Wrench(state.scale * rotors.force, state.scale * rotors.torque)


def is_sound(known: Estimate) -> Any:
    """1 for a robot whose bias and scale of the thrusts leave it fit to touch a surface, else 0."""
    sound, model = 1.0, known.body.model
    if known.bias is not None:
        sound = where(abs(known.bias.force[2]) > SOUND * model.mass * model.gravity[2], 0.0, sound)
    if known.scale is not None:
        sound = where(abs(known.scale - 1.0) > TRIM, 0.0, sound)
    return sound


def calibrated(gains: Any, state: Correction, body: BodyState) -> tuple[BodyState, Array]:
    """The body's state with attitude and centre of gravity put right, and the arm.

    Only places are corrected: attitude control and observer see the measured attitude, whose error the fed
    bias makes up.

    Args:
        gains: a `Calibration`.
        state: what is in force.
        body: as measured.

    Returns:
        The state, and the vector from the centre of gravity to the tip in W, m, (3,).
    """
    model = body.model
    weight = model.mass * model.gravity[2]
    none = 0.0 * state.force
    e = vector(state.force[1], -state.force[0], 0.0) / weight if gains.attitude else none
    d = vector(state.torque[1], -state.torque[0], 0.0) / weight if gains.cog else none
    # The measured body is the real one turned by e: the real one is the measured one turned back.
    to_cog = model.R_root_C.T @ model.cog_root + d
    to_tip = model.tip_C - d
    R = body.R_WC
    moved = R @ (to_cog - model.R_root_C.T @ model.cog_root - cross(e, to_cog))
    return body._replace(position=body.position + moved), R @ (to_tip - cross(e, to_tip))


def fed_bias(gains: Any, state: Correction, yaw: Any) -> Wrench:
    """The bias that the rotors have to make up: force in W (N), torque in C (N m)."""
    if not gains.feed:
        return Wrench(0.0 * state.force, 0.0 * state.torque)
    return Wrench(rot_z(yaw) @ state.force, state.torque)
