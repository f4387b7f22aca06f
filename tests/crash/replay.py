"""Cut the power after every file operation of a scenario, as file systems may lose what came last.

What the scenario does to its files is recorded, and replayed up to each operation by the rules of

- ext4 and XFS: names change in the order in which they were changed, up to any of those since the
  last sync; what was written into a file and not synced may be missing, in whole or in part;
- POSIX, strictly: a name is sure only once its folder was synced, each folder on its own, and
  content once its file was.

The store that is left must open, and what was acknowledged must be there. Prints a JSON document.
"""

import argparse
import io
import itertools
import json
import os
import random
import shutil
import sys
import tempfile
import warnings
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from unittest import mock

import numpy as np

from tests.crash import scenario
from tests.crash.bounded import add_seconds, until

RULES = ("ext4", "xfs", "posix")


class Recorder:
    """Notes what is done to the files below a folder.

    Attributes
    ----------
    done : list of tuple
        ("make", path, file), ("write", file, content), ("sync", file), ("rename", old, new),
        ("remove", path), ("folder", path), ("sync folder", path), ("told", how, point).
    """

    def __init__(self, root):
        self.done, self._root, self._files, self._number = [], os.fspath(root), {}, 0
        self._real = {name: getattr(os, name) for name in _HOOKED}
        self._io_open = io.open

    def __enter__(self):
        self._stack = ExitStack()
        for name in _HOOKED:
            self._stack.enter_context(mock.patch.object(os, name, getattr(self, name)))
        self._stack.enter_context(mock.patch.object(io, "open", self.io_open))
        return self

    def __exit__(self, *_):
        self._stack.close()

    def _is_ours(self, path):
        return isinstance(path, str | os.PathLike) and os.fspath(path).startswith(self._root)

    def open(self, path, flags, *arguments, **options):
        file = self._real["open"](path, flags, *arguments, **options)
        if self._is_ours(path):
            if flags & os.O_CREAT:
                self._number += 1
                self._files[file] = self._number
                self.done.append(("make", os.fspath(path), self._number))
            else:
                self._files[file] = os.fspath(path)
        return file

    def io_open(self, path, mode="r", *arguments, **options):
        opened = self._io_open(path, mode, *arguments, **options)
        if self._is_ours(path) and set(mode) & set("wx"):
            self._number += 1
            self.done.append(("make", os.fspath(path), self._number))
            write, number = opened.write, self._number

            class Written:
                def __enter__(self):
                    return self

                def __exit__(self, *_):
                    opened.close()

                def write(self, content):
                    recorder.done.append(("write", number, bytes(content)))
                    return write(content)

            recorder = self
            self._by_path = {**getattr(self, "_by_path", {}), os.fspath(path): number}
            return Written()
        return opened

    def write(self, file, content):
        if file in self._files:
            self.done.append(("write", self._files[file], bytes(content)))
        return self._real["write"](file, content)

    def fsync(self, file):
        self._real["fsync"](file)
        at = self._files.get(file)
        if isinstance(at, int):
            self.done.append(("sync", at))
        elif at in getattr(self, "_by_path", {}):
            self.done.append(("sync", self._by_path[at]))
        elif at is not None:
            self.done.append(("sync folder", at))

    def close(self, file):
        self._files.pop(file, None)
        self._real["close"](file)

    def replace(self, old, new, **options):
        self._real["replace"](old, new, **options)
        if self._is_ours(new):
            self.done.append(("rename", os.fspath(old), os.fspath(new)))

    def unlink(self, path, **options):
        self._real["unlink"](path, **options)
        if self._is_ours(path):
            self.done.append(("remove", os.fspath(path)))

    def mkdir(self, path, *arguments, **options):
        self._real["mkdir"](path, *arguments, **options)
        if self._is_ours(path):
            self.done.append(("folder", os.fspath(path)))


_HOOKED = ("open", "write", "fsync", "close", "replace", "unlink", "mkdir")
_OF_NAMES = ("make", "rename", "remove", "folder")


def folder_of(operation):
    """The folder whose entries an operation changes."""
    return str(Path(operation[-1] if operation[0] == "rename" else operation[1]).parent)


