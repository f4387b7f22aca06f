"""The shape of a store: its arrays and coordinates, brought to size and committed at one stroke."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from pipeline.store.chunks import ChunkedArray, chunks_of
from pipeline.store.files import files_in
from pipeline.store.folder import ROOT, Place, as_json
from pipeline.store.layout import codecs_of, data_type_of, in_chunks, new_chunks
from pipeline.store.root import commit_metadata
from pipeline.store.variables import (
    BY_POINT,
    COORDINATES,
    POINTS_PER_CHUNK,
    PRESENT,
    RECORDS,
    Variable,
    is_coordinate,
    note_versions,
    present_attributes,
    variables,
)
from pipeline.sweep.model import Sweep

_FILL: dict[str, Any] = {"float64": "NaN", "str": ""}
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
    changed: list[str] = []
    present = attributes.get("axes", {})
    leading, _ = sweep.axis or (None, ())
    units = {each.path: each.unit for each in sweep.samples.unknown} if sweep.samples else {}
    wanted = variables(leading, with_fields, sweep.unequal_bulks, units)
    for name in [name for name in arrays if is_coordinate(name) and name not in wanted]:
        if "." in name:  # an input that is known now, and did not count in the simulation
            del arrays[name]
    for name, variable in wanted.items():
        if name in RECORDS and is_old and name not in arrays:
            continue  # its points lack it
        shape = [len(axes[dim]) for dim in variable.dims]
        if name not in arrays:
            arrays[name] = _described(name, variable, shape, attributes.get(POINTS_PER_CHUNK))
        elif arrays[name]["shape"] == shape and not (
            name in units and present.get(name) != axes[name]
        ):
            continue
        arrays[name]["shape"] = shape
        changed.append(name)
    files.make_folders(changed)
    files.put_all((f"{name}/{ROOT}", as_json(arrays[name])) for name in changed)
    coordinates = [name for name in changed if is_coordinate(name)]
    files.put_all(coordinate_chunks(arrays, axes, coordinates))
    for name in PRESENT:
        attributes.pop(name, None)
    attributes |= present_attributes(sweep, attributes["format"])
    note_versions(attributes)
    attributes["axes"] = {name: axes[name] for name in [*COORDINATES, *units] if name in arrays}
    if json.dumps([attributes, arrays], sort_keys=True) != committed:
        commit_metadata(folder, attributes, arrays)


def coordinate_chunks(
    arrays: Mapping[str, Any], axes: Mapping[str, list[float]], names: Iterable[str]
) -> Iterable[tuple[str, bytes]]:
    """The files with the values of coordinates."""
    for name in names:
        yield from chunks_of(ChunkedArray.of(name, arrays[name]), (), axes[name])


def _described(
    name: str, variable: Variable, shape: list[int], block: list[int] | None
) -> dict[str, Any]:
    """Metadata of a new array, as Zarr writes them."""
    attributes = {"long_name": variable.long_name, **variable.attributes}
    if variable.units is not None:
        attributes["units"] = variable.units
    if variable.dtype == "float64" and not is_coordinate(name):
        attributes["_FillValue"] = _NAN
    chunks = new_chunks(name, variable, shape, block)
    return {
        "shape": shape,
        "data_type": data_type_of(variable),
        **in_chunks(chunks, BY_POINT),
        "fill_value": _FILL.get(variable.dtype, 0),
        "codecs": codecs_of(variable),
        "attributes": attributes,
        "dimension_names": list(variable.dims),
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    }
