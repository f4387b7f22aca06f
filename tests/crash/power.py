"""Cut the power of a disk while four processes write to a store on it, and look at what is left.

The disk is ext4 in a file of its own, mounted through a loop device. At a random moment its file
system is shut down without a last flush: nothing more reaches the disk, and what waits in memory is
lost, as when the power fails. Mounted again, it replays its journal. The store must open and hold
every point that was acknowledged, bit for bit; no point may be done that is not; and a run goes on
from there to the end. In every third cut a single process grows, compacts and splits the store
instead. What a drive loses after it has said that all is written is not tried here.

Needs root, loop devices and mkfs.ext4. Prints a JSON document.
"""

import argparse
import fcntl
import json
import multiprocessing
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from pipeline.run.sweep import run_sweep
from pipeline.store import (
    BY_POINT,
    COMPACT,
    DONE,
    Store,
    StoreError,
    files,
    lay_out,
    locked,
    prepare,
    verify_store,
)
from pipeline.sweep.plan import points, run_point
from tests.crash import scenario
from tests.crash.bounded import add_seconds, until
from tests.crash.compared import differing
from tests.helpers import tiny

WRITERS = 4
SWEEP = tiny.full(velocities=tuple(np.linspace(0.5, 1.5, 60).tolist()))
WIDER = replace(SWEEP, velocities=(*SWEEP.velocities, 2.0))
_LATEST = 0.5  # [s] after the beginning, for a cut
_MEMORY = Path("/dev/shm")  # where what counts as the disk takes no time
_SIZE = 64  # [MB]
_SHUT_DOWN = (
    (2 << 30) | (4 << 16) | (ord("X") << 8) | 125
)  # EXT4_IOC_SHUTDOWN: _IOR('X', 125, __u32)
_WITHOUT_FLUSH = struct.pack("I", 2)
_PROCESSES = multiprocessing.get_context("fork")


def can_cut():
    """Whether disks can be made and mounted here."""
    return os.geteuid() == 0 and Path("/dev/loop-control").exists() and shutil.which("mkfs.ext4")


@contextmanager
def mounted(image, folder):
    subprocess.run(["mount", "-o", "loop", image, folder], check=True, timeout=60)
    try:
        yield
    finally:
        subprocess.run(["umount", folder], check=True, timeout=60)


def cut_power(folder):
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.ioctl(descriptor, _SHUT_DOWN, _WITHOUT_FLUSH)
    finally:
        os.close(descriptor)


def write(path, share, results, told):
    """Commit points until there are no more, or no disk."""
    with suppress(StoreError, OSError):
        store = Store(path)
        for point in share:
            store.commit(results[point])
            told.send(point)


def change(path, told):
    """Grow, compact and split the store until there is no disk."""
    with suppress(StoreError, OSError), locked(path):
        while True:
            lay_out(path, COMPACT)
            lay_out(path, BY_POINT)
            prepare(path, WIDER)
            told.send(None)


def cut(path, order, results, moment):
    """Write to a store until the power fails; acknowledged points, and whether all were written."""
    with ExitStack() as stack:
        pipes = [_PROCESSES.Pipe(duplex=False) for _ in range(WRITERS if order else 1)]
        for end in (end for pipe in pipes for end in pipe):
            stack.callback(end.close)
        jobs = [(write, path, order[i::WRITERS], results) for i in range(WRITERS)]
        jobs = jobs if order else [(change, path)]
        writers = [
            _PROCESSES.Process(target=job, args=(*arguments, sender))
            for (job, *arguments), (_, sender) in zip(jobs, pipes, strict=True)
        ]
        for writer in writers:
            writer.start()
        time.sleep(moment)
        idle = not any(writer.is_alive() for writer in writers)
        cut_power(path.parent)
        for writer in writers:
            writer.join(30.0)
            writer.kill()
            writer.join()
        told = []
        for receiver, _ in pipes:
            while receiver.poll():
                told.append(receiver.recv())
    return [point for point in told if point], idle


def faults_of(path, told, results):
    """What is wrong with the store that a cut has left, and with what a run makes of it."""
    try:
        store = Store(path)
        done = {point for point, flag in store.status().items() if flag == DONE}
        yield from (f"{point} was acknowledged and is not done" for point in set(told) - done)
        yield from (f"damaged: {damage}" for damage in verify_store(path).damaged)
        yield from (f"{point} differs" for point in done if differing(store, results[point]))
        with scenario.computing(), mock.patch.object(scenario, "results", return_value=results):
            run_sweep(SWEEP, path)
        store = Store(path)
        wrong = (point for point, result in results.items() if differing(store, result))
        yield from (f"{point}: gone on with, differs" for point in wrong)
        yield from (f"left over: {left.name}" for left in path.rglob("*.partial"))
        if not verify_store(path).is_clean:
            yield "gone on with, it is damaged"
    except Exception as error:
        yield f"{type(error).__name__}: {error}"


@contextmanager
def unsynced():
    """A store that makes the mistake to find: it gives files their names before they are safe."""
    together = files._together

    def careless(act, items):
        if act is not os.fsync:
            together(act, items)

    with mock.patch.object(files, "_together", careless):
        yield


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cuts", type=int, default=120)
    add_seconds(parser)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--unsynced", action="store_true", help="make the mistake to find")
    options = parser.parse_args()
    if not can_cut():
        print(json.dumps({"cuts": 0, "skipped": "needs root, loop devices and mkfs.ext4"}))
        return 0
    np.seterr(all="raise", under="ignore")
    chance = random.Random(options.seed)
    results = {point: run_point(SWEEP, *point) for point in points(SWEEP)}
    report = {"cuts": 0, "acknowledged": 0, "too_late": 0, "faults": []}
    with tempfile.TemporaryDirectory(dir=_MEMORY if _MEMORY.is_dir() else None) as temporary:
        disk, folder = Path(temporary) / "disk", Path(temporary) / "mounted"
        folder.mkdir()
        path = folder / "out.zarr"
        for number in until(options.seconds, range(options.cuts)):
            disk.write_bytes(b"")
            os.truncate(disk, _SIZE * 2**20)
            subprocess.run(["mkfs.ext4", "-q", "-F", disk], check=True, timeout=60)
            order = chance.sample(list(results), len(results)) if number % 3 < 2 else []
            with mounted(disk, folder):
                with locked(path):
                    store = prepare(path, SWEEP)
                    for point in points(SWEEP)[: 0 if order else 20]:
                        store.commit(results[point])
                with unsynced() if options.unsynced else nullcontext():
                    told, idle = cut(path, order, results, chance.uniform(0.0, _LATEST))
            told += points(SWEEP)[: 0 if order else 20]
            with mounted(disk, folder):
                found = list(faults_of(path, told, results))
            report["cuts"] += 1
            report["acknowledged"] += len(told)
            report["too_late"] += idle
            report["faults"] += [f"cut {number}: {fault}" for fault in found]
    print(json.dumps(report, indent=1))
    return 1 if report["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
