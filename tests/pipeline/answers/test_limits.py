"""Mild and severe limits, compared with verdicts on both of their sides."""

import math

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline.answers.verdict_limits import Side
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED, UNKNOWN
from pipeline.store.schema import DONE, FAILED, PENDING, PLANE
from tests.helpers import synthetic
from tests.helpers.entries import bare_test
from tests.pipeline.test_film import filmed

LOADS, VELOCITIES = (200.0, 300.0, 400.0, 600.0, 750.0), (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
SMALL = {"loads": LOADS, "velocities": VELOCITIES}
LIMIT = synthetic.limit()
RULINGS = (
    bare_test(300.0, 0.75, outcome="severe", number="weak"),
    bare_test(700.0, 3.8, outcome="mild", number="strong"),
    *(
        bare_test(400.0, float(synthetic.critical_velocity(400.0, 1.05 * LIMIT)), number=f"t{k}")
        for k in range(12)
    ),
)


def kinked(load, velocity, quantile=1.0):
    """Rise with a step of 8 % at 1.4 m/s, which makes the interpolation error large there."""
    return synthetic.rise(load, velocity, quantile) * (1 + 0.08 * np.tanh(12 * (velocity - 1.4)))


SCENES = {
    "tests": lambda: synthetic.sweep(**SMALL),
    "without tests": lambda: synthetic.sweep(tests=(), **SMALL),
    "rulings": lambda: synthetic.sweep(tests=RULINGS, **SMALL),
    "film": lambda: filmed(**SMALL),
    "film at every place": lambda: filmed(inlet=1e9, **SMALL),
    "stages": lambda: synthetic.sweep(loading=tribo.Stages(LOADS, (5.0,) * 5, 150.0), **SMALL),
    "failed points": lambda: synthetic.sweep(
        status={(400.0, 1.5): FAILED, (600.0, 1.0): FAILED, (200.0, 0.5): FAILED}, **SMALL
    ),
    "failed load": lambda: synthetic.sweep(
        status={(600.0, v): FAILED for v in VELOCITIES[:-1]} | {(750.0, 4.0): FAILED}, **SMALL
    ),
    "pending mild test": lambda: synthetic.with_tests(
        synthetic.sweep(
            tests=(*synthetic.MEASURED, bare_test(300.0, 2.0, outcome="mild")), **SMALL
        ),
        status=[*[DONE] * 4, PENDING],
    ),
    "uneven": lambda: synthetic.sweep(rise=synthetic.uneven(4), **SMALL),
    "falling": lambda: synthetic.sweep(rise=synthetic.falling, tests=(), **SMALL),
    "kinked": lambda: synthetic.sweep(rise=kinked, **SMALL),
    "unknown error": lambda: synthetic.sweep(preset=None, **SMALL),
    "critical temperature from tests": lambda: synthetic.sweep(
        tests=(*synthetic.MEASURED, bare_test(300.0, 0.8, outcome="mild")),
        conditions=synthetic.CONDITIONS | {"critical_temperature": None},
        critical_from_tests=True,
        **SMALL,
    ),
}


def places(seed, count):
    """Random loads, velocities, friction coefficients and bulk temperatures.

    The bulk temperatures are multiples of 10 K: each needs its own posterior.
    """
    rng = np.random.default_rng(seed)
    values = rng.uniform([200, 0.5, 0.07, 290], [750, 4.0, 0.16, 340], (count, 4)).T
    values[3] = values[3].round(-1)
    names = *PLANE, "friction", "bulk_temperature"
    return {k: xr.DataArray(column, dims="place") for k, column in zip(names, values, strict=True)}


def margins_beside(ds, at, limits):
    """Margins (side, axis, place) just below and above the `limits` of each axis at places."""
    near = xr.DataArray([1 - 1e-3, 1 + 1e-3], dims="side")
    places = {
        name: xr.concat(
            [limits[axis] * near if axis == name else values + 0 * near for axis in limits], "axis"
        )
        for name, values in at.items()
    }
    return pipeline.margin(ds, **places).transpose("side", "axis", "place", ...)


@pytest.mark.parametrize("count", [25, pytest.param(150, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", SCENES)
def test_wear_is_mild_just_below_a_mild_limit_and_not_just_above(name, count):
    ds, at = SCENES[name](), places([*SCENES].index(name), count)
    margin = pipeline.margin(ds, **at)
    verdict = margin["verdict"].values
    limits = {
        axis: xr.DataArray(margin[f"mild_{axis}"].fillna(0.1).values, dims="place")
        for axis in (*PLANE, "friction")
    }
    beside = margins_beside(ds, at, limits)
    for k, axis in enumerate(limits):
        below, above = beside["verdict"].values[:, k]
        limit, side = margin[f"mild_{axis}"].values, margin[f"mild_{axis}_side"].values
        factor = margin[f"{axis}_safety_factor"].values
        is_inside = side == Side.INSIDE
        assert (np.isfinite(limit) == is_inside).all()
        low = -math.inf if axis == "friction" else float(ds[axis].min())
        is_tested = is_inside & (limit * (1 - 1e-3) > low)
        assert (below[is_tested] == MILD).all(), (axis, limit[is_tested & (below != MILD)])
        assert (above[is_inside] != MILD).all(), (axis, limit[is_inside & (above == MILD)])
        # The limit is the same from just below it, and never contradicts the verdict at its point.
        same = beside[f"mild_{axis}"].values[0, k]
        np.testing.assert_allclose(same[is_tested], limit[is_tested], rtol=1e-5)
        has_factor = np.isfinite(factor)
        assert ((factor >= 1 - 1e-9) == (verdict == MILD))[has_factor].all()
        assert (has_factor | (side == Side.ABOVE))[verdict == MILD].all()
        assert not (side == Side.ABOVE)[np.isin(verdict, (UNDECIDED, SEVERE))].any()


KINDS = {"mild": (MILD, 1), "severe": (SEVERE, -1)}  # verdict, and on which side it ends


@pytest.mark.parametrize("name", SCENES)
def test_limits_have_their_verdict_on_one_side_only(name):
    """Under the conditions of the scene, and under seven random ones."""
    ds, tested = SCENES[name](), 0
    conditions = {k: v for k, v in places([*SCENES].index(name), 8).items() if k not in PLANE}
    for condition, value in conditions.items():
        value[0] = synthetic.CONDITIONS[condition]
    boundary, near = pipeline.boundary(ds, **conditions), xr.DataArray([-1e-3, 1e-3], dims="side")
    for axis, other in (("velocity", "load"), ("load", "velocity")):
        ends = float(ds[axis].min()), float(ds[axis].max())
        limits = {kind: boundary[f"{kind}_{axis}"].drop_attrs() for kind in KINDS}
        beside = [
            (limit * (1 + KINDS[kind][1] * near)).clip(*ends) for kind, limit in limits.items()
        ]
        at = {axis: xr.concat(beside, "kind"), other: boundary[other]}
        verdicts = pipeline.margin(ds, **conditions, **at)["verdict"]
        for k, (kind, limit) in enumerate(limits.items()):
            (code, _), is_limit = KINDS[kind], limit.notnull()
            within, beyond = (verdicts.isel(kind=k, side=side) for side in (0, 1))
            assert (within == code).where(is_limit, True).all(), (axis, kind)
            assert not (beyond == code).where(is_limit, False).any(), (axis, kind)
            tested += int(is_limit.sum())
    assert tested > 0 or name in ("film at every place", "unknown error")


@pytest.mark.parametrize("name", SCENES)
def test_all_places_from_the_lowest_to_a_mild_limit_are_mild_and_from_a_severe_one_severe(name):
    ds = SCENES[name]()
    boundary = pipeline.boundary(ds)
    for axis, other in (("velocity", "load"), ("load", "velocity")):
        line = boundary[other].drop_vars(other)
        values = xr.DataArray(
            np.linspace(float(ds[axis].min()), float(ds[axis].max()), 25), dims=axis
        )
        verdicts = pipeline.margin(ds, **{axis: values, other: line})["verdict"]
        for kind, (code, _) in KINDS.items():
            limit, side = (
                boundary[f"{kind}_{axis}{end}"].drop_vars(other).fillna(math.inf)
                for end in ("", "_side")
            )
            is_in = values < limit if kind == "mild" else values > limit
            is_in |= side == (Side.ABOVE if kind == "mild" else Side.BELOW)
            is_in &= ~side.isin((Side.OUTSIDE_MODEL, Side.UNKNOWN))
            is_in &= (side != Side.BELOW) | (kind == "severe")
            is_right = verdicts.isin((code, OUTSIDE, UNKNOWN))
            assert (is_right | ~is_in).all()
            end = verdicts.isel({axis: 0 if kind == "mild" else -1})
            for verdict, nowhere in ((OUTSIDE, Side.OUTSIDE_MODEL), (UNKNOWN, Side.UNKNOWN)):
                assert (end == verdict).where(side == nowhere, True).all()


def test_a_severe_test_at_a_load_below_the_sweep_lowers_the_mild_limits_of_all_loads():
    repeats = tuple(
        bare_test(400.0, float(synthetic.critical_velocity(400.0, LIMIT)), number=f"t{k}")
        for k in range(60)
    )
    free = pipeline.boundary(synthetic.sweep(tests=repeats, **SMALL))["mild_velocity"].sel(load=200)
    velocity = 0.9 * free.item()
    severe = bare_test(150.0, velocity, outcome="severe")
    ds = synthetic.sweep(tests=(*repeats, severe), **SMALL)
    boundary = pipeline.boundary(ds).sel(load=200)
    assert boundary["mild_velocity"].item() == pytest.approx(velocity, rel=1e-5)
    assert boundary["mild_velocity"].item() < velocity
    assert "150 N" in boundary["ruled_out_by"].item()
    verdicts = pipeline.margin(ds, 200.0, [0.999 * velocity, 1.001 * velocity])["verdict"]
    assert verdicts.values.tolist() == [MILD, UNDECIDED]
