"""Sweeps on a cluster (pipeline/run/run_sweep.py and cluster.py)."""

import errno
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline import StoreError, StoreMismatchError, paths, run_sweep, summary, verify_store
from pipeline.run import run_sweep as execute
from pipeline.store import create
from pipeline.store.create import writing
from pipeline.store.schema import COLUMNS, DONE, FIELDS
from pipeline.store.status import FailedPoint
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import PointRecord, points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.processes import python
from tests.helpers.reported import Heard
from tests.helpers.stores import plain_values

ROOT = Path(__file__).parents[3]
SWEEP = tiny.full()


def content(path, names=(*COLUMNS, *FIELDS, "message", "steps", "status")):
    """Computed values of a store by name, comparable bit for bit."""
    values = plain_values(path)
    return {name: values[name].tolist().__repr__() for name in names}


def test_a_sweep_has_the_points_computed_alone_bit_for_bit(path, tiny_store):
    reports = []
    outcome = run_sweep(SWEEP, path, workers=2, progress=reports.append)
    assert (outcome.total, outcome.done, outcome.computed, outcome.failed) == (9, 9, 9, ())
    assert content(path) == content(tiny_store)
    done = [report.done for report in reports]
    assert (done[0], done[-1]) == (0, 9)
    assert done == sorted(done)
    assert reports[0].time_to_go is None
    assert reports[-1].time_to_go == 0.0


def test_a_measured_surface_gives_the_same_on_a_worker_as_here(path):
    """The array of heights must reach the worker unchanged, down to its alignment in memory."""
    heights = SWEEP.scene.roughness.heights(SWEEP.scene.pixels) * 1.01 + 3e-9
    sweep = tiny.sweep(roughness=tribo.MeasuredRoughness(heights), velocities=(1.0,))
    run_sweep(sweep, path, workers=1)
    with xr.open_zarr(path, chunks=None) as ds:
        expected = pipeline.run_point(sweep, 600.0, 1.0).columns["max_rise"]
        stored = ds["max_rise"].sel(load=600, velocity=1).values
        assert stored[-len(expected) :].tobytes() == expected.tobytes()


def test_a_run_resumes_where_points_are_pending_failed_damaged_or_new(tiny_store, copy):
    with writing(copy, SWEEP) as store:
        store.commit([PointRecord(Point(600.0, 0.5), None, "there was too little memory then")])
        store.forget([Point(150.0, 1.0)])
    (copy / "fields" / "pressure" / "c.2.1.0.0").write_bytes(b"1")
    messages = Heard()
    outcome = run_sweep(SWEEP, copy, workers=1, retry_failed=True, progress=messages.hear)
    assert messages == [f"{copy} had 2 damaged points or files, which are computed again"]
    assert (outcome.computed, outcome.done) == (3, 9)
    assert content(copy) == content(tiny_store)
    outcome = run_sweep(tiny.full(loads=(250.0, 800.0), velocities=(1.5,)), copy)
    assert (outcome.total, outcome.computed, outcome.done) == (10, 1, 10)
    result = pipeline.run_point(changed(SWEEP, loads=(*tiny.LOADS, 800.0)), 800.0, 1.5)
    with xr.open_zarr(copy, chunks=None) as ds:
        volumes = ds["wear_volume"].sel(load=800, velocity=1.5).values
        assert volumes[-len(result.columns["time"]) :].tobytes() == (
            result.columns["wear_volume"].tobytes()
        )


def test_other_versions_are_told_and_noted(copy, monkeypatch):
    other = create.versions().replace(f"numpy {np.__version__}", "numpy 99.0")
    for module in (create, execute):
        monkeypatch.setattr(module, "versions", lambda: other)
    messages = Heard()
    for _ in range(2):
        run_sweep(SWEEP, copy, progress=messages.hear)
    assert messages[0].startswith(f"{copy} was computed by irg-transition")
    assert (
        f"numpy {np.__version__}, scipy"
        in messages[0].partition("; points computed from now on by ")[0]
    )
    assert "numpy 99.0" in messages[0].partition("; points computed from now on by ")[2]
    first, later = pipeline.open_sweep(copy).attrs["history"].splitlines()
    assert f"numpy {np.__version__}" in first
    assert "numpy 99.0" in later


def test_other_conditions_of_the_scene_are_told(copy):
    messages = Heard()
    warmer = changed(SWEEP, conditions=replace(SWEEP.conditions, friction=0.12))
    for _ in range(2):
        run_sweep(warmer, copy, progress=messages.hear)
    assert len(messages) == 1  # only one: the store then has the new entries
    assert messages[0] == (
        f"the conditions in {copy} are replaced by those of the scene: friction.coefficient: 0.1 "
        "in the store, 0.12 in the scene"
    )


def test_a_point_that_fails_says_why_and_is_tried_again_when_asked_to(path):
    diverging = tiny.DivergingRamp(150.0, 750.0, faulty_load=250.0)
    sweep = tiny.sweep(loading=diverging, velocities=(1.0,))
    expected = FailedPoint(250.0, 1.0, "ConvergenceError: the contact did not converge")
    outcome = run_sweep(sweep, path, workers=1)
    assert (outcome.done, outcome.computed, outcome.failed) == (2, 2, (expected,))
    assert run_sweep(sweep, path, workers=1).computed == 0
    assert summary(path).failed == (expected,)
    assert run_sweep(sweep, path, workers=1, retry_failed=True).failed == (expected,)


