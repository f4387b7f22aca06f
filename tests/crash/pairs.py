"""Two faults, of which the second comes before the first is repaired.

A driver is killed at a random step on the disk while it creates, continues, mends or enlarges a
store. Then the disk of the next run is full, or two drivers run at the same time. A run without a
fault completes the store, and computes no point again that it still had undamaged, as plain Zarr
reads it.
"""

import errno
import itertools
import os
import shutil
import signal
import traceback
from contextlib import contextmanager
from unittest import mock

import numpy as np
import zarr

from pipeline import verify_store
from pipeline.paths import PARTIAL
from pipeline.store.location import OLD
from pipeline.store.schema import DONE, ENDS, FIELDS, PROGRESS, path_of
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.crash.driver import GIVEN_UP
from tests.crash.loop import Forked, acknowledged, code_of, faults_of_files
from tests.crash.sweeps import Expected
from tests.helpers import tiny
from tests.helpers.entries import changed

TRIALS = 200
MISTAKE = "old store deleted"
_FIRST = tiny.full(loads=(150.0, 600.0), velocities=(0.5, 1.0), case_table=surface_table((3,)))
_SWEEPS = {
    "same": _FIRST,
    "loads": changed(_FIRST, loads=(150.0, 400.0, 600.0)),
    "velocities": changed(_FIRST, velocities=(0.5, 0.7, 1.0)),
    "realizations": changed(_FIRST, case_table=surface_table((3, 4))),
}
_ALL = changed(
    _FIRST,
    loads=(150.0, 400.0, 600.0),
    velocities=(0.5, 0.7, 1.0),
    case_table=surface_table((3, 4)),
)
# Functions of the disk, and at most how many calls of them precede a kill.
_STEPS = {"replace": 120, "rename": 3, "mkdir": 30, "unlink": 60, "rmdir": 20}
_EXPECTED = Expected(_ALL)


@contextmanager
def dying(step, count):
    """Context: this process is killed before the call number `count` of a function of `os`."""
    function, numbers = getattr(os, step), itertools.count()

    def call(*arguments, **options):
        if next(numbers) == count:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(*arguments, **options)

    with mock.patch.object(os, step, call):
        yield


@contextmanager
def full(count):
    """Context: no file is written any more after `count` files."""
    fsync, numbers = os.fsync, itertools.count()

    def call(descriptor):
        if next(numbers) >= count:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(descriptor)

    with mock.patch.object(os, "fsync", call):
        yield


class _Pair:
    """A folder with a store, in which drivers run."""

    def __init__(self, run, folder, base):
        self.run, self.path, self.log = run, folder / "results" / "out.zarr", folder / "log"
        self.path.parent.mkdir(parents=True)
        if base is not None:
            shutil.copytree(base, self.path)

    def start(self, sweep, log, fault=None):
        records = _EXPECTED.records(sweep)
        return Forked(sweep, self.path, log, records, self.run.mistake, fault=fault)


def sound_points(folder):
    """Points of a store that plain Zarr reads as they are computed; none if it cannot read one."""
    try:
        axes = [_read(folder, name) for name in ("realization", "load", "velocity")]
        status = _read(folder, "status")
        expected = _EXPECTED(Point(150.0, 0.5, (("realization", 3),)))
        names = expected.record(with_fields=False).data.keys() - PROGRESS.keys() - ENDS.keys()
        arrays = {name: _read(folder, name) for name in (*names, "warning_flags", "steps")}
        _ = _read(folder, "message"), [_read(folder, k) for k in PROGRESS]
    except Exception:  # whatever Zarr raises for damaged data
        return set()
    sound = set()
    for index in np.argwhere(status == DONE).tolist():
        seed, load, velocity = (axis[i].item() for axis, i in zip(axes, index, strict=True))
        point = Point(load, velocity, (("realization", seed),))
        data = _EXPECTED(point).record(with_fields=True).data
        stored = {name: np.atleast_1d(values[tuple(index)]) for name, values in arrays.items()}
        is_sound = all(
            stored[name][-len(np.atleast_1d(data[name])) :].tobytes() == data[name].tobytes()
            for name in names
        )
        if is_sound and (seed != 3 or _has_fields(folder, index[1:], data)):
            sound.add(point)
    return sound


