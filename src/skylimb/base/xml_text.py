"""XML of a stranger's: parsed within bounds, and without a document type that declares anything."""

from __future__ import annotations

import re
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, TreeBuilder, XMLParser

_DEEPEST = 100
_MOST_ELEMENTS = 100_000
_DECLARATION = re.compile(rb"<!(ENTITY|ATTLIST|ELEMENT|NOTATION)")
_CHUNK = 1 << 16


class _Bounded(TreeBuilder):
    """Builds a tree, and stops where there is too much of it."""

    def __init__(self) -> None:
        super().__init__()
        self._depth = self._count = 0

    def start(self, tag: str, attrs: dict[str, str], /) -> Element:
        """An element begins."""
        self._depth, self._count = self._depth + 1, self._count + 1
        if self._depth > _DEEPEST:
            raise ValueError(f"more than {_DEEPEST} elements inside of each other")
        if self._count > _MOST_ELEMENTS:
            raise ValueError(f"more than {_MOST_ELEMENTS} elements")
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> Element:
        """An element ends."""
        self._depth -= 1
        return super().end(tag)


def read_xml(content: bytes, *, document_type: bool = False) -> Element:
    """The root element of a text in XML.

    Args:
        content: of a file that was read.
        document_type: whether the text may name a document type, as drawing programs do. Nothing is read for
            it, and none may declare entities, attributes or elements: those can make much of a small file.

    Raises:
        ValueError: no XML, too deep or too large, or with a document type that is not allowed.
    """
    plain = content.replace(b"\0", b"")  # as UTF-16 has the same words
    declared = _DECLARATION.search(plain)
    if declared or (not document_type and b"<!DOCTYPE" in plain):
        word = declared[1].decode() if declared else "DOCTYPE"
        raise ValueError(f"it declares a document type (DTD) with <!{word}, which is refused")
    parser = XMLParser(target=_Bounded())
    try:
        for start in range(0, len(content), _CHUNK):
            parser.feed(content[start : start + _CHUNK])
        return parser.close()
    except (ElementTree.ParseError, LookupError) as error:
        raise ValueError(" ".join(str(error).split())) from None
