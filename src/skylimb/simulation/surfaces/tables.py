"""Rows and columns of numbers from images and files, as height maps and friction maps use them."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from skylimb.base.errors import ConfigError, missing_extra
from skylimb.base.sources import Source, read_source

_IMAGES = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"}
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
            return np.asarray(np.load(content, allow_pickle=False), dtype=float)
        if suffix in _NUMBERS:
            return np.loadtxt(content, delimiter="," if suffix == ".csv" else None, ndmin=2)
        try:
            from PIL import Image
        except ImportError:
            raise missing_extra("PIL") from None
        with Image.open(content) as image:
            # "I" keeps the 16 bits of a deep image, which "L" would cut to 8.
            deep = image.mode.startswith("I")
            values = np.asarray(image.convert("I" if deep else "L"), dtype=float)
            return values / (65535.0 if deep else 255.0)
    except (OSError, ValueError) as error:
        raise ConfigError(f"{name}: cannot be read: {str(error).splitlines()[0]}") from error


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
