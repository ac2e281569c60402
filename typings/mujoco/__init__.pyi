# MuJoCo's wheels come without types for their compiled half: to the type checker everything in it is Any.
from typing import Any

def __getattr__(name: str) -> Any: ...
