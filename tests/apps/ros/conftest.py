"""Robots that take off soon."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest

from skylimb.apps.ros import lift

SLOWLY = {name: getattr(lift, name) for name in ("SPOOL", "SLOW")}
"""How the rotors of a user's robot come up."""


@contextmanager
def rotors_as(**numbers: float) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for name, value in numbers.items():
            patch.setattr(lift, name, value)
        yield


@pytest.fixture(scope="module", autouse=True)
def _rotors_come_up_soon() -> Iterator[None]:
    """In .8 s, not in 2.5: most tests begin in hover."""
    with rotors_as(SPOOL=0.3, SLOW=0.6):
        yield


@pytest.fixture(scope="session")
def slow_rotors() -> Callable[[], AbstractContextManager[None]]:
    """Within it they come up as a user's do, for what looks at a take-off."""
    return lambda: rotors_as(**SLOWLY)


@pytest.fixture
def rotors_come_up_slowly(slow_rotors: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    with slow_rotors():
        yield
