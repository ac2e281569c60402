"""A dataset as the bytes of a NetCDF-4 file, and back.

Such a file is an HDF5 file whose dimensions are HDF5's dimension scales. xarray and h5netcdf read and write
it as well, but take some five times as long for a flight's sixty small signals. The file is made in memory:
the HDF5 library crashes the process when the disk is full in the middle of a file.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

if TYPE_CHECKING:
    import xarray as xr

_CHUNK = 4 * 2**20
"""Bytes of a variable that are compressed together, at most."""
_BARE = "This is a netCDF dimension but not a netCDF variable."
"""How the name of a scale begins that stands for a dimension without coordinates."""
_OF_THE_FORMAT = {
    *("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"),  # of HDF5's scales
    *("_NCProperties", "_Netcdf4Dimid", "_Netcdf4Coordinates", "_nc3_strict"),
}
"""Attributes that say how the file is built, not what it holds."""


def netcdf_bytes(dataset: xr.Dataset) -> bytes:
    """A NetCDF-4 file with the dataset, compressed; numbers keep every bit.

    Args:
        dataset: of numbers, booleans and strings.

    Raises:
        TypeError: for a variable that holds anything else.
    """
    image = io.BytesIO()
    with h5py.File(image, "w", track_order=True) as file:
        libraries = f"h5py={h5py.version.version},hdf5={h5py.version.hdf5_version}"
        file.attrs["_NCProperties"] = np.bytes_(f"version=2,{libraries}")
        _describe(file, dataset.attrs)
        aside = [str(name) for name in dataset.coords if name not in dataset.dims]
        if aside:
            file.attrs["coordinates"] = " ".join(aside)
        variables = {str(name): variable for name, variable in dataset.variables.items()}
        scales: dict[str, h5py.Dataset] = {}
        for number, (name, size) in enumerate(dataset.sizes.items()):
            dim, coordinate = str(name), variables.pop(str(name), None)
            if coordinate is None:
                scales[dim] = file.create_dataset(dim, (size,), ">f4", track_order=True)
                scales[dim].make_scale(f"{_BARE}{size:10}")
            else:
                scales[dim] = _create(file, dim, coordinate)
                scales[dim].make_scale(dim)
            scales[dim].attrs["_Netcdf4Dimid"] = np.int32(number)
        for name, variable in variables.items():
            stored = _create(file, name, variable)
            for axis, dim in enumerate(variable.dims):
                h5py.h5ds.attach_scale(stored.id, scales[str(dim)].id, axis)
    return image.getvalue()


def read_netcdf(source: Any, most: float) -> xr.Dataset:
    """The dataset that a NetCDF-4 file holds, whoever wrote it, in memory.

    Args:
        source: the file's path, or a stream of its bytes.
        most: bytes that it may unpack to.

    Raises:
        ValueError: when it is larger.
        Exception: whatever the damaged part of a file makes h5py or xarray raise.
    """
    import xarray

    with h5py.File(source, "r") as file:
        stored = {name: node for name, node in file.items() if isinstance(node, h5py.Dataset)}
        size = sum(node.nbytes for node in stored.values())
        if size > most:
            raise ValueError(f"it says that it unpacks to {1e-9 * size:.3g} GB, more than {1e-9 * most:g} GB")
        variables = {
            name: xarray.Variable(_dims(node, name), _values(node), _attributes(node))
            for name, node in stored.items()
            if not _is_bare(node)
        }
        raw = xarray.Dataset(variables, attrs=_attributes(file))
    log = xarray.decode_cf(raw, decode_times=False, decode_timedelta=False).load()
    return log.drop_encoding()


def _create(file: h5py.File, name: str, variable: xr.Variable) -> h5py.Dataset:
    values, how = _stored(name, np.asarray(variable.values))
    stored = file.create_dataset(name, data=values, track_order=True, **how)
    _describe(stored, variable.attrs)
    if variable.dtype.kind == "b":  # NetCDF has no booleans; xarray reads this mark
        stored.attrs["dtype"] = "bool"
    return stored


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


def _describe(node: h5py.File | h5py.Dataset, attributes: Any) -> None:
    """Give a node attributes as NetCDF has them: words, and arrays of numbers or words, but no booleans."""
    for name, value in attributes.items():
        array = np.atleast_1d(value)
        plain = array.astype(np.int8) if array.dtype.kind == "b" else array
        node.attrs[str(name)] = value if array.dtype.kind == "U" else plain


def _values(node: h5py.Dataset) -> np.ndarray:
    text = h5py.check_string_dtype(node.dtype)
    return np.asarray(node.asstr()[...]).astype(str) if text and text.length is None else node[...]


def _is_bare(node: h5py.Dataset) -> bool:
    """Whether it stands for a dimension alone."""
    return h5py.h5ds.is_scale(node.id) and h5py.h5ds.get_scale_name(node.id).startswith(_BARE.encode())


def _dims(node: h5py.Dataset, name: str) -> tuple[str, ...]:
    """Its dimensions by name; a scale is its own."""
    if h5py.h5ds.is_scale(node.id):
        return (name,)
    scales: Any = node.attrs["DIMENSION_LIST"] if node.ndim else ()
    return tuple(h5py.h5r.get_name(attached[-1], node.id).decode().removeprefix("/") for attached in scales)


def _attributes(node: h5py.File | h5py.Dataset) -> dict[str, Any]:
    """Attributes as Python has them: HDF5 hands numbers back as arrays, and words of C as bytes."""
    found = {}
    # Those that are not wanted are not read: references are slow.
    for name in (one for one in node.attrs if one not in _OF_THE_FORMAT):
        value = node.attrs[name]
        array = np.atleast_1d("" if isinstance(value, h5py.Empty) else np.asarray(value))
        words = [entry.decode() if isinstance(entry, bytes) else entry for entry in array.tolist()]
        found[name] = words[0] if len(words) == 1 else words
    return found
