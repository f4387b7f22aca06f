"""The answer of a report where wear turns more than once with the velocity."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
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
        turns = pipeline.boundary(ds)["turns_at_load"].sel(load=load).dropna("turn").values
        assert len(turns) == 3
        first, middle, last = (f"{turn:.3g}" for turn in turns)
        words = f"from {first} to {middle} m/s and from {last} m/s on at {load:g} N"
        assert told.count(words) == 1


def both(*factors):
    each = [swept(loads=[200.0], rise=lambda *at, k=k: k * synthetic.rise(*at)) for k in factors]
    labels = xr.Variable("realization", range(len(factors)))
    return xr.concat(each, labels, combine_attrs="override")


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("factors", [(1.0, 1.01, 1.03), (1.0, 1.01, 2.0)])
def test_of_surfaces_that_turn_several_times_the_first_turn_of_each_counts(factors, tmp_path):
    ds = both(*factors)  # at a factor of 2 the surface is mild at low velocities alone
    alone = [pipeline.margin(ds.isel(realization=[k]), 200.0, 1.0) for k in range(3)]
    assert [one.velocity_outcome.count("from") for one in alone][:2] == [2, 2]
    middle = sorted(one.critical_velocity for one in alone)[1]
    assert pipeline.margin(ds, 200.0, 1.0).critical_velocity == pytest.approx(middle)
    crossings = pipeline.boundary(ds)
    median = crossings["critical_velocity_quantile"].sel(quantile=0.5, load=200.0).item()
    assert median == pytest.approx(middle)
    assert f"severe from {middle:.3g} m/s on at 200 N, on half of 3 surfaces" in answer(
        ds, tmp_path
    )


@pytest.mark.usefixtures("undrawn")
def test_a_report_of_surfaces_says_at_how_many_loads_half_of_them_does_not_turn(tmp_path):
    def rise(load, *rest):
        return synthetic.rise(load, *rest) * np.where(load < 320.0, 0.2, 1.0)

    both = xr.concat(
        [synthetic.sweep(rise=rise)] * 2, xr.Variable("realization", range(2)),
        combine_attrs="override",
    )  # fmt: skip
    assert "mild throughout at 200, 250, 300 N" in answer(both, tmp_path)
