"""An SDF's model with all models in it, its own and those that it includes, as one in one tree of XML."""

from __future__ import annotations

import itertools
import os
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

from skylimb.base.errors import DescriptionError, UnreadableError
from skylimb.base.sources import read_source
from skylimb.base.xml_text import read_xml

RESOURCES = "GZ_SIM_RESOURCE_PATH"
WHOLE = "__model__"
ADDED = "_added"
"""Attribute of a frame that no file has."""
_PREFIX = re.compile(rb"</?[\w.-]+:|\s[\w.-]+:(?=[\w.-]+\s*=\s*[\"'])")
_PARTS = ("link", "joint", "frame", "plugin")
_NAMING = {"pose": "relative_to", "frame": "attached_to", "xyz": "expressed_in", "mimic": "joint"}
"""Attributes that name a link, a joint or a frame, by their element."""
_NAMED = ("parent", "child", "linkName", "jointName")
"""Elements whose text does."""


class MergedModel:
    """One model with the content of those that are in it.

    What is in a model of its own is called `MODEL::NAME` where its name is another's as well. A frame stands
    where each model is placed, and what is in it is seen from there.

    Attributes:
        model: the <model> of the file that was named.
        folders: of all models that were read, by the folder's name, as `model://NAME/...` means them.
    """

    def __init__(self, path: Path, folders: Sequence[Path]) -> None:
        resources = [Path(place) for place in os.environ.get(RESOURCES, "").split(os.pathsep) if place]
        self._places = [*folders, path.resolve().parent.parent, *resources]
        self._count = itertools.count()
        self.folders = dict[str, Path]()
        self.model = self._load(path, ())
        named = [part.get("name", "") for part in self.model if part.tag in _PARTS and part.tag != "plugin"]
        short = {name: name.rpartition("::")[2] for name in named}
        times = Counter(short.values())
        for part in self.model:
            if part.tag in _PARTS:
                _rename(part, {name: one for name, one in short.items() if times[one] == 1})

    def _load(self, path: Path, above: tuple[Path, ...]) -> Element:
        """The <model> of a file as one.

        Raises:
            DescriptionError: no XML, not one model, one that includes itself, or one that is not found.
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
        self._flatten(models[0], path, (path, *above))
        return models[0]

    def _flatten(self, model: Element, path: Path, above: tuple[Path, ...]) -> None:
        """Put the content of the models in a model in their places."""
        for axis in model.iterfind("joint/axis"):
            if (axis.findtext("use_parent_model_frame") or "").strip() in ("1", "true"):  # until SDF 1.6
                for direction in axis.findall("xyz"):
                    direction.set("expressed_in", WHOLE)
        for inner in [one for one in model if one.tag in ("model", "include")]:
            if inner.tag == "model":
                content, name = inner, inner.get("name", "")
                self._flatten(inner, path, above)
            else:
                content = self._load(self._found(inner, path), above)
                name = inner.findtext("name") or content.get("name", "")
            merged = inner.get("merge") in ("true", "1")
            poses = [pose for pose in (inner.find("pose"), content.find("pose")) if pose is not None]
            at = list(model).index(inner)
            model[at : at + 1] = self._placed(
                content, "" if merged else name, poses[0] if poses else _at_origin()
            )

    def _found(self, include: Element, path: Path) -> Path:
        """The file of an included model."""
        uri = (include.findtext("uri") or "").strip()
        name = uri.removeprefix("model://").strip("/")
        found = next((file for place in self._places if (file := _sdf_of(place / name)) is not None), None)
        if not name or found is None:
            raise DescriptionError(
                f"'{path.name}' includes '{uri}', which is not found; say where its folder lies: "
                f"--packages DIR, or {RESOURCES}"
            )
        return found

    def _placed(self, content: Element, scope: str, pose: Element) -> list[Element]:
        """The parts of a model, named for the one that holds it, and the frame that they are seen from."""
        parts = [part for part in content if part.tag in _PARTS]
        own = [part.get("name", "") for part in parts if part.tag != "plugin"]
        frame = Element("frame", {"name": scope or f"_included_{next(self._count)}", ADDED: ""})
        names = {name: f"{scope}::{name}" for name in own} if scope else {}
        links = [part.get("name", "") for part in parts if part.tag == "link"]
        root = content.get("canonical_link") or next(iter(links), WHOLE)
        frame.set("attached_to", names.get(root, root))
        pose.set("relative_to", pose.get("relative_to") or WHOLE)
        frame.append(pose)
        names[WHOLE] = frame.attrib["name"]
        for part in parts:
            # Nothing said, a link is seen from the model, a frame from what it is on, a joint from its child.
            if part.tag == "frame":
                part.set("attached_to", part.get("attached_to") or WHOLE)
            elif part.tag == "link":
                at = part.find("pose")
                if at is None:
                    part.append(at := _at_origin())
                at.set("relative_to", at.get("relative_to") or WHOLE)
            _rename(part, names)
        return [frame, *parts]


def _rename(part: Element, names: Mapping[str, str]) -> None:
    """Call a part, and what it names, otherwise."""
    if part.tag != "plugin":
        part.set("name", names.get(part.get("name", ""), part.get("name", "")))
    for element in part.iter():
        said = _NAMING.get(element.tag)
        if said in element.attrib:
            element.set(said, names.get(element.attrib[said], element.attrib[said]))
        elif element.tag in _NAMED and element.text:
            element.text = names.get(element.text.strip(), element.text)


def _at_origin() -> Element:
    pose = Element("pose")
    pose.text = "0 0 0 0 0 0"
    return pose


def _sdf_of(place: Path) -> Path | None:
    """The SDF at a place: a file, or of a folder the last one that its model.config names, else model.sdf."""
    if _is_file(place):
        return place
    try:
        named = [one.text or "" for one in read_xml(read_source(place / "model.config").content).iter("sdf")]
    except (UnreadableError, ValueError):
        named = []
    files = (place / name.strip() for name in (*named[::-1], "model.sdf"))
    return next((file for file in files if _is_file(file)), None)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # no name that a file can have
        return False