def kept(done, rule, chance):
    """Operations on names that survive a cut after the last of `done`, in their order."""
    names = [(n, each) for n, each in enumerate(done) if each[0] in _OF_NAMES]
    if rule == "posix":
        sure = {}
        for n, each in enumerate(done):
            if each[0] == "sync folder":
                sure[each[1]] = n
        # In a folder, what was done since its last sync is there up to some point, or not at all.
        until = {}
        for folder in sorted({folder_of(each) for _, each in names}):
            known = sure.get(folder, -1)
            late = [n for n, each in names if n > known and folder_of(each) == folder]
            until[folder] = chance.choice([known, *late])
        return [each for n, each in names if n <= until[folder_of(each)]]
    synced = max((n for n, each in enumerate(done) if each[0].startswith("sync")), default=-1)
    until = chance.choice([synced, *(n for n, _ in names if n > synced)])
    return [each for n, each in names if n <= until]


def left(done, rule, chance):
    """Files and folders after a power cut: contents by path, None for folders."""
    contents, sure = {}, {}
    for each in done:
        if each[0] == "write":
            contents[each[1]] = contents.get(each[1], b"") + each[2]
        elif each[0] == "sync":
            sure[each[1]] = contents.get(each[1], b"")
    there = {}
    for each in kept(done, rule, chance):
        if each[0] == "make":
            there[each[1]] = each[2]
        elif each[0] == "folder":
            there[each[1]] = None
        elif each[0] == "remove":
            there.pop(each[1], None)
        elif each[1] in there:
            there[each[2]] = there.pop(each[1])
    found = {}
    for path, file in there.items():
        if file is None:
            found[path] = None
        elif file in sure and sure[file] == contents.get(file, b""):
            found[path] = sure[file]
        else:
            whole = contents.get(file, b"")
            found[path] = chance.choice([b"", bytes(len(whole)), whole[: len(whole) // 2], whole])
    return found


def laid(found, root, target):
    """Write what is left below another folder; a file whose folder was lost is lost with it."""
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    there = {os.fspath(root)}
    for path in sorted(found, key=len):
        if str(Path(path).parent) not in there:
            continue
        place = target / os.path.relpath(path, root)
        if found[path] is None:
            there.add(path)
            place.mkdir(exist_ok=True)
        else:
            place.write_bytes(found[path])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="operations to go on by")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rename-first", action="store_true", help="make the mistake to find")
    add_seconds(parser)
    options = parser.parse_args()
    warnings.simplefilter("error")
    np.seterr(all="raise", under="ignore")
    scenario.results()
    chance, tried, faults = random.Random(options.seed), Counter(), []
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as top:
        root, target = Path(top) / "real", Path(top) / "left"
        root.mkdir()
        recorder = Recorder(root)
        with recorder:
            scenario.run(
                root / "out.zarr", lambda how, point: recorder.done.append(("told", how, point))
            )
        done = recorder.done
        if options.rename_first:
            done = renamed_first(done)
        ends = range(1 + options.every // 2, len(done) + 1, options.every)
        for end, rule in until(options.seconds, itertools.product(ends, RULES)):
            told = [each[1:] for each in done[:end] if each[0] == "told"]
            laid(left(done[:end], rule, chance), root, target)
            tried[rule] += 1
            try:
                found = scenario.check(target / "out.zarr", told)
            except Exception as error:
                found = [f"{type(error).__name__}: {error}"]
            faults += [f"{rule}, cut after {end} of {len(done)}: {fault}" for fault in found]
    report = {"operations": len(done), "cuts": tried, "lost": len(faults), "faults": faults[:20]}
    print(json.dumps(report, indent=1))
    return 1 if faults else 0


def renamed_first(done):
    """The same operations, with no sync of a file before it has its name."""
    made = {each[1]: each[2] for each in done if each[0] == "make"}
    late, changed = [], []
    for each in done:
        if each[0] == "sync":
            late.append(each)
            continue
        changed.append(each)
        if each[0] == "rename" and ("sync", made.get(each[1])) in late:
            late.remove(("sync", made[each[1]]))
    return changed


if __name__ == "__main__":
    sys.exit(main())
