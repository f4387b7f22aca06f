"""All refusals of stores: what causes each, and what its message says."""

import os
import shutil
from pathlib import Path

import xarray as xr
import zarr

import tribo
from pipeline import boundary, open_sweep, summary, verify_store
from pipeline.store import lock
from pipeline.store.create import writing
from pipeline.store.location import ROOT, location_of
from pipeline.store.root import FACTS
from pipeline.store.schema import require_free_names
from tests.helpers import tiny
from tests.helpers.entries import placed_rows
from tests.helpers.refusals import refusal_tests
from tests.helpers.stores import commit, forge, lock_of

SWEEP = tiny.full()


def changed(change, read=summary):
    """Function that reads a copy of a store after a change."""

    def build():
        shutil.copytree("tiny.zarr", "a.zarr")
        change(Path("a.zarr"))
        return read("a.zarr")

    return build


def go_on(path):
    commit(path, SWEEP, ())


def load(path):
    open_sweep(path).load()


def put(name, content):
    return lambda path: (path / name).write_bytes(content)


def put_root(content):
    """Function that replaces one document with the data of the sweep, and deletes the other."""

    def write(path):
        (path / FACTS).write_bytes(content)
        (path / ROOT).unlink()

    return write


def flip_root(path):
    put_root((path / FACTS).read_bytes().replace(b"tiny", b"huge"))(path)


def lose_root(path):
    for key in (FACTS, ROOT):
        (path / key).unlink()


def folder_for_a_file(path):
    (path / "about/message/c.0.0").unlink()
    (path / "about/message/c.0.0").mkdir()


def file_for_a_folder(path):
    shutil.rmtree(path / "mean_rise")
    (path / "mean_rise").touch()


def lock_elsewhere(path):
    lock_of(path).write_text("process 7 on node7\n")


def forged(change):
    """Function that gives a store other facts and their right digest."""

    def write(path):
        forge(path, change)

    return write


def measured(change):
    """Read a store with a measured surface after a change of its chunk."""
    heights = SWEEP.scene.roughness.heights(SWEEP.scene.pixels)
    commit("a.zarr", tiny.full(roughness=tribo.MeasuredRoughness(heights)), ())
    change(Path("a.zarr"))
    return summary("a.zarr")


def exchange(path):
    """Set the heights of a store to zero, with a sound checksum."""
    zarr.open_group(path, mode="r+")["inputs"][:] = 0.0


def unfinished():
    """Read a store whose root is not written yet while it is locked."""
    with lock.locked(location_of("a.zarr")):
        return summary("a.zarr")


def in_use():
    with writing("a.zarr", SWEEP):
        commit("a.zarr", SWEEP, ())


def with_a_file(name):
    commit("a.zarr", SWEEP, ())
    Path("a.zarr", name).touch()
    commit("a.zarr", tiny.full(loads=(700.0,)), ())


def foreign():
    Path("a.zarr").mkdir()
    Path("a.zarr", ROOT).write_text('{"zarr_format": 3, "node_type": "group", "attributes": {}}')
    return summary("a.zarr")


def replaced():
    """Judge points that plain xarray loaded before another scene was run into their store."""
    commit("a.zarr", SWEEP, ())
    ds = xr.open_zarr("a.zarr").load()
    shutil.rmtree("a.zarr")
    commit("a.zarr", tiny.full(title="Another scene"), ())
    return boundary(ds)


def of_file(name):
    Path(name).write_text("[pin]\n")
    return summary(name)


OLD = b'{"attributes": {"format": 3, "history": ["computed by irg-transition 0.1"]}}'

