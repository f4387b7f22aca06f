"""Answers at operating points: probability of severe wear, and distance from it."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.margins import frame_of_points
from pipeline.scene.along import OperatingPoints, Place
from pipeline.scene.units import in_si
from pipeline.store.place import PathLike
from pipeline.uncertain.answers import STEPS, draws_of, log_crossings, probability_of
from pipeline.uncertain.ensemble import Ensemble, Excess
from pipeline.uncertain.inputs import BULK, CRITICAL, FRICTION, QUANTILES, Draws
from tribo.simulation.point_warnings import SLOWEST
from tribo.types import Array

_APART = 1.1  # ratio of velocities over which a slope is taken


@dataclass(frozen=True, slots=True)
class Risk:
    """Probability of severe wear at an operating point."""

    load: float  #: Normal load on the whole pin [N].
    velocity: float  #: Sliding velocity [m/s].
    probability: float  #: Probability of severe wear.
    error: float  #: Standard error of the probability, from the numbers of samples and of draws.
    #: Standard error of the emulated rise against a simulation, relative; the root mean square over
    #: the draws.
    rise_error: float
    samples: int  #: Samples that were simulated.
    #: The probability if all rises are too high or too low by the error of the samples' fidelity; 0
    #: and 1 where that error is not known.
    lowest: float
    highest: float
    #: Why the model does not fit the tests that weigh the inputs; empty if nothing speaks against.
    misfit: str = ""

    @property
    def verdict(self) -> str:
        """``"mild"`` or ``"severe"`` where 95 % of the probability says so, else not decided.

        Nothing is decided by a model that does not fit the tests.
        """
        if self.misfit:
            return NOT_DECIDED
        least, _, most = QUANTILES
        return "mild" if self.highest <= least else "severe" if self.lowest >= most else NOT_DECIDED

    def as_dict(self) -> dict[str, Any]:
        """Return all fields by name, and the verdict."""
        return asdict(self) | {"verdict": self.verdict}


def risk(
    ensemble: Ensemble,
    load: float | str,
    velocity: float | str,
    draws: Draws | None = None,
) -> Risk:
    """Probability of severe wear at an operating point.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    load : float or str
        Normal load on the whole pin [N], or text with a unit.
    velocity : float or str
        Sliding velocity [m/s], or text with a unit.
    draws : Draws, optional
        Draws of the unknown inputs; by the scene's distributions if not given.

    Raises
    ------
    InputError
        If the point lies outside the sweep, or the samples are too few.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> answer = pipeline.risk(ensemble, "400 N", "2.5 m/s")
    >>> 0.7 < answer.probability < 1.0
    True
    """
    return _judged(ensemble, load, velocity, draws_of(ensemble, draws))[0]


@dataclass(frozen=True, slots=True)
class Interval:
    """Values that 5, 50 and 95 % of the probability stay below; 0 or infinite beyond a sweep."""

    low: float
    middle: float
    high: float


@dataclass(frozen=True, slots=True)
class MarginIntervals:
    """The distance of an operating point from severe wear, as an interval of probability."""

    risk: Risk  #: Probability of severe wear at the operating point.
    #: Temperature that just the failing share of the contact area exceeds [K].
    decisive_temperature: Interval
    distance: Interval  #: Distance to the critical temperature [K]; negative where wear is severe.
    critical_velocity: Interval  #: Velocity at this load at which wear turns severe [m/s].
    #: Likewise the load at this velocity [N]; None in a sweep of a single load.
    critical_load: Interval | None
    #: The lowest and highest velocity [m/s] and load [N] of the sweep.
    velocity_range: tuple[float, float]
    load_range: tuple[float, float]

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        return asdict(self) | {"risk": self.risk.as_dict()}


def margin_intervals(
    ensemble: Ensemble,
    load: float | str,
    velocity: float | str,
    draws: Draws | None = None,
) -> MarginIntervals:
    """Distance of an operating point from severe wear, as intervals of probability.

    Parameters are those of `risk`.

    Raises
    ------
    InputError
        If the point lies outside the sweep, or the samples are too few.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> answer = pipeline.margin_intervals(ensemble, "400 N", "2 m/s")
    >>> critical = answer.critical_velocity
    >>> critical.low < 2.2 < critical.high
    True
    """
    draws = draws_of(ensemble, draws)
    here, temperature, distance, off = _judged(ensemble, load, velocity, draws)

    def crossed(axis: Array, load: Array | float, velocity: Array | float) -> Interval:
        excess = ensemble.excess(draws.inputs, load, velocity).with_chance(ensemble.design.seed)
        return _interval(
            draws, [_places(axis, excess + sign * off[:, None]) for sign in (1.0, 0.0, -1.0)]
        )

    velocities = np.geomspace(*ensemble.velocities, STEPS)
    loads = np.geomspace(ensemble.loads[0], ensemble.loads[-1], STEPS)
    has_loads = len(ensemble.loads) > 1
    return MarginIntervals(
        risk=here,
        decisive_temperature=temperature,
        distance=distance,
        critical_velocity=crossed(velocities, here.load, velocities),
        critical_load=crossed(loads, loads, here.velocity) if has_loads else None,
        velocity_range=ensemble.velocities,
        load_range=(float(ensemble.loads[0]), float(ensemble.loads[-1])),
    )


def _places(axis: Array, excess: Array) -> Array:
    """Place along an axis at which each draw crosses; 0 or infinite beyond its ends."""
    places = np.exp(log_crossings(axis, excess)[0])
    places[places > axis[-1]] = math.inf
    places[excess[:, 0] >= 0] = 0.0
    return places


def _interval(draws: Draws, values: Sequence[Array]) -> Interval:
    """Interval of probability whose ends are those of values with the error at its worst."""
    low, middle, high = map(draws.interval, values)
    return Interval(low[0], middle[1], high[2])


def risk_table(
    ensemble: Ensemble,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]],
    draws: Draws | None = None,
) -> pd.DataFrame:
    """Probability of severe wear at operating points, and their distance from it.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    points : path or mapping of str to sequence
        Operating points; see `pipeline.margin_table`. Conditions of a row take the place of the
        scene's, and of those that are drawn.
    draws : Draws, optional
        See `pipeline.risk`; not where rows have conditions of their own.

    Returns
    -------
    DataFrame
        A row for each operating point: ``load [N]``, ``velocity [m/s]``, the ``verdict`` where 95 %
        of the probability says so, the ``probability`` of severe wear and its standard ``error``,
        and the ``distance [K]`` below the critical temperature, with 5 % of it below ``distance low
        [K]`` and 95 % below ``distance high [K]``. A point that the samples say nothing about has a
        ``note`` instead.

    Raises
    ------
    InputError
        If the table has faults, all of which are named, or the samples are too few.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> points = {"load": ["400 N", "400 N"], "velocity": ["1 m/s", "2.2 m/s"]}
    >>> pipeline.risk_table(ensemble, points)["verdict"].to_list()
    ['mild', 'not decided']
    """
    read = points if isinstance(points, OperatingPoints) else OperatingPoints.read(points)
    if draws is not None:
        read.require_places_alone("tests weigh the conditions as they were drawn: leave these out")

    @functools.cache
    def judged_by(*own: tuple[str, float]) -> tuple[Ensemble, Draws]:
        judged = ensemble.judged_by(dict(own))
        return judged, draws_of(judged, draws)

    def answer(place: Place, own: Mapping[str, float]) -> tuple[Any, ...]:
        judged, of_row = judged_by(*own.items())
        here, _, distance, _ = _judged(judged, *place, of_row)
        ends = distance.middle, distance.low, distance.high
        return here.verdict, here.probability, here.error, *ends, None

    return frame_of_points(read, _HEADS, answer)


def _judged(
    ensemble: Ensemble, load: float | str, velocity: float | str, draws: Draws
) -> tuple[Risk, Interval, Interval, Array]:
    """Risk, deciding temperature and distance at a point, and by how much fidelity moves each."""
    load, velocity = in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s")
    excess, off = _with_error(ensemble, draws, load, velocity)
    probability, error = probability_of(excess, draws)
    lowest, highest = (
        probability_of(excess._replace(values=excess.values + sign * off), draws)[0]
        for sign in (-1.0, 1.0)
    )
    risk = Risk(
        load=load,
        velocity=velocity,
        probability=probability,
        error=error,
        rise_error=math.sqrt(float(draws.mean(excess.error**2))),
        samples=len(ensemble.inputs),
        lowest=lowest if ensemble.velocity_error is not None else 0.0,
        highest=highest if ensemble.velocity_error is not None else 1.0,
        misfit=draws.misfit,
    )
    friction, bulk, critical = (
        ensemble.values(path, draws.inputs) for path in (FRICTION, BULK, CRITICAL)
    )
    log_rise = excess.with_chance(ensemble.design.seed) + ensemble.log_limit(draws.inputs)
    rise = friction * np.exp(log_rise)
    temperatures = [bulk + rise * np.exp(sign * off) for sign in (-1.0, 0.0, 1.0)]
    distances = [critical - temperature for temperature in reversed(temperatures)]
    return risk, _interval(draws, temperatures), _interval(draws, distances), off


def _with_error(
    ensemble: Ensemble, draws: Draws, load: float, velocity: float
) -> tuple[Excess, Array]:
    """Excess by draw, and how much the fidelity of the samples may move its values."""
    lowest, highest = ensemble.velocities
    beside = velocity * _APART if velocity * _APART <= highest else velocity / _APART
    both = ensemble.excess(draws.inputs, load, np.array([velocity, max(beside, lowest)]))
    excess = Excess(*(part[:, 0] for part in both))
    if beside < lowest:
        slope = np.ones(len(excess.values))
    else:
        slope = (both.values[:, 1] - excess.values) / math.log(beside / velocity)
    return excess, np.clip(slope, SLOWEST, 1.0) * math.log1p(ensemble.velocity_error or 0.0)


_HEADS = (
    "verdict", "probability", "error", "distance [K]", "distance low [K]", "distance high [K]",
)  # fmt: skip
