"""How far an operating point lies from severe wear, where inputs are not known exactly."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.analysis.ensemble import Ensemble
from pipeline.analysis.risk import QUANTILES, Draws, Risk, prior, risk
from pipeline.analysis.surrogate import Surrogate
from pipeline.scene.quantities import in_si
from tribo.types import Array

_STEPS = 41  # velocities or loads among which a boundary is found


@dataclass(frozen=True, slots=True)
class Interval:
    """What 5, 50 and 95 % of the probability stays below.

    Attributes
    ----------
    low, middle, high : float
        The three values.

    Examples
    --------
    >>> Interval(1.6, 2.1, 2.7).middle
    2.1
    """

    low: float
    middle: float
    high: float

    @classmethod
    def of(cls, draws: Draws, values: Array) -> Interval:
        """The interval of one value a draw."""
        return cls(*(draws.quantile(values, share) for share in QUANTILES))


@dataclass(frozen=True, slots=True)
class MarginIntervals:
    """The distance of an operating point from severe wear, as an interval of probability.

    Attributes
    ----------
    risk : Risk
        Probability of severe wear at the operating point.
    decisive_temperature : Interval
        Temperature that just the failing share of the contact area exceeds [K].
    distance : Interval
        What is left to the critical temperature [K]; negative where wear is severe.
    critical_velocity : Interval
        Velocity at this load at which wear turns severe [m/s]; where it lies beyond the sweep, the
        end of that.
    critical_load : Interval or None
        Likewise the load at this velocity [N]; None in a sweep of a single load.
    velocity_range, load_range : tuple of float
        The lowest and highest velocity [m/s] and load [N] of the sweep.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.margin_intervals(ensemble, "400 N", "2 m/s")
    >>> found.distance.low < 0 < found.distance.high
    True
    """

    risk: Risk
    decisive_temperature: Interval
    distance: Interval
    critical_velocity: Interval
    critical_load: Interval | None
    velocity_range: tuple[float, float]
    load_range: tuple[float, float]

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        return asdict(self)


def margin_intervals(
    ensemble: Ensemble, load: float | str, velocity: float | str, draws: Draws | None = None
) -> MarginIntervals:
    """Tell how far an operating point lies from severe wear, and how surely.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    load : float or str
        Normal load on the whole pin [N], or text with a unit.
    velocity : float or str
        Sliding velocity [m/s], or text with a unit.
    draws : Draws, optional
        Draws of the unknown inputs; by what the scene assumes of them if not given.

    Raises
    ------
    InputError
        If the point lies outside the sweep, or the samples are too few.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.margin_intervals(ensemble, "400 N", "2 m/s")
    >>> critical = found.critical_velocity
    >>> critical.low < 2.2 < critical.high
    True
    """
    draws = draws or prior(ensemble)
    load, velocity = in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s")
    at_point = risk(ensemble, load, velocity, draws)
    # What the polynomials miss of a sample is another for each draw, and of one kind for all three.
    chance = np.random.default_rng(ensemble.seed).standard_normal(len(draws.inputs))
    here = ensemble.surrogate(load, [velocity])
    friction, bulk, critical = ensemble.conditions_at(draws.inputs)
    excess = ensemble.excess(here, draws.inputs)[:, 0] + chance * here.error[0]
    temperature = bulk + friction * np.exp(excess + ensemble.log_limit(draws.inputs))
    velocities, loads = (
        np.geomspace(axis[0], axis[-1], _STEPS) for axis in (ensemble.velocities, ensemble.loads)
    )

    def critical_values(fit: Surrogate, axis: Array) -> Interval:
        found = np.exp(ensemble.crossings(fit, axis, draws.inputs, chance))
        return Interval.of(draws, np.clip(found, axis[0], axis[-1]))

    across = ensemble.surrogate(load, velocities)
    upwards = None
    if len(ensemble.loads) > 1:
        upwards = critical_values(ensemble.surrogate_over_loads(loads, velocity), loads)
    return MarginIntervals(
        risk=at_point,
        decisive_temperature=Interval.of(draws, temperature),
        distance=Interval.of(draws, critical - temperature),
        critical_velocity=critical_values(across, velocities),
        critical_load=upwards,
        velocity_range=(float(velocities[0]), float(velocities[-1])),
        load_range=(float(loads[0]), float(loads[-1])),
    )
