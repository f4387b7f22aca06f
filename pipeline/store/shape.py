"""The shape of a store: its arrays and coordinates, brought to size and committed at one stroke."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from zarr.api.asynchronous import create_array, open_array

from pipeline.store.chunks import COMPRESSOR
from pipeline.store.files import Files, RemoteFiles, files_in
from pipeline.store.folder import ROOT, Place, commit_metadata, read_json, write_json
from pipeline.store.together import together
from pipeline.store.variables import (
    BY_POINT,
    COORDINATES,
    RECORDS,
    Variable,
    note_versions,
    present_attributes,
    variables,
)
from pipeline.sweep.model import Sweep

__all__ = ["commit_shape"]

_GROWING = ("realization", "load", "velocity", "step")
_GROWING_CHUNK = 256  # of the coordinates along which a store grows
_FILL: dict[str, Any] = {"float64": np.nan, "str": ""}
_NAN = base64.b64encode(struct.pack("<d", np.nan)).decode()  # as xarray spells it in attributes


def commit_shape(
    folder: Place,
    attributes: dict[str, Any],
    arrays: dict[str, Any],
    axes: Mapping[str, list[float]],
    sweep: Sweep,
) -> None:
    """Bring arrays and coordinates to size; then commit that and the attributes at one stroke."""
    files = files_in(folder)
    with_fields = sweep.store_fields or "pressure" in arrays
    committed = json.dumps([attributes, arrays], sort_keys=True)
    is_old = bool(arrays)
    for name, variable in variables(bool(sweep.realizations), with_fields).items():
        if name in RECORDS and is_old and name not in arrays:
            continue  # its points lack it
        shape = [len(axes[dim]) for dim in variable.dims]
        if name not in arrays:
            arrays[name] = _create(folder / name, name, variable, shape)
        elif arrays[name]["shape"] != shape:
            arrays[name]["shape"] = shape
            write_json(folder / name / ROOT, arrays[name])
        else:
            continue
        if name in COORDINATES:
            together([_fill(files, name, axes[name])])
    files.sync()
    attributes |= present_attributes(sweep)
    note_versions(attributes)
    attributes["axes"] = {name: axes[name] for name in COORDINATES if name in arrays}
    if json.dumps([attributes, arrays], sort_keys=True) != committed:
        commit_metadata(folder, attributes, arrays)


async def _fill(files: Files | RemoteFiles, name: str, values: list[float]) -> None:
    array = await open_array(store=files, path=name, mode="r+")
    await array.setitem(slice(None), np.array(values))


def _create(folder: Place, name: str, variable: Variable, shape: list[int]) -> dict[str, Any]:
    """Create an array; return its metadata."""
    if name in COORDINATES:
        chunks = [_GROWING_CHUNK] if name in _GROWING else shape
    else:
        own = variable.dims.index("velocity") + 1  # the dimensions that choose a point
        chunks = [1] * own + shape[own:]
    attributes = {"long_name": variable.long_name, **variable.attributes}
    if variable.units is not None:
        attributes["units"] = variable.units
    if variable.dtype == "float64" and name not in COORDINATES:
        attributes["_FillValue"] = _NAN
    files = files_in(folder)  # of the array; given its name instead, Zarr would make the root, too
    creation = create_array(
        files,
        shape=tuple(shape),
        dtype=variable.dtype,
        chunks=tuple(chunks),
        compressors=[COMPRESSOR],
        fill_value=_FILL.get(variable.dtype, 0),
        chunk_key_encoding={"name": "default", "separator": BY_POINT},
        dimension_names=variable.dims,
        attributes=attributes,
        overwrite=True,
    )
    together([creation])
    files.sync()
    return read_json(folder / ROOT)
