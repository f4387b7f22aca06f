"""Numbers of a page's scripts, run by Node, beside `irg boundary` and `irg margin`."""

import csv
import io
import math

import numpy as np
import pytest

import pipeline
from pipeline.analysis.dataset import variant_of
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.transition import crossing, interpolated, outcomes
from pipeline.figures.page.content import content
from pipeline.sweep.lubrication import Lubrication
from tests.helpers import synthetic
from tests.helpers.javascript import run
from tests.pipeline.figures.page import sweeps
from tests.pipeline.figures.page.sweeps import column, same
from tribo import Oil

BOUNDARY = """
return argument.map((given) => {
  chosen.conditions = { ...content.conditions, ...given };
  return sides().map(csv);
});
"""
SIDES = (("load", "critical_velocity", "[m/s]"), ("velocity", "critical_load", "[N]"))


def random_conditions(ds, count=12):
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
        if "criterion" not in ds.attrs["conditions"]:
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
    for conditions, texts in zip(asked, run(ds, BOUNDARY, asked), strict=True):
        expected = boundary(ds, conditions)
        for text, (axis, name, unit) in zip(texts, SIDES, strict=True):
            table = list(csv.DictReader(io.StringIO(text)))
            words = f"{name.replace('_', ' ')} {unit}"
            if "crossing_at_load" in expected:
                for k, part in enumerate(("10 %", "median", "90 %")):
                    same(column(table, f"{words} {part}"), expected[f"{name}_quantile"][k])
                same(column(table, "crossing"), expected[f"crossing_at_{axis}"])
                same(column(table, "known"), expected[f"known_at_{axis}"])
                crossings += int(expected[f"crossing_at_{axis}"].sum())
            else:
                same(column(table, words), expected[name])
                codes = expected[f"outcome_at_{axis}"].values.tolist()
                meanings = outcomes(name.removeprefix("critical_"))
                assert [row["outcome"] for row in table] == [meanings[code] for code in codes]
                crossings += int(np.isfinite(expected[name]).sum())
            bridged = expected[f"bridged_at_{axis}"] > 0
            if "crossing_at_load" in expected:
                bridged = bridged.sum(variant_of(bridged))
            same(column(table, "across points not done"), bridged)
            if "bulk_temperature" in conditions:
                same(column(table, "bulk temperature [K]"), conditions["bulk_temperature"], rtol=0)
    assert crossings > 40


@pytest.mark.parametrize("kind", ["one surface", "a hold", "two bulk temperatures", "a warm pin"])
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
    places = [[float(draw.uniform(160, 740)), float(draw.uniform(0.6, 3.9))] for _ in range(10)]
    places += [[450.0, 1.55], [333.0, 1.8]]
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
    places = np.linspace(stored[0], stored[-1], 2000)
    rows = np.array([interpolated(stored, row, places) for row in rise.values])
    plane = np.array([interpolated(ds["load"].values, column, loads) for column in rows.T]).T
    expected = [crossing(places, row, synthetic.limit()) for row in plane]
    known = np.isfinite(velocities)
    assert known.sum() > 20
    same(np.array(velocities)[known], np.array(expected)[known])


def test_no_line_is_drawn_beyond_what_was_computed():
    ds = sweeps.along_boundary()
    drawn = """
    chosen.conditions = { ...chosen.conditions, friction: argument };
    return sweep.drawn([0], chosen.conditions)[0];
    """
    for friction in (0.02, 0.05, 0.1, 0.3):
        crosses = pipeline.boundary(ds, friction)["outcome_at_load"].values == 0
        assert np.isfinite(run(ds, drawn, friction)).any() == crosses.any()


@pytest.mark.parametrize("kind", ["one surface", "zero velocity", "several surfaces"])
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


def test_the_film_of_each_crossing_is_that_of_the_boundary():
    oil = Oil((313.15, 373.15), (32e-6, 5e-6), 866.0, (20e-9, 18e-9))
    lubrication = Lubrication(oil, 2e-3, 3.4e-3, 115.385e9, 0.338e-6).as_dict()
    ds = synthetic.sweep(lubrication=lubrication)
    script = """
    return argument.map((bulk_temperature) => {
      chosen.conditions = { ...content.conditions, bulk_temperature };
      const { velocity } = summary();
      return sweep.loads.map((load, k) => filmParameter(content.film, load, velocity[k].middle));
    });
    """
    bulks = [298.15, 331.0]
    for bulk, films in zip(bulks, run(ds, script, bulks), strict=True):
        expected = pipeline.boundary(ds, bulk_temperature=bulk)["film_parameter_at_load"]
        np.testing.assert_allclose(films, expected, rtol=2e-4)  # 1 K between rows of the table
