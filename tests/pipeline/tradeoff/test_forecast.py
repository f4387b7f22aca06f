"""What `irg check` foretells, against what then happens."""

from dataclasses import replace

import pytest

from pipeline.store.points import locked, prepare
from pipeline.sweep.plan import chains, points, run_point
from pipeline.tradeoff import forecast as cost
from pipeline.tradeoff.forecast import estimate
from tests.helpers import tiny
from tests.helpers.kept import PAPER
from tribo import PRESETS, Fidelity, Grid, Wear

SWEEP = replace(PAPER, loads=(250.0, 500.0, 750.0), velocities=(1.0, 2.0))


def counted(sweep):
    """Steps, temperatures and convolutions of a whole sweep."""
    steps = temperatures = convolutions = 0
    for chain in chains(points(sweep), sweep.independent):
        trunk = None
        for point in chain:
            before = len(trunk.records) if trunk else 0
            result = run_point(sweep, *point, trunk)
            new = slice(before, None)
            steps += len(result.columns["time"][new])
            convolutions += result.columns["iterations"][new].sum()
            temperatures += (result.columns["max_rise"][new] >= 0).sum()
            convolutions += result.state.heat.iterations
            trunk = result.trunk
    return steps, temperatures, convolutions


@pytest.mark.parametrize(
    "sweep",
    [
        replace(SWEEP, fidelity=Fidelity(pixels_per_element=1, increments=30)),
        replace(SWEEP, fidelity=replace(PRESETS["standard"], history_coarsening=1)),
        replace(SWEEP, fidelity=Fidelity(increments=30), wear=None),
        replace(SWEEP, fidelity=Fidelity(increments=30), roughness=None),
    ],
    ids=["fine grid", "standard", "no wear", "smooth"],
)
def test_steps_and_convolutions_are_foretold(sweep):
    found = estimate(sweep, workers=1)
    steps, temperatures, convolutions = counted(sweep)
    assert (found.steps, found.temperatures) == (steps, temperatures)
    assert found.convolutions == pytest.approx(convolutions, rel=0.35)


def test_the_time_says_what_it_rests_on():
    found = estimate(tiny.sweep(), workers=1)
    for words in ("measured just now", "ms a convolution", "a contact", "cores were busy"):
        assert words in found.basis


def test_more_work_takes_more_time_on_the_same_measure(monkeypatch):
    sample = cost.sampled(SWEEP)
    monkeypatch.setattr(cost, "sampled", lambda sweep: sample)
    monkeypatch.setattr(cost, "busy_cores", lambda: 0.0)
    monkeypatch.setattr(cost.os, "cpu_count", lambda: 2)
    alone, both = (estimate(SWEEP, workers).seconds for workers in (1, 2))
    start = cost._SECONDS_TO_START + sample.surface_seconds
    assert both - start == pytest.approx(
        (alone - start) / 2, rel=0.1
    )  # but for the kernels of each
    # Where other work has taken the cores, a second worker gains nothing.
    monkeypatch.setattr(cost, "busy_cores", lambda: 100.0)
    crowded = [estimate(SWEEP, workers).seconds for workers in (1, 2)]
    assert crowded[0] > alone
    assert crowded[1] > 0.5 * crowded[0]


def test_a_partition_beyond_reason_is_named_beforehand(monkeypatch):
    direct = replace(SWEEP, fidelity=replace(PRESETS["as-published"], pixels_per_element=1))
    assert not estimate(direct).warnings
    monkeypatch.setattr(cost, "DIRECT_MEMORY", 1e5)
    (said,) = estimate(direct).warnings
    assert "points at high loads will fail" in said
    monkeypatch.undo()
    monkeypatch.setattr(cost, "elimination_seconds", lambda sweep, nodes: 600.0)
    (said,) = estimate(direct).warnings
    assert "about 600 s a temperature" in said
    assert not estimate(replace(direct, velocities=(0.0,))).warnings  # no heat at all


def test_fields_take_room_only_where_they_are_asked_for(tmp_path):
    sizes, foretold = [], []
    for fields in (False, True):
        sweep = tiny.sweep(store_fields=fields, pixels=Grid((64, 32), (6.5e-6, 7.5e-6)))
        with locked(tmp_path / f"{fields}.zarr"):
            store = prepare(tmp_path / f"{fields}.zarr", sweep)
            for point in points(sweep)[:3]:
                store.commit(run_point(sweep, *point))
        files = [file for file in store.path.rglob("*") if file.is_file()]
        assert any(file.parent.name == "pressure" for file in files) == fields
        sizes.append(sum(file.stat().st_size for file in files))
        foretold.append(estimate(sweep).disk_bytes)
    assert foretold[1] - foretold[0] == len(points(sweep)) * 3 * 8 * 64 * 32
    assert sizes[1] > 1.5 * sizes[0], sizes


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"wear": None}, "wear: the scene has none"),
        ({"wear": None}, "steps: without wear no step needs the others"),
        ({"roughness": None}, "the axis y: both bodies are smooth"),
        ({"velocities": (0.0, 1.0)}, "heat at 3 points: nothing moves there"),
        ({}, "temperatures at up to"),
        ({"fidelity": PRESETS["standard"]}, "the fine grid until a point's last step"),
        ({}, "rows of elements, which carry nothing even at 750 N"),
        ({}, "fields: not asked for"),
    ],
)
def test_what_is_left_out_is_named_with_its_reason(changes, said):
    kept = replace(
        SWEEP, store_fields=True, wear=Wear(1.2e-15), pixels=Grid((192, 96), (2e-6, 2e-6))
    )
    if said.startswith("fields"):
        kept = replace(kept, store_fields=False)
    assert any(said in reason for reason in estimate(replace(kept, **changes)).left_out)
