"""Damage of a file of a store: a bit flipped, cut, emptied, zeroed, deleted, or filled by another.

`irg verify` names it or it is harmless, no command ends with a traceback or prints other numbers
without a word, and after `irg verify --repair` and a run the store is what it was.
"""

import contextlib
import io
import json
import shutil
import traceback
from contextlib import nullcontext
from unittest import mock

import pipeline
from pipeline.cli import main as irg
from pipeline.store import verify as verifying
from tests.crash.loop import Forked, code_of, differing, places
from tests.crash.sweeps import STAGES

TRIALS = 60
MISTAKE = "unchecked"
_COMMANDS = ("status", "boundary", "verify")


def _flipped(file, chance):
    content = bytearray(file.read_bytes())
    if content:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    file.write_bytes(content)


def _cut(file, chance):
    content = file.read_bytes()
    file.write_bytes(content[: chance.randrange(len(content))] if content else b"")


def _emptied(file, chance):
    file.write_bytes(b"")


def _deleted(file, chance):
    file.unlink()


def _zeroed(file, chance):
    file.write_bytes(bytes(file.stat().st_size))


def _swapped(file, chance):
    """Give a file the content of another one of the store."""
    others = sorted(other for other in file.parents[1].rglob("c.*") if other != file)
    file.write_bytes(chance.choice(others).read_bytes())


_KINDS = (_flipped, _flipped, _cut, _emptied, _deleted, _zeroed, _swapped)


def called(*arguments):
    """Exit code, output and messages of a command; None and its traceback if it has one."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = irg([str(argument) for argument in arguments])
        except SystemExit as error:
            code = error.code
        except BaseException:
            return None, out.getvalue(), traceback.format_exc()[-400:]
    return code, out.getvalue(), err.getvalue()


class _Whole:
    """A complete store, of which copies are damaged."""

    def __init__(self, run):
        self.path, self.log = run.folder / "whole.zarr", run.folder / "acknowledged"
        self.expected, self.records = run.expected, run.records
        self.resume(self.path)
        files = sorted(file for file in self.path.rglob("*") if file.is_file())
        self.files = [file.relative_to(self.path) for file in files]
        self.boundary = called("boundary", self.path, "--json")[1]

    def resume(self, path):
        return code_of(Forked(STAGES[-1], path, self.log, self.records))

    def faults(self, path):
        """Faults of a store that should be as this one."""
        with pipeline.open_sweep(path) as ds:
            arrays = {name: ds[name].values for name in ds.data_vars}
            for index, point in places(ds):
                names = list(differing(arrays, index, self.expected(point)))
                if arrays["status"][index] != 1 or names:
                    yield f"{point}: {names} differ"
        if called("verify", path)[0] != 0:
            yield f"not clean: {called('verify', path)[1:]}"


def _faults_of(path, whole):
    """Faults of the answers of commands to a damaged store, and of what becomes of it."""
    answers = {name: called(name, path, "--json") for name in _COMMANDS}
    for name, (code, _, err) in answers.items():
        if code is None:
            yield f"{name}: {err}"
        elif code == 2 and not any(word in err for word in ("irg verify", "backup")):
            yield f"{name} does not say what to do: {err}"
    code, out, _ = answers["boundary"]
    pending = answers["status"][0] == 0 and json.loads(answers["status"][1])["pending"]
    if code == 0 and out != whole.boundary and not pending:
        yield f"the boundary is another, and nothing says so: {out}"
    if answers["verify"][0] == 0 and (code != 0 or out != whole.boundary):
        yield f"verify names nothing, and the boundary is not as before: {code} {out}"
    code, _, err = called("verify", path, "--repair")
    if code not in (0, 1):
        if "backup" not in err:
            yield f"verify --repair ends with {code}: {err}"
        return
    if code := whole.resume(path):
        yield f"a run after the repair ends with {code}"
    for fault in whole.faults(path):
        yield f"after a repair and a run, {fault}"


def campaign(run):
    """Damage so many files, the one after the other."""
    whole = _Whole(run)
    # Most other damage is noticed by the codec already.
    kinds = (_swapped,) if run.mistake else _KINDS
    cases = [(file, kind) for file in whole.files for kind in kinds]
    cases = run.chance.sample(cases, min(run.count, len(cases)))
    # Checksums of points are left unread.
    wrong = mock.patch.object(verifying, "_OTHER", "") if run.mistake else nullcontext()
    with wrong:
        for file, kind in cases:
            path = run.folder / "out.zarr"
            shutil.rmtree(path, ignore_errors=True)
            shutil.copytree(whole.path, path)
            kind(path / file, run.chance)
            what = kind.__name__.strip("_")
            run.report.counts[what] += 1
            try:
                faults = [f"{file} {what}: {fault}" for fault in _faults_of(path, whole)]
                run.report.faults += faults[:3]
            except Exception:
                run.report.faults.append(f"{file} {what}: {traceback.format_exc()[-400:]}")
