"""Reading a store while it is written, and telling how fast that goes (pipeline/store/pace.py)."""

import itertools
import json
import threading
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from pipeline.store.finished import Finished
from pipeline.store.variables import COLUMNS, FIELDS

import pipeline
from pipeline.cli import main
from pipeline.store import DONE, Store, locked, prepare, summary
from pipeline.store.pace import pace
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny

LOADS = (150.0, 600.0)
SWEEP = tiny.full(loads=LOADS, velocities=(0.5, 1.0))
LONGER = tiny.full(loads=(*LOADS, 900.0), velocities=(0.5, 1.0))


@pytest.fixture(scope="module")
def results():
    with np.errstate(all="raise", under="ignore"):
        return {point: run_point(LONGER, *point) for point in points(LONGER)}


@pytest.fixture
def growing(tmp_path, results):
    """A store that is written all the time: its points are made pending and committed again."""
    path, begun, stop = tmp_path / "tiny.zarr", threading.Event(), threading.Event()
    prepare(path, SWEEP)

    def write():
        with locked(path):
            begun.set()
            for round_ in itertools.count():
                store = prepare(path, SWEEP if round_ < 3 else LONGER)
                for point in store.asked():
                    if stop.is_set():
                        return
                    store.commit(results[point])
                    store.forget(point) if round_ % 2 else None

    writer = threading.Thread(target=write)
    writer.start()
    begun.wait()
    yield path
    stop.set()
    writer.join()


def whole_points(ds, results):
    """Points that are done; each must have all that was computed, and the others no more."""
    found = 0
    for load, velocity in itertools.product(ds["load"].values, ds["velocity"].values):
        stored = ds.sel(load=load, velocity=velocity)
        if stored["status"] == DONE:
            found += 1
            result = results[Point(float(load), float(velocity))]
            for name, values in (result.columns | result.fields).items():
                assert stored[name].values[: len(values)].tobytes() == values.tobytes(), name
    return found


def test_what_is_read_while_it_is_written_is_whole(growing, results):
    seen, grown = 0, False
    while seen < 40 or not grown:
        assert summary(growing).running  # or there is no more to wait for
        with xr.open_zarr(growing, chunks=None) as ds:
            seen += whole_points(ds.load(), results)
        with pipeline.open_sweep(growing) as ds:
            seen += whole_points(ds.load(), results)
            pending = ds["status"].values != DONE
            for name in (*COLUMNS, *FIELDS):
                assert np.isnan(ds[name].values[pending]).all()
            grown = ds.sizes["load"] == len(LONGER.loads)


def test_what_was_opened_keeps_its_size_while_the_store_grows(tmp_path, results):
    path = tmp_path / "tiny.zarr"
    prepare(path, SWEEP).commit(*(results[point] for point in points(SWEEP)))
    found = Finished(path)
    sizes = {name: found.shape(name) for name in (*COLUMNS, *FIELDS, "status", "message")}
    prepare(path, LONGER)
    for name, size in sizes.items():
        assert found.pick(name, [np.arange(n) for n in size]).shape == size
        assert found.shape(name) == size


def test_commands_read_a_store_while_it_is_written(growing, tmp_path, capsys):
    assert main(["status", str(growing), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["running"]
    assert main(["boundary", str(growing), "--json"]) == 0
    assert main(["plot", str(growing), "-o", str(tmp_path / "diagram.png")]) == 0
    assert main(["verify", str(growing)]) == 0


def test_the_rate_and_the_time_to_go_are_known_from_the_store(tmp_path, results):
    path = tmp_path / "tiny.zarr"
    store = prepare(path, LONGER)
    assert summary(path).rate is None
    times = 100.0, 7000.0, 7002.0, 7004.0
    for point, time in zip(points(LONGER), times, strict=False):
        store.commit(replace(results[point], finished_at=time))
    found = summary(path)
    assert found.rate == 0.5
    assert found.time_to_go == 4.0
    assert found.running is None
    with locked(path):
        assert summary(path).running.startswith("process ")


def test_status_says_how_long_it_takes(tmp_path, capsys, results):
    store = prepare(tmp_path / "tiny.zarr", LONGER)
    for point, time in zip(points(LONGER), (0.0, 40.0, 80.0), strict=False):
        store.commit(replace(results[point], finished_at=time))
    assert main(["status", str(store.path)]) == 0
    assert "1.5 points a minute the last time, 2 min to go" in capsys.readouterr().out


def test_an_interruption_does_not_slow_the_rate_down():
    steady = np.arange(0.0, 100.0, 2.0)
    assert pace(steady) == pytest.approx(0.5)
    assert pace(np.concatenate([steady, 1e5 + np.arange(0.0, 10.0, 1.0)])) == pytest.approx(1.0)
    assert pace(np.array([])) is pace(np.array([5.0, 6.0])) is pace(np.full(9, 7.0)) is None


def test_times_of_which_nothing_is_known_are_left_out(tmp_path):
    store = prepare(tmp_path / "tiny.zarr", SWEEP)
    assert Store(store.path).finished_at().size == 0
