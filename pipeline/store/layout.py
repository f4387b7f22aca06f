"""Layout of a store: values along its axes, coordinates that follow from them, and its chunks."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pipeline.store.schema import PLANE, Variable, is_of_points
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import choose_stations
from pipeline.sweep.points_of_tests import TEST_POINT
from pipeline.sweep.stations import ramp_of
from pipeline.sweep.variants import Variant, in_order
from tribo import QUANTILES
from tribo.thermal import BULK_RATIOS
from tribo.types import Array, Indices, Mask

Axes = dict[str, list[Any]]
"""Values along each dimension, and values of coordinates that lie along another dimension."""
Slices = tuple[slice, ...]

_LARGEST = 2**22  # bytes of a chunk
_FEWEST, _MOST = 1, 1024  # points in a chunk
# Fewest points in a chunk along dimensions to which later runs add points.
_LEAST = {"velocity": 16}
_ROOM = 2  # multiple of the reference load up to which all steps of a ramp have room


def chunk_sizes(sizes: Mapping[str, int], bytes_of_a_point: int) -> dict[str, int]:
    """Number of points in a chunk along each dimension; at most 1024 in total.

    They are fewer if points are large. `sizes` are the lengths of the dimensions, and
    `bytes_of_a_point` is for the largest variable. A chunk has all loads, since one ramp computes
    them, then neighbouring velocities, then surfaces.
    """
    room, block = min(max(_LARGEST // bytes_of_a_point, _FEWEST), _MOST), dict[str, int]()
    for name in sorted(sizes, key=lambda name: (name != "load", name != "velocity")):
        most = max(sizes[name], _LEAST.get(name, 1))
        block[name] = max(1, min(most, room // math.prod(block.values())))
    return block


def bytes_of_a_point(wanted: Iterable[Variable], axes: Axes) -> int:
    """Bytes of a point in the largest of the variables `wanted`, at 8 bytes a value."""
    return max(
        8 * math.prod(len(axes[dim]) for dim in variable.dims if not is_of_points(dim))
        for variable in wanted
    )


def grown_axes(before: Axes, kept: Sweep, sweep: Sweep) -> Axes:
    """Axes of a store that grows: the values `before`, and those that `sweep` adds.

    `kept` is the sweep in the store joined with `sweep`, so that it has old and new variants.
    """
    values = {"load": sweep.loads, "velocity": sweep.velocities}
    plane = {name: in_order([*before.get(name, ()), *added]) for name, added in values.items()}
    rows = {name: in_order(values) for name, values in kept.variants.axes.items()}
    # A column that a dimension determines has a value for each of its labels, in the same order.
    rows |= {
        column.name: [values[label] for label in rows[column.along]]
        for column, values in kept.variants.coordinates.items()
    }
    scenes = [case.scene for case in kept._given]
    stations, steps = choose_stations(kept), len(before.get("step", ()))
    if TEST_POINT not in rows:  # the layout of tests has room for their steps
        ramps = {ramp_of(scene): scene for scene in scenes}.values()
        loads = [*itertools.product(ramps, sweep.loads)]
        steps = max(steps, *(len(stations.kept(scene, load)) for scene, load in loads))
    if stations.steps == "course" and not before:
        steps = max(steps, _ROOM * kept.scene.fidelity.increments + 1)
    return {
        **plane,
        **rows,
        "step": [*range(1 - steps, 1)],
        "cooler_share": [*QUANTILES],
        "bulk_ratio": [*BULK_RATIOS],
        "x": scenes[0].grid.coordinates(0).tolist(),
        "y": scenes[0].grid.coordinates(1).tolist(),
    }


def points_at(
    sweep: Sweep, axes: Axes, wanted: Mapping[str, Variable], where: Sequence[Indices]
) -> list[Point]:
    """Points at some indices of the variable ``status``.

    `where` has an array of indices for each dimension of ``status``, as `np.nonzero` gives; the
    arrays are taken elementwise. `wanted` has the store's variables by name.
    """
    dims, names, columns = wanted["status"].dims, [*PLANE, *sweep.variants.axes], []
    for name in names:
        numbers = where[dims.index(wanted[name].dims[0])]
        columns.append([axes[name][number] for number in numbers.tolist()])
    return [
        Point(load, velocity, tuple(zip(names[2:], labels, strict=True)))
        for load, velocity, *labels in zip(*columns, strict=True)
    ]


def points_on(
    sweep: Sweep, axes: Axes, wanted: Mapping[str, Variable], dims: Sequence[str]
) -> list[Point]:
    """Points at every index along `dims`, and at the first index along all other dimensions.

    `wanted` has the store's variables.
    """
    sizes = [len(axes[dim]) if dim in dims else 1 for dim in wanted["status"].dims]
    return points_at(sweep, axes, wanted, np.nonzero(np.ones(sizes)))


def made_coordinates(sweep: Sweep, axes: Axes, wanted: Mapping[str, Variable]) -> dict[str, Array]:
    """Compute the coordinates that follow from the scene, and return their values by name.

    They are time [s], load [N] and sliding distance [m] at each step. Values are
    NaN at unused steps before the first step of a point. `axes` has the values along each dimension
    of the store. `wanted` has the store's variables by name, with the dimensions of each result.
    `ids` are the scene ids of the sweep's variants, in the order of the table.
    """
    stations, dims = choose_stations(sweep), wanted["time"].dims

    @functools.cache
    def known(name: Variant, load: float, velocity: float | None) -> list[Any]:
        kept = stations.kept(sweep.case(name).scene, load, velocity)
        lacking = [(math.nan,) * 3] * (len(axes["step"]) - len(kept))
        slid = [math.nan if one.slid is None else one.slid for one in kept]
        steps = zip(kept, slid, strict=True)
        return lacking + [(step.time, step.normal_load, way) for step, way in steps]

    def along(dims: Sequence[str], values: Any) -> Any:
        return xr.Variable(dims, np.reshape(values, [len(axes[dim]) for dim in dims]))

    own = TEST_POINT in axes  # a test may have stages of velocity
    ramps = [
        known(point.variant, point.load, point.velocity if own else None)
        for point in points_on(sweep, axes, wanted, dims)
    ]
    time, normal_load, way = (along(dims, one) for one in np.moveaxis(np.array(ramps), -1, 0))
    speed: Any = xr.Variable(wanted["velocity"].dims, np.abs(axes["velocity"]))
    made = {
        "time": time,
        "normal_load": normal_load,
        "sliding_distance": way.where(way.notnull(), speed * time) if own else speed * time,
    }
    sizes = {name: {dim: len(axes[dim]) for dim in wanted[name].dims} for name in made}
    return {name: array.set_dims(sizes[name]).values for name, array in made.items()}


def blocks(mask: Mask, sizes: Sequence[int]) -> Iterator[tuple[tuple[int, ...], Slices]]:
    """Yield index and slices of each chunk with at least one point where `mask` is True.

    `sizes` are the numbers of points in a chunk along each dimension.
    """
    for chunk in np.ndindex(*(-(-n // size) for n, size in zip(mask.shape, sizes, strict=True))):
        if mask[block := slices_of(chunk, sizes)].any():
            yield chunk, block


def slices_of(chunk: Sequence[int], sizes: Sequence[int]) -> Slices:
    """Slices of the chunk with indices `chunk`, if chunks have `sizes` along the dimensions."""
    return tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, sizes, strict=True))


def parts_of(block: Slices, sizes: Sequence[int]) -> Iterator[Slices]:
    """Yield slices of the parts into which chunks of other `sizes` cut a `block`."""
    cuts = [
        [part.start, *range((part.start // n + 1) * n, part.stop, n), part.stop]
        for part, n in zip(block, sizes, strict=True)
    ]
    yield from itertools.product(*([slice(*ends) for ends in itertools.pairwise(c)] for c in cuts))
