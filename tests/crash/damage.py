"""Damage of a file of a store: flipped, cut, emptied, zeroed, deleted, or an older one.

`irg verify` names it or it is harmless, and no command ends with a traceback. No other numbers are
printed without a word, except for an older chunk, which `irg verify` names.
After one run the store is what it was, whichever file was damaged.
Files are those of two stores, with fields and without; each kind of file is as likely.
"""

import contextlib
import functools
import io
import json
import shutil
import time
import traceback
from contextlib import ExitStack
from pathlib import Path
from unittest import mock

import pipeline
from pipeline.cli import main as irg
from pipeline.store import create, status
from pipeline.store.points import Damage
from pipeline.store.root import FACTS
from tests.crash.loop import PATIENCE, Forked, code_of, differing, indexed_points, values_of_points
from tests.crash.sweeps import EXPECTED, STAGES
from tests.helpers.entries import changed

TRIALS = 300
MISTAKE = "unchecked"
_COMMANDS = ("status", "boundary", "verify")


def _flipped(file, chance, older):
    content = bytearray(file.read_bytes())
    if content:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    file.write_bytes(content)


def _cut(file, chance, older):
    content = file.read_bytes()
    file.write_bytes(content[: chance.randrange(len(content))] if content else b"")


def _emptied(file, chance, older):
    file.write_bytes(b"")


def _deleted(file, chance, older):
    file.unlink()


def _zeroed(file, chance, older):
    file.write_bytes(bytes(file.stat().st_size))


def _restored(file, chance, older):
    """Replace a file by its older version from when half of the points were done, with its time."""
    if older.exists():
        shutil.copy2(older, file)
    else:
        file.unlink()


_KINDS = (_flipped, _flipped, _cut, _emptied, _deleted, _zeroed, _restored)
_SOUND = (_restored,)  # damage after which a chunk may be sound


def called(*arguments):
    """Exit code, stdout and stderr of a command; (None, stdout, traceback) if it raises."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = irg([str(argument) for argument in arguments])
        except SystemExit as error:
            code = error.code
        except BaseException:
            return None, out.getvalue(), traceback.format_exc()[-400:]
    return code, out.getvalue(), err.getvalue()


def _answer(*arguments):
    """Exit code, JSON document and stderr of a command that prints JSON."""
    code, out, err = called(*arguments)
    return code, json.loads(out) if out else [], err


class _Original:
    """A complete store, whose copies are damaged, and its state when half of it was done."""

    def __init__(self, run, fields):
        name = "fields" if fields else "plain"
        self.path, self.older = run.folder / f"{name}.zarr", run.folder / f"{name}.older.zarr"
        self.log = run.folder / f"acknowledged {name}"
        self._sweep = changed(STAGES[-1], fields=fields)
        self._records = EXPECTED.records(self._sweep)
        self._begin()
        self.resume(self.path)
        self.files: dict[str, list[Path]] = {}
        for file in sorted(file for file in self.path.rglob("*") if file.is_file()):
            within = file.relative_to(self.path)
            is_chunk, is_root = file.name.startswith("c."), within == Path(FACTS)
            kind = str(within.parent) if is_chunk else "root" if is_root else within.name
            self.files.setdefault(kind, []).append(within)
        self.boundary = _answer("boundary", self.path, "--json")[1]

    def _begin(self):
        driver = Forked(self._sweep, self.path, self.log, self._records, pace=0.05)
        limit, half = time.monotonic() + PATIENCE, len(self._records) // 2
        while time.monotonic() < limit and driver.poll() is None:
            if self.log.exists() and len(self.log.read_text().splitlines()) >= half:
                break
            time.sleep(0.01)
        driver.kill()
        driver.wait()
        shutil.copytree(self.path, self.older)

    def resume(self, path):
        return code_of(Forked(self._sweep, path, self.log, self._records))

    def faults(self, path):
        """Yield faults of a store that should be equal to this one."""
        with pipeline.open_sweep(path) as ds:
            arrays = values_of_points(ds)
            for index, point in indexed_points(ds):
                names = list(differing(arrays, index, EXPECTED(point)))
                if arrays["status"][index] != 1 or names:
                    yield f"{point}: {names} differ"
        if called("verify", path)[0] != 0:
            yield f"not clean: {called('verify', path)[1:]}"


def _faults_of(path, original, kind):
    """Yield faults of the commands on a damaged store, and of the store after a resume."""
    answers = {name: _answer(name, path, "--json") for name in _COMMANDS}
    for name, (code, _, err) in answers.items():
        if code is None:
            yield f"{name}: {err}"
        elif code == 2 and not any(word in err for word in ("irg verify", "another store")):
            yield f"{name} does not say what to do: {err}"
    code, out, _ = answers["boundary"]
    pending = answers["status"][0] == 0 and answers["status"][1][0]["pending"]
    is_named = answers["verify"][0] != 0 and kind in _SOUND
    if code == 0 and out != original.boundary and not (pending or is_named):
        yield f"the boundary is another, and nothing says so: {out}"
    if answers["verify"][0] == 0 and not pending and (code != 0 or out != original.boundary):
        yield f"verify names nothing, and the boundary is not as before: {code} {out}"
    if code := original.resume(path):
        yield f"a run ends with {code}: {original.log.with_suffix('.err').read_text()[-400:]}"
    for fault in original.faults(path):
        yield f"after a run, {fault}"


def campaign(run):
    """Damage `run.count` files, one after the other, each in a new copy of a store."""
    original_store = functools.cache(lambda fields: _Original(run, fields))
    # The codec itself notices most other damage.
    kinds = (_cut, _deleted) if run.mistake else _KINDS
    # With the mistake, no damage is found.
    unfound = ExitStack()
    for module in (create, status) if run.mistake else ():
        unfound.enter_context(mock.patch.object(module, "find_damage", return_value=Damage({}, [])))
    with unfound:
        for number in range(run.count):
            original = original_store(bool(run.mistake) or number % 2 == 0)
            kind = run.chance.choice(kinds)
            # Each chunk of a field belongs to a single point.
            among = ["fields/pressure"] if run.mistake else sorted(original.files)
            file = run.chance.choice(original.files[run.chance.choice(among)])
            path = run.folder / "out.zarr"
            shutil.rmtree(path, ignore_errors=True)
            shutil.copytree(original.path, path)
            kind(path / file, run.chance, original.older / file)
            kind_name = kind.__name__.strip("_")
            run.report.counts[kind_name] += 1
            try:
                faults = _faults_of(path, original, kind)
                run.report.faults += [f"{file} {kind_name}: {fault}" for fault in faults][:3]
            except Exception:
                run.report.faults.append(f"{file} {kind_name}: {traceback.format_exc()[-400:]}")