REFUSALS = {
    # paths
    "top": (lambda: location_of("/"), "/ cannot be a store; choose a folder below it"),
    "nothing": (lambda: summary("a.zarr"), "no store at "),
    "foreign": (foreign, "it is of another program, or has lost its about/zarr.json"),
    "memory": (lambda: commit("memory://b.zarr", SWEEP, ()), "memory://b.zarr can only be read"),
    "scene": (lambda: of_file("a.toml"), "it is a scene file; run it with irg run"),
    "text": (lambda: of_file("a.txt"), "it is not a folder; give the folder written by irg run"),
    "address": (lambda: commit("http://a/b.zarr", SWEEP, ()), "http://a/b.zarr can only be read"),
    # locks
    "link": (changed(lambda path: lock_of(path).symlink_to(path), go_on), "cannot be written: "),
    "in use": (in_use, f"in use by process {os.getpid()}"),
    "elsewhere": (changed(lock_elsewhere, go_on),
                  "on node7; if that has ended, delete"),
    "being made": (unfinished, "is being created by process"),
    # the root
    "old": (changed(put_root(OLD)), "its format is 3, this version reads"),
    "torn": (changed(put_root(b"{")), "is damaged (JSONDecodeError"),
    "digest": (changed(flip_root), "it is not what was written"),
    "inputs": (lambda: measured(put("inputs/c.0", b"1")), "inputs cannot be read"),
    "exchanged": (lambda: measured(exchange), "other numbers than were written"),
    "file": (lambda: location_of("a.nc"), "a.nc cannot be a store, which is a Zarr folder; give"),
    "many points": (changed(forged(lambda sweep, _: sweep.update(
        loads=[*range(1, 5000)], velocities=[*range(1, 5000)]))), "2.499e+07 points are too many"),
    "many cases": (changed(forged(lambda sweep, _: sweep.update(cases=[{}] * 10_001))),
                   "the sweep of the store has 10001 cases; at most 10000 can be kept; read it"),
    "many brackets": (changed(put_root(b"[" + b"[]," * 300_000 + b"[]]")),
                      "it has 600002 brackets and commas; at most"),
    "long root": (changed(put_root(b" " * 10_000_001)),
                  "it has 10 MB; at most 10 MB are read"),
    "long title": (lambda: commit("a.zarr", tiny.sweep(title="x" * 4_000_000), ()),
                   "the data of the sweep are too large for a store: it has 8.0"),
    "kind": (changed(forged(lambda sweep, _: sweep["case_table"].update(columns=["a"]))),
             "'str' object has no attribute 'name'; read it with that version, or run the scene"),
    "many inputs": (changed(forged(lambda _, facts: facts.update(inputs={"a": 10**9}))),
                    "it contains 1e+09 numbers of the scene's files"),
    "why": (changed(forged(lambda sweep, _: sweep["base"]["scene"]["pin"].update(radius=-1))),
            "another version of this program (computed by irg-transition"),
    "lost": (changed(lose_root), "its about/zarr.json is lost; irg run restores it with the scene"),
    "lost for a run": (changed(lose_root, lambda path: commit(path, tiny.full(increments=7), ())),
                       "its about/zarr.json is lost; irg run restores it with the scene"),
    "group": (lambda: verify_store("tiny.zarr/fields/rise"), "it is a part of the store "),
    "replaced": (replaced, "a.zarr now; open it again, and keep its attributes"),
    # files
    "chunk": (changed(put("max_rise/c.0.0.0", b"1"), load), "damaged"),
    "statuses": (changed(lambda path: (path / "status" / "c.0.0").unlink()),
                 "status cannot be read; irg verify names what is damaged"),
    "folder in a file's place": (changed(folder_for_a_file, verify_store),
               "message/c.0.0 cannot be read: it is a folder, where a store has a file"),
    "file in a folder's place": (changed(file_for_a_folder, verify_store),
             "mean_rise cannot be read: it is a file, where a store has a folder"),
    "missing": (changed(lambda path: (path / "mean_rise" / "c.0.0.0").unlink(), load),
                "mean_rise is missing at 150 N, 0.5 m/s and at 8 more; irg verify"),
    "notes": (lambda: with_a_file("notes.txt"), "notes.txt, which is not of this program, would"),
    "notes on an array": (lambda: with_a_file("status/notes.txt"), "notes.txt, which is not of"),
    "label": (lambda: require_free_names(tiny.sweep(case_table=placed_rows(
        (250.0, 1.0, {"time": 1.0})))),
              "a column of the cases is called time"),
}  # fmt: skip

ELSEWHERE = {
    "files.store_file OSError": "rows of links, which tell it as a StoreError",
    "location.keys StoreError": "test_create.py, with a web server",
    "create._require_same_scene StoreMismatchError": "test_create.py, in several lines",
    "create._open _not_extensible": "test_s3.py: on an object store",
    "resume._union InputError": "test_create.py, as a StoreMismatchError",
    "create._replace _not_extensible": "a done point without a place, which no sweep makes",
    "lock.locked StoreError": "a run that ended between opening the lock and taking it",
    "store._require_lock StoreError": "test_writing.py",
    "store.read StoreError": "test_writing.py: enlarged since it was opened",
    "root.read_root StoreError": "a run that was cut short between two renames",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "store", REFUSALS, ELSEWHERE, tiny="tiny_store"
)
