"""Links and decompression bombs in a store are detected and not followed."""

import os
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
from pipeline.paths import PARTIAL
from pipeline.store import store as stored
from tests.helpers import tiny
from tests.helpers.stores import commit, lock_of

SWEEP = tiny.full()
FIELD, CHUNK = "fields/rise/c.0.0.0.0", "mean_rise/c.0.0.0"
KEY = "a private key"


@pytest.fixture
def outside(tmp_path):
    """A folder beside the store, with files named like those of a store."""
    for name in (FIELD, CHUNK, f"load/c.0{PARTIAL}", "load/zarr.json", "status/c.0.0", "key"):
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
    "lock": lambda store, out: link(lock_of(store), out / "key"),
    "pipe for a lock": lambda store, out: os.mkfifo(lock_of(store)),
    "folder of chunks": lambda store, out: link(store / "mean_rise", out / "mean_rise"),
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


BOMBS = {
    "larger": lambda content, zeros: zeros,
    "larger behind the chunk": lambda content, zeros: content + zeros,
    "of unknown size": lambda content, zeros: zeros[:4] + b"\x04\x58" + zeros[9:],
}


@pytest.fixture(scope="module")
def zeros():
    """268 MB of zeros, compressed."""
    return Zstd(level=1, checksum=True).encode(np.zeros(2**28, np.uint8))


@pytest.mark.parametrize(
    ("name", "bomb"), [*((CHUNK, bomb) for bomb in BOMBS), ("about/message/c.0.0", "larger")]
)
def test_a_chunk_of_another_size_than_its_array_s_is_not_unpacked(copy, zeros, name, bomb):
    (copy / name).write_bytes(BOMBS[bomb]((copy / name).read_bytes(), zeros))
    tracemalloc.start()
    try:
        assert not pipeline.verify_store(copy).is_clean
        with pytest.raises(StoreError, match=f"{name.split('/')[-2]} cannot be read; irg verify"):
            _ = pipeline.open_sweep(copy).load(), stored.opened(copy).read("message", ...)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 100e6  # unpacked it would take 268 MB


def test_a_fault_of_this_program_is_not_called_damage_of_the_store(path, monkeypatch):
    commit(path, tiny.sweep(title="read with a fault"), ())

    def faulty(*_, **__):
        raise TypeError("a fault of this program")

    monkeypatch.setattr(tribo.Ramp, "__post_init__", faulty)
    for read in (pipeline.open_sweep, pipeline.summary):
        with pytest.raises(pipeline.StoreError, match="a fault of this program") as error:
            read(path)
        assert "damaged" not in str(error.value)
        assert isinstance(error.value.__cause__, TypeError)
