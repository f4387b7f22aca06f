"""One table of 200 points, and each type of argument, given to every door: one answer, or none."""

import functools
import html
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline.page import report
from pipeline.page.report import Picture
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
    "critical_velocity_p50",
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
    late = {place: 0 for number, place in enumerate(late) if number % 2}
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
    """50 points in and around a plane, half of them with a friction and a bulk of their own."""
    rng = np.random.default_rng([*STORES].index(name))
    places = rng.uniform(190, 760, 50).round(2), rng.uniform(0.45, 4.1, 50).round(3)
    own = rng.random(50) < 0.5
    friction = np.where(own, rng.uniform(0.08, 0.13, 50).round(4), np.nan)
    bulk = np.where(own, rng.uniform(15, 60, 50).round(2), np.nan)
    heads = "load [N]", "velocity [m/s]", "friction", "bulk temperature [degC]"
    return pd.DataFrame(dict(zip(heads, (*places, friction, bulk), strict=True)))


@functools.cache
def store(name):
    """A store, and what `pipeline.margin` says of its table, given as arrays."""
    ds, rows = STORES[name](), table(name)
    load, velocity, friction, bulk = (one.to_numpy() for one in map(rows.get, rows))
    told = {"friction": friction, "bulk_temperature": bulk + 273.15}
    told = {
        name: xr.DataArray([None if np.isnan(one) else one for one in values], dims="place")
        for name, values in told.items()
    }
    return ds, pipeline.margin(ds, load, velocity, **told)


@pytest.fixture(params=STORES)
def asked(request, monkeypatch):
    ds, found = store(request.param)
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: ds)
    return request.param, ds, found


def words(found):
    codes = named(found["verdict"]).ravel().tolist()
    return np.array([one.replace("outside_", "outside the ") for one in codes], object)


def same(left, right, rtol=1e-12):
    np.testing.assert_allclose(np.array(left, float), np.array(right, float), rtol, 1e-12)


def columns(rows, *names):
    """Values of rows of JSON or CSV, by the names of variables and in SI."""
    heads = {head.partition(" [")[0]: head for head in rows[0]}
    for name in names:
        head = heads[
            {"critical_velocity_p50": "with tests, 50 %"}.get(name, name.replace("_", " "))
        ]
        values = np.array([row[head] or np.nan for row in rows], float)
        yield name, values + 273.15 * (name == "governing_temperature")


def test_array_table_and_command_say_the_same_of_all_points(asked, tmp_path, irg):
    name, ds, found = asked
    by_table = pipeline.margin(ds, table(name))
    for one in (*NUMBERS, "verdict", "warning_flags", "outcome_along_velocity"):
        same(by_table[one], found[one])
    found = found.transpose("place", ...)  # the order of rows
    assert (by_table["reason"] == found["reason"]).all()
    seen = words(found).tolist()
    assert len({*seen}) >= 3
    table(name).to_csv(tmp_path / "t.csv", index=False)
    command = "margin", "out.zarr", "--points", tmp_path / "t.csv", "-o", tmp_path / "out.csv"
    said, rows = irg(*command), irg(*command, "--json")
    assert [row["verdict"] for row in rows] == seen
    for one, values in columns(rows, *NUMBERS):
        same(values, found[one].values.ravel(), 1e-9)
    written = pd.read_csv(tmp_path / "out.csv").replace({np.nan: None}).to_dict("records")
    assert [row["verdict"] for row in written] == seen
    for one, values in columns(written, "probability", "temperature_margin"):
        np.testing.assert_allclose(values, found[one].values.ravel(), 1e-5, 1e-5)
    counts = {verdict: seen.count(verdict) for verdict in {*seen}}
    assert all(f"{count} {verdict}" in said for verdict, count in counts.items())


