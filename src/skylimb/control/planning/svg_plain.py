"""An SVG file in the terms of its reader: what svgelements reads otherwise than the standard does, rewritten.

A `symbol` is drawn where a `use` names it, fitted into the size that the use says, and nowhere else. Nothing
is drawn where a `mask` or a `marker` stands. An `ellipse` with one radius is a circle. A percentage is one of
the viewport at hand, of a radius one of its diagonal. An inner `svg` without a `viewBox` stands at its x, y.
A `text` without letters is nothing. Lengths in a unit that depends on a font or a window are refused.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element, SubElement, tostring

from skylimb.base.errors import ConfigError
from skylimb.base.xml_text import read_xml

_HREF = ("href", "{http://www.w3.org/1999/xlink}href")
_NOWHERE = ("symbol", "mask", "marker")
"""What is not drawn where it stands."""
_PLACE, _SIDES = ("x", "y"), ("width", "height")
_ACROSS, _UP = ("x", "cx", "rx", "x1", "x2", "width"), ("y", "cy", "ry", "y1", "y2", "height")
_LENGTHS = {*_ACROSS, *_UP, "r"}
_UNREAD = re.compile(r"[-+.\deE]+\s*(em|ex|ch|rem|vw|vh|vmin|vmax|q)\s*", re.IGNORECASE)

_Viewport = tuple[float, float]
"""Width and height in units of the drawing; NaN where the file does not say them."""
_PIXELS_PER_INCH = 96.0


def plain_svg(content: bytes, what: str) -> bytes:
    """The same drawing, in elements that are read as they are meant.

    Args:
        content: of an SVG file.
        what: it is called in messages.

    Raises:
        ConfigError: where a length has a unit that depends on a font or a window.
        ValueError: where it is no XML.
    """
    root = read_xml(content, document_type=True)
    if _tag(root) != "svg":
        return content
    standing = list(_standing(root, _viewport(root, (math.nan, math.nan))))
    for part, viewport in standing:
        _require_read(part, what)
        part.attrib |= _said(part, viewport)
    _fit(root, standing)
    for part, _ in standing:
        if _tag(part) in _NOWHERE:
            part.tag = _like(part, "defs")
        elif _tag(part) == "svg" and "viewBox" not in part.attrib:
            _without_view(part)
        elif _tag(part) == "text" and not "".join(part.itertext()).strip():
            part.clear()
            part.tag = _like(root, "g")
    return tostring(root)


def _standing(element: Element, viewport: _Viewport) -> Iterator[tuple[Element, _Viewport]]:
    """All that is in an element, at any depth, and the viewport in which each stands."""
    for part in element:
        yield part, viewport
        yield from _standing(part, _viewport(part, viewport) if _tag(part) in ("svg", "symbol") else viewport)


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


def _like(element: Element, tag: str) -> str:
    """A tag in an element's namespace."""
    return "".join([*str(element.tag).rpartition("}")[:2], tag])


def _fit(root: Element, standing: list[tuple[Element, _Viewport]]) -> None:
    """Every use of a symbol, or of an inner `svg`, gets one of its own size; equal ones share it."""
    views = {part.get("id"): part for part, _ in standing if _tag(part) in ("symbol", "svg")}
    shelf, fitted = SubElement(root, _like(root, "defs")), dict[tuple[str, ...], str]()
    for use, viewport in standing:
        key = next((key for key in reversed(_HREF) if key in use.attrib), "")
        source = views.get(use.get(key, "").removeprefix("#")) if _tag(use) == "use" else None
        if source is None:
            continue
        sizes = {
            side: use.get(side) or source.get(side) or str(whole)
            for side, whole in zip(_SIDES, viewport, strict=True)
        }
        which = use.get(key, ""), *sizes.values()
        if which not in fitted:
            fitted[which] = " ".join(which).removeprefix("#")
            one = SubElement(shelf, _like(root, "svg"), source.attrib | sizes | {"id": fitted[which]})
            one.extend(source)  # shared with it: each is written where it is
            if _tag(source) == "symbol":
                one.attrib |= dict.fromkeys(_PLACE, "0")
            if "viewBox" not in one.attrib:
                _without_view(one)
        use.set(key, f"#{fitted[which]}")


def _require_read(element: Element, what: str) -> None:
    for name, value in element.attrib.items():
        if name in _LENGTHS and _UNREAD.fullmatch(value):
            raise ConfigError(
                f"{what} has {name} = '{value}' in a {_tag(element)} element, a unit that "
                "depends on a font or a window; give it in px, mm, cm, in, pt, pc or %"
            )


def _said(part: Element, viewport: _Viewport) -> dict[str, str]:
    """Attributes that an element has to say of itself, or to say otherwise."""
    tag, said = _tag(part), dict[str, str]()
    if tag in ("rect", "use"):  # else it takes those of what it stands in
        said = {name: part.get(name, "0") for name in (*_PLACE, *(_SIDES if tag == "rect" else ()))}
    for name, value in part.attrib.items():
        if name in _LENGTHS and value.strip().endswith("%"):
            diagonal = math.hypot(*viewport) / math.sqrt(2.0)
            whole = viewport[0] if name in _ACROSS else viewport[1] if name in _UP else diagonal
            said |= {name: str(_pixels(value, whole))} if math.isfinite(whole) else {}
    if tag == "ellipse":
        radii = [(part.attrib | said).get(name, "auto") for name in ("rx", "ry")]
        if radii.count("auto") == 1:
            said |= dict.fromkeys(("rx", "ry"), min(radii, key="auto".__eq__))
    return said


def _without_view(element: Element) -> None:
    """An inner `svg` that does not say what is seen in it, as the group that it is."""
    x, y = (_pixels(element.attrib.pop(key, "0"), math.nan) for key in _PLACE)
    for side in _SIDES:
        element.attrib.pop(side, None)
    element.tag = _like(element, "g")
    element.set("transform", f"{element.get('transform', '')} translate({x} {y})")


def _viewport(element: Element, outer: _Viewport) -> _Viewport:
    """What an `svg` or a `symbol` shows, in its own units."""
    view = element.get("viewBox", "").replace(",", " ").split()
    sizes = view[2:] if len(view) == 4 else [element.get(side, "100%") for side in _SIDES]
    width, height = (_pixels(size, whole) for size, whole in zip(sizes, outer, strict=True))
    return width, height


def _pixels(length: str, whole: float) -> float:
    """A length in units of the drawing, a percentage of `whole`; NaN where it is none."""
    from svgelements import Length

    try:
        return float(Length(length).value(ppi=_PIXELS_PER_INCH, relative_length=whole))
    except (ValueError, TypeError, AttributeError):
        return math.nan
