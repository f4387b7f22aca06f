"""Links, bombs and forged roots in a store are noticed, and nothing is done by way of them."""

import json
import math
import os
import random
import shutil
import tracemalloc
from contextlib import suppress

import numpy as np
import pytest
from numcodecs.zstd import Zstd

import pipeline
import tribo
from pipeline import StoreError
from pipeline.cli import main
from pipeline.store import store as stored
from pipeline.store.create import writing
from pipeline.store.files import PARTIAL
from pipeline.store.place import LOCK, ROOT
from pipeline.store.root import FACTS
from pipeline.store.schema import path_of
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.stores import commit, forge, places, record

SWEEP = tiny.full()
FIELD, CHUNK = "fields/rise/c.0.0.0", "mean_rise/c.0.0.0"
KEY = "a private key"


@pytest.fixture
def outside(tmp_path):
    """A folder beside the store, with files named like those of a store."""
    for name in (LOCK, FIELD, CHUNK, f"load/c.0{PARTIAL}", "load/zarr.json", "status/c.0.0", "key"):
        (tmp_path / "outside" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "outside" / name).write_text(KEY)
    return tmp_path / "outside"


def tree(folder):
    """Targets of links and contents of files below a folder, by relative path."""
    return {
        path.relative_to(folder): path.readlink() if path.is_symlink() else path.read_bytes()
        for path in folder.rglob("*")
        if path.is_symlink() or path.is_file()
    }


def link(path, target):
    """Replace a file or folder, if it exists, by a link; return its path."""
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    path.symlink_to(target)
    return path


LINKS = {
    "lock": lambda store, out: link(store / LOCK, out / "key"),
    "pipe for a lock": lambda store, out: ((store / LOCK).unlink(), os.mkfifo(store / LOCK)),
    "folder of chunks": lambda store, out: link(store / "mean_rise", out / "mean_rise"),
    "folder with a file half written": lambda store, out: link(store / "load", out / "load"),
    "root": lambda store, out: link(store / "zarr.json", out / "key"),
    "chunk": lambda store, out: link(store / CHUNK, out / "key"),
}


@pytest.mark.parametrize("lay", LINKS.values(), ids=LINKS)
def test_nothing_is_written_by_way_of_a_link(copy, outside, lay):
    lay(copy, outside)
    before = tree(outside)
    wider = tiny.full(loads=(150.0, 250.0, 600.0, 700.0))  # needs a larger store
    with suppress(StoreError):
        pipeline.run_sweep(wider, copy, workers=1)
    for command in ("status", "verify", "boundary"):
        assert main([command, str(copy)]) in (0, 1, 2)  # fails if the command reads the linked file
    assert tree(outside) == before


def test_a_link_that_is_laid_while_a_run_writes_is_not_followed(path, outside):
    with writing(path, SWEEP) as store:
        store.commit([record(Point(250.0, 1.0))])
        for name in ("fields", "mean_rise"):
            (path / name).rename(path.parent / name)
            (path / name).symlink_to(outside / name)
        before = tree(outside)
        with pytest.raises(StoreError, match=f"{path}"):
            store.commit([record(Point(600.0, 1.0))])
        assert tree(outside) == before


ZEROS = Zstd(level=1, checksum=True).encode(np.zeros(2**28, np.uint8))
BOMBS = {
    "larger": lambda content: ZEROS,
    "larger behind the chunk": lambda content: content + ZEROS,
    "of unknown size": lambda content: ZEROS[:4] + b"\x04\x58" + ZEROS[9:],
}


@pytest.mark.parametrize(
    ("name", "bomb"), [*((CHUNK, bomb) for bomb in BOMBS), ("about/message/c.0.0", "larger")]
)
def test_a_chunk_of_another_size_than_its_array_s_is_not_unpacked(copy, name, bomb):
    (copy / name).write_bytes(BOMBS[bomb]((copy / name).read_bytes()))
    tracemalloc.start()
    try:
        assert not pipeline.verify_store(copy).is_clean
        with pytest.raises(StoreError, match=f"{name.split('/')[-2]} cannot be read; irg verify"):
            _ = pipeline.open_sweep(copy).load(), stored.opened(copy).read("message", ...)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 100e6  # unpacked it would take 268 MB


# Roots of stores that are not as they were written.

VALUES = (
    None, True, 0, -1, 2**70, 10**12, 0.5, -1e300, math.nan, math.inf, "", "float32", "inf", "\0µ",
    "\ud800", [], {}, [1, 1, 1], [None, [0.5]], {"": {"a": -1}}, {"name": "a", "value": 1},
)  # fmt: skip


def edit(document, path, new):
    """Replace the value at a path of a JSON document."""
    for key in path[:-1]:
        document = document[key]
    document[path[-1]] = new


@pytest.fixture(scope="module")
def forged(alone, tmp_path_factory):
    return shutil.copytree(alone, tmp_path_factory.mktemp("forged") / "tiny.zarr")


@pytest.mark.parametrize("seed", range(25))
def test_any_value_of_the_root_may_be_any_other_with_the_right_digest(forged, alone, seed):
    chance = random.Random(seed)
    (forged / FACTS).write_bytes((alone / FACTS).read_bytes())
    facts = json.loads((alone / FACTS).read_text())["attributes"]
    path = chance.choice([one for one in places(facts) if one])
    new = chance.choice(VALUES)
    forge(forged, lambda _, facts: edit(facts, path, new))
    text, refused = (forged / FACTS).read_text(), 0
    for function in (pipeline.summary, pipeline.open_sweep, pipeline.verify_store):
        try:
            function(forged)
        except StoreError:
            refused += 1
    if refused:  # values that are not refused are not read, or make another sound sweep
        assert refused == 3
        with pytest.raises(StoreError):
            commit(forged, SWEEP, ())
        assert (forged / FACTS).read_text() == text


@pytest.mark.parametrize("seed", range(4))
def test_any_value_of_the_metadata_of_an_array_may_be_any_other(forged, alone, seed):
    """Metadata of arrays follow from the sweep; only `verify_store` reads them."""
    chance = random.Random(seed)
    (forged / FACTS).write_bytes((alone / FACTS).read_bytes())
    name = chance.choice(["mean_rise", "status", "message", "load", "pressure"])
    text = (alone / path_of(name) / ROOT).read_text()
    path = chance.choice(list(places(json.loads(text))))
    document = {"whole": json.loads(text)}
    edit(document, ("whole", *path), chance.choice(VALUES))
    (forged / path_of(name) / ROOT).write_text(json.dumps(document["whole"]))
    before = pipeline.open_sweep(alone)
    assert pipeline.open_sweep(forged).load().equals(before.load())
    assert pipeline.verify_store(forged).done == 9


def test_a_fault_of_this_program_is_not_called_damage_of_the_store(path, monkeypatch):
    commit(path, tiny.sweep(title="read with a fault"), ())

    def faulty(*_, **__):
        raise TypeError("a fault of this program")

    monkeypatch.setattr(tribo.Ramp, "__post_init__", faulty)
    for read in (pipeline.open_sweep, pipeline.summary):
        with pytest.raises(TypeError, match="a fault of this program"):
            read(path)