def test_a_point_alone_gets_what_it_gets_in_the_table(asked, irg):
    name, ds, found = asked
    load, velocity, friction, bulk = table(name).iloc[17].tolist()
    own = {} if np.isnan(friction) else {"friction": friction, "bulk_temperature": f"{bulk} °C"}
    here, there = pipeline.margin(ds, load, f"{velocity} m/s", **own), found.isel(place=17)
    for one in NUMBERS:
        same(here[one], there[one])
    assert words(here).tolist() == words(there).tolist()
    told = [part for key, x in own.items() for part in (f"--{key.replace('_', '-')}", x)]
    place = "margin", "out.zarr", "--load", f"{load} N", "--velocity", f"{velocity} m/s"
    if "unknown" in words(there):
        assert there["reason"].values.ravel()[0] in irg(*place, *told, code=2)
        return
    said, rows = irg(*place, *told), irg(*place, *told, "--json")
    assert [row["verdict"] for row in rows] == words(there).tolist()
    for one, values in columns(rows, *NUMBERS):
        same(values, there[one].values.ravel(), 1e-9)
    assert words(there)[0].capitalize() in said.replace("\n    ", " ")


def test_boundary_figure_and_margin_draw_one_line(asked, irg):
    _, ds, _ = asked
    found = pipeline.boundary(ds)
    rows = irg("boundary", "out.zarr", "--json")
    for one, values in columns(rows, "critical_velocity", "critical_velocity_p50"):
        same(values, found[one].values.ravel(), 1e-9)
    along = pipeline.margin(ds, found["load"], 1.2)
    known = along["log_rise_ratio"].notnull()
    for one in ("critical_velocity", "outcome_along_velocity"):
        same(along[one].where(known), found[one].where(known).transpose(*along.dims))
    shares = xr.DataArray([0.05, 0.5, 0.95], dims="share")
    ends = [found[f"critical_velocity_p{100 * share:02.0f}"] for share in shares.values]
    ends = xr.concat(ends, "share", combine_attrs="override")
    here = pipeline.margin(ds, ends["load"], ends)["probability"]
    assert (abs(here - shares) < 1e-6).where(here.notnull(), True).all()
    assert here.notnull().any()


@pytest.mark.parametrize("name", ["film", "pending"])
def test_the_figure_shades_a_point_as_it_is_judged(name):
    ds, _ = store(name)
    regions = {one.get_gid(): one.get_paths() for one in pipeline.plot(ds).axes[0].collections}
    rng, seen = np.random.default_rng(1), set()
    loads, velocities = rng.uniform(210, 735, 120), rng.uniform(0.55, 3.95, 120)
    # The end of a region is known only to within a cell of the figure's grid.
    nearby = xr.DataArray([0.99, 1.0, 1.01], dims="near")
    at = (xr.DataArray(one, dims="place") * nearby for one in (loads, velocities))
    around = words(pipeline.margin(ds, *at).transpose("near", "place")).reshape(3, -1)
    for load, velocity, *verdicts in zip(loads, velocities, *around, strict=True):
        if len({*verdicts}) == 1 and verdicts[0] not in ("unknown", "outside the model"):
            painted = [
                verdict
                for verdict in ("mild", "undecided", "severe")  # each upon those before
                for path in regions.get(f"{verdict} region", ())
                if path.contains_point((velocity, load))
            ]
            assert painted[-1:] == verdicts[:1], (load, velocity)
            seen |= {*painted[-1:]}
    assert len(seen) >= 2


@pytest.mark.parametrize("name", [name for name in STORES if name != "cases"])
def test_the_report_has_the_verdicts_of_the_table(name, monkeypatch):
    ds, found = store(name)
    # Its pictures take seconds to draw.
    monkeypatch.setattr(report, "picture_of", lambda draw, *texts: Picture("", "", *texts))
    page = html.unescape(pipeline.report(ds, points=table(name)))
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page)
    assert [one for one in cells if one in VERDICTS][:50] == words(found).tolist()


# Dominance


