"""Layout of a store: its axes and arrays, their chunks, and the files that these take."""

from __future__ import annotations

import functools
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
    PLANE,
    POINT,
    SCENE_ID,
    STEPPED,
    Variable,
    attributes_of,
    is_coordinate,
    is_of_points,
    path_of,
    variables_of,
)
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points as points_of
from pipeline.sweep.station_choice import choose_stations
from pipeline.sweep.stations import ramp_of
from pipeline.sweep.variants import Variant, combinations, in_order
from tribo import QUANTILES
from tribo.thermal import BULK_RATIOS
from tribo.types import Array, Mask

Slices = tuple[slice, ...]

_LARGEST = 2**22  # bytes of a chunk
_FEWEST, _MOST = 64, 1024  # points in a chunk
_GROWING = 4096  # entries in a chunk of a coordinate that grows
_ROOM = 2  # reference loads up to which a course has room for its steps


def block_of(sizes: Mapping[str, int], bytes_of_a_point: int) -> dict[str, int]:
    """Points in a chunk along each dimension: some hundred, fewer where they are large.

    All loads, which one ramp computes, then neighbouring velocities, then surfaces or samples.
    Points of a search lie one after the other.
    """
    room = min(max(_LARGEST // bytes_of_a_point, _FEWEST), _MOST)
    if POINT in sizes:
        return {POINT: room}
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


Axes = dict[str, list[Any]]
"""Values along each dimension, and of coordinates along another one."""


def grown_axes(before: Axes, kept: Sweep, sweep: Sweep) -> Axes:
    """Axes of a store: those that it had before, and what a sweep adds, ascending.

    `kept` is the sweep of the store with the rows of both.
    """
    loads, velocities = sweep.plane.loads, sweep.plane.velocities
    if sweep.chosen is not None:
        return _listed_axes(before, kept, sweep)
    values = {"load": loads, "velocity": velocities}
    plane = {name: in_order([*before.get(name, ()), *added]) for name, added in values.items()}
    return {**plane, **row_axes(kept), **_inner_axes(before, kept, loads)}


def _listed_axes(before: Axes, kept: Sweep, sweep: Sweep) -> Axes:
    """Axes of points that a search has chosen: those there before, then the others."""
    rows = dict.fromkeys([*(listed_points(kept, before) if before else ()), *points_of(sweep)])
    names = [dict(point.variant) for point in rows]
    followers = {
        column.name: [values[name[column.along]] for name in names]
        for column, values in kept.variants.coordinates.items()
    }
    return {
        POINT: [*range(len(rows))],
        "load": [point.load for point in rows],
        "velocity": [point.velocity for point in rows],
        **{dim: [name[dim] for name in names] for dim in kept.variants.axes},
        **followers,
        **_inner_axes(before, kept, sweep.plane.loads),
    }


def row_axes(sweep: Sweep) -> Axes:
    """Dimensions of the rows of a sweep, ascending, and the columns that follow from them."""
    axes: Axes = {name: in_order(values) for name, values in sweep.variants.axes.items()}
    followers = sweep.variants.coordinates.items()
    return axes | {
        column.name: [values[label] for label in axes[column.along]] for column, values in followers
    }


def _inner_axes(before: Axes, kept: Sweep, loads: Sequence[float]) -> Axes:
    """Dimensions within a point; that of steps has room, since it cannot grow at its lower end."""
    scenes = [kept.variant(name).scene for name in kept.variants.given]
    stations = choose_stations(kept)
    ramps = {ramp_of(scene): scene for scene in scenes}.values()
    steps = max(len(stations.kept(scene, load)) for scene in ramps for load in loads)
    if stations.steps == "course" and not before:
        steps = max(steps, _ROOM * kept.scene.fidelity.increments + 1)
    return {
        "step": [*range(1 - max(steps, len(before.get("step", ()))), 1)],
        "cooler_share": [*QUANTILES],
        "bulk_ratio": [*BULK_RATIOS],
        "x": scenes[0].grid.coordinates(0).tolist(),
        "y": scenes[0].grid.coordinates(1).tolist(),
    }


def listed_points(sweep: Sweep, axes: Axes) -> list[Point]:
    """Points of a search, in the order of its store."""
    names = [*sweep.variants.axes]
    columns = (axes[name] for name in ("load", "velocity", *names))
    return [
        Point(load, velocity, tuple(zip(names, labels, strict=True)))
        for load, velocity, *labels in zip(*columns, strict=True)
    ]


def made_coordinates(sweep: Sweep, axes: Axes) -> dict[str, Array]:
    """Time, load and distance at each step, by the dimensions that `variables_of` names.

    NaN before a point's first step.
    """
    wanted, stations = variables_of(sweep), choose_stations(sweep)
    dims, steps = wanted["time"].dims, len(axes["step"])

    @functools.cache
    def known(name: Variant, load: float) -> list[tuple[float, float]]:
        kept = stations.kept(sweep.variant(name).scene, load)
        lacking = [(math.nan, math.nan)] * (steps - len(kept))
        return lacking + [(step.time, step.normal_load) for step in kept]

    values = np.array([known(*place) for place in _ramps(sweep, axes, dims)])
    sizes = (len(axes[dim]) for dim in dims)
    time, normal_load = np.moveaxis(values, -1, 0).reshape(2, *sizes)
    speeds: Any = xr.Variable(wanted["velocity"].dims, np.abs(axes["velocity"]))
    whole = {dim: len(axes[dim]) for dim in wanted["sliding_distance"].dims}
    distance = (speeds * xr.Variable(dims, time)).set_dims(whole).values
    return {"time": time, "normal_load": normal_load, "sliding_distance": distance}


def spread_ids(sweep: Sweep, axes: Axes, ids: Sequence[int]) -> Array:
    """Id of the scene of each point, by those of the rows of a sweep."""
    by_row = dict(zip(sweep.variants.names, ids, strict=True))
    if POINT in axes:
        return np.array([by_row[point.variant] for point in listed_points(sweep, axes)], np.int32)
    dims = variables_of(sweep)[SCENE_ID].dims
    rows = combinations({dim: axes[dim] for dim in sweep.variants.axes})
    inner = [len(axes[dim]) for dim in dims if dim not in sweep.variants.axes]
    outer = [len(axes[dim]) for dim in sweep.variants.axes]
    values = np.array([by_row[row] for row in rows], np.int32).reshape(*outer, *[1] * len(inner))
    return np.broadcast_to(values, (*outer, *inner))


def _ramps(sweep: Sweep, axes: Axes, dims: Sequence[str]) -> Iterator[tuple[Variant, float]]:
    """Variant and load of each ramp along dimensions that end with the step."""
    if POINT in dims:
        yield from ((point.variant, point.load) for point in listed_points(sweep, axes))
        return
    for name in combinations({dim: axes[dim] for dim in dims if dim not in ("load", "step")}):
        is_shared = "load" in dims
        loads = axes["load"] if is_shared else sweep.variants.plane_of(name, (), ())[0]
        yield from ((name, load) for load in loads)


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
        if variable.dims == (name,) and is_of_points(name):
            chunks[name] = _GROWING
        elif name in AT_END:
            chunks |= {dim: 1 for dim in variable.dims if is_of_points(dim)}
        is_real = variable.dtype.startswith("float")
        array = group.create_array(
            path_of(name),
            shape=shape,
            chunks=tuple(chunks[dim] for dim in variable.dims),
            dtype=str if variable.dtype == "str" else variable.dtype,
            fill_value="" if variable.dtype == "str" else np.nan if is_real else 0,
            compressors=ZstdCodec(**COMPRESSION),
            dimension_names=variable.dims,
            attributes=attributes_of(variable),
            chunk_key_encoding={"name": "default", "separator": "."},
        )
        if is_coordinate(name):
            array[:] = np.array(axes[name], variable.dtype)
    memory.pop(ROOT)
    contents = {key: content.to_bytes() for key, content in memory.items()}
    return contents, {name: json.loads(contents[f"{path_of(name)}/{ROOT}"]) for name in wanted}


def arrays_of(place: StorePlace, metadata: Mapping[str, Any], read_only: bool) -> dict[str, Any]:
    """Open the arrays of a store by the metadata of its root, which may have changed since."""
    store = place.zarr(read_only)
    arrays = bounded(metadata)
    # A chunk of nothing but fill values that is not written looks like one that was lost. Zarr's
    # own setting of this belongs to all threads, and one that ends would change it for another.
    opened = {
        name: zarr.AsyncArray(array, StorePath(store, path_of(name)), {"write_empty_chunks": True})
        for name, array in arrays.items()
    }
    return {name: zarr.Array(array) for name, array in opened.items()}


def bounded(metadata: Mapping[str, Any]) -> dict[str, Any]:
    """Metadata of arrays that unpack no chunk of another size than they say."""
    codec = BoundedZstd(**COMPRESSION)
    return {
        name: {**array, "codecs": [array["codecs"][0], codec]} for name, array in metadata.items()
    }


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
    return f"{path_of(name)}/" + ".".join(map(str, ("c", *numbers)))


def field_key(name: str, index: Sequence[int]) -> str:
    """Key of the one chunk of a field at a point, by its place."""
    return chunk_key(name, (*index, 0, 0))
