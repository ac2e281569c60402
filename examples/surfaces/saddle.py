"""A saddle: it recedes along u and comes nearer along v."""

from typing import Annotated

from skylimb.base.keys import Key, configuration


@configuration
class Keys:
    """How much it bends."""

    bend: Annotated[float, Key("1/m", "curvature along u, and against it along v", low=-2.0, high=2.0)] = 0.4


def height(u, v, keys):
    """How far the surface recedes from its flat plane, m."""
    return 0.5 * keys.bend * (u * u - v * v)
