"""What rubs across the contact axis, and how much of it is made up for.

A force that the contact law expects is made up for at once (`feed`). Of what is felt beyond it, behind a low
pass, a law cancels a share.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any

from skylimb.base.keys import Key
from skylimb.control.records import NOTHING, ContactView, LawInput
from skylimb.symbolic import Array, clip, dot, low_pass, vector

Cancel = Annotated[
    tuple[float, float],
    Key("", "shares of the estimated force along the sliding axes that are cancelled", low=0.0, high=1.0),
]
CancelCutoff = Annotated[
    tuple[float, float], Key("Hz", "cut-off of the low pass on that force", above=0.0, high=1e4)
]
CancelLimit = Annotated[
    float, Key("N", "greatest cancelled force; friction and slope give no more", above=0.0, high=1e3)
]
Feed = Annotated[
    float,
    Key(
        "",
        "share of the force across the contact axis that the contact law expects which is made up for "
        "at once; only of a law that knows it",
        low=0.0,
        high=1.0,
    ),
]


def expected_across(contact: ContactView) -> Array:
    """The force across the contact axis that the contact law expects, W, N, (3,); 0 where it knows none."""
    return NOTHING.force if contact.across is None else contact.across


def made_up(
    gains: Any,
    expected: Array,
    shares: Sequence[Any],
    before: Array,
    inputs: LawInput,
    axes: tuple[Array, Array],
) -> tuple[Array, list[Any]]:
    """The low-passed force along the sliding axes, N, (2,), and what of force along each is made up for, N.

    Args:
        gains: of a law, with all that is named here.
        expected: of `expected_across`.
        shares: of that low-passed force that are cancelled now, along u and v.
        before: the low-passed force of the last tick, N, (2,).
        inputs: of this tick.
        axes: u and v.
    """
    engaged, gravity = inputs.contact.engaged, inputs.estimate.body.model.gravity
    most = gains.cancel_limit * clip(inputs.force, 1.0, 100.0)
    slow, known = [], []
    for i, axis in enumerate(axes):
        unexpected = dot(axis, inputs.estimate.wrench.force - gains.feed * expected)
        rubbing = clip(unexpected, -gains.cancel_limit, gains.cancel_limit)
        slow.append(low_pass(before[i], rubbing, 2.0 * math.pi * gains.cancel_cutoff[i], inputs.dt))
        made = shares[i] * slow[i] + gains.feed * dot(axis, expected)
        # What no contact gives is the robot's own: a rotor that has lost thrust is not to be waited for.
        own = unexpected - clip(unexpected, -most, most)
        known.append(made + engaged * upright(axis, gravity) * own)
    return vector(*slow), known


def upright(axis: Array, gravity: Array) -> Any:
    """1 for an axis that carries, 0 for a level one."""
    return dot(axis, gravity) ** 2 / dot(gravity, gravity)