def _read(folder, name, key=...):
    return zarr.open_array(folder / path_of(name), mode="r")[key]


def _has_fields(folder, index, data):
    try:
        return all(
            _read(folder, name, tuple(index)).tobytes() == data[name].tobytes() for name in FIELDS
        )
    except Exception:  # whatever Zarr raises for damaged data
        return False


def _fill_disk(pair, chance):
    driver = pair.start(pair.sweep, pair.log, full(chance.randrange(150)))
    if code_of(driver) not in (0, GIVEN_UP):
        yield "a driver on a full disk ends without a message"


def _run_twice(pair, chance):
    drivers = [pair.start(pair.sweep, pair.log) for _ in range(2)]
    if sorted(map(code_of, drivers)) not in ([0, 0], [0, GIVEN_UP]):
        yield "two drivers at once do not end as they should"


_SECOND = {"full disk": _fill_disk, "second driver": _run_twice}


def _faults_of(pair, base, second, chance):
    """Yield faults of a pair: a kill, and the second fault."""
    # With the mistake, drivers are killed between the two renames of a growth.
    key = "loads" if pair.run.mistake else chance.choice(sorted(_SWEEPS))
    step = "rename" if pair.run.mistake else chance.choice(sorted(_STEPS))
    count = 1 if pair.run.mistake else chance.randrange(_STEPS[step])
    pair.sweep = _SWEEPS[key]
    driver = pair.start(pair.sweep, pair.log.with_name("killed"), dying(step, count))
    code_of(driver)
    word = "killed" if driver.returncode < 0 else "not killed"
    pair.run.report.counts[f"{word}, then {second}"] += 1
    old = pair.path.with_name(f"{pair.path.name}{OLD}")
    sound = sound_points(pair.path if pair.path.exists() else old)
    if not pair.run.mistake:
        yield from _SECOND[second](pair, chance)
    driver = pair.start(pair.sweep, pair.log)
    if code_of(driver) != 0:
        words = pair.log.with_suffix(".err").read_text()[-300:]
        yield f"{base}, {key}, {step}: the last run ends with {driver.returncode}: {words}"
        return
    computed = acknowledged(pair.log)
    if again := sound & {*computed} or [point for point, times in computed.items() if times > 1]:
        yield f"{base}, {key}, {step}: {len(again)} undamaged points are computed again"
    yield from faults_of_files(verify_store(pair.path))
    if missing := {*points(pair.sweep)} - sound_points(pair.path):
        yield f"{base}, {key}, {step}: {len(missing)} points are not as computed"
    if len([*pair.path.parent.iterdir()]) > 1 or [*pair.path.rglob(f"*{PARTIAL}")]:
        yield f"{base}, {key}, {step}: files are left over"


def campaign(run):
    """Try `run.count` pairs of faults."""
    bases = {"no store": None}
    for name in ("half", "complete", "damaged"):
        pair = _Pair(run, run.folder / name, None)
        fault = dying("replace", 90) if name == "half" else None
        code_of(pair.start(_FIRST, pair.log, fault))
        bases[name] = pair.path
    chunk = bases["damaged"] / "mean_rise" / "c.0.0.0.0"
    chunk.write_bytes(chunk.read_bytes()[:20])
    for number in range(run.count):
        second = [*_SECOND][number % len(_SECOND)]
        base = "complete" if run.mistake else run.chance.choice(sorted(bases))
        folder = run.folder / str(number)
        pair = _Pair(run, folder, bases[base])
        try:
            faults = [*_faults_of(pair, base, second, run.chance)]
        except Exception:
            faults = [traceback.format_exc()[-400:]]
        run.report.faults += [f"{number}, {second}: {fault}" for fault in faults][:3]
        shutil.rmtree(folder)
