"""What `irg check` foretells, against what then happens."""

import math
from dataclasses import replace

import pytest

from pipeline.store import locked, prepare
from pipeline.sweep.plan import chains, points, run_point
from pipeline.tradeoff import forecast
from pipeline.tradeoff.forecast import estimate
from pipeline.tradeoff.sample import Sample
from tests.helpers import tiny
from tests.helpers.kept import PAPER
from tribo import PRESETS, Fidelity, Grid, Ramp, Wear

SWEEP = replace(PAPER, loads=(250.0, 500.0, 750.0), velocities=(1.0, 2.0))


def counted(sweep):
    """Steps and temperatures of a whole sweep."""
    steps = temperatures = 0
    for chain in chains(points(sweep), sweep.independent):
        trunk = None
        for point in chain:
            new = slice(len(trunk.records) if trunk else 0, None)
            result = run_point(sweep, *point, trunk=trunk)
            steps += len(result.columns["time"][new])
            temperatures += (result.columns["max_rise"][new] >= 0).sum()
            trunk = result.trunk
    return steps, temperatures


@pytest.mark.parametrize(
    "changes",
    [
        {"fidelity": Fidelity(increments=30)},
        {"fidelity": Fidelity(increments=30, temperature_interval=4)},
        {"fidelity": Fidelity(increments=6, heat_model="history")},
        {"fidelity": PRESETS["standard"], "loads": (240.0, 250.0, 750.0)},
        {"fidelity": Fidelity(increments=30), "wear": None},
        {"fidelity": Fidelity(increments=30), "independent": True},
        {"fidelity": Fidelity(increments=9), "loading": Ramp(150.0, 750.0, 1.0, 4)},
    ],
    ids=["ramp", "interval", "history", "stations", "no wear", "independent", "hold"],
)
def test_steps_and_temperatures_are_foretold(changes):
    sweep = replace(SWEEP, **{"roughness": None} | changes)
    found = estimate(sweep, workers=1)
    assert (found.steps, found.temperatures) == counted(sweep)


def test_the_time_says_what_it_rests_on():
    found = estimate(tiny.sweep(), workers=1)
    for words in ("from real steps at", "timed just now", "a factor of 1.5", "cores were busy"):
        assert words in found.basis


def test_a_load_between_those_sampled_takes_a_time_between_theirs():
    sample = Sample((100.0, 300.0), (1.0, 2.0), (3.0, 7.0), 0.0, 1, 1)
    assert (sample.step(200.0), sample.end(200.0)) == (1.5, 5.0)
    assert (sample.step(50.0), sample.end(400.0)) == (1.0, 7.0)


@pytest.fixture
def known(monkeypatch):
    """A quiet machine with two cores, where steps take 1 s, and 10 s with a temperature."""
    loads = (min(SWEEP.loads), max(SWEEP.loads))
    sample = Sample(loads, (1.0, 1.0), (10.0, 10.0), 5.0, 100, 10)
    monkeypatch.setattr(forecast, "sampled", lambda sweep: sample)
    monkeypatch.setattr(forecast, "busy_cores", lambda: 0.0)
    monkeypatch.setattr(forecast.os, "cpu_count", lambda: 2)


def test_the_time_is_that_of_all_steps_shared_by_the_workers(known):
    sweep = replace(SWEEP, fidelity=Fidelity(increments=30))
    three = replace(sweep, velocities=(1.0, 2.0, 4.0))
    # 30 steps up to 750 N at each velocity, of which 3 have a temperature.
    ramp = 27 * 1.0 + 3 * 10.0
    for case, workers, turns in ((sweep, 1, 2), (sweep, 2, 1), (three, 2, 2)):
        assert estimate(case, workers).seconds == pytest.approx(turns * ramp + 5, rel=0.02)
    # Three at a time on two cores
    assert estimate(three, 3).seconds == pytest.approx(1.5 * (ramp + 5), rel=0.02)


def test_where_other_work_has_taken_the_cores_a_second_worker_gains_nothing(known, monkeypatch):
    alone = estimate(SWEEP, 1).seconds
    monkeypatch.setattr(forecast, "busy_cores", lambda: 100.0)
    crowded = [estimate(SWEEP, workers).seconds for workers in (1, 2)]
    assert "2 of 2 cores were busy" in estimate(SWEEP, 1).basis
    assert crowded[0] >= alone
    assert crowded[1] > 0.5 * crowded[0]


def test_a_partition_beyond_reason_is_named_beforehand(monkeypatch):
    direct = replace(SWEEP, fidelity=replace(PRESETS["as-published"], pixels_per_element=1))
    assert not estimate(direct).warnings
    monkeypatch.setattr(forecast, "DIRECT_MEMORY", 1e5)
    (said,) = estimate(direct).warnings
    assert "points at high loads will fail" in said
    monkeypatch.undo()
    monkeypatch.setattr(forecast, "elimination_seconds", lambda sweep, nodes: 600.0)
    (said,) = estimate(direct).warnings
    assert "about 600 s a temperature" in said
    assert not estimate(replace(direct, velocities=(0.0,))).warnings  # no heat at all


def test_fields_take_room_only_where_they_are_asked_for(tmp_path):
    sizes, taken, foretold = [], [], []
    for fields in (False, True):
        sweep = tiny.sweep(store_fields=fields, pixels=Grid((64, 32), (6.5e-6, 7.5e-6)))
        with locked(tmp_path / f"{fields}.zarr"):
            store = prepare(tmp_path / f"{fields}.zarr", sweep)
            store.commit(*(run_point(sweep, *point) for point in points(sweep)))
        files = [file for file in store.path.rglob("*") if file.is_file()]
        assert any(file.parent.name == "pressure" for file in files) == fields
        sizes.append(sum(file.stat().st_size for file in files))
        of_points = [file for file in files if file.name.count(".") > 1]
        taken.append(sum(math.ceil(file.stat().st_size / 4096) * 4096 for file in of_points))
        foretold.append(estimate(sweep).disk_bytes)
    assert foretold[1] - foretold[0] == len(points(sweep)) * 3 * 8 * 64 * 32
    assert taken[0] <= foretold[0] < 1.2 * taken[0]  # in whole blocks of a disk
    assert sizes[1] > 1.5 * sizes[0], sizes


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"wear": None}, "wear: the scene has none"),
        ({"wear": None}, "steps: without wear no step needs the others"),
        ({"roughness": None}, "the axis y: both bodies are smooth"),
        ({"velocities": (0.0, 1.0)}, "heat at 3 points: nothing moves there"),
        ({}, "temperatures at up to"),
        ({"fidelity": PRESETS["standard"]}, "the scene's own grid before a point's last step"),
        ({}, "rows of elements, which carry nothing even at 750 N"),
        ({}, "fields: not asked for"),
    ],
)
def test_what_is_left_out_is_named_with_its_reason(changes, said):
    kept = replace(
        SWEEP, store_fields=True, wear=Wear(1.2e-15), pixels=Grid((256, 96), (2e-6, 2e-6))
    )
    if said.startswith("fields"):
        kept = replace(kept, store_fields=False)
    assert any(said in reason for reason in estimate(replace(kept, **changes)).left_out)
