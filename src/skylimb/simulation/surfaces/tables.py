"""Rows and columns of numbers from images and files, as height maps and friction maps use them."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np

from skylimb.base.errors import ConfigError, SkylimbError, first_line, missing_extra
from skylimb.base.sources import Source, read_source

_IMAGES = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"}
_MOST_VALUES = 4_000_000
_NUMBERS = {".npy", ".csv", ".txt"}


def read_table(file: str, name: str) -> Source:
    """A file for `values_in`, refused where it is of no kind that can be read."""
    suffix = Path(file).suffix.lower()
    if suffix not in _IMAGES | _NUMBERS:
        known = ", ".join(sorted(_IMAGES | _NUMBERS))
        raise ConfigError(f"{name}: cannot read a '{suffix}' file; these are known: {known}")
    try:
        return read_source(file)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from None


def values_in(source: Source, name: str) -> np.ndarray:
    """Rows and columns of numbers from an image (brightness, 0 to 1) or a file of numbers."""
    suffix, content = source.path.suffix.lower(), io.BytesIO(source.content)
    try:
        if suffix == ".npy":
            return _numbers_of_npy(content)
        if suffix in _NUMBERS:
            return np.loadtxt(content, delimiter="," if suffix == ".csv" else None, ndmin=2)
        try:
            from PIL import Image
        except ImportError:
            raise missing_extra("PIL") from None
        # Only these: other readers of Pillow's run other programs.
        with Image.open(content, formats=("PNG", "JPEG", "TIFF", "BMP")) as image:
            _require_few(image.width * image.height)
            # "I" keeps the 16 bits of a deep image, which "L" would cut to 8.
            deep = image.mode.startswith("I")
            values = np.asarray(image.convert("I" if deep else "L"), dtype=float)
            return values / (65535.0 if deep else 255.0)
    except SkylimbError:
        raise
    except Exception as error:  # a damaged file fails in whatever layer meets the damage first
        raise ConfigError(f"{name}: cannot be read: {first_line(error)}") from error


def _numbers_of_npy(content: io.BytesIO) -> np.ndarray:
    """The array in a file of NumPy's; its header is believed of no more than the file has."""
    version = np.lib.format.read_magic(content)
    header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, kind = header(content)
    _require_few(math.prod(shape))
    if math.prod(shape) * kind.itemsize > len(content.getbuffer()) - content.tell():
        raise ValueError(f"its header says {shape}, for which it is too short")
    content.seek(0)
    return np.asarray(np.load(content, allow_pickle=False), dtype=float)


def _require_few(values: int) -> None:
    if values > _MOST_VALUES:
        raise ValueError(f"it has {values} values, more than {_MOST_VALUES}")


def checked_rows(rows: tuple[tuple[float, ...], ...], name: str) -> np.ndarray:
    """Rows of equal length as an array."""
    if len({len(row) for row in rows}) != 1:
        raise ConfigError(f"{name}: its rows have different lengths")
    return np.array(rows, dtype=float)


def on_grid(values: np.ndarray) -> np.ndarray:
    """Rows as a viewer sees them (top first, from the left) as a grid over growing u, then v.

    Before a wall with v upward the viewer's left is +u.
    """
    return values[::-1, ::-1].T
