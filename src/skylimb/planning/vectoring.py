"""Vectoring angles psi(theta) along the posture family, as smooth polynomials that never flip.

They are cheap enough for every tick. The search takes seconds, so its result is kept: in a file beside a
robot that comes with the package, else in the user's cache folder. Both carry a digest of everything that the
search depends on; where a file is for another robot, or cannot be read, the search runs anew.
"""

from __future__ import annotations

import hashlib
import logging
import os
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from skylimb.errors import UnreachableError
from skylimb.planning import vectoring_search
from skylimb.planning.control_torque import guaranteed_control_torque
from skylimb.planning.vectoring_search import evaluate, search_vectoring
from skylimb.robots import SHIPPED, Robot
from skylimb.symbolic import is_symbolic

__all__ = ["VectoringTable", "guaranteed_control_torque", "robot_digest", "vectoring_table"]

TABLE_FILE = "vectoring.toml"
_DECIMALS = 10
_SLACK = 1e-9
_log = logging.getLogger(__name__)
_known: dict[str, np.ndarray] = {}


class VectoringTable:
    """psi(theta) for one robot.

    Attributes:
        coefficients: (n_vectoring, degree + 1) Chebyshev coefficients over theta_min .. theta_max, rad.
        theta_min: start of the range of theta, rad.
        theta_max: end of it, rad.
        digest: of what the table was found for.
    """

    def __init__(self, robot: Robot, coefficients: np.ndarray, digest: str) -> None:
        self._robot = robot
        posture = robot.description.posture
        self.coefficients = coefficients
        self.theta_min, self.theta_max = posture.theta_min, posture.theta_max
        self.digest = digest

    def angles(self, theta: Any) -> Any:
        """Vectoring angles psi: (nv,) rad, or (..., nv) for an array of theta; nv x 1 in CasADi.

        Symbols are held inside theta_min .. theta_max; numbers outside of it raise `UnreachableError`.
        """
        return self._series(theta, 0)

    def slope(self, theta: Any) -> Any:
        """dpsi/dtheta in rad/rad, shaped as `angles`."""
        return self._series(theta, 1)

    def guaranteed_torque(self, theta: Any) -> Any:
        """FCTmin in N m at each theta (float or array), with each rotor's greatest thrust."""
        limits = [rotor.thrust_max for rotor in self._robot.description.rotors]
        return self._along(theta, lambda state: guaranteed_control_torque(state.allocation_C, limits))

    def hover_tilt(self, theta: Any) -> Any:
        """Angle in rad between z of {C} and z of the root frame at each theta (float or array)."""
        return self._along(theta, lambda state: float(np.arccos(np.clip(state.R_root_C[2, 2], -1.0, 1.0))))

    def _series(self, theta: Any, order: int) -> Any:
        low, high = self.theta_min, self.theta_max
        if not is_symbolic(theta):
            return evaluate(self.coefficients, low, high, self._checked(theta), order)
        # Powers of x by Horner's rule cost half of Clenshaw's recurrence; at this degree they are as exact.
        x = (2.0 * ca.fmin(ca.fmax(theta, low), high) - (low + high)) / (high - low)
        rows = []
        for series in np.polynomial.chebyshev.chebder(self.coefficients, order, axis=1):
            powers = np.polynomial.chebyshev.cheb2poly(series) * (2.0 / (high - low)) ** order
            value = powers[-1]
            for power in powers[-2::-1]:
                value = value * x + power
            rows.append(value)
        return ca.vertcat(*rows) if rows else ca.SX(0, 1)

    def _checked(self, theta: Any) -> np.ndarray:
        value = np.asarray(theta, dtype=float)
        inside = (value >= self.theta_min - _SLACK) & (value <= self.theta_max + _SLACK)
        if not np.all(inside):
            raise UnreachableError(
                f"vectoring angles of '{self._robot.name}' are known for shape angles {self.theta_min:.4g} "
                ".. "
                f"{self.theta_max:.4g} rad, not for {float(np.ravel(value[~inside])[0]):.4g} rad"
            )
        return value

    def _along(self, theta: Any, measure: Any) -> Any:
        posture = self._robot.description.posture
        value = self._checked(theta)
        angles = self.angles(value).reshape(value.size, self._robot.n_vectoring)
        found = [
            measure(self._robot.at(posture.offset + posture.slope * at, psi))
            for at, psi in zip(np.ravel(value), angles, strict=True)
        ]
        return np.array(found).reshape(value.shape) if value.ndim else found[0]


