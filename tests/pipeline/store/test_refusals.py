"""All refusals of stores: what causes each, and what its message says."""

import os
import shutil
from pathlib import Path

import zarr

import tribo
from pipeline import open_sweep, summary, verify_store
from pipeline.store import lock
from pipeline.store.create import writing
from pipeline.store.place import LOCK, ROOT, place_of
from pipeline.store.schema import require_free_names
from tests.helpers import tiny
from tests.helpers.entries import placed_rows
from tests.helpers.refusals import refusal_tests
from tests.helpers.stores import commit, forge

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


def relink(path):
    (path / LOCK).unlink(missing_ok=True)
    (path / LOCK).hardlink_to(path / ROOT)


def forged(change):
    """Function that gives a store a root with other values and the right hash."""

    def write(path):
        forge(path, path / ROOT, change)

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


def unfinished(is_held):
    """Read a store whose root is not written yet, whether locked or not."""
    Path("a.zarr/status").mkdir(parents=True)
    if not is_held:
        Path("a.zarr", LOCK).touch()
        return summary("a.zarr")
    with lock.locked(place_of("a.zarr")):
        return summary("a.zarr")


def in_use():
    with writing("a.zarr", SWEEP):
        commit("a.zarr", SWEEP, ())


def with_another_variable():
    commit("a.zarr", SWEEP, ())
    forged(lambda _, arrays: arrays.update(mine={"dimension_names": ["load"]}))(Path("a.zarr"))
    commit("a.zarr", tiny.full(loads=(700.0,)), ())


def grown():
    commit("a.zarr", SWEEP, ())
    commit("a.zarr", tiny.full(loads=(50.0, 150.0)), ())


def by_xarray():
    open_sweep("tiny.zarr").to_zarr("a.zarr", consolidated=False)
    commit("a.zarr", SWEEP, ())


def copy_cut():
    open_sweep("tiny.zarr").to_zarr("a.zarr", consolidated=False)
    for file in Path("a.zarr/max_rise/c").rglob("0"):
        if file.is_file():
            file.write_bytes(b"1")
    verify_store("a.zarr")


def below_file():
    Path("file").touch()
    commit("file/a.zarr", SWEEP, ())


def foreign():
    Path("a.zarr").mkdir()
    Path("a.zarr", ROOT).write_text('{"zarr_format": 3, "node_type": "group", "attributes": {}}')
    return summary("a.zarr")


def folder():
    Path("mine").mkdir()
    Path("mine", "thesis.tex").touch()
    return summary("mine")


def file():
    Path("mine").touch()
    return summary("mine")


REFUSALS = {
    # paths
    "top": (lambda: place_of("/"), "/ cannot be a store; give a folder below it"),
    "below": (below_file, "cannot be written: File exists"),
    "nothing": (lambda: summary("a.zarr"), "there is no store at "),
    "file": (file, "mine is no store"),
    "folder": (folder, "mine is no store: it is a folder with other files"),
    "foreign": (foreign, "zarr.json is that of another program"),
    "address": (lambda: commit("memory://a.zarr", SWEEP, ()), "memory://a.zarr can only be read"),
    # locks
    "hard link": (changed(lambda path: relink(path), go_on),
                  "cannot be written: it is a hard link, so it has another name"),
    "in use": (in_use, f"in use by process {os.getpid()}"),
    "elsewhere": (changed(put(LOCK, b"process 7 on node7\n"), go_on),
                  "on node7; if that has ended, delete"),
    "unfinished": (lambda: unfinished(is_held=False), "there is no store at "),
    "being made": (lambda: unfinished(is_held=True), "is being made by process"),
    # the root
    "old": (changed(forged(lambda texts, _: texts["store"].update(format=3))), "of format 3"),
    "variable": (changed(forged(lambda texts, _: texts["store"]["axes"].update(mine=[1.0]))),
                 "zarr.json is damaged, or not"),
    "inputs": (lambda: measured(put("inputs/c.0", b"1")), "zarr.json is damaged, or not"),
    "exchanged": (lambda: measured(exchange), "zarr.json is damaged, or not"),
    "sweep": (changed(forged(lambda texts, _: texts["sweep"]["entries"]["sweep"].update(loads=3))),
              "zarr.json is damaged, or not"),
    "why": (changed(forged(lambda texts, _: texts["sweep"]["entries"]["pin"].update(radius=-1))),
            "the text of a sweep: pin.radius: -1 has no unit; give"),
    "chunks": (changed(forged(lambda texts, _: texts["store"].update(points_per_chunk={}))),
               "zarr.json is damaged, or not"),
    "labels": (changed(forged(lambda texts, _: texts["store"]["axes"].update(load=[[1.0]]))),
               "zarr.json is damaged, or not"),
    "lost": (changed(lambda path: (path / ROOT).unlink()), "it has lost its zarr.json; restore it"),
    "copy, cut": (copy_cut, "the copy cannot be read"),
    "copy": (by_xarray, "zarr.json is that of a copy by xarray, which can be read"),
    # files
    "chunk": (changed(put("max_rise/c.0.0.0", b"1"), load), "damaged"),
    "statuses": (changed(lambda path: (path / "status" / "c.0.0").unlink()),
                 "status cannot be read; irg verify names what is damaged"),
    "missing": (changed(lambda path: (path / "steps" / "c.0.0").unlink(), load), "damaged"),
    "beside": (with_another_variable, "mine, an array added by a user, would not grow with it"),
    "grown": (grown, "these points: load can only grow at its upper end; write a new store"),
    "label": (lambda: require_free_names(tiny.sweep(variants=placed_rows(
        (250.0, 1.0, {"time": 1.0})))),
              "a column of the rows is called time"),
}  # fmt: skip

ELSEWHERE = {
    "files.open_file OSError": "row of the hard link, which tells it as a StoreError",
    "files._require_no_link OSError": "rows of links, which tell it as a StoreError",
    "place.keys StoreError": "test_create.py, with a web server",
    "root_file.require_same_scene StoreMismatchError": "test_create.py, in several lines",
    "write._require_lock StoreError": "test_lock.py",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "store", REFUSALS, ELSEWHERE, tiny="alone"
)
