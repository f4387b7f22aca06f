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


@pytest.mark.parametrize("loads", [[200.0, 400.0], [400.0]])
def test_a_report_answers_with_every_range_of_severe_wear(loads, tmp_path):
    ds = swept(loads=loads)
    told = answer(ds, tmp_path)
    assert "no transition" not in told
    for load in loads:
        turns = pipeline.margin(ds, load, 1.0).velocity_turns
        assert len(turns) == 3
        first, middle, last = (f"{turn:.3g}" for turn in turns)
        words = f"severe from {first} to {middle} and from {last} on m/s at {load:g} N"
        assert told.count(words) == 1


def both(*factors):
    each = [swept(loads=[200.0], rise=lambda *at, k=k: k * synthetic.rise(*at)) for k in factors]
    labels = xr.Variable("realization", range(len(factors)))
    return xr.concat(each, labels, combine_attrs="override")


def test_surfaces_that_turn_alike_have_the_median_of_each_turn_and_all_their_own(tmp_path):
    ds = both(1.0, 1.01, 1.03)
    each = [pipeline.margin(ds.isel(realization=[k]), 200.0, 1.0).velocity_turns for k in range(3)]
    middle = sorted(each)[1]
    found = pipeline.margin(ds, 200.0, 1.0)
    assert found.velocity_turns == pytest.approx(middle)
    assert found.velocity_member_turns == tuple(each)
    assert found.critical_velocity in middle
    told = "from {:.3g} to {:.3g} and from {:.3g} on m/s".format(*middle)
    assert f"{told} at 200 N, the medians of 3 surfaces" in answer(ds, tmp_path)
    band, _, rows = pipeline.analysis.frames.frames_of(pipeline.boundary(ds))
    assert band["turns, median"].item() == f"severe {told}"
    assert band["critical velocity, median [m/s]"].item() == pytest.approx(middle[0])
    assert rows["outcome"].str.count("from").tolist() == [2, 2, 2]


def test_surfaces_that_turn_unlike_have_no_median_turns_and_no_words_without_numbers(tmp_path):
    hotter = both(1.0, 2.0)
    told = answer(hotter, tmp_path)
    assert "no transition" not in told
    assert "at no load do all surfaces have one transition alone" in told
    found = pipeline.margin(hotter, 200.0, 1.0)
    assert found.velocity_turns == ()
    assert [*map(len, found.velocity_member_turns)] == [3, 1]
    assert not [line for line in _margin_lines(found) if "severe  " in line]


def test_a_report_of_surfaces_says_at_how_many_loads_it_knows_no_median(tmp_path):
    def rise(load, *rest):
        return synthetic.rise(load, *rest) * np.where(load < 320.0, 0.2, 1.0)

    both = xr.concat(
        [synthetic.sweep(rise=rise)] * 2, xr.Variable("realization", range(2)),
        combine_attrs="override",
    )  # fmt: skip
    assert "at 3 of 12 loads not every surface has one transition alone" in answer(both, tmp_path)
