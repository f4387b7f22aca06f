"""A sweep that is created, run, grown and resumed, in one process and with known results."""

import functools
import itertools
from contextlib import contextmanager
from dataclasses import replace
from unittest import mock

import numpy as np
import xarray as xr
from pipeline.store.variables import COLUMNS, FIELDS

import tribo
from pipeline.run import sweep as execute
from pipeline.run import work
from pipeline.store import DONE, FAILED, Store, compact_store, files, verify_store
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny
from tests.helpers.here import Here

FIRST = tiny.full(loads=(150.0, 600.0), velocities=(0.5,), realizations=(1,))
GROWN = replace(FIRST, loads=(150.0, 600.0, 900.0))  # and longer by some steps
WIDER = replace(FIRST, loads=(150.0,), realizations=(1, 2))
ASKED = {*points(FIRST), *points(GROWN), *points(WIDER)}
_AXES = ("realization", "load", "velocity")  # as a store has them
FAILING, REASON = Point(600.0, 0.5, 1), "ConvergenceError: the contact did not converge"


@functools.cache
def results():
    """What is computed at each point."""
    with np.errstate(all="raise", under="ignore"):
        return {point: run_point(GROWN, *point) for point in ASKED}


def run(path, tell):
    """Create, run with a failure, grow and try again, compact, grow and run on.

    `tell` is called with what was acknowledged: "done" or "failed", and the point; and with
    "pending", before a point is made that.
    """
    with acknowledging(tell):
        with computing(failing={FAILING}):
            execute.run_sweep(FIRST, path)
        resume(path)


def resume(path):
    """Go on from wherever the store is, to its end."""
    with computing():
        execute.run_sweep(GROWN, path, retry_failed=True)
        compact_store(path)
        execute.run_sweep(WIDER, path)


@contextmanager
def computing(failing=frozenset()):
    """Let points be computed here, one after the other, from what is known."""

    def known(sweep, *at, trunk=None):
        point = Point(*at)
        if point in failing:
            raise tribo.ConvergenceError("the contact did not converge", solution=None)
        return results()[point]

    @contextmanager
    def connected(*_):
        yield Here()

    with (
        mock.patch.object(work, "run_point", known),
        mock.patch.object(execute, "connected", connected),
        # One write after the other: so a crash point is the same each time.
        mock.patch.object(files, "_THREADS", 1),
    ):
        yield


@contextmanager
def acknowledging(tell):
    commit, fail, forget = Store.commit, Store.fail, Store.forget

    def committed(self, *results):
        commit(self, *results)
        for result in results:
            tell("done", result.point)

    def failed(self, point, message):
        fail(self, point, message)
        tell("failed", point)

    def forgotten(self, *points):
        for point in points:
            tell("pending", point)
        forget(self, *points)

    with (
        mock.patch.object(Store, "commit", committed),
        mock.patch.object(Store, "fail", failed),
        mock.patch.object(Store, "forget", forgotten),
    ):
        yield


@contextmanager
def status_first():
    """A store that makes the mistake which all of this is to find."""

    def commit(self, *results):
        self._write({result.point: {"status": DONE} for result in results}, {})
        self._write({each.point: self._values(each) for each in results}, {}, also_done=True)

    with mock.patch.object(Store, "commit", commit):
        yield


def check(path, acknowledged):
    """Faults of a store left by a crash, given what was acknowledged before."""
    if not (path / "zarr.json").exists():
        return ["a point was acknowledged, but there is no store"] if acknowledged else []
    with xr.open_zarr(path, chunks=None) as ds:
        ds = ds.load()
    faults = [str(damage) for damage in verify_store(path).damaged]
    told = {tuple(point): how for how, point in acknowledged}
    values = {name: ds[name].values for name in ds.data_vars}
    for index, point in places(ds):
        stored = {name: array[index] for name, array in values.items()}
        status, known = int(stored["status"]), told.pop(point, "pending")
        if known != "pending" and status != {"done": DONE, "failed": FAILED}[known]:
            faults.append(f"{point} was acknowledged as {known}, but its status is {status}")
        if status == DONE:
            faults += [f"{point}: {name} differs" for name in differing(stored, point)]
        if status == FAILED and stored["message"] != REASON:
            faults.append(f"{point}: the reason of its failure is {stored['message']!r}")
    return faults + [f"{point} was acknowledged, but is not there" for point in told]


def places(ds):
    """Points that there is room for, each with its place in an array."""
    axes = [list(enumerate(ds[name].values.tolist())) for name in _AXES]
    for place in itertools.product(*axes):
        yield (
            tuple(i for i, _ in place),
            Point(**{n: v for n, (_, v) in zip(_AXES, place, strict=True)}),
        )


def differing(stored, point):
    """Variables whose values are not, bit for bit, those that were computed."""
    result = results()[point]
    for name, expected in result.columns.items():
        values = stored[name]
        own, beyond = values[: len(expected)], values[len(expected) :]
        if own.tobytes() != expected.tobytes() or np.isfinite(beyond).any():
            yield name
    for name, expected in result.fields.items():
        if stored[name].tobytes() != expected.tobytes():
            yield name


def content(path):
    """All that a finished store holds, whatever the order of its axes on the disk."""
    with xr.open_zarr(path, chunks=None) as ds:
        ds = ds.sortby(list(_AXES)).load()
        names = (*COLUMNS, *FIELDS, "status", "message", "checksum", *_AXES)
        return {name: ds[name].values.tolist().__repr__() for name in names}
