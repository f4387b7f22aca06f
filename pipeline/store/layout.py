"""Layout of a group of points, derived from its sweep: axes, variables and chunks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from pipeline.store import schema
from pipeline.store.arrays import Document, array_document
from pipeline.sweep.case import TEST
from pipeline.sweep.case_table import LOAD_FACTOR, in_order
from pipeline.sweep.plan import choose_stored_steps
from pipeline.sweep.stored_steps import ramp_of
from pipeline.sweep.sweep import Point, Sweep
from tribo import QUANTILES, Scene
from tribo.types import Array, Indices, Mask

Axes = dict[str, list[Any]]
"""Values along each dimension, and of coordinates along another dimension."""
Slices = tuple[slice, ...]

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
    growths: int = 0  # how often the store was replaced

    @property
    def step(self) -> str:
        """Name of the dimension of steps."""
        return schema.TEST_STEP if self.prefix else "step"

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
        if factors := sweep.case_table.load_factors:
            rows["load"] = [sweep.case_table.loads_of({"load": load}) for load in rows["load"]]
        scenes = [case.scene for case in sweep.on_first_surface]
        ramps = {ramp_of(scene): scene for scene in scenes}.values()
        loads_of_scenes: Iterable[tuple[Scene, float]] = itertools.product(ramps, sweep.loads)
        if self.prefix:  # each test has loads of its own
            table = sweep.case_table.by_name.items()
            loads_of_scenes = ((sweep.case(name).scene, float(row["load"])) for name, row in table)
        steps_of_points = itertools.starmap(stored_steps.select, loads_of_scenes)
        values: dict[str, Any] = {
            LOAD_FACTOR: [*factors],
            "load": [*sweep.loads],
            "velocity": [*sweep.velocities],
            **rows,
            self.step: [*range(1 - max(map(len, steps_of_points)), 1)],
            "area_fraction_below": [*QUANTILES],
            "x": scenes[0].grid.coordinates(0).tolist(),
            "y": scenes[0].grid.coordinates(1).tolist(),
        }
        return {
            name: labels for name, labels in values.items() if name in schema.variables_of(sweep)
        }

    @cached_property
    def variables(self) -> dict[str, schema.Variable]:
        """Variables of the group by name."""
        return schema.variables_of(self.sweep) | schema.inputs_variable(sizes_of(self.inputs))

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions."""
        lengths = {name: len(values) for name, values in self.axes.items()}
        lengths[schema.INPUT_DIM] = sum(sizes_of(self.inputs).values())
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
        """For each of `dims`, whether the variable has it."""
        return [dim in self.variables[name].dims for dim in self.dims]

    def point_indices(self, name: str, indices: Indices) -> Indices:
        """Indices of points, shape (n, n_dim), along those of `dims` that a variable has."""
        return indices[:, self.has_dims(name)]

    def values_at(self, name: str, points: Mask) -> Mask:
        """True at the values of a variable that belong to any of some points."""
        points = points & self.with_fields if name in schema.FIELDS else points
        shared_axes = [axis for axis, has_dim in enumerate(self.has_dims(name)) if not has_dim]
        return np.asarray(points.any(axis=tuple(shared_axes)))

    @cached_property
    def arrays(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by name."""
        block, documents = self._block(), dict[str, Document]()
        for name, variable in self.variables.items():
            is_axis = variable.dims == (name.rpartition("/")[2],)
            chunk = {} if schema.is_coordinate(name) or name == "status" else block
            if schema.is_in_fields(name) and not is_axis:  # Dask demands the same chunks in a group
                chunk = dict.fromkeys(block, 1)
            documents[name] = array_document(variable, self.sizes, chunk, self.growths)
        return documents

    def _block(self) -> dict[str, int]:
        """Number of points in a chunk along each dimension: all loads, velocities, then rows."""
        max_bytes = max(
            8 * math.prod(self.sizes[dim] for dim in variable.dims if not schema.is_of_points(dim))
            for name, variable in self.variables.items()
            if not (name in schema.FIELDS or schema.is_coordinate(name))
        )
        max_points, block = min(max(_MAX_BYTES // max_bytes, 1), _MAX_POINTS), dict[str, int]()
        for dim in sorted(self.dims, key=lambda dim: (dim != "load", dim != "velocity")):
            block[dim] = max(1, min(self.sizes[dim], max_points // math.prod(block.values())))
        return block

    def paths(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by path in the store."""
        return {self.prefix + schema.path_of(name): array for name, array in self.arrays.items()}

    @cached_property
    def coordinates(self) -> dict[str, Any]:
        """Values of coordinates, and of the arrays from the scene's files, by name."""
        values: dict[str, Any] = {**self.axes}
        for _, label in self.sweep.surface_with_fields if self.sweep.fields else ():
            values[schema.FIELD_REALIZATION] = label
        copies = {f"{schema.OF_FIELDS}/{name}": labels for name, labels in self.axes.items()}
        values |= {name: labels for name, labels in copies.items() if name in self.variables}
        if self.inputs:
            values[schema.INPUTS] = np.concatenate(
                [array.ravel() for array in self.inputs.values()]
            )
        return values

    def points_at(self, indices: Sequence[Indices]) -> list[Point]:
        """Points at indices; `indices` has an array for each of `dims`, as from `numpy.nonzero`."""
        names, columns = [*schema.PLANE, *self.sweep.case_table.axes], []
        for name in names:
            at = tuple(indices[self.dims.index(dim)] for dim in self.variables[name].dims)
            columns.append(np.array(self.axes[name], object)[at].tolist())
        return [
            Point(load, velocity, tuple(zip(names[2:], labels, strict=True)))
            for load, velocity, *labels in zip(*columns, strict=True)
        ]

    def scene_hash(self, point: Point) -> str:
        """SHA-256 of the scene that is simulated at a point."""
        return self.sweep.scene_hashes[point.case]

    def is_stepped(self, name: str) -> bool:
        """True for a variable with values at each step of a point."""
        return self.step in self.variables[name].dims

    def to_text(self, point: Point) -> str:
        """Text of a point, such as "400 N, 2 m/s, pin.radius 2 mm" or "…, test 1"."""
        if self.prefix:
            number = int(self.sweep.case_table.by_name[point.case][TEST])
            return f"{point._replace(case=())}, test {number + 1}"
        labels = self.sweep.case_table.to_text(point.case)
        return str(point._replace(case=tuple(labels.items())))


def sizes_of(arrays: Mapping[str, Array]) -> dict[str, int]:
    """Number of values of each array."""
    return {digest: array.size for digest, array in arrays.items()}


def block_at(chunk: Sequence[int], sizes: Sequence[int]) -> Slices:
    """Slices of a chunk by its indices; `sizes` are the numbers of points in each chunk."""
    return tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, sizes, strict=True))
