"""The answer of a report where wear turns more than once with the velocity."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pipeline
import pipeline.analysis.frames
import tribo
from pipeline.cli.verdicts import _margin_lines
from tests.helpers import synthetic

BACK = ((0.5, 4.0), (2.0, 0.9), (6.0, 0.8))


def swept(**changes):
    corrections = tribo.Corrections(friction=tribo.Friction(by_velocity=BACK))
    conditions = replace(synthetic.conditions(), corrections=corrections)
    velocities = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 6.0]
    return synthetic.sweep(velocities=velocities, conditions=conditions, **changes)


def answer(ds, tmp_path):
    page = pipeline.report(ds, tmp_path / "report.html").read_text(encoding="utf-8")
    return page.split("Answer: ")[1].split("</p>")[0]


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("loads", [[200.0, 400.0], [400.0]])
def test_a_report_answers_with_every_range_of_severe_wear(loads, tmp_path):
    ds = swept(loads=loads)
    told = answer(ds, tmp_path)
    assert "no transition" not in told
    for load in loads:
        turns = pipeline.margin(ds, load, 1.0).velocity_turns
        assert len(turns) == 3
        first, middle, last = (f"{turn:.3g}" for turn in turns)
        words = f"from {first} to {middle} m/s and from {last} m/s on at {load:g} N"
        assert told.count(words) == 1


def both(*factors):
    each = [swept(loads=[200.0], rise=lambda *at, k=k: k * synthetic.rise(*at)) for k in factors]
    labels = xr.Variable("realization", range(len(factors)))
    return xr.concat(each, labels, combine_attrs="override")


@pytest.mark.usefixtures("undrawn")
def test_surfaces_that_turn_alike_have_the_median_of_each_turn_and_all_their_own(tmp_path):
    ds = both(1.0, 1.01, 1.03)
    each = [pipeline.margin(ds.isel(realization=[k]), 200.0, 1.0).velocity_turns for k in range(3)]
    middle = sorted(each)[1]
    found = pipeline.margin(ds, 200.0, 1.0)
    assert found.velocity_turns == pytest.approx(middle)
    assert found.velocity_member_turns == tuple(each)
    assert found.critical_velocity in middle
    told = "severe from {:.3g} to {:.3g} m/s and from {:.3g} m/s on".format(*middle)
    assert f"{told} at 200 N, on half of 3 surfaces" in answer(ds, tmp_path)
    band, _, rows = pipeline.analysis.frames.frames_of(pipeline.boundary(ds))
    assert band["half of them"].item() == told
    assert band["critical velocity, median [m/s]"].item() == pytest.approx(middle[0])
    assert rows["outcome"].str.count("from").tolist() == [2, 2, 2]


def test_surfaces_that_turn_unlike_have_the_turns_of_half_of_them(tmp_path):
    hotter = both(1.0, 1.01, 2.0)  # the last is mild at low velocities alone
    found = pipeline.margin(hotter, 200.0, 1.0)
    assert [*map(len, found.velocity_member_turns)] == [3, 3, 1]
    first, second, (last,) = found.velocity_member_turns
    # Two of three are severe where the second is, as the third is hotter and the first colder.
    half = (second[0], second[1], second[2])
    assert last < second[0] < first[0]
    assert first[1] < second[1]
    assert found.velocity_turns == pytest.approx(half)
    told = "severe from {:.3g} to {:.3g} m/s and from {:.3g} m/s on".format(*half)
    assert f"{told} at 200 N, on half of 3 surfaces" in answer(hotter, tmp_path)
    assert f"in velocity, half of the surfaces: {told}" in _margin_lines(found)


def test_where_as_many_surfaces_are_severe_as_mild_half_of_them_does_not_turn():
    found = pipeline.margin(both(1.0, 2.0), 200.0, 1.0)
    first, second = found.velocity_member_turns
    assert found.velocity_turns == pytest.approx([(first[0] + second[0]) / 2])


@pytest.mark.usefixtures("undrawn")
def test_a_report_of_surfaces_says_at_how_many_loads_half_of_them_does_not_turn(tmp_path):
    def rise(load, *rest):
        return synthetic.rise(load, *rest) * np.where(load < 320.0, 0.2, 1.0)

    both = xr.concat(
        [synthetic.sweep(rise=rise)] * 2, xr.Variable("realization", range(2)),
        combine_attrs="override",
    )  # fmt: skip
    assert "at 3 of 12 loads no transition is known" in answer(both, tmp_path)
