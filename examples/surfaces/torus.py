"""The outside of a bent pipe: no graph as a whole, so that its closest point is given."""

from typing import Annotated

from skylimb.base.keys import Key, configuration
from skylimb.symbolic import sqrt, vector


@configuration
class Keys:
    """The bend, in the plane of w and u."""

    ring: Annotated[float, Key("m", "radius of the pipe's middle line", low=0.05, high=100.0)] = 0.5
    tube: Annotated[float, Key("m", "radius of the pipe", low=0.05, high=100.0)] = 0.6


def closest(point, keys):
    """The closest point to (w, u, v), and the outward normal there."""
    centre = keys.ring + keys.tube
    w, u = point[0] - centre, point[1]
    far = sqrt(w * w + u * u)
    middle = vector(centre + keys.ring * w / far, keys.ring * u / far, 0.0)
    ray = point - middle
    normal = ray / sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2])
    return middle + keys.tube * normal, normal
