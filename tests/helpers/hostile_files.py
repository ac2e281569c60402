"""Files that ask for more than a machine has, made here and not kept, and who reads them.

As a program it measures each in a process of its own and prints a table: time, memory, what was said.
"""

import io
import json
import resource
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.tables import _read as read_servo_tables
from skylimb.base.config import read_toml
from skylimb.base.errors import SkylimbError
from skylimb.base.sources import read_source
from skylimb.base.user_modules import load_module
from skylimb.control.planning.drawing_sources import svg_strokes
from skylimb.robots.urdf import read_urdf
from skylimb.simulation.surfaces.meshes import MeshSurface
from skylimb.simulation.surfaces.tables import read_table, values_in

SVG = '<svg xmlns="http://www.w3.org/2000/svg" fill="none" stroke="red">'
LINE = '<path d="M0 0 L9 9"/>'
BOMB = '<!ENTITY e0 "haha">' + "".join(f'<!ENTITY e{i} "' + f"&e{i - 1};" * 10 + '">' for i in range(1, 9))


def svg(text: str) -> str:
    return f"{SVG}{text}</svg>"


def uses(levels: int, times: int = 10) -> str:
    """Each group repeats the one before some times."""
    groups = (f'<g id="g{i}">' + f'<use href="#g{i - 1}"/>' * times + "</g>" for i in range(1, levels))
    return f'<g id="g0">{LINE}</g>' + "".join(groups)


def ten_times(level: int) -> str:
    """The list of the level below, ten times."""
    return f"*a{level - 1}," * 10 if level else ""


def png(width: int, height: int) -> bytes:
    """A picture without a picture: only its size."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(b"\0" * 10**6)) + chunk(b"IEND", b"")


def npy(shape: tuple[int, ...]) -> bytes:
    """A header that says more than the file has."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return file.getvalue() + b"\0" * 800


def stl(triangles: int) -> bytes:
    """A front of many small triangles."""
    n = int(np.sqrt(triangles / 2))
    u, v = np.meshgrid(np.linspace(-0.6, 0.6, n + 1), np.linspace(-0.6, 0.6, n + 1), indexing="ij")
    points = np.stack([0.02 * np.sin(5 * u), u, v], axis=-1).astype("<f4")
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    corners = np.concatenate([np.stack([a, c, b], axis=2), np.stack([a, d, c], axis=2)]).reshape(-1, 3, 3)
    rows = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    rows["corners"] = corners
    return b"\0" * 80 + struct.pack("<I", len(corners)) + rows.tobytes()


PLY = "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n0\n"
GLTF = {
    "asset": {"version": "2.0"},
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "nodes": [{"mesh": 0}],
    "scenes": [{"nodes": [0]}],
    "accessors": [{"componentType": 5126, "count": 10**10, "type": "VEC3"}],
}
LINK = '<link name="a"/>'

DECLARED = f"<!DOCTYPE svg [{BOMB}]>" + svg(f"<title>&e8;</title>{LINE}")

