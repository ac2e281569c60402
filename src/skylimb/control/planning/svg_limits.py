"""What reading an SVG will take, counted in its XML before the reader of SVGs sees it.

A `use` repeats what it names, and what it names may repeat again; a transform is applied by all that is in
there. So a file of a few lines can ask for more than any machine has.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from skylimb.base.errors import ConfigError

_HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_OUTLINES = ("d", "points")
_DEEPEST = 100
_LONGEST = 5_000
"""Letters of an attribute that is neither an outline nor another program's own."""
_LONGEST_STYLE = 20_000
_RULE = re.compile(r"([^{}]*)\{([^{}]*)\}")
_DIGITS = str.maketrans("", "", "0123456789")

_SECONDS = 1.0
"""Most that reading may take, by the figures below: of svgelements 1.9, on a core of 2020."""
_ELEMENT, _SHAPE, _NUMBER = 3e-5, 2.5e-4, 1e-5
_TRANSFORM = 2.5e-5
"""Of every element that a transform is applied to."""
_ATTRIBUTE = 2e-7
"""Of every element that inherits it; it also takes 20 bytes in there."""
_LETTER = 1.2e-7
"""Of the longest rules of the style sheet, for every element and class that they may mean."""
_CLOSE = 4e-7
"""Of every number that stands before the end of an outline that is closed."""

_SHAPES = {"path", "circle", "ellipse", "line", "polyline", "polygon", "rect"}


@dataclass(frozen=True)
class _Cost:
    """Of an element with all that is in it and all that it repeats.

    Attributes:
        elements: how many.
        seconds: of reading them.
        depth: levels.
    """

    elements: float
    seconds: float
    depth: int


def require_readable(root: Element, what: str) -> None:
    """Refuse an SVG that would take long to read.

    Raises:
        ConfigError: naming what is too much.
    """
    cost = _Costs(root, what, _longest_style(root, what)).cost(root, 1)
    if cost.seconds > _SECONDS:
        raise ConfigError(
            f"{what} is too complicated: {cost.elements:.4g} elements with all that they repeat, and their "
            f"transforms and points, take more than {_SECONDS:g} s to read; make it simpler"
        )


def _longest_style(root: Element, what: str) -> int:
    """Letters that the style sheet has for the selector for which it has most."""
    sheet = "".join(element.text or "" for element in root.iter() if _name(element) == "style")
    if len(sheet) > _LONGEST_STYLE or sheet.count("{") != sheet.count("}"):
        raise ConfigError(
            f"{what} has a style sheet of {len(sheet)} letters, more than {_LONGEST_STYLE} or with a bracket "
            "that is not closed; make it simpler"
        )
    total: Counter[str] = Counter()
    for selectors, style in _RULE.findall(sheet):
        for selector in selectors.split(","):
            total[selector.strip()] += len(style)
    longest = max(total.values(), default=0)
    if longest > _LONGEST_STYLE:
        raise ConfigError(f"{what} has a style sheet that repeats itself; make it simpler")
    return longest


class _Costs:
    """Counts each element once, however often it is repeated."""

    def __init__(self, root: Element, what: str, sheet: int) -> None:
        self._what, self._sheet = what, sheet
        self._named = {element.get("id"): element for element in root.iter()}
        self._known: dict[Element, _Cost] = {}
        self._open: set[Element] = set()

    def cost(self, element: Element, depth: int) -> _Cost:
        """Of an element that stands at a depth."""
        if element in self._open:
            raise ConfigError(f"{self._what} has a <use> that repeats itself ('#{element.get('id')}')")
        if element not in self._known:
            if depth > _DEEPEST:
                self._refuse_depth()
            self._open.add(element)
            inside = [self.cost(child, depth + 1) for child in (*element, *self._repeated(element))]
            self._open.remove(element)
            self._known[element] = self._with(element, inside)
        found = self._known[element]
        if depth + found.depth > _DEEPEST + 1:
            self._refuse_depth()
        return found

    def _with(self, element: Element, inside: list[_Cost]) -> _Cost:
        elements = 1 + sum(one.elements for one in inside)
        transforms = self._transforms(element)
        declared = (element.get("style") or "").count(";")
        classes = len((element.get("class") or "").split())
        return _Cost(
            elements,
            sum(one.seconds for one in inside)
            + elements * (_ATTRIBUTE * (len(element.attrib) + declared) + _TRANSFORM * transforms)
            + (_SHAPE if _name(element) in _SHAPES else _ELEMENT)
            + _LETTER * self._sheet * (3 + 2 * classes)
            + sum(map(_outline_seconds, (element.get(name) or "" for name in _OUTLINES))),
            1 + max((one.depth for one in inside), default=0),
        )

    def _transforms(self, element: Element) -> int:
        for name, value in element.attrib.items():
            if len(value) > _LONGEST and name not in (*_OUTLINES, *_HREFS) and not name.startswith("{"):
                raise ConfigError(
                    f"{self._what} has the attribute '{name[:40]}' with {len(value)} letters, more than "
                    f"{_LONGEST}; make it simpler"
                )
        text = element.get("transform") or ""
        if text.count("(") != text.count(")"):
            raise ConfigError(f"{self._what} has a transform with a bracket that is not closed")
        return text.count("(") + len(text) // 100

    def _repeated(self, element: Element) -> list[Element]:
        """What an element repeats; of two names the reader takes the plain one."""
        if _name(element) != "use":
            return []
        name = next((value for href in _HREFS if (value := element.get(href)) is not None), "")
        found = self._named.get(name[1:])
        return [] if found is None else [found]

    def _refuse_depth(self) -> None:
        raise ConfigError(f"{self._what} has more than {_DEEPEST} elements inside of each other")


def _outline_seconds(text: str) -> float:
    """Of reading an outline: its numbers, and for every end the way back to its beginning."""
    seconds = 0.0
    for part in re.split("[mM]", text) if text else ():
        rest = part.translate(_DIGITS)
        dots = rest.count(".")
        numbers = max(len(rest) - dots, dots)
        seconds += _NUMBER * numbers + _CLOSE * numbers * (rest.count("z") + rest.count("Z"))
    return seconds


def _name(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]
