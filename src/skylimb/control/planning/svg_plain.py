"""An SVG file in the terms of its reader: what svgelements reads otherwise than the standard does, rewritten.

A `symbol` is drawn where a `use` names it, fitted into the size that the use says, and nowhere else. Nothing
is drawn where a `mask` or a `marker` stands. An `ellipse` with one radius is a circle, a percentage of a
radius is one of the viewport's diagonal, and an inner `svg` without a `viewBox` stands at its x and y. A
`text` without letters is nothing. Lengths in a unit that depends on a font or a window are refused.
"""

from __future__ import annotations

import math
import re
from xml.etree.ElementTree import Element, SubElement, tostring

from skylimb.base.errors import ConfigError
from skylimb.base.xml_text import read_xml

_HREF = ("href", "{http://www.w3.org/1999/xlink}href")
_NOWHERE = ("symbol", "mask", "marker")
"""What is not drawn where it stands."""
_SIDES = ("width", "height")
_LENGTHS = ("x", "y", *_SIDES, "cx", "cy", "r", "rx", "ry", "x1", "y1", "x2", "y2")
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
    if _tag(root) == "svg":
        inner = [each for each in root.iter() if _tag(each) in ("symbol", "svg") and each is not root]
        views = {each.get("id", ""): (each, _tag(each), dict(each.attrib)) for each in inner}
        uses = [each for each in root.iter() if _tag(each) == "use"]
        _rewrite(root, _viewport(root, (math.nan, math.nan)), what)
        _fit(root, uses, views)
    return tostring(root)


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


def _like(element: Element, tag: str) -> str:
    """A tag in an element's namespace."""
    return "".join([*str(element.tag).rpartition("}")[:2], tag])


def _fit(root: Element, uses: list[Element], views: dict[str, tuple[Element, str, dict[str, str]]]) -> None:
    """Every use of a symbol, or of an inner `svg`, gets one of its own size; equal ones share it.

    Args:
        root: of the drawing.
        uses: all that are in it.
        views: what may be used by its name: with what is in it, and its tag and attributes as they were.
    """
    shelf, fitted = SubElement(root, _like(root, "defs")), dict[tuple[str, ...], str]()
    for use in uses:
        key = next((key for key in reversed(_HREF) if key in use.attrib), "")
        name = use.get(key, "").removeprefix("#")
        if name not in views:
            continue
        source, tag, attributes = views[name]
        sizes = {side: use.get(side) or attributes.get(side) or "100%" for side in _SIDES}
        if (name, *sizes.values()) not in fitted:
            place = () if tag == "symbol" else ("x", "y")
            kept = {key: value for key, value in attributes.items() if key not in ("x", "y", *_SIDES)}
            one = SubElement(
                shelf, _like(root, "svg"), kept | {key: attributes.get(key, "0") for key in place}
            )
            one.attrib |= {"id": f"{name} in {' x '.join(sizes.values())}"} | sizes
            one.extend(source)  # shared with it: each is written where it is
            if "viewBox" not in one.attrib:
                _without_view(one)
            fitted[name, *sizes.values()] = one.attrib["id"]
        use.set(key, f"#{fitted[name, *sizes.values()]}")


def _rewrite(element: Element, viewport: _Viewport, what: str) -> None:
    """An element and all that is in it.

    Args:
        element: changed in place.
        viewport: in which it stands.
        what: it is called in messages.
    """
    for name in _LENGTHS:
        if _UNREAD.fullmatch(element.get(name, "")):
            raise ConfigError(
                f"{what} has {name} = '{element.get(name)}' in a {_tag(element)} element, a unit that "
                "depends on a font or a window; give it in px, mm, cm, in, pt, pc or %"
            )
    for part in list(element):
        tag = _tag(part)
        if tag == "text" and not "".join(part.itertext()).strip():
            element.remove(part)
            continue
        _rewrite(part, _viewport(part, viewport) if tag in ("svg", "symbol") else viewport, what)
        part.attrib |= _said(part, tag, viewport)
        if tag in _NOWHERE:
            part.tag = _like(part, "defs")
        elif tag == "svg" and "viewBox" not in part.attrib:
            _without_view(part)


def _said(part: Element, tag: str, viewport: _Viewport) -> dict[str, str]:
    """Attributes that an element has to say of itself, or to say otherwise."""
    if tag == "rect":  # it takes those of what it stands in
        return {name: part.get(name, "0") for name in ("x", "y", *_SIDES)}
    if tag == "use":
        places = zip(("x", "y"), viewport, strict=True)
        return {name: str(_pixels(part.get(name, "0"), whole)) for name, whole in places}
    if tag == "circle" and part.get("r", "").strip().endswith("%"):
        return {"r": str(_pixels(part.get("r", ""), math.hypot(*viewport) / math.sqrt(2.0)))}
    if tag == "ellipse":
        radii = [part.get(name, "auto") for name in ("rx", "ry")]
        if radii.count("auto") == 1:
            return dict.fromkeys(("rx", "ry"), min(radii, key="auto".__eq__))
    return {}


def _without_view(element: Element) -> None:
    """An inner `svg` that does not say what is seen in it, as the group that it is."""
    x, y = (_pixels(element.attrib.pop(key, "0"), math.nan) for key in ("x", "y"))
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
