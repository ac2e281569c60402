"""What installed packages add, each with who adds it, or why it cannot be used."""

from __future__ import annotations

from collections.abc import Iterable

from skylimb.base.errors import did_you_mean, nearest
from skylimb.base.plugins import GROUPS, added_by, added_names


def added_rows() -> list[tuple[str, str]]:
    """Kind and name of all that packages add, and which package does, or why it is not usable."""
    rows = []
    for group in GROUPS:
        ships = set(shipped_names(group))
        rows += [(f"{group[:-1]} {name}", _who(group, name, ships)) for name in added_names(group)]
    return rows


def shipped_names(group: str) -> Iterable[str]:
    """The names that skylimb itself has in a group of `GROUPS`; a law's begins with its slot's."""
    from skylimb.control.laws.preset import preset_names
    from skylimb.control.laws.slots import SLOTS, law_names
    from skylimb.flight.experiments.listing import list_experiments
    from skylimb.robots.loader import list_robots
    from skylimb.simulation.surfaces import SURFACES

    names: dict[str, Iterable[str]] = {
        "laws": [f"{slot}.{law}" for slot in SLOTS for law in law_names(slot)],
        "controllers": preset_names(),
        "robots": list_robots(),
        "surfaces": SURFACES,
        "experiments": list_experiments(),
    }
    return names.get(group, ())


def _who(group: str, name: str, ships: set[str]) -> str:
    from skylimb.control.laws.slots import SLOTS

    who = added_by(group, name)
    if name in ships:
        return f"not usable: skylimb itself has '{name}', {who} has to call it otherwise"
    slot, dot, _ = name.partition(".")
    if group == "laws" and not (dot and slot in SLOTS):
        known = ", ".join(SLOTS) + (did_you_mean(nearest(slot, SLOTS)) if dot else "")
        return f"not usable: '{name}' of {who} should begin with its slot's name, one of {known}"
    return who
