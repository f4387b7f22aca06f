"""Functions, commands, figures and reports give the same answers to the same 200 points."""

import functools
import html
import json
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.text import Text

import pipeline
import tribo
from pipeline.answers.verdict_model import MILD, SEVERE
from tests.helpers import synthetic
from tests.helpers.answer_at import named
from tests.helpers.entries import bare_test
from tests.helpers.entries import two_pins as two_rows
from tests.pipeline.test_film import filmed
from tribo import InputError

LOADS, VELOCITIES = (200.0, 300.0, 400.0, 600.0, 750.0), (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
SMALL = {"loads": LOADS, "velocities": VELOCITIES}
NUMBERS = (
    "probability", "probability_low", "probability_high", "governing_temperature",
    "temperature_margin", "temperature_error", "critical_velocity", "critical_load",
    "critical_velocity_p50", "mild_velocity", "mild_load", "mild_friction", "load_safety_factor",
)  # fmt: skip
VERDICTS = {"mild", "undecided", "severe", "outside the model", "unknown"}


def cases():
    """Two pins, the second less hot."""
    parts = [
        synthetic.sweep(
            case_table=two_rows(), rise=lambda *at, k=k: k * synthetic.rise(*at), **SMALL
        )
        for k in (1.0, 0.8)
    ]
    radii = xr.DataArray([1e-3, 2e-3], dims="pin_radius", name="pin_radius", attrs={"units": "m"})
    return xr.concat(parts, radii, combine_attrs="override")


def pending():
    """Sweep with a third of its points pending, and a mild test that has no result yet."""
    late = {(F, V): 0 for k, F in enumerate(LOADS) for j, V in enumerate(VELOCITIES) if (k + j) % 3}
    late = {point: 0 for number, point in enumerate(late) if number % 2}
    tests = *synthetic.MEASURED[:3], bare_test(300.0, 2.0, outcome="mild")
    ds = synthetic.sweep(status=late, tests=tests, **SMALL)
    return synthetic.with_tests(ds, status=[1, 1, 1, 0])


STORES = {
    "cases": cases,
    "film": lambda: filmed(**SMALL),
    "stages": lambda: synthetic.sweep(loading=tribo.Stages(LOADS, (5.0,) * 5, 150.0), **SMALL),
    "pending": pending,
}


@functools.cache
def table(name):
    """50 points in and around a plane; half of them with another friction and bulk temperature."""
    rng = np.random.default_rng([*STORES].index(name))
    coordinates = rng.uniform(190, 760, 50).round(2), rng.uniform(0.45, 4.1, 50).round(3)
    has_conditions = rng.random(50) < 0.5
    friction = np.where(has_conditions, rng.uniform(0.08, 0.13, 50).round(4), 0.1)
    bulk = np.where(has_conditions, rng.choice([18.25, 31.5, 44.75, 58.0], 50), 25.0)
    heads = "load [N]", "velocity [m/s]", "friction", "bulk temperature [degC]"
    return pd.DataFrame(dict(zip(heads, (*coordinates, friction, bulk), strict=True)))


@functools.cache
def store(name):
    """A store, and the margins of its table, computed from arrays."""
    ds, rows = STORES[name](), table(name)
    load, velocity, friction, bulk = (column.to_numpy() for column in map(rows.get, rows))
    conditions = {"friction": friction, "bulk_temperature": bulk + 273.15}
    conditions = {name: xr.DataArray(values, dims="place") for name, values in conditions.items()}
    return ds, pipeline.margin(ds, load, velocity, **conditions)


@pytest.fixture(params=STORES)
def margin_case(request, monkeypatch):
    ds, margin = store(request.param)
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: ds)
    return request.param, ds, margin


def words(margin):
    codes = named(margin["verdict"]).ravel().tolist()
    return np.array([code.replace("outside_", "outside the ") for code in codes], object)


def same(left, right, rtol=1e-12):
    np.testing.assert_allclose(np.array(left, float), np.array(right, float), rtol, 1e-12)


def columns(rows, *names):
    """Values of rows of JSON or CSV, by the names of variables and in SI."""
    heads = {head.partition(" [")[0]: head for head in rows[0]}
    for name in names:
        head = heads[{"critical_velocity_p50": "50 % severe"}.get(name, name.replace("_", " "))]
        values = np.array([row[head] or np.nan for row in rows], float)
        yield name, values + 273.15 * (name == "governing_temperature")


