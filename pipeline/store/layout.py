"""Layout of a store: its axes and arrays, their chunks, and the files that these take."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
import zarr
from zarr.codecs import ZstdCodec
from zarr.storage import MemoryStore, StorePath

from pipeline.store.bounded import BoundedZstd
from pipeline.store.place import ROOT, StorePlace
from pipeline.store.schema import (
    AT_END,
    COMPRESSION,
    MADE,
    PLANE,
    STEPPED,
    Variable,
    is_coordinate,
    is_of_points,
    variables_of,
)
from pipeline.sweep.model import Plane, Sweep
from pipeline.sweep.station_choice import choose_stations
from pipeline.sweep.stations import ramp_of
from pipeline.sweep.variants import combinations
from tribo import QUANTILES
from tribo.thermal import BULK_RATIOS
from tribo.types import Array, Mask

Slices = tuple[slice, ...]

_LARGEST = 2**22  # bytes of a chunk
_FEWEST, _MOST = 64, 1024  # points in a chunk
_GROWING = 4096  # entries in a chunk of a coordinate that grows


def block_of(sizes: Mapping[str, int], bytes_of_a_point: int) -> dict[str, int]:
    """Points in a chunk along each dimension: some hundred, fewer where they are large.

    All loads, which one ramp computes, then neighbouring velocities, then surfaces or samples.
    """
    room = min(max(_LARGEST // bytes_of_a_point, _FEWEST), _MOST)
    block = dict.fromkeys(sizes, 1)
    if "load" in sizes:
        block["load"] = min(sizes["load"], room)
    if "velocity" in sizes:  # to which a search adds others later
        block["velocity"] = max(1, min(max(sizes["velocity"], 16), room // block.get("load", 1)))
    for name in sizes:
        if name not in PLANE:
            block[name] = max(1, min(sizes[name], room // math.prod(block.values())))
    return block


def bytes_of_a_point(wanted: Mapping[str, Variable], axes: Mapping[str, list[float]]) -> int:
    """Size of a point in the largest variable whose chunks hold several points [B]."""
    return max(
        8 * math.prod(len(axes[dim]) for dim in variable.dims if not is_of_points(dim))
        for name, variable in wanted.items()
        if name in STEPPED
    )


def grown_axes(axes: Mapping[str, list[Any]], kept: Sweep, plane: Plane) -> dict[str, list[Any]]:
    """Values along each dimension: those of a store, and what its sweep and a plane add, ascending.

    The sweep has all rows of the store.
    """
    table = kept.variants
    scenes = [kept.variant(name).scene for name in table.given]
    stations = choose_stations(kept)
    ramps = {ramp_of(scene): scene for scene in scenes}.values()
    steps = max(len(stations.kept(scene, load)) for scene in ramps for load in plane.loads)
    velocities = plane.velocities
    if plane.chosen is not None:
        velocities = tuple(point.velocity for point in plane.chosen)
    places = {"velocity": velocities, "load": plane.loads}
    return (
        {name: [*values] for name, values in table.axes.items()}
        | {name: sorted({*axes.get(name, ()), *values}) for name, values in places.items()}
        | {column.name: [*values.values()] for column, values in table.coordinates.items()}
        | {
            "step": list(range(1 - max(steps, len(axes.get("step", []))), 1)),
            "cooler_share": list(QUANTILES),
            "bulk_ratio": list(BULK_RATIOS),
            "x": scenes[0].grid.coordinates(0).tolist(),
            "y": scenes[0].grid.coordinates(1).tolist(),
        }
    )


def made_coordinates(sweep: Sweep, axes: Mapping[str, Sequence[Any]]) -> dict[str, Array]:
    """Time, load and distance at each step, by the dimensions that `variables_of` names.

    NaN before a point's first step.
    """
    wanted, stations = variables_of(sweep), choose_stations(sweep)
    dims, steps = wanted["time"].dims, len(axes["step"])
    rows = [dim for dim in dims if dim not in ("load", "step")]
    known = []
    for name in combinations({dim: axes[dim] for dim in rows}):
        scene, loads = sweep.variant(name).scene, axes["load"]
        if "load" not in dims:
            loads, _ = sweep.variants.plane_of(name, (), ())
        for load in loads:
            kept = [(step.time, step.normal_load) for step in stations.kept(scene, load)]
            known.append([(np.nan, np.nan)] * (steps - len(kept)) + kept)
    time, normal_load = np.moveaxis(np.array(known), -1, 0).reshape(
        2, *(len(axes[dim]) for dim in dims)
    )
    speeds: Any = xr.Variable(wanted["velocity"].dims, np.abs(axes["velocity"]))
    whole = {dim: len(axes[dim]) for dim in wanted["sliding_distance"].dims}
    distance = (speeds * xr.Variable(dims, time)).set_dims(whole).values
    return {"time": time, "normal_load": normal_load, "sliding_distance": distance}


def documents(
    wanted: Mapping[str, Variable], axes: Mapping[str, Any], block: Mapping[str, int]
) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Documents and coordinates of a store by key, as Zarr writes them, and metadata by array.

    They follow from the values along each dimension and the points in a chunk along it.
    """
    memory: dict[str, Any] = {}
    group = zarr.open_group(MemoryStore(memory), mode="w")
    for name, variable in wanted.items():
        shape = [len(axes[dim]) for dim in variable.dims]
        chunks = {**dict(zip(variable.dims, shape, strict=True)), **block}
        if is_coordinate(name) and name not in MADE:  # which are as large as those of points
            chunks |= {dim: _GROWING for dim in variable.dims if is_of_points(dim)}
        elif name in AT_END:
            chunks |= {dim: 1 for dim in variable.dims if is_of_points(dim)}
        is_real = variable.dtype.startswith("float")
        units = {} if variable.units is None else {"units": variable.units}
        array = group.create_array(
            name,
            shape=shape,
            chunks=tuple(chunks[dim] for dim in variable.dims),
            dtype=str if variable.dtype == "str" else variable.dtype,
            fill_value="" if variable.dtype == "str" else np.nan if is_real else 0,
            compressors=ZstdCodec(**COMPRESSION),
            dimension_names=variable.dims,
            attributes={"long_name": variable.long_name, **units, **variable.attributes},
            chunk_key_encoding={"name": "default", "separator": "."},
        )
        if is_coordinate(name):
            array[:] = np.array(axes[name], variable.dtype)
    memory.pop(ROOT)
    contents = {key: content.to_bytes() for key, content in memory.items()}
    return contents, {name: json.loads(contents[f"{name}/{ROOT}"]) for name in wanted}


