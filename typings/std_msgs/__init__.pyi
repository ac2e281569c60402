"""What is used of Debian's package; whatever else it has is unknown here."""

from typing import Any

def __getattr__(name: str) -> Any: ...
