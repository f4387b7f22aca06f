"""The outcomes along lines of a boundary say no more than is known."""

import functools
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.answers.conditions import judged
from pipeline.answers.field import Outcome
from pipeline.answers.results import sweep_of
from pipeline.sweep.conditions import allowable_rise
from tests.helpers import page_sweeps as sweeps
from tests.helpers.sweeps import deciding_rise, with_fields
from tribo import Corrections, Friction


def done_only(ds, is_done):
    """Copy of a sweep in which only some points are done, and the others pending."""
    mask = is_done & (ds["status"] == 1)
    steps = ["normal_load", "time", "rise_quantile", "mean_rise", "max_rise"]
    columns = {name: ds[name].where(mask) for name in steps if name in ds}
    return ds.assign(columns | {"status": ds["status"].where(mask, 0).astype(np.int8)})


def full(seed=0):
    return sweeps.one(status={}, rise=sweeps.uneven(seed))


def interrupted(ds):
    """Copy of a sweep with half of the velocities done, and one more point."""
    velocity, load = ds["velocity"], ds["load"]
    return done_only(ds, (velocity < 1.6) | ((load == load[-1]) & (velocity == 3.0)))


def several(axis, parts):
    return xr.concat(
        parts,
        xr.Variable(axis, np.arange(len(parts))),
        combine_attrs="override",
        join="override",
        coords="minimal",
        compat="override",
    )


CASES = {
    "a grid": lambda: (full(), full()),
    "a hold": lambda: (sweeps.held(), sweeps.held()),
    "interrupted": lambda: (interrupted(full()), full()),
    "interrupted from above": lambda: (done_only(full(), full()["velocity"] > 1.6), full()),
    "boundary only": lambda: (sweeps.along_boundary(0), full()),
    "realizations": lambda: (
        several("realization", [interrupted(full(k)) for k in range(3)]),
        several("realization", [full(k) for k in range(3)]),
    ),
    "one load": lambda: (one_load(interrupted(full())), one_load(full())),
    "one velocity": lambda: (
        one_velocity(done_only(full(), full()["load"] < 500.0)),
        one_velocity(full()),
    ),
    "friction by velocity": lambda: (interrupted(slippery()), slippery()),
}


def one_load(ds):
    """Sweep of a scene that has only one load."""
    one = ds.isel(load=[3])
    return with_fields(one, loads=tuple(one["load"].values.tolist()))


def one_velocity(ds):
    """Sweep of a scene that has only one velocity."""
    one = ds.isel(velocity=[3])
    return with_fields(one, velocities=tuple(one["velocity"].values.tolist()))


def slippery():
    """Sweep with friction that falls with velocity."""
    ds = full()
    falling = Corrections(friction=Friction(by_velocity=((1.0, 1.1), (3.0, 0.9))))
    return with_fields(ds, conditions=replace(sweep_of(ds).conditions, corrections=falling))


CROSSES, MILD, SEVERE, ABOVE, BELOW, SEVERAL, UNKNOWN, *_ = Outcome
SEVERE_NEARLY_EVERYWHERE = {"friction": 0.3}
OTHERS = (
    {"friction": 0.05},
    {"friction": 0.07, "bulk_temperature": 330.0, "critical_temperature": 400.0},
    {"critical_area_fraction": 0.4, "friction": 0.12},
    {"critical_area_fraction": 0.0, "friction": 0.08},
)
ASKED = [
    pytest.param(name, changes, id=f"{name}, {changes}")
    for name in CASES
    for changes in ({}, *((SEVERE_NEARLY_EVERYWHERE, *OTHERS) if name == "a grid" else ()))
]


@functools.cache
def sweeps_of(name):
    return CASES[name]()


@functools.cache
def _judged(name, changes):
    ds, truth = sweeps_of(name)
    return ds, truth, pipeline.boundary(ds, **dict(changes))


def conditions_of(ds, changes):
    return judged(sweep_of(ds).conditions, changes)


def judged_case(name, changes):
    """A case under conditions, its true answers and its boundary; cached."""
    return _judged(name, tuple(changes.items()))


@pytest.mark.parametrize(("name", "changes"), ASKED)
def test_no_outcome_is_contradicted_by_points_that_were_not_computed(name, changes):
    ds, truth, crossings = judged_case(name, changes)
    conditions = conditions_of(ds, changes)
    limit = allowable_rise(conditions)
    for axis, along in (("load", "velocity"), ("velocity", "load")):
        x, may_turn_back = ds[along].values, along == "velocity" and conditions.has_friction_curve
        partial, true = (
            deciding_rise(sweep, conditions).transpose(..., axis, along).values.reshape(-1, len(x))
            for sweep in (ds, truth)
        )
        all_turns = crossings[f"crossings_along_{along}"].values
        all_turns = all_turns.reshape(-1, all_turns.shape[-1])
        outcomes = crossings[f"outcome_along_{along}"].values.ravel()
        if len(partial) > 1:  # realizations of one specimen, whose mean is no point of either
            continue
        lines = zip(partial, true, all_turns, outcomes, strict=True)
        for rises, all_rises, turns, outcome in lines:
            done, severe = np.isfinite(rises), all_rises > limit
            turns = turns[np.isfinite(turns)]
            assert (len(turns) > 0) == (outcome in (CROSSES, SEVERAL))
            for number, place in enumerate(turns):  # between points of different wear
                lower, upper = severe[done & (x <= place)], severe[done & (x >= place)]
                assert place in x or (lower[-1] != upper[0])
                assert place in x or outcome == SEVERAL or (number, lower[-1]) == (0, False)
            if outcome in (CROSSES, SEVERAL):
                continue
            if outcome == MILD:
                assert done[-1]
                assert not severe[np.isfinite(all_rises)].any()
            elif outcome == SEVERE:
                assert done[0]
                assert severe[0]
            elif outcome == ABOVE:
                assert not (done[-1] and (done[0] or not may_turn_back))
                assert not severe[done].any()
            elif outcome == BELOW:
                assert not (done[0] and (done[-1] or not may_turn_back))
                assert severe[done][0]
            else:
                assert not done.any()