def test_array_table_and_command_say_the_same_of_all_points(margin_case, tmp_path, irg):
    name, ds, margin = margin_case
    by_table = pipeline.margin(ds, table(name))
    for variable in (*NUMBERS, "verdict", "warning_flags", "outcome_along_velocity"):
        same(by_table[variable], margin[variable])
    margin = margin.transpose("place", ...)  # the order of rows
    assert (by_table["reason"] == margin["reason"]).all()
    seen = words(margin).tolist()
    assert len({*seen}) >= 3
    table(name).to_csv(tmp_path / "t.csv", index=False)
    command = "margin", "out.zarr", "--points", tmp_path / "t.csv", "-o", tmp_path / "out.csv"
    output, rows = irg(*command), irg(*command, "--json")
    assert [row["verdict"] for row in rows] == seen
    for variable, values in columns(rows, *NUMBERS):
        same(values, margin[variable].values.ravel(), 1e-9)
    written = pd.read_csv(tmp_path / "out.csv").replace({np.nan: None}).to_dict("records")
    assert [row["verdict"] for row in written] == seen
    for variable, values in columns(written, "probability", "temperature_margin"):
        np.testing.assert_allclose(values, margin[variable].values.ravel(), 1e-5, 1e-5)
    counts = {verdict: seen.count(verdict) for verdict in {*seen}}
    assert all(f"{count} {verdict}" in output for verdict, count in counts.items())


def test_a_point_alone_gets_what_it_gets_in_the_table(margin_case, irg, tmp_path):
    name, ds, margins = margin_case
    load, velocity, friction, bulk = table(name).iloc[17].tolist()
    conditions = {"friction": friction, "bulk_temperature": f"{bulk} °C"}
    margin, row_margin = (
        pipeline.margin(ds, load, f"{velocity} m/s", **conditions),
        margins.isel(place=17),
    )
    for variable in NUMBERS:
        same(margin[variable], row_margin[variable])
    assert words(margin).tolist() == words(row_margin).tolist()
    options = [part for key, x in conditions.items() for part in (f"--{key.replace('_', '-')}", x)]
    command = "margin", "out.zarr", "--load", f"{load} N", "--velocity", f"{velocity} m/s"
    if "unknown" in words(row_margin):
        assert row_margin["reason"].values.ravel()[0] in irg(*command, *options, code=2)
        return
    output = irg(*command, *options, "-o", tmp_path / "row.json")
    rows = json.loads((tmp_path / "row.json").read_text())
    assert [row["verdict"] for row in rows] == words(row_margin).tolist()
    for variable, values in columns(rows, *NUMBERS):
        same(values, row_margin[variable].values.ravel(), 1e-9)
    assert words(row_margin)[0].capitalize() in output.replace("\n    ", " ")


def test_boundary_figure_and_margin_draw_one_line(margin_case, irg):
    _, ds, _ = margin_case
    boundary = pipeline.boundary(ds)
    rows = irg("boundary", "out.zarr", "--json")
    for variable, values in columns(rows, "critical_velocity", "critical_velocity_p50"):
        same(values, boundary[variable].values.ravel(), 1e-9)
    along = pipeline.margin(ds, boundary["load"], 1.2)
    known = along["log_rise_ratio"].notnull()
    for variable in ("critical_velocity", "outcome_along_velocity"):
        same(along[variable].where(known), boundary[variable].where(known).transpose(*along.dims))
    names = "critical_velocity_p50", "mild_velocity", "severe_velocity"
    half, mild, severe = lines = [boundary[name].drop_attrs().rename("velocity") for name in names]
    beside = pipeline.margin(ds, boundary["load"], xr.concat(lines, "line"))
    is_half = abs(beside["probability"].isel(line=0) - 0.5) < 1e-6
    assert is_half.where(half.notnull(), True).all()
    for k, (limit, code) in enumerate(((mild, MILD), (severe, SEVERE)), 1):
        assert (beside["verdict"].isel(line=k) == code).where(limit.notnull(), True).all()