def test_a_full_disk_stops_the_sweep_and_keeps_what_is_finished(path, monkeypatch):
    def full(file, content):
        if (
            file.parent == path / "rise_quantile"
            and (path / "zarr.json").exists()
            and summary(path).done
        ):
            raise OSError(errno.ENOSPC, "No space left on device")
        written(file, content)

    written = paths.write_file
    slow = tiny.sweep(loading=tiny.SlowRamp(150.0, 750.0), velocities=(1.0,))
    with monkeypatch.context() as patch:
        patch.setattr(paths, "write_file", full)
        with pytest.raises(StoreError, match=r"cannot be written: No space left .*are saved"):
            run_sweep(slow, path, workers=1)
    assert 1 <= summary(path).done < 3
    assert summary(path).failed == ()
    assert verify_store(path).is_clean
    assert run_sweep(slow, path, workers=1).done == 3


def test_another_scene_and_a_second_driver_are_refused_before_a_cluster_starts(copy, monkeypatch):
    monkeypatch.setattr(execute, "connected", None)
    with pytest.raises(StoreMismatchError, match=r"fidelity\.increments"):
        run_sweep(tiny.sweep(increments=5), copy)
    in_use = f"in use by process {os.getpid()}"
    with writing(copy, SWEEP), pytest.raises(StoreError, match=in_use):
        run_sweep(SWEEP, copy)


SCRIPT = """
import sys
from pipeline.run.run_sweep import run_sweep
from tests.helpers import tiny
if __name__ == "__main__":
    endless = tiny.EndlessRamp(150.0, 750.0, faulty_load=max(tiny.LOADS))
    sweep = tiny.full(loading=endless)
    try:
        run_sweep(
            sweep, sys.argv[1], workers=2, progress=lambda report: print(report.done, flush=True)
        )
    except KeyboardInterrupt:
        sys.exit(130)
"""


def is_gone(group):
    """True if no process of a group is left within a minute."""
    for _ in range(1200):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGKILL, -9)])
def test_ctrl_c_or_a_kill_ends_everything_and_keeps_finished_points(
    sent, code, path, tmp_path, tiny_store
):
    """The signal goes to the driver and all workers, as from a terminal."""
    (tmp_path / "script.py").write_text(SCRIPT)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(
        [sys.executable, tmp_path / "script.py", path], start_new_session=True, **pipes,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        # Ctrl-C acts as in a terminal, even if this suite runs in the background, which ignores it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as driver:  # fmt: skip
        try:
            assert any(int(line) >= 3 for line in driver.stdout)
            os.killpg(driver.pid, sent)
            assert driver.wait(60) == code
            assert driver.stderr.read() == ""
            assert is_gone(driver.pid)
        except BaseException:
            os.killpg(driver.pid, signal.SIGKILL)
            raise
    assert 3 <= summary(path).done < summary(path).total
    assert verify_store(path).is_clean
    assert summary(path).running is None
    stored, expected = plain_values(path), plain_values(tiny_store)
    is_done = stored["status"] == DONE
    assert stored["max_rise"][is_done].tobytes() == expected["max_rise"][is_done].tobytes()


UNGUARDED = """
import sys
from pipeline.run.run_sweep import run_sweep
from tests.helpers import tiny
run_sweep(tiny.sweep(), sys.argv[1], workers=1)
"""


def test_a_script_that_calls_it_unguarded_is_told_so_once(path, tmp_path):
    (tmp_path / "script.py").write_text(UNGUARDED)
    done = python(tmp_path / "script.py", path)  # takes up to two minutes on a busy machine
    assert done.returncode == 1
    assert done.stderr.count("Traceback") == done.stderr.count("ExecutionError: ") == 1
    assert 'call run_sweep under if __name__ == "__main__":' in done.stderr


# Several surfaces


SEEDS = (4, 1)


def several(seeds=SEEDS):
    return tiny.full(case_table=surface_table(seeds), loads=(150.0, 600.0), velocities=(0.5, 1.5))


def alone_on(seed):
    """The same sweep on a single surface, without realizations."""
    plain = several(())
    return changed(plain, roughness=replace(plain.scene.roughness, seed=seed))


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    path = tmp_path_factory.mktemp("several") / "several.zarr"
    outcome = run_sweep(several(), path, workers=2)
    assert (outcome.total, outcome.computed, outcome.failed) == (8, 8, ())
    return path


def test_a_point_among_others_equals_the_point_alone_bit_for_bit(swept):
    ds = pipeline.open_sweep(swept)
    assert ds["realization"].values.tolist() == sorted(SEEDS)
    for point in points(several()):
        seed = dict(point.case)["realization"]
        expected = pipeline.run_point(alone_on(seed), point.load, point.velocity)
        stored = ds.sel(realization=seed, load=point.load, velocity=point.velocity)
        for name, values in expected.columns.items():
            assert stored[name].values[-len(values) :].tobytes() == values.tobytes()
        if seed == min(SEEDS):  # only the first surface has fields
            fields = xr.open_zarr(swept, group="fields", chunks=None)
            assert fields["field_realization"].item() == seed
            stored = fields.sel(load=point.load, velocity=point.velocity)
            for name, field in expected.fields.items():
                assert stored[name].values.tobytes() == field.astype(np.float32).tobytes()
    first, second = (ds["max_rise"].sel(realization=seed).values for seed in SEEDS)
    assert not np.array_equal(first, second, equal_nan=True)
