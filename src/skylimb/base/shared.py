"""A setting of the whole process that several threads need at once."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Any


def shared(context: Callable[[], AbstractContextManager[Any]]) -> Callable[[], AbstractContextManager[None]]:
    """The same context for all who are in it: who comes first enters it, who leaves last leaves it."""
    lock, entered, users = threading.Lock(), ExitStack(), 0

    @contextmanager
    @functools.wraps(context)
    def held() -> Iterator[None]:
        nonlocal users
        with lock:
            if users == 0:
                entered.enter_context(context())
            users += 1
        try:
            yield
        finally:
            with lock:
                users -= 1
                if users == 0:
                    entered.close()

    return held
