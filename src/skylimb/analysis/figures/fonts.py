"""The font of the figures: DejaVu Sans without the tables that only typesetting programs read.

A PDF holds the letters that it uses of each font. Cutting them out of the full font takes some 50 ms a font
and file, half of all that the figures cost; out of this one it takes a few. It is made once a process from
matplotlib's own copy, under another name. Letters that it lacks come from the full font.
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path

import matplotlib
from fontTools import subset
from matplotlib import font_manager

FAMILY = "Skylimb Sans"
FULL_FAMILY = "DejaVu Sans"

_SOURCES = ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf")
_LETTERS = (*range(0x20, 0x180), *range(0x391, 0x3CA), 0x2013, 0x2014, 0x2019, 0x2026, 0x2212)
_TYPESETTING_TABLES = ("GSUB", "GPOS", "GDEF", "kern", "FFTM", "PfEd")
_FAMILY_NAME_IDS = (1, 4, 16)


@cache
def families() -> list[str]:
    """Font families to name in a style, the light one first; the first call registers it with matplotlib."""
    folder = Path(tempfile.mkdtemp(prefix="skylimb-fonts-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    for source in _SOURCES:
        options = subset.Options()
        options.layout_features = []
        options.drop_tables += list(_TYPESETTING_TABLES)
        font = subset.load_font(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / source), options)
        cutter = subset.Subsetter(options=options)
        cutter.populate(unicodes=_LETTERS)
        cutter.subset(font)
        for record in font["name"].names:
            if record.nameID in _FAMILY_NAME_IDS:
                record.string = FAMILY.encode(record.getEncoding())
        font.save(folder / source)
        font_manager.fontManager.addfont(folder / source)
    return [FAMILY, FULL_FAMILY]
