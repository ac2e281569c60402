"""An SDF's model with what it includes, `<include merge="true">`, in one tree of XML."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

from skylimb.base.errors import DescriptionError
from skylimb.base.sources import read_source
from skylimb.base.xml_text import read_xml

RESOURCES = "GZ_SIM_RESOURCE_PATH"
WHOLE = "__model__"
_MERGE = "<include merge='true'>"
_PREFIX = re.compile(rb"</?[\w.-]+:|\s[\w.-]+:(?=[\w.-]+\s*=\s*[\"'])")


class MergedModel:
    """One model with the content of those that it includes.

    A frame stands where each of these is placed, and what is in them is seen from there.

    Attributes:
        model: the <model> of the file that was named.
        frames: names of the frames that were added.
        folders: of all models that were read, by the folder's name, as `model://NAME/...` means them.
    """

    def __init__(self, path: Path, folders: Sequence[Path]) -> None:
        resources = [Path(place) for place in os.environ.get(RESOURCES, "").split(os.pathsep) if place]
        self._places = [*folders, path.resolve().parent.parent, *resources]
        self.frames = list[str]()
        self.folders = dict[str, Path]()
        self.model = self._load(path, ())

    def _load(self, path: Path, above: tuple[Path, ...]) -> Element:
        """The <model> of a file, what it includes merged.

        Raises:
            DescriptionError: no XML, not one model, or one inside of another.
        """
        path = path.resolve()
        try:
            # SDF knows no name spaces: its files use prefixes that they never say.
            root = read_xml(
                _PREFIX.sub(lambda found: found[0].replace(b":", b"."), read_source(path).content)
            )
        except ValueError as error:
            raise DescriptionError(f"'{path}' is no XML of a robot: {error}") from None
        models = root.findall("model") if root.tag == "sdf" else []
        if len(models) != 1:
            found = "a world" if root.find("world") is not None else f"{len(models)} models"
            raise DescriptionError(f"'{path.name}' needs one model, and has {found}")
        if path in above:
            raise DescriptionError(f"'{path.parent.name}/{path.name}' includes itself")
        self.folders[path.parent.name] = path.parent
        model = models[0]
        for inner in model.findall("model"):
            name = inner.get("name")
            raise DescriptionError(f"'{path.name}' has a model '{name}' in its model; use {_MERGE}")
        for include in model.findall("include"):
            at = list(model).index(include)
            model[at : at + 1] = [*self._included(include, path, (path, *above))]
        return model

    def _included(self, include: Element, path: Path, above: tuple[Path, ...]) -> Iterator[Element]:
        """The content of an included model, and the frame that it is seen from."""
        uri = (include.findtext("uri") or "").strip()
        if include.get("merge") not in ("true", "1"):
            raise DescriptionError(f"'{path.name}' includes '{uri}' as a model of its own; use {_MERGE}")
        name = uri.removeprefix("model://").strip("/")
        found = next((file for place in self._places if (file := _sdf_of(place / name)) is not None), None)
        if not name or found is None:
            raise DescriptionError(
                f"'{path.name}' includes '{uri}', which is not found; say where its folder lies: "
                f"--packages DIR, or {RESOURCES}"
            )
        model = self._load(found, above)
        frame = Element("frame", {"name": f"_included_{len(self.frames)}"})
        self.frames.append(frame.attrib["name"])
        placed = [pose for pose in (include.find("pose"), model.find("pose")) if pose is not None]
        frame.append(placed[0] if placed else _at_origin())
        yield frame
        for part in model:
            if part.tag not in ("link", "joint", "frame", "plugin"):
                continue
            pose = part.find("pose")
            # Nothing said, a link is seen from the model, a joint from its child, a frame from what it is on.
            implied = part.tag == "link" or (
                part.tag == "frame" and part.get("attached_to") in (None, "", WHOLE)
            )
            if pose is None and implied:
                part.append(pose := _at_origin())
            if pose is not None and (pose.get("relative_to") or (WHOLE if implied else "")) == WHOLE:
                pose.set("relative_to", frame.attrib["name"])
            yield part


def _at_origin() -> Element:
    pose = Element("pose")
    pose.text = "0 0 0 0 0 0"
    return pose


def _sdf_of(place: Path) -> Path | None:
    """The SDF at a place: a file, or of a folder the last one that its model.config names, else model.sdf."""
    if place.is_file():
        return place
    try:
        named = [one.text or "" for one in read_xml((place / "model.config").read_bytes()).iter("sdf")]
    except (OSError, ValueError):
        named = []
    files = (place / name.strip() for name in (*named[::-1], "model.sdf"))
    return next((file for file in files if file.is_file()), None)
