"""Stores of the tiny sweep, made without a cluster, and writers that are killed."""

import functools
import json
import os
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress

import numpy as np
import xarray as xr

from pipeline import paths
from pipeline.run.serial import run_serial
from pipeline.store import root
from pipeline.store.create import writing
from pipeline.store.location import LOCK, ROOT
from pipeline.store.schema import DONE, ENDS
from pipeline.store.store import opened
from pipeline.sweep.plan import PointRecord, points, tasks
from tests.helpers import tiny
from tests.helpers.points import run_point
from tribo.simulation import RampCache

HOLDER = """if True:
    import sys, time
    from pipeline.store.create import writing
    from tests.helpers import tiny
    with writing(sys.argv[1], tiny.full()):
        print("held", flush=True)
        time.sleep(60)
"""
"""Program that holds the lock of a store, once it has said so."""


def lock_of(path):
    """Path of the lock of a store."""
    return path.with_name(f"{path.name}{LOCK}")


@contextmanager
def held_elsewhere(path):
    """Context: another process holds the lock of a store; yields how the lock names it."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", HOLDER, path]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout.readline() == b"held\n"
        try:
            yield f"process {process.pid} on {os.uname().nodename}"
        finally:
            process.kill()


class Killed(BaseException):
    """Stands for the death of the process: no code of the store catches it."""


@functools.cache
def record(point):
    """Record of a point of the tiny sweep with fields."""
    with np.errstate(all="raise", under="ignore"):
        return run_point(tiny.full(), point).record(with_fields=True)


def commit(path, sweep, chosen=None):
    """Create or resume the store of a tiny sweep, and commit points, by default all."""
    with writing(path, sweep) as store:
        store.commit([record(point) for point in (points(sweep) if chosen is None else chosen)])


def commit_all(path, sweep, skip=(), shares_ramps=True):
    """Create the store of a sweep, and compute its points and tests in this process."""
    ramp_cache = RampCache() if shares_ramps else None
    with writing(path, sweep) as store, np.errstate(all="raise", under="ignore"):
        selected = [task.point for task in tasks(points(sweep), sweep) if task.point not in skip]
        store.commit(run_point(sweep, point, ramp_cache).record(sweep.fields) for point in selected)
        run_serial(store)


def fail(path, sweep, point, message):
    """Commit the failure of a point, with a message."""
    with writing(path, sweep) as store:
        store.commit([PointRecord(point, None, message)])


def done_points(path):
    """Points of a store that are done, in its order."""
    store = opened(path)
    return store.points_where(store.flags == DONE)


def plain_values(path):
    """Values of all variables of a store and its groups, as plain xarray reads them.

    Coordinates of fields have names such as "fields/load" if the root has them, too.
    """
    values = {}
    for group in (None, "about", "fields"):
        with suppress(FileNotFoundError, KeyError):  # a store without fields
            ds = xr.open_zarr(path, group=group, chunks=None)
            values |= {f"{group}/{k}" if k in values else k: ds[k].values for k in ds.variables}
    return values


def assert_is_as_computed(path, expected):
    """Assert that exactly these points are done, with the computed values bit for bit.

    Only stores of pins with free ends have the variables of ends.
    """
    assert set(done_points(path)) == set(expected)
    stored = plain_values(path)
    loads, velocities = stored["load"].tolist(), stored["velocity"].tolist()
    for point in expected:
        index = loads.index(point.load), velocities.index(point.velocity)
        assert stored["message"][index] == record(point).message
        data = record(point).data
        for name in data.keys() - ENDS.keys():
            values = data[name]
            present, values = np.atleast_1d(stored[name][index]), np.atleast_1d(values)
            assert present[-len(values) :].tobytes() == values.tobytes(), (point, name)
            assert np.isnan(present[: -len(values)]).all(), (point, name)


@contextmanager
def killed_after(monkeypatch, count):
    """Context: kill the process after it has replaced `count` files; yields [True] if killed."""
    replace, lock, left, was_killed = paths.write_file, threading.Lock(), [count], []

    def replace_some(file, content):
        with lock:
            left[0] -= 1
        if left[0] < 0:
            file.with_name(file.name + paths.PARTIAL).write_bytes(content[: len(content) // 2])
            raise Killed
        replace(file, content)

    with monkeypatch.context() as patch:
        patch.setattr(paths, "write_file", replace_some)
        try:
            yield was_killed
        except Killed:
            was_killed.append(True)


def forge(store, change):
    """Change the facts of a store and their copy, and give them the right digest.

    `change` is called with the sweep and the facts.
    """
    document = json.loads((store / root.FACTS).read_bytes())
    facts = document["attributes"]
    change(facts["sweep"], facts)
    facts["digest"] = root._digest(facts)
    write_facts(store, json.dumps(document).encode())


def write_facts(store, content):
    """Replace the document with the facts of a store, and remove its copy."""
    (store / root.FACTS).write_bytes(content)
    document = json.loads((store / ROOT).read_bytes())
    (store / ROOT).write_text(json.dumps(document | {"consolidated_metadata": None}))


def contents(path):
    """Contents of all files below a path, by relative path."""
    present = (file for file in path.rglob("*") if file.is_file())
    return {str(file.relative_to(path)): file.read_bytes() for file in present}