def vectoring_table(robot: Robot, *, cache: bool = True) -> VectoringTable:
    """The robot's table: the one that comes with it, a cached one, or a newly found one.

    Args:
        robot: any robot.
        cache: False searches anew and neither reads nor writes a file.

    Raises:
        AllocationError: no continuous path of vectoring angles hovers without tilt over the range of theta.
    """
    digest = robot_digest(robot)
    if not cache:
        return VectoringTable(robot, np.round(search_vectoring(robot), _DECIMALS), digest)
    if digest not in _known:
        _known[digest] = _stored(robot, digest)
    return VectoringTable(robot, _known[digest], digest)


def _stored(robot: Robot, digest: str) -> np.ndarray:
    cached = _cache_file(digest)
    # A robot that differs from a shipped one only where the table does not look finds that one's table.
    shipped = sorted(SHIPPED.glob(f"*/{TABLE_FILE}"))
    for path in (robot.description.folder / TABLE_FILE, *shipped, cached):
        coefficients = _read(path, digest, robot.n_vectoring)
        if coefficients is not None:
            return coefficients
    _log.info("searching for the vectoring angles of '%s' (a few seconds, once)", robot.name)
    coefficients = np.round(search_vectoring(robot), _DECIMALS)
    try:
        write_table(cached, coefficients, digest, robot)
    except OSError as error:
        # Without a cache everything works, only slower.
        _log.warning("cannot keep the vectoring angles of '%s' in '%s': %s", robot.name, cached, error)
    return coefficients


def _cache_file(digest: str) -> Path:
    import platformdirs

    return platformdirs.user_cache_path("skylimb") / "vectoring" / f"{digest[:32]}.toml"


def _read(path: Path, digest: str, n_vectoring: int) -> np.ndarray | None:
    """The coefficients in a file, or None where it is absent, damaged or for something else."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        coefficients = np.array(table["coefficients"], dtype=float)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        _log.warning("'%s' is no vectoring table and is not used: %s", path, error)
        return None
    usable = (
        coefficients.ndim == 2 and coefficients.shape[0] == n_vectoring and np.all(np.isfinite(coefficients))
    )
    return coefficients if table.get("digest") == digest and usable else None


def write_table(path: Path, coefficients: np.ndarray, digest: str, robot: Robot) -> None:
    """Write a table to a file, aside first and then renamed, so that a reader never sees half of it.

    Raises:
        OSError: the folder cannot be made or written.
    """
    posture = robot.description.posture
    rows = ",\n".join(
        "  [" + ", ".join(f"{entry:.{_DECIMALS}f}" for entry in row) + "]" for row in coefficients
    )
    text = (
        f"# Vectoring angles of {robot.name}, found by skylimb.planning.vectoring_search. One row a "
        "vectoring joint:\n"
        "# Chebyshev coefficients of psi (rad) over theta from theta_min to theta_max (rad). Not to be "
        "edited by hand.\n\n"
        f'digest = "{digest}"\n'
        f"theta_min = {posture.theta_min!r}\ntheta_max = {posture.theta_max!r}\n"
        f"coefficients = [\n{rows},\n]\n"
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, aside = tempfile.mkstemp(dir=path.parent, prefix=path.stem, suffix=".part")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(aside, path)
    except OSError:
        Path(aside).unlink(missing_ok=True)
        raise


def robot_digest(robot: Robot) -> str:
    """SHA-256 over every number that the search depends on, hexadecimal.

    It follows the model, not the files: another colour or lag keeps the table, another mass in memory does
    not. Numbers count to nine decimals, so that the last bit of a sine on another machine makes no other
    robot.
    """
    total = hashlib.sha256()
    for item in _relevant(robot):
        text = (
            item
            if isinstance(item, str)
            else " ".join(f"{entry:.9f}" for entry in np.round(np.ravel(item), 9) + 0.0)
        )
        total.update(text.encode() + b"\n")
    return total.hexdigest()


def _relevant(robot: Robot) -> Iterator[Any]:
    description, search = robot.description, vectoring_search
    yield f"search {search.VERSION}"
    yield [search.DEGREE, search.SMOOTHING, search.SLOPE, search.TILT]
    joints = [*description.shape_joints, *description.vectoring_joints]
    yield [len(description.shape_joints), len(description.vectoring_joints)]
    for body in robot.bodies:
        yield [
            body.parent,
            -1 if body.joint is None else joints.index(body.joint.name),
            body.mass,
            *body.xyz,
            *body.com,
        ]
        yield body.R
        if body.joint is not None:
            yield body.joint.axis
    for rotor in description.rotors:
        place = robot.placements[rotor.link]
        yield [place.body, *(place.xyz + place.R @ rotor.xyz), rotor.drag_torque_coefficient]
        yield (place.R @ rotor.R)[:, 2]
        yield [rotor.thrust_min, rotor.thrust_max]
    posture = description.posture
    yield [*posture.offset, *posture.slope, posture.theta_min, posture.theta_max, posture.theta_nominal]
    yield description.vectoring_start
