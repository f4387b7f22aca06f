"""Processor time against the error of the boundary, on a small scene."""

import csv
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from tests.helpers.heard import Heard
from tribo import InputError

SMALL = {
    "window.pixels": [96, 96],
    "window.pixel_size": ["5 um", "5 um"],
    "disk.roughness.correlation_length": "12 um",
    "sweep.loads": {"from": "200 N", "to": "750 N", "count": 6},
    "sweep.velocities": {"from": "0.5 m/s", "to": "8 m/s", "count": 12},
}


def small(**changes):
    return pipeline.load_scene("first_try", overrides=SMALL | changes)


@pytest.fixture(scope="module")
def measured():
    said = Heard()
    found = pipeline.trade(small(), progress=said.hear)
    assert said[1:3] == ["a timed point of preset standard", "a timed point of preset fine"]
    assert said[-1] == "runs with each accuracy"
    return found


def test_smaller_errors_cost_more_and_are_below_what_is_asked(measured):
    assert len(measured.searches) >= 3
    for one in measured.searches:
        assert one.error <= one.accuracy
        assert one.preset in ("standard", "fine")
    for looser, tighter in zip(measured.searches, measured.searches[1:], strict=False):
        assert tighter.accuracy < looser.accuracy
        if tighter.preset == looser.preset:
            assert tighter.points >= looser.points
            assert tighter.seconds >= looser.seconds


def test_planes_end_with_that_of_the_scene_on_one_patch(measured):
    assert [one.shape for one in measured.planes] == [(3, 4), (4, 6), (6, 12)]
    assert [one.points for one in measured.planes] == [12, 24, 72]
    assert {one.patches for one in measured.planes} == {1}
    # Patches, not points, limit a plane: with all its points it errs as much as a search with few.
    assert measured.planes[-1].error > 0.8 * measured.searches[0].error


def test_the_advised_run_has_the_least_squared_error_times_time(measured):
    worth = [one.accuracy**2 * one.seconds for one in measured.searches]
    assert measured.advised is measured.searches[int(np.argmin(worth))]
    assert str(measured).endswith(f"advised: {measured.command(measured.advised)}")


def test_a_run_computes_about_as_many_points_as_rehearsed(measured, tmp_path):
    for one in measured.searches[:2]:
        path = tmp_path / f"{one.accuracy}.zarr"
        done = pipeline.run_sweep(small(), path, workers=1, accuracy=one.accuracy).done
        # The deviation that one patch states is itself known to a quarter.
        assert 0.5 <= one.points / done <= 2


def test_an_error_by_own_numbers_is_not_known():
    found = pipeline.trade(small(**{"fidelity.increments": 20}))
    assert found.planes[-1].preset is None
    assert np.isnan([one.error for one in found.planes]).all()
    assert not np.isnan([one.error for one in found.searches]).any()
    assert "own numerical choices" in str(found)


def test_the_part_of_a_surface_that_is_given_stays_and_is_told():
    found = pipeline.trade(small(**{"sweep.realizations": [3, 4]}))
    assert {one.patches for one in (*found.searches, *found.planes)} == {2}
    left = [one.errors[3] for one in found.searches]  # by the surface
    assert min(left) > 0.01
    assert "2 listed seeds" in str(found)


def test_warnings_leave_no_accuracy_within_reach():
    coarse = {"window.pixels": [48, 24], "window.pixel_size": ["10 um", "10 um"]}
    found = pipeline.trade(small(**coarse, **{"disk.roughness.correlation_length": "20 um"}))
    assert found.searches == ()
    assert found.advised is found.planes[-1]
    assert "No accuracy of 10 % or less is within reach." in str(found)


def test_scenes_without_a_boundary_are_refused():
    for value in (["0.01 m/s", "0.02 m/s"], ["0 m/s"]):
        with pytest.raises(InputError, match="no boundary"):
            pipeline.trade(small(**{"sweep.velocities": value}))


def test_the_command_prints_what_to_type_and_writes_the_table(measured, irg, monkeypatch, tmp_path):
    monkeypatch.setattr(pipeline, "trade", lambda *_, **__: measured)  # it takes a while
    options = "--set", "friction.coefficient=0.12"
    document = irg("trade", "first_try", *options, "--json")
    said = irg("trade", "first_try", *options, "-o", tmp_path / "trade.csv")
    typed = "irg run first_try --set friction.coefficient=0.12"
    best = f"{typed} --accuracy {100 * measured.advised.accuracy:g}%"
    assert f"advised: {best}" in said
    assert best in [row["command"] for row in document]
    assert document[-1]["command"] == typed
    for row, one in zip(document, (*measured.searches, *measured.planes), strict=True):
        assert row["points"] == one.points
        assert row["error [%]"] == pytest.approx(100 * one.error, rel=5e-3)  # three digits
        assert row["CPU time [s]"] == pytest.approx(one.seconds, rel=0.05)  # two digits
    with (tmp_path / "trade.csv").open() as file:
        assert [row["run"] for row in csv.DictReader(file)] == [row["run"] for row in document]


def test_the_figure_shows_both_curves_without_unknown_errors(measured):
    nan = replace(measured.planes[0], errors=(np.nan,) * 4)
    changed = replace(measured, planes=(nan, *measured.planes[1:]))
    (axes,) = pipeline.plot(changed).axes
    drawn = {line.get_gid(): line for line in axes.lines}
    for gid, choices in (
        ("search (--accuracy)", changed.searches),
        ("uniform plane, one patch of the surface", changed.planes[1:]),
    ):
        assert list(drawn[gid].get_xdata()) == [one.seconds for one in choices]
        assert list(drawn[gid].get_ydata()) == [one.error for one in choices]
