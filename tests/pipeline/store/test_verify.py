"""Finding and repairing damage (pipeline/store/verify.py), and never reading it (committed.py)."""

import json
import shutil

import numpy as np
import pipeline.store.shape as shape_module
import pytest
import xarray as xr
from numcodecs.zstd import Zstd
from pipeline.store.variables import COLUMNS, COORDINATES, FIELDS, RECORDS

from pipeline.analysis.dataset import open_sweep
from pipeline.cli import main
from pipeline.run.sweep import run_sweep
from pipeline.store import Store, StoreError, locked, prepare, summary, verify_store
from pipeline.sweep.model import Point
from tests.helpers import tiny
from tests.pipeline.conftest import commit_all

SWEEP = tiny.full()
AXES = [name for name in COORDINATES if name not in ("realization", "sample", "bulk_ratio")]
POINT = Point(250.0, 1.0)


@pytest.fixture
def copy(alone, tmp_path):
    return shutil.copytree(alone, tmp_path / "copy.zarr")


def flip(file, bit):
    content = bytearray(file.read_bytes())
    content[bit // 8 % len(content)] ^= 1 << bit % 8
    file.write_bytes(content)


def flip_any(file, rng):
    """Flip a bit of a chunk; not one of the few that Zstandard reads the same data without."""
    before = decoded(file)
    while decoded(file) == before:
        file.write_bytes(Zstd(level=1, checksum=True).encode(before))
        flip(file, int(rng.integers(8 * file.stat().st_size)))


def decoded(file):
    try:
        return bytes(Zstd().decode(file.read_bytes()))
    except RuntimeError:
        return None


def chunks(path, names=(*COLUMNS, *RECORDS, *FIELDS)):
    return sorted(file for name in names for file in path.glob(f"{name}/c*") if file.is_file())


def test_a_store_without_damage_is_clean(alone):
    found = verify_store(alone)
    assert found.is_clean
    assert found.done == 9


@pytest.mark.parametrize("seed", range(2))
def test_a_flipped_bit_in_any_chunk_is_found_and_repaired(copy, alone, seed):
    """A bit in each file at once, since the reasons name them one by one."""
    rng = np.random.default_rng(seed)
    files = chunks(copy)
    for file in [*files, *chunks(copy, AXES)]:
        flip_any(file, rng)
    found = verify_store(copy)
    assert found.done == 0
    assert sum(damage.reason.count(",") + 1 for damage in found.damaged) == len(files)
    assert len(found.shared) == len(AXES)
    assert not verify_store(copy, repair=True).is_clean
    assert verify_store(copy).is_clean
    assert summary(copy).pending == 9
    run_sweep(SWEEP, copy, workers=1)
    with xr.open_zarr(copy, chunks=None) as ds, xr.open_zarr(alone, chunks=None) as expected:
        xr.testing.assert_identical(
            *(each.drop_vars(["wall_time", "finished_at"]) for each in (ds, expected))
        )


@pytest.mark.parametrize(
    "name", sorted({*COLUMNS, *RECORDS, *FIELDS, *AXES} - {"status", "checksum"})
)
def test_a_flipped_bit_in_any_variable_is_not_read(copy, name):
    for file in chunks(copy, [name]):
        flip(file, 8 * (file.stat().st_size // 2))
    with pytest.raises(StoreError, match=rf"{name}|status.* irg verify"), open_sweep(copy) as ds:
        ds[name].load()


def test_every_single_bit_of_a_chunk_is_noticed_or_changes_nothing(copy):
    file = copy / "wall_time" / "c.1.1"
    store, before, harmless = Store(copy), decoded(file), 0
    for bit in range(8 * file.stat().st_size):
        flip(file, bit)
        if decoded(file) == before:
            harmless += 1
        else:
            assert store.unreadable(POINT) == ["wall_time"], bit
        flip(file, bit)
    assert harmless < 4


@pytest.mark.parametrize("name", [*COLUMNS, *RECORDS, *FIELDS])
def test_a_lost_and_a_truncated_file_are_found(copy, name):
    lost, cut = chunks(copy, [name])[3:5]
    lost.unlink()
    cut.write_bytes(cut.read_bytes()[:-3])
    found = {damage.point: damage.reason for damage in verify_store(copy).damaged}
    expected = {Point(250.0, 0.5), Point(250.0, 1.0)}
    # Without its status, a point is one that was never finished.
    assert set(found) == (expected - {Point(250.0, 0.5)} if name == "status" else expected)
    assert found[Point(250.0, 1.0)] == f"{name} cannot be read"


def test_data_of_another_computation_are_found(copy):
    shutil.copy(copy / "time" / "c.2.1.0", copy / "time" / "c.1.1.0")
    (damage,) = verify_store(copy).damaged
    assert str(damage) == "250 N, 1 m/s: the data are not those that were computed"


def test_lost_coordinates_are_not_read_as_numbers_and_can_be_restored(copy):
    (copy / "load" / "c.0").unlink()
    with pytest.raises(StoreError, match="load cannot be read; irg verify"):
        open_sweep(copy)
    assert verify_store(copy, repair=True).shared == ("the coordinate load is damaged",)
    with open_sweep(copy) as ds:
        assert tuple(ds["load"].values) == SWEEP.loads


def test_damaged_metadata_are_found_and_restored(copy):
    root, array = copy / "zarr.json", copy / "time" / "zarr.json"
    array.write_text(array.read_text().replace("float64", "float32"))
    assert verify_store(copy, repair=True).shared == ("the metadata of time are damaged",)
    assert verify_store(copy).is_clean
    document = json.loads(root.read_text())
    document["attributes"]["scene"]["pin"]["radius"] *= 2
    root.write_text(json.dumps(document))
    (fault,) = verify_store(copy).shared
    assert fault.startswith("zarr.json is damaged: it is not what was committed")
    assert len(verify_store(copy, repair=True).shared) == 1
    assert verify_store(copy).is_clean
    assert json.loads(root.read_text()) != document


def test_a_growth_cut_short_is_no_damage(copy, monkeypatch):
    def cut(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(shape_module, "commit_metadata", cut)
    with pytest.raises(KeyboardInterrupt):
        prepare(copy, tiny.full(loads=(150.0, 1500.0)))
    assert verify_store(copy).is_clean


def test_a_store_in_use_is_verified_but_not_repaired(copy):
    with locked(copy):
        assert verify_store(copy).is_clean
        with pytest.raises(StoreError, match="in use"):
            verify_store(copy, repair=True)


def test_the_command_names_what_is_damaged(copy, capsys):
    assert main(["verify", str(copy)]) == 0
    flip(copy / "rise" / "c.1.1.0.0", 800)
    capsys.readouterr()
    assert main(["verify", str(copy), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["done"] == 8
    assert document["damaged"] == [
        {"load": 250.0, "velocity": 1.0, "reason": "rise cannot be read"}
    ]
    assert main(["verify", str(copy), "--repair"]) == 1
    assert "damaged: 250 N, 1 m/s: rise cannot be read" in capsys.readouterr().out
    assert main(["verify", str(copy)]) == 0
    assert main(["verify", str(copy.parent)]) == 2


def test_fields_of_a_point_that_is_not_done_are_not_there(copy):
    Store(copy).forget(POINT)
    with open_sweep(copy) as ds:
        for name in FIELDS:
            known = np.isfinite(ds[name].values).all(axis=(-2, -1))
            np.testing.assert_array_equal(known, ds["status"] == 1)
            assert np.isnan(ds[name].sel(load=250, velocity=1)).all()


def test_opening_reads_no_field(copy):
    """Fields may be larger than the memory."""
    for name in FIELDS:
        shutil.rmtree(copy / name)
    with open_sweep(copy) as ds:
        assert ds["pressure"].shape == (3, 3, 32, 16)
        np.testing.assert_array_equal(ds["load"], SWEEP.loads)


def test_damage_on_one_of_several_surfaces_is_named_and_repaired(tmp_path):
    path = tmp_path / "tiny.zarr"
    commit_all(path, tiny.sweep(loads=(150.0,), velocities=(0.5,), realizations=(1, 2)))
    flip(path / "time" / "c.1.0.0.0", 200)
    flip(path / "realization" / "c.0", 100)
    found = verify_store(path, repair=True)
    assert [str(damage) for damage in found.damaged] == [
        "150 N, 0.5 m/s, surface 2: time cannot be read"
    ]
    assert found.shared == ("the coordinate realization is damaged",)
    assert verify_store(path).is_clean
    with open_sweep(path) as ds:
        assert ds["realization"].values.tolist() == [1, 2]
        assert ds["status"].values.ravel().tolist() == [1, 0]