def test_every_door_names_the_test_that_limits_the_boundary(monkeypatch, irg, undrawn):
    severe = bare_test(300.0, 1.0, outcome="severe", bulk_temperature=280.0)
    mild = [bare_test(200.0, 3.0, outcome="mild", number=f"m{k}") for k in range(40)]
    ds = synthetic.sweep(tests=(*synthetic.MEASURED, severe, *mild), **SMALL)
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: ds)
    ruling = "test 5 (severe, 300 N, 1 m/s) rules out mild wear from 1 m/s"
    line = f"at 300 to 600 N, {ruling}"
    assert line in irg("boundary", "out.zarr").replace("\n    ", " ")
    rows = irg("boundary", "out.zarr", "--json")
    assert [row["ruled out by"] for row in rows] == ["", *[ruling] * 3, ""]
    mild = [row["mild up to [m/s]"] for row in rows][1:4]
    assert mild == pytest.approx([1.0] * 3, rel=1e-5)
    assert max(mild) < 1.0
    caption = "".join(text.get_text() for text in pipeline.plot(ds).findobj(Text))
    assert line in caption.replace("\n", " ")
    assert f"A{line[1:]}." in html.unescape(pipeline.report(ds))
    reason = irg("margin", "out.zarr", "--load", "400 N", "--velocity", "1.05 m/s")
    assert "test 5 (severe, 300 N, 1 m/s) rules it out" in reason


@pytest.mark.parametrize("name", ["film", "stages", "pending"])
def test_the_edges_of_regions_in_the_figure_are_the_limits_of_the_boundary(name):
    ds, _ = store(name)
    boundary, compared = pipeline.boundary(ds), 0
    collections = pipeline.plot(ds).axes[0].collections
    for verdict in ("mild", "severe"):
        shades = [shade for shade in collections if shade.get_gid() == f"{verdict} region"]
        paths = [path.vertices for shade in shades for path in shade.get_paths()]
        corners = np.concatenate([np.empty((0, 2)), *paths])
        for load, limit in boundary[f"{verdict}_velocity"].to_series().dropna().items():
            assert limit in corners[corners[:, 1] == load, 0], (verdict, load)
            compared += 1
    assert compared >= 5


@pytest.mark.parametrize("name", ["film", "pending"])
def test_the_figure_shades_a_point_as_it_is_judged(name):
    ds, _ = store(name)
    regions = {}
    for collection in pipeline.plot(ds).axes[0].collections:
        regions.setdefault(collection.get_gid(), []).extend(collection.get_paths())
    rng, seen = np.random.default_rng(1), set()
    loads, velocities = rng.uniform(210, 735, 60), rng.uniform(0.55, 3.95, 60)
    # The end of a region is a line between the loads of its corners.
    nearby = xr.DataArray([0.99, 1.0, 1.01], dims="near")
    at = (xr.DataArray(values, dims="place") * nearby for values in (loads, velocities))
    around = words(pipeline.margin(ds, *at).transpose("near", "place")).reshape(3, -1)
    for load, velocity, *verdicts in zip(loads, velocities, *around, strict=True):
        if len({*verdicts}) == 1 and verdicts[0] not in ("unknown", "outside the model"):
            painted = [
                verdict
                for verdict in ("undecided", "mild", "severe")  # in the order of painting
                for path in regions.get(f"{verdict} region", ())
                if path.contains_point((velocity, load))
            ]
            assert painted[-1:] == verdicts[:1], (load, velocity)
            seen |= {*painted[-1:]}
    assert len(seen) >= 2


@pytest.mark.parametrize("name", [name for name in STORES if name != "cases"])
def test_the_report_has_the_verdicts_of_the_table(name, undrawn):
    ds, margin = store(name)
    page = html.unescape(pipeline.report(ds, points=table(name)))
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page)
    assert [cell for cell in cells if cell in VERDICTS][:50] == words(margin).tolist()


# Dominance


