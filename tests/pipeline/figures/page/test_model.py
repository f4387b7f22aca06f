"""Numbers of a page's scripts, run by Node, beside `irg boundary` and `irg margin`."""

import math

import numpy as np
import pytest

import pipeline
from pipeline.analysis.dataset import variant_of
from pipeline.analysis.decisive import conditions_of, decisive_rise
from pipeline.analysis.transition import ABOVE, BELOW, CROSSES, crossing, interpolated
from pipeline.figures.page.content import content
from tests.helpers import synthetic
from tests.helpers.javascript import run
from tests.pipeline.figures.page import sweeps
from tests.pipeline.figures.page.sweeps import same

BOUNDARY = """
return argument.map((given) => {
  chosen.conditions = { ...content.conditions, ...given };
  const { velocity, load } = summary();
  return [velocity, load].map((rows) => [
    rows.map(({ low, middle, high }) => [low, middle, high].map((x) => isFinite(x) ? x : NaN)),
    rows.map(({ transitions }) => transitions.map(({ outcome }) => outcome)),
    rows.map(({ transitions }) => transitions.map(({ isBridged }) => isBridged)),
  ]);
});
"""


def random_conditions(ds, count=4):
    """Conditions of all kinds, the first those of the sweep."""
    draw = np.random.default_rng(ds.sizes["velocity"])
    yield {}
    yield {"friction": 0.0}
    for _ in range(count - 2):
        bulk = draw.uniform(250.0, 400.0)
        conditions = {
            "friction": round(draw.uniform(0.04, 0.25), 4),
            "bulk_temperature": bulk,
            "critical_temperature": bulk + draw.uniform(20.0, 250.0),
        }
        if "bulk_ratio" in ds.coords:
            conditions["disk_temperature"] = bulk + 12.0 * math.sin(conditions["friction"] * 300)
        if conditions_of(ds).criterion == "share":
            conditions["failing_share"] = draw.choice([0.0, 0.1, draw.uniform(0.0, 0.6)])
        yield conditions


def boundary(ds, conditions):
    """The boundary under conditions as the page has them."""
    conditions = dict(conditions)
    if "disk_temperature" in conditions:
        pin = conditions["bulk_temperature"]
        conditions["bulk_temperature"] = {"pin": pin, "disk": conditions.pop("disk_temperature")}
    if "failing_share" in conditions:
        conditions["share"] = conditions.pop("failing_share")
    return pipeline.boundary(ds, **conditions)


@pytest.mark.parametrize("kind", sweeps.KINDS)
def test_the_boundary_is_that_of_the_command(kind):
    ds = sweeps.KINDS[kind]()
    asked, crossings = list(random_conditions(ds)), 0
    for conditions, sides in zip(asked, run(ds, BOUNDARY, asked), strict=True):
        expected = boundary(ds, conditions)
        for side, axis, name in zip(
            sides, ("load", "velocity"), ("critical_velocity", "critical_load"), strict=True
        ):
            quantiles, codes, bridged = (np.array(part) for part in side)
            if "crossing_at_load" in expected:
                same(quantiles.T, expected[f"{name}_quantile"])
                same((codes == CROSSES).sum(axis=1), expected[f"crossing_at_{axis}"])
                across = expected[f"bridged_at_{axis}"] > 0
                same(bridged.sum(axis=1), across.sum(variant_of(across)))
            else:
                same(quantiles[:, 1], expected[name])
                assert codes[:, 0].tolist() == expected[f"outcome_at_{axis}"].values.tolist()
                same(bridged[:, 0], expected[f"bridged_at_{axis}"] > 0)
            crossings += int((codes == CROSSES).sum())
    assert crossings > 20


@pytest.mark.parametrize("kind", ["a hold", "two bulk temperatures"])
def test_the_place_of_an_operating_point_is_that_of_the_command(kind):
    ds = sweeps.KINDS[kind]()
    margin = """
    return argument.map(([load, velocity]) => {
      const { rise, ...ways } = sweep.margin(0, load, velocity, chosen.conditions);
      const [along, up] = [ways.velocity, ways.load].map(({ ends: [low, high] }) =>
        low === high && Number.isFinite(low) ? low : NaN);
      const error = errorAt(0, load, velocity) * (temperature(rise) - temperature(0));
      return [error, temperature(rise), along, up];
    });
    """
    draw = np.random.default_rng(3)
    places = [[float(draw.uniform(160, 740)), float(draw.uniform(0.6, 3.9))] for _ in range(5)]
    places += [[333.0, 1.8]]
    for place, (error, temperature, along, up) in zip(places, run(ds, margin, places), strict=True):
        (expected,) = pipeline.margins(ds, *place)
        if np.isfinite(temperature):  # else beyond the points computed there
            same(temperature, expected.decisive_temperature)
            assert error == pytest.approx(expected.temperature_error, rel=0.3)
        for there, critical in (along, expected.critical_velocity), (up, expected.critical_load):
            if np.isfinite(there):
                same(there, critical, rtol=0.02)


def test_the_line_that_is_drawn_lies_on_the_plane_of_the_diagram():
    ds = sweeps.one(status={})
    fine, velocities = run(ds, "return [sweep.fine.load, sweep.drawn([0], chosen.conditions)[0]];")
    rise = decisive_rise(ds, synthetic.conditions())
    stored, loads = ds["velocity"].values, np.array(fine)
    places = np.linspace(stored[0], stored[-1], 500)
    rows = np.array([interpolated(stored, row, places) for row in rise.values])
    plane = np.array([interpolated(ds["load"].values, column, loads) for column in rows.T]).T
    expected = [crossing(places, row, synthetic.limit()) for row in plane]
    known = np.isfinite(velocities)
    assert known.sum() > 20
    same(np.array(velocities)[known], np.array(expected)[known])


def test_no_line_is_drawn_beyond_what_was_computed():
    ds = sweeps.along_boundary()
    drawn = """
    return argument.map((friction) => {
      chosen.conditions = { ...chosen.conditions, friction };
      return [sweep.drawn([0], chosen.conditions)[0], isCut([friction])];
    });
    """
    frictions = [0.02, 0.05, 0.1, 0.3]
    for friction, (line, is_cut) in zip(frictions, run(ds, drawn, frictions), strict=True):
        outcomes = pipeline.boundary(ds, friction)["outcome_at_load"].values
        assert np.isfinite(line).any() == (outcomes == CROSSES).any()
        assert is_cut or not np.isin(outcomes, (ABOVE, BELOW)).any()


@pytest.mark.parametrize("kind", ["one surface", "zero velocity"])
def test_straight_lines_err_by_no_more_than_the_page_says(kind):
    ds = sweeps.KINDS[kind]()
    said = content(ds, 0)["error"]
    script = (
        "return summary().velocity.map(({ transitions }) => transitions.map(({ ends }) => ends));"
    )
    expected = pipeline.boundary(ds)["critical_velocity"].transpose("load", ...).values
    ends = np.array(run(ds, script), float).reshape(len(expected), -1, 2)
    off = np.abs(ends[..., 0] / expected.reshape(len(expected), -1) - 1)[
        ends[..., 0] == ends[..., 1]
    ]
    assert np.isfinite(off).sum() > 3
    assert np.nanmax(off) <= max(said, 1e-6)
    assert said < 0.01
