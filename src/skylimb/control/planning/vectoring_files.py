"""Where tables of vectoring angles are kept: beside a robot that comes with the package, else in a cache.

Every file carries a digest of all that its search depends on; where a file is for another robot, or cannot be
read, the search runs anew.
"""

from __future__ import annotations

import logging
import tomllib
from pathlib import Path

import numpy as np

from skylimb.base.cache import cache_folder, keep, kept
from skylimb.base.files import replace_text
from skylimb.base.sources import content_of
from skylimb.control.planning.vectoring_criteria import TORQUE, VectoringCriteria
from skylimb.control.planning.vectoring_digest import robot_digest
from skylimb.control.planning.vectoring_search import NoPathError, no_path, search_vectoring
from skylimb.robots import SHIPPED, Robot

_DECIMALS = 10
_log = logging.getLogger(__name__)
_known: dict[str, np.ndarray] = {}


def find_coefficients(
    robot: Robot, criteria: VectoringCriteria, *, cache: bool = True
) -> tuple[np.ndarray, str]:
    """Coefficients and digest: from the robot's own file, the cache or a new search.

    Args:
        robot: any robot.
        criteria: what the angles are chosen for.
        cache: False searches anew and neither reads nor writes a file.

    Raises:
        AllocationError: no continuous path of vectoring angles keeps the criteria.
    """
    digest = robot_digest(robot, criteria)
    if robot.n_vectoring == 0:  # nothing to search, nothing to keep
        return search_vectoring(robot, criteria), digest
    if not cache:
        return np.round(search_vectoring(robot, criteria), _DECIMALS), digest
    if digest not in _known:
        _known[digest] = _stored(robot, criteria, digest)
    if not len(_known[digest]):
        raise no_path(robot, criteria)
    return _known[digest], digest


def table_file(criteria: VectoringCriteria) -> str:
    """Name of the file of a table beside a robot's own files."""
    spared = "_spared" if np.isfinite(criteria.servos) else ""
    return "vectoring.toml" if criteria == TORQUE else f"vectoring_{criteria.purpose}{spared}.toml"


def _stored(robot: Robot, criteria: VectoringCriteria, digest: str) -> np.ndarray:
    """Coefficients from a file or a new search; no rows where the search found no path."""
    name = table_file(criteria)
    # A robot that differs from a shipped one only where the table does not look finds that one's table.
    for path in (robot.description.folder / name, *sorted(SHIPPED.glob(f"*/{name}"))):
        found = _coefficients(content_of(path), path, digest, robot.n_vectoring)
        if found is not None:
            return found
    cached = cache_folder() / "vectoring" / f"{digest[:32]}.toml"
    found = _coefficients(kept(cached), cached, digest, robot.n_vectoring)
    if found is not None:
        return found
    # A user who waits for minutes should know what for, so this is no mere information.
    _log.warning("searching for the vectoring angles of '%s': seconds to minutes, once", robot.name)
    try:
        found = np.round(search_vectoring(robot, criteria), _DECIMALS)
    except NoPathError:
        found = np.zeros((0, criteria.degree + 1))  # worth knowing as well: it takes as long to find out
    try:
        keep(cached, table_text(found, digest, robot, criteria).encode())
    except OSError as error:
        # Without a cache everything works, only slower.
        _log.warning("cannot keep the vectoring angles of '%s' in '%s': %s", robot.name, cached, error)
    return found


def _coefficients(content: bytes | None, path: Path, digest: str, n_vectoring: int) -> np.ndarray | None:
    """The coefficients in a file's content, or None where it is absent, damaged or for something else."""
    if content is None:
        return None
    try:
        table = tomllib.loads(content.decode("utf-8"))
        coefficients = np.array(table["coefficients"], dtype=float)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        _log.warning("'%s' is no vectoring table and is not used: %s", path, error)
        return None
    whole = coefficients.ndim == 2 and coefficients.shape[0] == n_vectoring
    usable = not coefficients.size or (whole and np.all(np.isfinite(coefficients)))
    return coefficients if table.get("digest") == digest and usable else None


def write_table(
    path: Path, coefficients: np.ndarray, digest: str, robot: Robot, criteria: VectoringCriteria = TORQUE
) -> None:
    """Write a table to a file, aside first and then renamed, so that a reader never sees half of it.

    Raises:
        OSError: the folder cannot be made or written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    replace_text(path, table_text(coefficients, digest, robot, criteria))


def table_text(
    coefficients: np.ndarray, digest: str, robot: Robot, criteria: VectoringCriteria = TORQUE
) -> str:
    """The text of a table's file."""
    low, high = criteria.span(robot)
    chosen = "" if criteria == TORQUE else f" for {criteria.purpose}"
    lines = ["  [" + ", ".join(f"{entry:.{_DECIMALS}f}" for entry in row) + "],\n" for row in coefficients]
    rows = "".join(["\n", *lines]) if lines else ""
    none = (
        "# There are none: the search found no path that keeps the criteria.\n"
        if robot.n_vectoring and not rows
        else ""
    )
    return (
        f"# Vectoring angles of {robot.name}{chosen}, found by skylimb.control.planning.vectoring_search. "
        "One row a vectoring joint:\n"
        "# Chebyshev coefficients of psi (rad) over theta from theta_min to theta_max (rad). Not to be "
        f"edited by hand.\n{none}\n"
        f'digest = "{digest}"\n'
        f"theta_min = {low!r}\ntheta_max = {high!r}\n"
        f"coefficients = [{rows}]\n"
    )
