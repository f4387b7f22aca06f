"""Results at the points of a scene's tests, and of its uncertain inputs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pipeline.store.place import StoreError
from pipeline.store.read import open_tests
from pipeline.store.schema import AT_TESTS, DONE, MADE, PLANE, STEPPED, TEST_STEP, test_variable
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.points_of_tests import SCENE_HASH, TEST_POINT, Slot, wanted_slots
from pipeline.sweep.stations import load_that_counts
from pipeline.sweep.sweep import Sweep
from tribo.simulation.severity import worst_rises
from tribo.types import Array

_INNER = (TEST_STEP, "bulk_ratio", "cooler_share")
ABSENT = -1
"""Status of the point of a test that the dataset does not have."""


@dataclass(frozen=True, eq=False)
class TestResults:
    """Results at the points of a scene's tests, in the order of the tests.

    A transition with a step has two points, the easier one first. Arrays have the axis of points
    first.

    Attributes
    ----------
    numbers : ndarray of int, shape (n,)
        Number of the test of each point, from 0.
    loads, velocities : ndarray, shape (n,)
        Load [N] and velocity [m/s] of each point.
    least_loads : ndarray, shape (n,)
        Load from which on steps of each point can decide [N].
    status : ndarray of int, shape (n,)
        State of each point as in the store; `ABSENT` if the dataset does not have it.
    messages : ndarray of str, shape (n,)
        Warnings, or the reason for a failure.
    columns : mapping
        Variables by name, as `Results.columns` has them; NaN at points without a result.
    shares : ndarray
        Shares of the contact area that are cooler than the quantiles of the rise.
    """

    numbers: NDArray[np.int_]
    loads: Array
    velocities: Array
    least_loads: Array
    status: NDArray[np.int_]
    messages: NDArray[np.object_]
    columns: Mapping[str, Array] = field(repr=False)
    shares: Array = field(repr=False)

    def rise(self, place: int, conditions: Conditions) -> float:
        """Temperature rise per unit friction coefficient at one of the points [K].

        It is the rise at the worst step that the criterion of `conditions` compares with its limit;
        NaN if the point is not done.
        """
        if self.status[place] != DONE:
            return math.nan
        columns: dict[str, Any] = {name: one[place] for name, one in self.columns.items()}
        columns["quantile"] = self.shares
        return float(worst_rises(columns, self.least_loads[place, None], conditions))


def read_test_results(ds: xr.Dataset, sweep: Sweep) -> TestResults:
    """Results of the tests of a sweep, from a dataset or the store that it was read from."""
    slots = wanted_slots(sweep)
    found = ds if test_variable("status") in ds.variables else _stored_tests(ds, slots)
    held = {}
    if test_variable("status") in found.variables:
        own = {test_variable(name): name for name in AT_TESTS}
        held = {own[str(k)]: one for k, one in found.variables.items() if k in own}
    if any({*one.dims} - {TEST_POINT, *_INNER} for one in held.values()):  # changed by the user
        held = {}
    held = {name: _with_axes(name, one) for name, one in held.items()}
    rows = dict[tuple[Any, ...], list[int]]()
    if held:
        keys = (held[name].values.tolist() for name in (SCENE_HASH, "load", "velocity"))
        for row, key in enumerate(zip(*keys, strict=True)):
            rows.setdefault(key, []).append(row)
    places = [rows[slot[:3]].pop(0) if rows.get(slot[:3]) else ABSENT for slot in slots]
    is_here = np.array(places, int) != ABSENT

    def least(slot: Slot) -> float:
        return load_that_counts(sweep.tests[slot.test].case.scene, slot.load)

    def taken(name: str, usual: Any) -> Any:
        if not held:
            return np.full(len(slots), usual)
        values = held[name].values[places]
        values[~is_here] = usual
        return values

    columns = [name for name in held if held[name].dtype.kind == "f"]
    return TestResults(
        numbers=np.array([slot.test for slot in slots], int),
        loads=np.array([slot.load for slot in slots], float),
        velocities=np.array([slot.velocity for slot in slots], float),
        least_loads=np.array([least(slot) for slot in slots], float),
        status=taken("status", ABSENT).astype(int),
        messages=taken("message", "").astype(object),
        columns={name: taken(name, math.nan) for name in columns if name not in PLANE},
        shares=np.array(found["cooler_share"].values) if held else np.empty(0),
    )


def _with_axes(name: str, one: Any) -> Any:
    """Variable of tests with its axes in order, also those of one value that a user took off."""
    is_stepped = name in STEPPED or name in MADE
    inner = (dim for dim in _INNER if dim in one.dims or (dim == TEST_STEP and is_stepped))
    return one.set_dims((TEST_POINT, *inner))


def _stored_tests(ds: xr.Dataset, slots: Sequence[Slot]) -> xr.Dataset:
    """Results of tests from the store that a dataset was read from; empty without one."""
    source = ds.encoding.get("source")
    if source and slots:
        with suppress(StoreError):
            return open_tests(source)
    return xr.Dataset()
