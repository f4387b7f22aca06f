"""A result is not read from a damaged point in silence."""

import re
import shutil

import numpy as np
import pytest
import zarr

import pipeline
from pipeline.cli import main
from pipeline.store.place import StoreError

# Between the rises of the tiny sweep, so that boundaries cross it.
CRITICAL = {"critical_temperature": 380.0}


def replace_rises(path, change):
    """Let the block of rises be another one that can be read."""
    array = zarr.open_array(path / "rise_quantile", mode="r+")
    array[...] = change(array[...])


def restored(values):
    """An older block, of before some points were done."""
    values[1] = np.nan
    return values


DAMAGE = re.compile(
    r"tiny\.zarr is damaged at \d+ N, [\d.]+ m/s: the data are not those that were computed; "
    r"irg verify \S+tiny\.zarr --repair"
)


def test_a_boundary_of_a_swapped_block_is_damage(copy):
    before = pipeline.boundary(copy, **CRITICAL)
    assert before["critical_velocity"].notnull().any()
    replace_rises(copy, lambda values: values * 0.97)  # of a sweep like it
    with pytest.raises(StoreError, match=DAMAGE):
        pipeline.boundary(pipeline.open_sweep(copy), **CRITICAL)


@pytest.mark.parametrize("command", ["boundary", "plot", "report", "explore", "margin"])
def test_every_command_that_reads_rises_names_the_damage(copy, tmp_path, capsys, command):
    replace_rises(copy, restored)
    place = ["--load", "300 N", "--velocity", "1.1 m/s"] if command == "margin" else []
    out = ["-o", str(tmp_path / "a.html")] if command in ("report", "explore") else []
    out = ["-o", str(tmp_path / "a.png")] if command == "plot" else out
    assert main([command, str(copy), *place, *out]) == 2
    assert DAMAGE.search(capsys.readouterr().err)


def test_a_sound_store_is_read_once_and_copies_and_files_are_free(alone, tmp_path):
    ds = pipeline.open_sweep(alone)
    boundary = pipeline.boundary(ds, **CRITICAL)
    reader = ds["status"].encoding["reader"]
    assert reader._sound
    assert ds.copy(deep=True)["status"].encoding["reader"] is reader
    ds.drop_vars(ds.coords.keys() & {"x", "y"}).to_netcdf(tmp_path / "a.nc")
    shutil.rmtree(tmp_path / "b.zarr", ignore_errors=True)
    ds.to_zarr(tmp_path / "b.zarr", consolidated=False)
    assert pipeline.boundary(ds, **CRITICAL).equals(boundary)


def test_a_dataset_in_memory_outlives_its_store(copy):
    ds = pipeline.open_sweep(copy).load()
    before = pipeline.boundary(pipeline.open_sweep(copy), **CRITICAL)
    shutil.rmtree(copy)
    assert pipeline.boundary(ds, **CRITICAL).equals(before)
