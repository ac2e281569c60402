"""A dataset as the bytes of a NetCDF-4 file.

xarray reads such files, and could write them, but takes longer for a flight's sixty small signals than
h5netcdf by itself. The file is made in memory: the HDF5 library crashes the process when the disk is full in
the middle of a file.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import h5netcdf
import h5py
import numpy as np

if TYPE_CHECKING:
    import xarray as xr

_CHUNK = 4 * 2**20
"""Bytes of a variable that are compressed together, at most."""


def netcdf_bytes(dataset: xr.Dataset) -> bytes:
    """A NetCDF-4 file with the dataset, compressed; numbers keep every bit.

    Args:
        dataset: of numbers, booleans and strings.

    Raises:
        TypeError: for a variable that holds anything else.
    """
    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        file.dimensions = dict(dataset.sizes)
        file.attrs.update(_plain(dataset.attrs))
        aside = [str(name) for name in dataset.coords if name not in dataset.dims]
        if aside:
            file.attrs["coordinates"] = " ".join(aside)
        for name, variable in dataset.variables.items():
            values, how = _stored(str(name), np.asarray(variable.values))
            stored = file.create_variable(str(name), variable.dims, data=values, **how)
            stored.attrs.update(_plain(variable.attrs))
            if variable.dtype.kind == "b":  # NetCDF has no booleans; xarray reads this mark
                stored.attrs["dtype"] = "bool"
    return image.getvalue()


def _stored(name: str, values: np.ndarray) -> tuple[np.ndarray, dict[str, Any]]:
    """An array of a kind that NetCDF has, and how it is stored."""
    kind = values.dtype.kind
    if kind in "UO" and all(isinstance(entry, str) for entry in values.ravel()):
        return values.astype(object), {"dtype": h5py.string_dtype()}
    if kind not in "fiub":
        raise TypeError(f"variable '{name}' holds {values.dtype}; a record has numbers, booleans and strings")
    values = values.astype(np.int8) if kind == "b" else values
    if not values.ndim or not values.size:
        return values, {}
    rows = max(1, min(len(values), _CHUNK * len(values) // values.nbytes))
    packed = {"shuffle": True, "compression": "gzip", "compression_opts": 1}
    return values, {"chunks": (rows, *values.shape[1:]), **packed}


def _plain(attributes: Any) -> dict[str, Any]:
    """Attributes as NetCDF has them: words, numbers, and lists of either, but no booleans."""
    return {
        str(name): np.asarray(value, dtype=np.int8) if np.asarray(value).dtype.kind == "b" else value
        for name, value in attributes.items()
    }