@pytest.mark.parametrize("film", [None, 1e9, 1.0])
def test_nothing_is_mild_that_is_no_easier_than_a_severe_test(film):
    rng, against = np.random.default_rng(7), 0
    for _ in range(2):
        tests = [
            bare_test(
                float(rng.uniform(250, 700)), float(rng.uniform(0.6, 3)), outcome=outcome,
                bulk_temperature=float(rng.uniform(280, 330)),
            )
            for outcome in rng.choice(["mild", "severe"], 3)
        ]  # fmt: skip
        arguments = {"tests": tests, "model_bias": 0.01, **SMALL}
        ds = filmed(inlet=film, **arguments) if film else synthetic.sweep(**arguments)
        if film == 1e9:  # only the tests had an oil film
            ds = ds.assign(film_inlet=ds["film_inlet"] * 0 + 1e-9)
        load, velocity = rng.uniform(210, 740, 60), rng.uniform(0.55, 3.9, 60)
        bulk = rng.uniform(280, 330, 60).round(-1)
        at = load, velocity
        conditions = {"bulk_temperature": xr.DataArray(bulk, dims="place")}
        margin = pipeline.margin(ds, *at, **conditions)
        free = pipeline.margin(ds.assign_attrs(without_tests="yes"), *at, **conditions)
        for test in tests:
            ways = load - test.normal_load, velocity - test.velocity, bulk - test.bulk_temperature
            kind, sign = ("mild", 1) if test.outcome == "severe" else ("severe", -1)
            if kind == "severe" and film == 1e9:  # known to be too thick for a mild test to count
                continue
            no_easier = (sign * np.array(ways) >= 0).all(axis=0)
            assert not (no_easier & (words(margin) == kind)).any(), (kind, test)
            against += int((no_easier & (words(free) == kind)).sum())
    assert against > 0


# Arguments of every type


@functools.cache
def plane():
    return synthetic.sweep(**SMALL)


@functools.cache
def usual_probability():
    return pipeline.margin(plane(), 400.0, 2.0)["probability"].item()


@functools.cache
def usual_boundary():
    return pipeline.boundary(plane())["critical_velocity"]


def with_unit(value, unit, **attributes):
    return xr.DataArray(value, attrs={"units": unit, **attributes})


@pytest.mark.parametrize(
    ("load", "conditions"),
    [
        (np.str_("0.4 kN"), {"friction": "10 %"}),
        (["0.4 kN", 400.0], {"bulk_temperature": with_unit(25.0, "degC")}),
        (pd.Series(["400 N"]), {"friction": with_unit(10.0, "%")}),
        (with_unit(0.4, "kN"), {"critical_temperature": None}),
    ],
)
def test_values_are_taken_with_their_units_by_every_door(load, conditions):
    probability = pipeline.margin(plane(), load, "2 m/s", **conditions)["probability"]
    same(probability, np.full(probability.shape, usual_probability()))
    same(usual_boundary(), pipeline.boundary(plane(), **conditions)["critical_velocity"])


REFUSED = {  # load and velocity, conditions, message
    "no unit": (("400", 2.0), {}, '"400" has no unit'),
    "of time": ((with_unit(3.0, "s"), 2.0), {}, "cannot be converted to N"),
    "true": ((True, 2.0), {}, "load: true is not a number"),
    "newtons": ((), {"friction": "300 N"}, 'friction: "300 N" is not a number'),
    "nan": ((), {"friction": np.nan}, "friction: nan is outside the allowed range"),
    "hot bulk": ((), {"bulk_temperature": "150 degC"}, "must be above the bulk temperature"),
    "slip": ((), {"fricton": 0.1}, "fricton is not a condition"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_load_and_no_condition_is_refused_in_a_line(name):
    point, conditions, message = REFUSED[name]
    doors = ("margin",) if point else ("boundary", "points")
    for door in doors:
        with pytest.raises(InputError, match=re.escape(message)) as error:
            getattr(pipeline, door)(plane(), *point, **conditions)
        assert "\n" not in str(error.value)


def test_a_load_that_no_contact_has_is_unknown_and_said():
    loads = [np.nan, np.inf, -400.0, 0, "-4 N", 400.0, 400.0]
    margin = pipeline.margin(plane(), loads, [*[2.0] * 5, 0.0, 2.0])
    assert words(margin).tolist() == ["unknown"] * 6 + ["undecided"]
    assert np.isnan(margin["probability"].values[:-1]).all()
    assert all("give a value inside it" in reason for reason in margin["reason"].values[:-1])


def test_only_margin_and_boundary_take_several_values():
    for door in ("points", "compare_tests", "infer", "temperatures"):
        with pytest.raises(InputError, match="friction takes a single value here"):
            getattr(pipeline, door)(plane(), friction=[0.1, 0.2])
    for argument in (None, 5, plane()["status"]):
        for door in ("margin", "boundary", "points", "infer", "temperatures"):
            with pytest.raises(InputError, match=r"give a Dataset of pipeline\.open_sweep"):
                getattr(pipeline, door)(argument)