@pytest.mark.parametrize("film", [None, 1e9, 1.0])
def test_nothing_is_mild_that_is_no_easier_than_a_severe_test(film):
    rng, against = np.random.default_rng(7), 0
    for _ in range(2):
        made = [
            bare_test(
                float(rng.uniform(250, 700)), float(rng.uniform(0.6, 3)), outcome=outcome,
                bulk_temperature=float(rng.uniform(280, 330)),
            )
            for outcome in rng.choice(["mild", "severe"], 3)
        ]  # fmt: skip
        told = {"tests": made, "model_bias": 0.01, **SMALL}
        ds = filmed(inlet=film, **told) if film else synthetic.sweep(**told)
        if film == 1e9:  # tests alone had a film
            ds = ds.assign(film_inlet=ds["film_inlet"] * 0 + 1e-9)
        load, velocity = rng.uniform(210, 740, 60), rng.uniform(0.55, 3.9, 60)
        bulk = rng.uniform(280, 330, 60)
        at = load, velocity
        own = {"bulk_temperature": xr.DataArray(bulk, dims="place")}
        asked = pipeline.margin(ds, *at, **own)
        free = pipeline.margin(ds.assign_attrs(without_tests="yes"), *at, **own)
        for test in made:
            ways = load - test.normal_load, velocity - test.velocity, bulk - test.bulk_temperature
            kind, sign = ("mild", 1) if test.outcome == "severe" else ("severe", -1)
            if kind == "severe" and film == 1e9:  # known to be too thick for a mild test to count
                continue
            no_easier = (sign * np.array(ways) >= 0).all(axis=0)
            assert not (no_easier & (words(asked) == kind)).any(), (kind, test)
            against += int((no_easier & (words(free) == kind)).sum())
    assert against > 0


# Arguments of every type


@functools.cache
def plane():
    return synthetic.sweep(**SMALL)


def with_unit(value, unit, **attributes):
    return xr.DataArray(value, attrs={"units": unit, **attributes})


@pytest.mark.parametrize(
    ("load", "told"),
    [
        (np.str_("0.4 kN"), {"friction": "10 %"}),
        (["0.4 kN", 400.0], {"bulk_temperature": with_unit(25.0, "degC")}),
        (pd.Series(["400 N"]), {"friction": with_unit(10.0, "%")}),
        (with_unit(0.4, "kN"), {"critical_temperature": None}),
    ],
)
def test_values_are_taken_with_their_units_by_every_door(load, told):
    usual = pipeline.margin(plane(), 400.0, 2.0)["probability"].item()
    found = pipeline.margin(plane(), load, "2 m/s", **told)["probability"].values.ravel()
    same(found, np.full(found.shape, usual))
    critical = [pipeline.boundary(plane(), **own)["critical_velocity"] for own in ({}, told)]
    same(*critical)


REFUSED = {  # by the place or the conditions that are given
    "no unit": (("400", 2.0), {}, '"400" has no unit'),
    "of time": ((with_unit(3.0, "s"), 2.0), {}, "cannot be converted to N"),
    "true": ((True, 2.0), {}, "True is no number"),
    "empty": (([], 2.0), {}, "load is empty"),
    "plane": (([[1.0]], 2.0), {}, "2 dimensions"),
    "alone": ((None, 2.0), {}, "give both a load and a velocity"),
    "newtons": ((), {"friction": "300 N"}, "friction is '300 N'"),
    "nan": ((), {"friction": np.nan}, "must be one finite number"),
    "celsius as kelvin": ((), {"bulk_temperature": 25}, "at which no oil works"),
    "hot bulk": ((), {"bulk_temperature": "150 degC"}, "must be above the bulk temperature"),
    "slip": ((), {"fricton": 0.1}, "fricton is no condition"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_load_and_no_condition_is_refused_in_a_line(name):
    place, told, said = REFUSED[name]
    doors = ("margin",) if place else ("boundary", "points")
    for door in doors:
        with pytest.raises(InputError, match=re.escape(said)) as error:
            getattr(pipeline, door)(plane(), *place, **told)
        assert "\n" not in str(error.value)


def test_a_load_that_no_contact_has_is_unknown_and_said():
    impossible = np.nan, np.inf, -400.0, 0, "-4 N"
    found = pipeline.margin(plane(), [*impossible, 400.0], 2.0)
    assert words(found).tolist() == ["unknown"] * len(impossible) + ["undecided"]
    assert np.isnan(found["probability"].values[:-1]).all()
    assert all("give a value inside it" in one for one in found["reason"].values[:-1])


def test_only_margin_and_boundary_take_several_values():
    for door in ("points", "compare_tests", "infer", "temperatures"):
        with pytest.raises(InputError, match="friction takes a single value here"):
            getattr(pipeline, door)(plane(), friction=[0.1, 0.2])
    for given in (None, 5, plane()["status"]):
        for door in ("margin", "boundary", "points", "infer", "temperatures"):
            with pytest.raises(InputError, match=f"not a {type(given).__name__}"):
                getattr(pipeline, door)(given)
