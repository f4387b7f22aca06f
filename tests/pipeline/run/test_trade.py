"""Processor time against the error of the boundary, measured on a small scene."""

import pytest

import pipeline
from pipeline.figures.style import texts_of
from tests.helpers.kept import assert_as_kept
from tests.helpers.reported import Heard

SMALL = {
    "without": ["tests"],
    "window.pixels": [96, 48],
    "window.pixel_size": ["5 um", "5 um"],
    "disk.roughness.correlation_length": "12 um",
    "sweep.loads": ["300 N", "750 N"],  # below, fewer than 200 pixels touch, which warns
    "sweep.velocities": {"from": "0.5 m/s", "to": "8 m/s", "count": 4},
}


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    out = tmp_path_factory.mktemp("trade") / "trade.zarr"
    scene = pipeline.load_scene("first_try", overrides=SMALL)
    outcomes, heard = [], Heard()

    def run_sweep(*arguments, **options):
        outcomes.append(pipeline.run_sweep(*arguments, **options))
        return outcomes[-1]

    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("pipeline.run.trade.run_sweep", run_sweep)
        options = {"accuracies": (0.2, 0.1), "workers": 1, "progress": heard.hear}
        trade = pipeline.trade(scene, out, **options)
    return trade, out, outcomes, heard


def test_smaller_errors_cost_more_and_go_on_in_one_store(measured):
    trade, out, outcomes, _ = measured
    first, second = trade.runs
    assert second.error <= 0.1
    assert first.error <= 0.2
    assert first.points <= second.points == pipeline.summary(out).done
    times = [outcome.cpu_time for outcome in outcomes]
    assert [run.seconds for run in trade.runs] == [times[0], sum(times)]  # earlier runs included
    assert min(times) > 0


def test_planes_have_all_points_and_slower_presets_err_less(measured):
    planes = measured[0].planes
    assert [plane.preset for plane in planes] == ["standard", "fine", "reference"]
    assert {plane.points for plane in planes} == {8}
    errors = [plane.error for plane in planes]
    assert errors == sorted(errors, reverse=True)
    assert all(plane.seconds > 0 for plane in planes)


def test_table_and_figure_have_each_run(measured, tmp_path):
    trade = measured[0]
    errors = [100 * run.error for run in (*trade.runs, *trade.planes)]
    assert trade.table["numerical error [%]"].tolist() == pytest.approx(errors, rel=1e-2)
    assert trade.table["points"].tolist() == [run.points for run in (*trade.runs, *trade.planes)]
    runs, planes = ["accuracy 20%", "accuracy 10%"], ["standard", "fine", "reference"]
    assert trade.table["run"].tolist() == [*runs, *(f"plane by {preset}" for preset in planes)]
    assert pipeline.plot(trade, out=tmp_path / "trade.svg").exists()
    for line, runs in zip(
        pipeline.plot(trade).axes[0].lines, (trade.runs, trade.planes), strict=True
    ):
        points = [(run.seconds, run.error) for run in runs]
        assert [*zip(*line.get_data(), strict=True)] == points


def test_the_words_of_a_trade_are_kept(measured):
    trade = measured[0]
    heading, *_, last = str(trade).splitlines()
    figure = "\n".join(texts_of(pipeline.plot(trade)))
    heard = "\n".join(measured[-1])
    assert_as_kept("trade", {"table": f"{heading}\n{last}", "figure": figure, "progress": heard})
