"""All refusals of stores: what causes each; tests/kept has what it says."""

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
from tests.helpers.stores import commit, forge, lock_of, write_facts

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


def facts(content):
    """Function that replaces the facts of a store, of which no copy is left."""
    return lambda path: write_facts(path, content)


def change_a_word(path):
    write_facts(path, (path / FACTS).read_bytes().replace(b"tiny", b"huge"))


def lose_facts(path):
    write_facts(path, b"")
    (path / FACTS).unlink()


def link_folder(path):
    (path / "mean_rise").rename("mean_rise")
    (path / "mean_rise").symlink_to(Path("mean_rise").resolve())


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
    "top": lambda: location_of("/"),
    "nothing": lambda: summary("a.zarr"),
    "foreign": foreign,
    "scene": lambda: of_file("a.toml"),
    "text": lambda: of_file("a.txt"),
    "folder of stores": lambda: summary(Path("tiny.zarr").resolve().parent),
    "address": lambda: commit("http://a/b.zarr", SWEEP, ()),
    # locks
    "link": changed(lambda path: lock_of(path).symlink_to(path), go_on),
    "linked folder": changed(link_folder, go_on),
    "in use": in_use,
    "elsewhere": changed(lock_elsewhere, go_on),
    "being made": unfinished,
    # the root
    "old": changed(facts(OLD)),
    "torn": changed(facts(b"{")),
    "digest": changed(change_a_word),
    "inputs": lambda: measured(put("inputs/c.0", b"1")),
    "exchanged": lambda: measured(exchange),
    "file": lambda: location_of("a.nc"),
    "many points": changed(forged(lambda sweep, _: sweep.update(
        loads=[*range(1, 5000)], velocities=[*range(1, 5000)]))),
    "many brackets": changed(facts(b"[" * 300_000 + b"]" * 300_000)),
    "kind": changed(forged(lambda sweep, _: sweep["case_table"].update(columns=["a"]))),
    "many inputs": changed(forged(lambda _, facts: facts.update(inputs={"a": 10**9}))),
    "why": changed(forged(lambda sweep, _: sweep["base"]["scene"]["pin"].update(radius=-1))),
    "later": changed(forged(lambda sweep, _: sweep["base"]["scene"]["wear"].update(later=8))),
    "lost": changed(lose_facts),
    "group": lambda: verify_store("tiny.zarr/fields/rise"),
    "inner store": lambda: commit("tiny.zarr/new.zarr", SWEEP, ()),
    "replaced": replaced,
    # files
    "chunk": changed(put("max_rise/c.0.0.0", b"1"), load),
    "statuses": changed(lambda path: (path / "status" / "c.0.0").unlink()),
    "missing": changed(lambda path: (path / "mean_rise" / "c.0.0.0").unlink(), load),
    "notes": lambda: with_a_file("notes.txt"),
    "notes on an array": lambda: with_a_file("status/notes.txt"),
    "label": lambda: require_free_names(tiny.sweep(case_table=placed_rows(
        (250.0, 1.0, {"time": 1.0})))),
}  # fmt: skip

ELSEWHERE = {
    "create._require_same_scene StoreMismatchError": "test_create.py, in several lines",
    "create._union InputError": "test_create.py, as a StoreMismatchError",
    "lock.locked StoreError": "a run that ended between opening the lock and taking it",
    "store._require_lock StoreError": "test_writing.py",
    "store.read StoreError": "test_create.py: enlarged since it was opened",
    "root.read_root StoreError": "a run that was cut short between two renames",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "store", REFUSALS, ELSEWHERE, tiny="tiny_store"
)