FILES: dict[str, Callable[[], str | bytes]] = {
    "brackets.toml": lambda: "a = " + "[" * 100_000 + "]" * 100_000,
    "tables.toml": lambda: "a = " + "{b=" * 50_000 + "1" + "}" * 50_000,
    "dots.toml": lambda: "a" + ".a" * 100_000 + " = 1",
    "quoted_dots.toml": lambda: '"a"' + ' . "a"' * 40_000 + " = 1",
    "digits.toml": lambda: "a = " + "9" * 240_000,
    "many_keys.toml": lambda: "\n".join(f"[a.b{i}]" for i in range(20_000)),
    "long_list.toml": lambda: "a = [" + "1," * 124_000 + "]",
    "large.toml": lambda: "#" * 600_000,
    "halves.toml": lambda: b"a = '\xff'",
    "itself.svg": lambda: svg(f'<g id="a">{LINE}<use href="#a"/></g>'),
    "each_other.svg": lambda: svg('<g id="a"><use href="#b"/></g><g id="b"><use href="#a"/></g>'),
    "use_bomb.svg": lambda: svg(uses(9)),
    "use_chain.svg": lambda: svg(uses(2000, 1)),
    "groups.svg": lambda: svg("<g>" * 20_000 + LINE + "</g>" * 20_000),
    "transforms.svg": lambda: svg('<g transform="' + "scale(1) " * 20_000 + f'">{LINE * 100}</g>'),
    "inherited_transforms.svg": lambda: svg(
        ('<g transform="' + "scale(1) " * 500 + '">') * 90 + LINE * 900 + "</g>" * 90
    ),
    "open_transform.svg": lambda: svg(f'<g transform="{"scale(" * 800}">{LINE * 900}</g>'),
    "attributes.svg": lambda: svg(
        "<g " + " ".join(f'a{i}=""' for i in range(9000)) + f">{'<g/>' * 9000}</g>"
    ),
    "style.svg": lambda: svg("<style>*{" + "a:b;" * 49_000 + f"}}</style>{LINE * 900}"),
    "open_style.svg": lambda: svg(f"<style>{'a{' * 90_000}</style>{LINE}"),
    "pieces.svg": lambda: svg(f'<path d="M0 0{"h1" * 1_900_000}"/>'),
    "closes.svg": lambda: svg(f'<path d="M0 0{"z" * 100_000}"/>'),
    "curves.svg": lambda: svg(f'<path d="M0 0{"c1 9 2-9 3 1" * 19_000}"/>'),
    "entities.svg": lambda: DECLARED,
    "entities16.svg": lambda: DECLARED.encode("utf-16"),
    "defaults.svg": lambda: f'<!DOCTYPE svg [<!ATTLIST g a CDATA "{"x" * 90_000}">]>' + svg("<g/>" * 90_000),
    "entities.urdf": lambda: f'<!DOCTYPE robot [{BOMB}]><robot name="&e8;">{LINK}</robot>',
    "groups.urdf": lambda: '<robot name="a">' + "<link>" * 100_000 + "</link>" * 100_000 + "</robot>",
    "links.urdf": lambda: '<robot name="a">' + "<link/>" * 560_000 + "</robot>",
    "brackets.yaml": lambda: "a: " + "[" * 100_000,
    "dashes.yaml": lambda: "- " * 100_000,
    "aliases.yaml": lambda: "".join(f"a{i}: &a{i} [{ten_times(i)}]\n" for i in range(12)),
    "huge.png": lambda: png(60_000, 60_000),
    "wide.png": lambda: png(9_000, 9_000),
    "header.npy": lambda: npy((10**6, 10**6)),
    "short.npy": lambda: npy((1000, 1000)),
    "bytes.npy": lambda: b"\x93NUMPY\x01\0v\0" + b"(" * 118,
    "count.stl": lambda: b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 500,
    "triangles.stl": lambda: stl(190_000),
    "count.gltf": lambda: json.dumps(GLTF),
    "vertices.ply": lambda: PLY,
    "brackets.py": lambda: "a = " + "(" * 100_000,
    "minuses.py": lambda: "a = " + "-" * 100_000 + "1",
    "attributes.py": lambda: "a = b" + ".c" * 100_000,
}  # fmt: skip


def read(path: Path) -> object:
    """Read a file as its user would have it read."""
    match path.suffix:
        case ".toml":
            return read_toml(path)
        case ".svg":
            return svg_strokes(read_source(path), path.name)
        case ".urdf":
            return check_robot_file(path), read_urdf(read_source(path))
        case ".yaml":
            return read_servo_tables(path, "servo_controller")
        case ".py":
            return load_module(path, ("a",))
        case ".png" | ".npy":
            return values_in(read_table(str(path), path.name), path.name)
        case _:
            return MeshSurface(file=str(path), allow_open=True)


def said(path: Path) -> str:
    """What a user reads; what is no error of skylimb's is raised."""
    try:
        read(path)
    except SkylimbError as error:
        return str(error)
    return "read"


def made(folder: Path, name: str) -> Path:
    """A file of that name, in a folder."""
    content = FILES[name]()
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder / name


def _memory() -> float:
    return 1e-3 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _measure(path: Path) -> None:
    _warm_up(path)
    before, began = _memory(), time.perf_counter()
    words = said(path)
    taken, more = time.perf_counter() - began, max(0.0, _memory() - before)
    print(f"{taken:.2f} | {more:.0f} | {' '.join(words.split())[:150]}")


def _warm_up(path: Path) -> None:
    """Import what the kind of file needs, with a harmless one."""
    harmless = {
        ".svg": svg(LINE), ".toml": "a = 1", ".yaml": "a: 1", ".py": "a = 1", ".png": "", ".npy": "",
        ".urdf": f'<robot name="a">{LINK}</robot>', ".stl": "", ".gltf": "", ".ply": "",
    }[path.suffix]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"harmless{path.suffix}"
        file.write_text(harmless)
        said(file)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        _measure(Path(sys.argv[1]))
    else:
        print("| file | MB | s | MB of memory | what is said |\n|---|---|---|---|---|")
        with tempfile.TemporaryDirectory() as folder:
            for name in FILES:
                path = made(Path(folder), name)
                done = subprocess.run(
                    [sys.executable, __file__, str(path)],
                    capture_output=True,
                    text=True,
                    timeout=60,
                    check=False,
                )
                last = (done.stdout or done.stderr).strip().splitlines()[-1].replace(folder, "")
                print(f"| {name} | {1e-6 * path.stat().st_size:.2f} | {last} |", flush=True)
