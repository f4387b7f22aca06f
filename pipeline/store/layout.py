"""Layout of a group of points, derived from its sweep: axes, variables and chunks."""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.store.arrays import Document, array_document
from pipeline.store.schema import (
    DIM,
    FIELD_REALIZATION,
    FIELDS,
    INPUTS,
    OF_FIELDS,
    PLANE,
    TEST_STEP,
    Variable,
    inputs_variable,
    is_coordinate,
    is_in_fields,
    is_of_points,
    path_of,
    variables_of,
)
from pipeline.sweep.case import TEST
from pipeline.sweep.case_table import in_order
from pipeline.sweep.plan import choose_stored_steps
from pipeline.sweep.points_of_tests import NO_TEST
from pipeline.sweep.stored_steps import ramp_of
from pipeline.sweep.sweep import Point, Sweep
from tribo import QUANTILES
from tribo.types import Array, Indices, Mask

Axes = dict[str, list[Any]]
"""Values along each dimension, and of coordinates along another dimension."""
Slices = tuple[slice, ...]

_OF_POINT = ("message", "warning_flags")  # also stored for failed points
_MAX_BYTES, _MAX_POINTS = 2**22, 1024  # limits of a chunk


@dataclass(frozen=True, eq=False)
class Group:
    """The points of a plane or of tests; all properties are derived from the sweep.

    `prefix` is the path of the group in the store with a slash at the end, empty for the plane.
    `inputs` has the arrays read from the scene's files, by SHA-256.
    """

    sweep: Sweep
    inputs: Mapping[str, Array] = field(default_factory=dict)
    prefix: str = ""
    growths: int = 0  # how often the store replaced a smaller one
    field_growths: int = 0  # how often its fields did; more realizations leave them as they are

    @property
    def step(self) -> str:
        """Name of the dimension of steps."""
        return TEST_STEP if self.prefix else "step"

    @cached_property
    def axes(self) -> Axes:
        """Values along each dimension, and of columns of the case table."""
        sweep, stored_steps = self.sweep, choose_stored_steps(self.sweep)
        rows = {name: in_order(values) for name, values in sweep.case_table.axes.items()}
        # A column along a dimension has a value for each label of it, in the same order.
        rows |= {
            column.name: [values[label] for label in rows[column.along]]
            for column, values in sweep.case_table.coordinates.items()
        }
        scenes = [case.scene for case in sweep._on_first_surface]
        if self.prefix:
            steps_of_points = (
                stored_steps.select(sweep.case(name).scene, load) for load, _, name in self._points
            )
        else:
            ramps = {ramp_of(scene): scene for scene in scenes}.values()
            steps_of_points = (
                stored_steps.select(*labels) for labels in itertools.product(ramps, sweep.loads)
            )
        values: dict[str, Any] = {
            "load": [*sweep.loads],
            "velocity": [*sweep.velocities],
            **rows,
            self.step: [*range(1 - max(map(len, steps_of_points)), 1)],
            "area_fraction_below": [*QUANTILES],
            "x": scenes[0].grid.coordinates(0).tolist(),
            "y": scenes[0].grid.coordinates(1).tolist(),
        }
        return {name: labels for name, labels in values.items() if name in variables_of(sweep)}

    @cached_property
    def _points(self) -> list[Point]:
        """Points of a group of tests: each row of the case table has a load and a velocity."""
        return [
            Point(float(row["load"]), float(row["velocity"]), name)
            for name, row in self.sweep.case_table.by_name.items()
        ]

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """Variables of the group by name."""
        return variables_of(self.sweep) | inputs_variable(sizes_of(self.inputs))

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions."""
        lengths = {name: len(values) for name, values in self.axes.items()}
        lengths[DIM] = sum(sizes_of(self.inputs).values())
        return lengths

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the points."""
        return self.variables["status"].dims

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions of the points."""
        return tuple(self.sizes[dim] for dim in self.dims)

    @cached_property
    def with_fields(self) -> Mask:
        """True at points with fields; the shape is that of the points."""
        mask, surface = np.zeros(self.shape, bool), dict(self.sweep.surface_with_fields)
        at = [
            self.axes[dim].index(surface[dim]) if dim in surface else slice(None)
            for dim in self.dims
        ]
        mask[tuple(at)] = bool(self.sweep.fields)
        return mask

    # A variable may lack some of the dimensions of points: times are equal for all realizations,
    # and fields are stored for one of them.

    def has_dims(self, name: str) -> list[bool]:
        """True for each of `dims` that a variable has."""
        return [dim in self.variables[name].dims for dim in self.dims]

    def point_indices(self, name: str, where: Indices) -> Indices:
        """Indices of points, shape (n, n_dim), along those of `dims` that a variable has."""
        return where[:, self.has_dims(name)]

    def values_at(self, name: str, points: Mask) -> Mask:
        """True at the values of a variable that belong to any of some points."""
        (missing,) = np.nonzero(np.logical_not(self.has_dims(name)))
        return np.asarray((points & self._with_values(name)).any(axis=tuple(missing.tolist())))

    def points_at_values(self, name: str, values: Mask) -> Mask:
        """True at the points that some values of a variable belong to."""
        (missing,) = np.nonzero(np.logical_not(self.has_dims(name)))
        return np.expand_dims(values, tuple(missing.tolist())) & self._with_values(name)

    def _with_values(self, name: str) -> Mask:
        """True at points that have values of a variable."""
        return self.with_fields if name in FIELDS else np.ones(self.shape, bool)

    @cached_property
    def arrays(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by name."""
        block, documents = self._block(), dict[str, Document]()
        for name, variable in self.variables.items():
            is_axis = variable.dims == (name.rpartition("/")[2],)
            chunk = {} if is_coordinate(name) or name == "status" else block
            if is_in_fields(name) and not is_axis:  # Dask demands the same chunks in a group
                chunk = dict.fromkeys(block, 1)
            growths = self.field_growths if is_in_fields(name) else self.growths
            documents[name] = array_document(variable, self.sizes, chunk, growths)
        return documents

    @property
    def fields(self) -> dict[str, Any]:
        """Dimensions of the variables of the group of fields, with the values of coordinates."""
        names = filter(is_in_fields, self.variables)
        return {name: (self.variables[name].dims, self.coordinates.get(name)) for name in names}

    def continues_fields_of(self, before: Group) -> bool:
        """True if the chunks of all fields of a smaller group have the same keys in this one."""
        return before.fields.items() <= self.fields.items()

    def _block(self) -> dict[str, int]:
        """Number of points in a chunk along each dimension, except of fields."""
        max_bytes = max(
            8 * math.prod(self.sizes[dim] for dim in variable.dims if not is_of_points(dim))
            for name, variable in self.variables.items()
            if not (name in FIELDS or is_coordinate(name))
        )
        return chunk_sizes(dict(zip(self.dims, self.shape, strict=True)), max_bytes)

    def paths(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by path in the store."""
        return {self.prefix + path_of(name): array for name, array in self.arrays.items()}

    @cached_property
    def coordinates(self) -> dict[str, Any]:
        """Values of coordinates, and of the arrays from the scene's files, by name."""
        values: dict[str, Any] = {**self.axes}
        for _, label in self.sweep.surface_with_fields if self.sweep.fields else ():
            values[FIELD_REALIZATION] = label
        copies = {f"{OF_FIELDS}/{name}": labels for name, labels in self.axes.items()}
        values |= {name: labels for name, labels in copies.items() if name in self.variables}
        if self.inputs:
            values[INPUTS] = np.concatenate([array.ravel() for array in self.inputs.values()])
        return values

    def points_at(self, where: Sequence[Indices]) -> list[Point]:
        """Points at indices; `where` has an array for each of `dims`, as from `numpy.nonzero`."""
        names, columns = [*PLANE, *self.sweep.case_table.axes], []
        for name in names:
            numbers = where[self.dims.index(self.variables[name].dims[0])]
            columns.append([self.axes[name][number] for number in numbers.tolist()])
        return [
            Point(load, velocity, tuple(zip(names[2:], labels, strict=True)))
            for load, velocity, *labels in zip(*columns, strict=True)
        ]

    def scene_hash(self, point: Point) -> str:
        """SHA-256 of the scene that is simulated at a point."""
        return self.sweep._scene_hashes[point.case]

    def is_stepped(self, name: str) -> bool:
        """True for a variable with values at each step of a point."""
        return self.step in self.variables[name].dims

    def to_text(self, point: Point) -> str:
        """Text of a point, such as "400 N, 2 m/s, pin.radius 2 mm" or "…, test 1"."""
        if self.prefix:
            number = int(self.sweep.case_table.by_name[point.case][TEST])
            test = "an earlier test" if number == NO_TEST else f"test {number + 1}"
            return f"{point._replace(case=())}, {test}"
        words = self.sweep.case_table.to_text(point.case)
        return str(point._replace(case=tuple(words.items())))


def sizes_of(arrays: Mapping[str, Array]) -> dict[str, int]:
    """Number of values of each array."""
    return {digest: array.size for digest, array in arrays.items()}


def chunk_sizes(sizes: Mapping[str, int], bytes_of_a_point: int) -> dict[str, int]:
    """Number of points in a chunk along each dimension: all loads, then velocities, then rows.

    `sizes` are the lengths of the dimensions, and `bytes_of_a_point` is for the largest variable.
    """
    max_points, block = min(max(_MAX_BYTES // bytes_of_a_point, 1), _MAX_POINTS), dict[str, int]()
    for dim in sorted(sizes, key=lambda dim: (dim != "load", dim != "velocity")):
        block[dim] = max(1, min(sizes[dim], max_points // math.prod(block.values())))
    return block


def blocks(mask: Mask, sizes: Sequence[int]) -> Iterator[tuple[tuple[int, ...], Slices]]:
    """Yield index and slices of each chunk with a point where `mask` is True.

    `sizes` are the numbers of points in a chunk along each dimension.
    """
    for chunk in np.ndindex(*(-(-n // size) for n, size in zip(mask.shape, sizes, strict=True))):
        block = tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, sizes, strict=True))
        if mask[block].any():
            yield chunk, block


def checksums(
    group: Group, where: Indices, values: Mapping[str, Any], done: Mask
) -> NDArray[np.uint32]:
    """CRC-32 of each point: of its scene, load, velocity and stored values.

    It detects files that were exchanged. Points that failed have no results.
    """
    sums = np.zeros(len(where), np.uint32)
    names = sorted(values.keys() - {"checksum", "wall_time"})
    has_fields = group.with_fields[tuple(where.T)]
    for number, point in enumerate(group.points_at(tuple(where.T))):
        is_of = f"{group.scene_hash(point)} {point.load!r} {point.velocity!r}"
        crc = zlib.crc32(is_of.encode())
        for name in names:
            is_record = name in _OF_POINT
            if not (is_record or done[number]) or (name in FIELDS and not has_fields[number]):
                continue
            stored = values[name][number]
            if stored is None:
                continue
            if name == "message":
                stored = str(stored).encode()
            elif group.is_stepped(name):
                stored = stored[-int(values["steps"][number]) :]
            crc = zlib.crc32(stored, crc)
        sums[number] = crc
    return sums