def arrays_of(place: StorePlace, metadata: Mapping[str, Any], read_only: bool) -> dict[str, Any]:
    """Open the arrays of a store by the metadata of its root, which may have changed since."""
    store = place.zarr(read_only)
    codec = BoundedZstd(**COMPRESSION)
    arrays: dict[str, Any] = {
        name: {**array, "codecs": [array["codecs"][0], codec]} for name, array in metadata.items()
    }
    # A chunk of nothing but fill values that is not written looks like one that was lost. Zarr's
    # own setting of this belongs to all threads, and one that ends would change it for another.
    opened = {
        name: zarr.AsyncArray(array, StorePath(store, name), {"write_empty_chunks": True})
        for name, array in arrays.items()
    }
    return {name: zarr.Array(array) for name, array in opened.items()}


def blocks(mask: Mask, sizes: Sequence[int]) -> Iterator[tuple[tuple[int, ...], Slices]]:
    """Numbers and slices of the chunks of these sizes that hold any point of a mask."""
    for numbers in np.ndindex(*(-(-n // size) for n, size in zip(mask.shape, sizes, strict=True))):
        if mask[block := slices_of(numbers, sizes)].any():
            yield numbers, block


def slices_of(numbers: Sequence[int], sizes: Sequence[int]) -> Slices:
    """Slices of a chunk of these sizes by its numbers."""
    return tuple(slice(i * n, (i + 1) * n) for i, n in zip(numbers, sizes, strict=True))


def chunk_key(name: str, numbers: Sequence[int]) -> str:
    """Key of a chunk of an array, such as ``time/c.0.2.0``."""
    return f"{name}/" + ".".join(map(str, ("c", *numbers)))


def chunk_numbers(file: str) -> tuple[int, ...]:
    """Numbers of a chunk by the name of its file; none if it is no chunk."""
    first, *numbers = file.split(".")
    is_chunk = first == "c" and all(number.isdigit() for number in numbers)
    return tuple(map(int, numbers)) if is_chunk else ()


def field_key(name: str, index: Sequence[int]) -> str:
    """Key of the one chunk of a field at a point, by its place."""
    return chunk_key(name, (*index, 0, 0))
