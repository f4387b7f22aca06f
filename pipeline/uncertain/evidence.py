"""Likelihood of tests: transitions that were measured, and points that were mild or severe.

Each draw of the inputs has a velocity V_c of its own at which wear turns severe, at the load,
friction and bulk temperature of the test. With d = ln(V/V_c) over its standard deviation σ, a
transition measured at V has the likelihood φ(d/σ)/σ, a test that turned severe Φ(d/σ), a mild one
Φ(−d/σ). σ has the scatter of the velocity, those of load and friction by the slope of the rise, and
the emulator's error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.special import log_ndtr

from pipeline.uncertain.answers import log_crossings
from pipeline.uncertain.ensemble import Ensemble
from tribo import InputError
from tribo.types import Array

_NODES = 9  # velocities at which rises are emulated
_SPAN = 1.05  # ratio of loads between which a slope is taken
_LEAST_SLOPE = 0.05  # of ln(rise) over ln(velocity)


class Distances(NamedTuple):
    """Distances of draws from tests.

    Attributes
    ----------
    values : ndarray, shape (n_test, n)
        Logarithm of a test's velocity over the critical one of each draw.
    variance : ndarray, shape (n_test, n)
        Its variance, without the scatter of the velocity.
    """

    values: Array
    variance: Array


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Tests of one sweep.

    Attributes
    ----------
    ensemble : Ensemble
        Samples of the sweep.
    columns : ndarray of int
        Columns of the draws that are its unknown inputs.
    tests : tuple of mapping
        Tests, as `Measurement.as_dict` gives them.
    """

    ensemble: Ensemble
    columns: Any
    tests: tuple[Mapping[str, Any], ...]

    def __post_init__(self) -> None:
        for test in self.tests:
            place = f"the test at {test['normal_load']:g} N and {test['velocity']:g} m/s"
            try:
                self.ensemble.require_within([test["normal_load"]], [test["velocity"]])
            except InputError as error:
                raise InputError(f"{place}: {error}") from error
            hold = test.get("hold", self.ensemble.hold)
            if hold != self.ensemble.hold:
                raise InputError(
                    f"{place} held the load for {hold:g} s, the samples for "
                    f"{self.ensemble.hold:g} s: run them with loading.hold as in the tests"
                )
            if "load_scatter" in test and len(self.ensemble.loads) < 2:
                raise InputError(
                    f"{place} has a load_scatter, and the samples one load alone: give more "
                    "sweep.loads, or leave out the scatter"
                )

    def distances(self, draws: Array) -> Distances:
        """Distances of draws, shape (n, n_unknown of all sweeps), from the tests."""
        ensemble, inputs = self.ensemble, draws[:, self.columns]
        nodes = np.geomspace(*ensemble.velocities, _NODES)
        ends = ensemble.loads[[0, -1]]
        loads = sorted({
            load
            for test in self.tests
            for load in (test["normal_load"], *_around(test, ends))
        })  # fmt: skip
        excess = ensemble.excesses(inputs, loads, nodes)
        rises = excess.values + ensemble.log_limit(inputs)[:, None, None]
        x = np.log(nodes)
        conditions = ensemble.conditions
        # A friction that was measured stands in place of the scene's friction by velocity.
        table = np.log([conditions.friction_at(v) / conditions.friction for v in nodes.tolist()])
        values, variances = [], []
        for test in self.tests:
            rise = rises[:, loads.index(test["normal_load"])]
            if test.get("friction") is not None:
                rise = rise - table
            limit = ensemble.log_limit(inputs, conditions_of(test))
            log_velocity = math.log(test["velocity"])
            place = int(np.clip(np.searchsorted(x, log_velocity) - 1, 0, _NODES - 2))
            slope = (rise[:, place + 1] - rise[:, place]) / (x[place + 1] - x[place])
            slope = np.maximum(slope, _LEAST_SLOPE)
            error = excess.error[:, loads.index(test["normal_load"]), place]
            variance = error**2
            if around := _around(test, ends):
                low, high = (rises[:, loads.index(load), place] for load in around)
                steepness = (high - low) / math.log(around[1] / around[0])
                variance = variance + (steepness * test["load_scatter"] / test["normal_load"]) ** 2
            if "friction_scatter" in test:
                variance = variance + (test["friction_scatter"] / test["friction"]) ** 2
            values.append(log_velocity - log_crossings(nodes, rise - limit[:, None]))
            variances.append(variance / slope**2)
        return Distances(np.array(values), np.array(variances))


def conditions_of(test: Mapping[str, Any]) -> dict[str, float]:
    """Conditions that a test gives itself."""
    names = ("friction", "bulk_temperature")
    return {name: test[name] for name in names if test.get(name) is not None}


def _around(test: Mapping[str, Any], ends: Array) -> tuple[float, ...]:
    """Loads between which the slope over the load is taken, if the load scatters."""
    if "load_scatter" not in test:
        return ()
    low, high = np.clip([test["normal_load"] / _SPAN, test["normal_load"] * _SPAN], *ends)
    return float(low), float(high)


def log_likelihoods(
    tests: Sequence[Mapping[str, Any]], distances: Distances, scatters: Sequence[float] | Array
) -> Array:
    """Logarithm of the likelihood of each test by draw and scatter, shape (n_test, n, n_scatter).

    Parameters
    ----------
    tests : sequence of mapping
        Tests, an ``outcome`` among their entries where they are no transitions.
    distances : Distances
        Distances of the draws.
    scatters : sequence of float
        Relative standard deviations of velocities that do not give their own.

    Examples
    --------
    >>> tests = [{"velocity": 2.0}, {"velocity": 2.0, "outcome": "severe"}]
    >>> apart = Distances(np.array([[0.0], [0.0]]), np.zeros((2, 1)))
    >>> print(np.exp(log_likelihoods(tests, apart, [0.05])).round(2).ravel())
    [20.   0.5]
    """
    rows = []
    for test, d, variance in zip(tests, *distances, strict=True):
        deviation = np.sqrt(variance[:, None] + scatters_of(test, scatters) ** 2)
        z = d[:, None] / deviation
        match test.get("outcome"):
            case "severe":
                rows.append(log_ndtr(z))
            case "mild":
                rows.append(log_ndtr(-z))
            case _:
                rows.append(-0.5 * z**2 - np.log(deviation))
    return np.array(rows)


def scatters_of(test: Mapping[str, Any], scatters: Sequence[float] | Array) -> Array:
    """Relative scatter of a test's velocity for each that others may have."""
    if "velocity_scatter" in test:
        return np.full(len(scatters), test["velocity_scatter"] / test["velocity"])
    return np.asarray(scatters)
