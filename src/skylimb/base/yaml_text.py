"""YAML of a stranger's, as ROS has it: tables and lists that are written out, within bounds."""

from __future__ import annotations

from typing import Any

_DEEPEST = 32


def read_yaml(content: bytes) -> Any:
    """Tables, lists and values of a text in YAML.

    Raises:
        ValueError: no YAML, nested too deeply, or with an alias: those can make much of a small file.
    """
    import yaml

    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    depth = 0
    try:
        for event in yaml.parse(content, Loader=loader):
            if isinstance(event, yaml.AliasEvent):
                raise ValueError(f"it repeats '*{event.anchor}'; write out what that stands for")
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > _DEEPEST:
                raise ValueError(f"it has more than {_DEEPEST} tables or lists inside of each other")
        return yaml.load(content, Loader=loader)
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())[:200]) from None
