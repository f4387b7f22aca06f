"""Damage each file of a store, and see what every command makes of it.

A bit is flipped, the file is cut, emptied or deleted, or a FIFO, a folder or an endless device is
in its place. No command may end with a traceback or hang; numbers that are printed are those of the
store as it was, unless points are missing and counted as such; what is damaged is named, and in the
end `irg verify --repair` and a run bring back what was there. Prints a JSON document.
"""

import argparse
import contextlib
import io
import json
import os
import random
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from pipeline.cli import main as irg
from pipeline.run import sweep as execute
from pipeline.store import compact_store, locked, prepare
from pipeline.sweep.plan import points, run_point
from tests.crash import scenario
from tests.crash.bounded import add_seconds, until
from tests.helpers import tiny
from tests.pipeline.conftest import chunks_by_point

SWEEP = tiny.full(loads=(150.0, 600.0), velocities=(0.5, 1.0, 4.0))
COMMANDS = ("status", "boundary", "verify", "plot", "compact")


def flipped(file, chance):
    content = bytearray(file.read_bytes())
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    file.write_bytes(content)


def cut(file, chance):
    content = file.read_bytes()
    file.write_bytes(content[: chance.randrange(len(content))])


def emptied(file, chance):
    file.write_bytes(b"")


def deleted(file, chance):
    file.unlink()


def fifo(file, chance):
    file.unlink()
    os.mkfifo(file)


def folder(file, chance):
    file.unlink()
    file.mkdir()


def device(file, chance):
    file.unlink()
    file.symlink_to("/dev/zero")


KINDS = ("by point", "shared", "compact")
DAMAGE = (flipped, cut, emptied, deleted, fifo, folder, device)


def called(*arguments):
    """Exit code, output and messages of a command, and its traceback if it has one."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = irg([str(argument) for argument in arguments])
        except SystemExit as error:
            code = error.code
        except BaseException:
            return None, out.getvalue(), traceback.format_exc()[-300:]
    return code, out.getvalue(), err.getvalue()


def content(path):
    """What a finished store holds."""
    found = scenario.xr.open_zarr(path, chunks=None)
    with found as ds:
        ds = ds.sortby(["load", "velocity"]).load()
        names = (*scenario.COLUMNS, *scenario.FIELDS, "status", "message", "load", "velocity")
        return {name: ds[name].values.tolist().__repr__() for name in names}


class Whole:
    """A finished store to damage copies of."""

    def __init__(self, folder, results):
        folder.mkdir()
        self.path = folder / "whole.zarr"
        with locked(self.path), chunks_by_point() if folder.name == "by point" else nullcontext():
            store = prepare(self.path, SWEEP)
            store.commit(*results.values())
        if folder.name == "compact":
            compact_store(self.path)
        found = sorted(file for file in self.path.rglob("*") if file.is_file())
        self.files = [file.relative_to(self.path) for file in found]
        self.content = content(self.path)
        self.boundary = called("boundary", self.path, "--json")[1]

    def copy(self):
        path = self.path.with_name("out.zarr")
        shutil.rmtree(path, ignore_errors=True)
        return shutil.copytree(self.path, path)


def faults_of(path, what, whole):
    """What is wrong with the answers of the commands to a damaged store."""
    for command in COMMANDS:
        further = ["--kind", "diagram", "-o", path.parent / "a.png"] if command == "plot" else []
        code, out, err = called(command, path, *further, *(["--json"] if not further else []))
        if code is None:
            yield f"{what}: {command}: {err}"
        elif command == "boundary" and code == 0 and out != whole.boundary:
            pending = json.loads(called("status", path, "--json")[1])["pending"]
            if not pending:
                yield f"{what}: the boundary is another, and nothing says why: {out}"
        elif code == 2 and "irg verify" not in err and "backup" not in err:
            yield f"{what}: {command} does not say what to do: {err}"
    code, out, err = called("verify", path, "--repair")
    if code is None:
        yield f"{what}: verify --repair: {err}"
    elif code == 2:
        yield f"{what}: cannot be repaired: {err}"
        return
    try:
        with scenario.computing():
            execute.run_sweep(SWEEP, path)
    except Exception:
        yield f"{what}: run: {traceback.format_exc()[-300:]}"
        return
    if content(path) != whole.content:
        yield f"{what}: not as it was after a repair and a run"
    if called("verify", path)[0] != 0:
        yield f"{what}: not clean after a repair and a run: {called('verify', path)[1]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="files to go on by")
    parser.add_argument("--seed", type=int, default=0)
    add_seconds(parser)
    options = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    chance = random.Random(options.seed)
    results = {point: run_point(SWEEP, *point) for point in points(SWEEP)}
    scenario.results = lambda: results
    tried, faults = Counter(), []
    with tempfile.TemporaryDirectory() as temporary:
        stores = {kind: Whole(Path(temporary) / kind, results) for kind in KINDS}
        cases = [
            (kind, file, damage)
            for kind, store in stores.items()
            for file in store.files
            for damage in DAMAGE
        ]
        cases = cases[chance.randrange(options.every) :: options.every]
        for kind, file, damage in until(options.seconds, cases, options.seed):
            path = stores[kind].copy()
            damage(path / file, chance)
            tried[damage.__name__] += 1
            faults += faults_of(path, f"{kind}, {file} {damage.__name__}", stores[kind])
    print(json.dumps({"tried": tried, "of": len(cases), "faults": faults}, indent=1))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
