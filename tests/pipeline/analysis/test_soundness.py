"""A result is not read from a damaged point in silence."""

import re
import shutil

import numpy as np
import pytest
import zarr

import pipeline
from pipeline.cli import main
from pipeline.store.create import writing
from pipeline.store.place import StoreError
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny
from tests.helpers.stores import contents, opened

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
    before = pipeline.boundary(pipeline.at(copy, **CRITICAL))
    assert before["critical_velocity"].notnull().any()
    replace_rises(copy, lambda values: values * 0.97)  # of a sweep like it
    with pytest.raises(StoreError, match=DAMAGE):
        pipeline.boundary(pipeline.at(pipeline.open_sweep(copy), **CRITICAL))


@pytest.mark.parametrize("command", ["boundary", "plot", "report", "explore", "margin"])
def test_every_command_that_reads_rises_names_the_damage(copy, tmp_path, capsys, command):
    replace_rises(copy, restored)
    place = ["--load", "300 N", "--velocity", "1.1 m/s"] if command == "margin" else []
    out = ["-o", str(tmp_path / "a.html")] if command in ("report", "explore") else []
    out = ["-o", str(tmp_path / "a.png")] if command == "plot" else out
    assert main([command, str(copy), *place, *out]) == 2
    assert DAMAGE.search(capsys.readouterr().err)


def test_where_nothing_crosses_a_swapped_block_is_damage_too(copy):
    """All points of a small store are checked, whatever they tell."""
    replace_rises(copy, lambda values: values * 0.97)
    for answer in (pipeline.boundary, pipeline.margin):
        place = ("300 N", "1 m/s") if answer is pipeline.margin else ()
        with pytest.raises(StoreError, match=DAMAGE):
            answer(pipeline.at(copy, critical_temperature=900.0), *place)


def test_of_a_large_store_the_points_that_a_margin_rests_on_are_checked(path, irg):
    sweep = tiny.sweep(velocities=tuple(np.linspace(0.5, 1.5, 701).tolist()))
    done = [point for point in points(sweep) if point.velocity in (0.5, 1.0, 1.5)]
    with writing(path, sweep) as store:
        store.commit(run_point(sweep, *point).record(with_fields=False) for point in done)
    damaged = opened(path).index(Point(250.0, 1.0))
    array = zarr.open_array(path / "rise_quantile", mode="r+")
    array[damaged] = 0.97 * array[damaged]
    never = pipeline.at(path, critical_temperature=900.0)
    for place in (("250 N", "1 m/s"), ("200 N", "1.1 m/s"), ("300 N", "0.9 m/s")):
        with pytest.raises(StoreError, match=r"damaged at 250 N, 1 m/s"):
            pipeline.margin(never, *place)
    assert pipeline.margin(never, "600 N", "1 m/s")
    assert "damaged at 250 N, 1 m/s" in irg(
        "explore", path, "-o", path.with_suffix(".html"), code=2
    )
    with pytest.raises(StoreError, match=r"damaged at 250 N, 1 m/s"):
        pipeline.diff(pipeline.at(path, criterion="mean"), path)


def test_commands_that_read_write_nothing_into_a_store(copy, irg, tmp_path):
    before = contents(copy)
    for command in ("status", "boundary", "verify"):
        irg(command, copy)
    irg("margin", copy, "--load", "300 N", "--velocity", "1.1 m/s")
    irg("plot", copy, "-o", tmp_path / "a.png")
    assert contents(copy) == before


def test_a_dataset_of_a_sound_store_can_be_copied_and_written_as_a_file(alone, tmp_path):
    ds = pipeline.open_sweep(alone)
    boundary = pipeline.boundary(pipeline.at(ds, **CRITICAL))
    assert pipeline.boundary(pipeline.at(ds.copy(deep=True), **CRITICAL)).equals(boundary)
    ds.drop_vars(ds.coords.keys() & {"x", "y"}).to_netcdf(tmp_path / "a.nc")
    shutil.rmtree(tmp_path / "b.zarr", ignore_errors=True)
    ds.to_zarr(tmp_path / "b.zarr", consolidated=False)
    assert pipeline.boundary(pipeline.at(ds, **CRITICAL)).equals(boundary)


def test_a_dataset_in_memory_outlives_its_store(copy):
    ds = pipeline.open_sweep(copy).load()
    before = pipeline.boundary(pipeline.at(pipeline.open_sweep(copy), **CRITICAL))
    shutil.rmtree(copy)
    assert pipeline.boundary(pipeline.at(ds, **CRITICAL)).equals(before)
