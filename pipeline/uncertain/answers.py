"""Probability of severe wear, and the distance of an operating point from it."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.tables import Column, Table
from pipeline.scene.quantities import in_si
from pipeline.uncertain.ensemble import BULK, CRITICAL, FRICTION, Axis, Ensemble, Excess, Overrides
from pipeline.uncertain.inputs import Draws, prior
from tribo.types import Array

QUANTILES = (0.05, 0.5, 0.95)
"""Probabilities of severe wear of which the lines are drawn."""
STEPS = 41
"""Velocities or loads among which a boundary is sought."""
_LEAST_SLOPE = 0.05  # of ln(rise) over ln(velocity or load), by which a boundary is extrapolated


def draws_of(ensemble: Ensemble, draws: Draws | None) -> Draws:
    """Draws that are given, or those of the scene's own distributions."""
    return draws or prior(ensemble.unknown, ensemble.design.seed + 1)


@dataclass(frozen=True, slots=True)
class Risk:
    """Probability of severe wear at an operating point.

    Attributes
    ----------
    load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    probability : float
        Probability of severe wear.
    error : float
        Standard error of the probability, from the numbers of samples and of draws.
    rise_error : float
        Standard error of the emulated rise against a simulation, relative; the root mean square
        over the draws.
    samples : int
        Samples that were simulated.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> answer = pipeline.risk(ensemble, load=400.0, velocity=2.2)
    >>> 0.4 < answer.probability < 0.7
    True
    """

    load: float
    velocity: float
    probability: float
    error: float
    rise_error: float
    samples: int

    def as_dict(self) -> dict[str, Any]:
        """Return all fields by name."""
        return asdict(self)


def risk(
    ensemble: Ensemble,
    load: float | str,
    velocity: float | str,
    draws: Draws | None = None,
    conditions: Overrides = None,
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
    conditions : mapping, optional
        See `Ensemble.excess`.

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
    load, velocity = in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s")
    draws = draws_of(ensemble, draws)
    excess = ensemble.excess(draws.inputs, load, velocity, conditions)
    severe = excess.probability[:, 0]
    probability = float(np.clip(draws.mean(severe), 0.0, 1.0))
    by_draws = math.sqrt(float(np.sum((draws.weights * (severe - probability)) ** 2)))
    # What neighbours share is taken as shared by all draws, which errs to the safe side.
    density = np.exp(-0.5 * (excess.values / excess.error) ** 2) / math.sqrt(2 * math.pi)
    by_samples = float(draws.mean(density * excess.shared / excess.error)[0])
    return Risk(
        load=load,
        velocity=velocity,
        probability=probability,
        error=math.hypot(by_draws, by_samples),
        rise_error=math.sqrt(float(draws.mean(excess.error**2)[0])),
        samples=len(ensemble.inputs),
    )


def probabilities(
    ensemble: Ensemble,
    draws: Draws | None = None,
    loads: Axis | None = None,
    velocities: Axis | None = None,
    conditions: Overrides = None,
) -> xr.DataArray:
    """Probability of severe wear over the plane, dims (load, velocity).

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    loads, velocities : sequence of float, optional
        Axes of the plane [N, m/s]; evenly between the ends of the sweep if not given.
    draws, conditions : optional
        See `risk`.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> plane = pipeline.probabilities(ensemble)
    >>> bool(plane.sel(load=400, velocity=1.0) < 0.01)
    True
    """
    draws = draws_of(ensemble, draws)
    if loads is None:
        loads = np.linspace(ensemble.loads[0], ensemble.loads[-1], 45)
    if velocities is None:
        velocities = np.linspace(*ensemble.velocities, 121)
    rows = [
        draws.mean(excess.probability)
        for excess in ensemble.rows(draws.inputs, loads, velocities, conditions)
    ]
    return xr.DataArray(
        np.clip(rows, 0.0, 1.0),
        {
            "load": ("load", np.asarray(loads), {"units": "N"}),
            "velocity": ("velocity", np.asarray(velocities), {"units": "m/s"}),
        },
        ("load", "velocity"),
        "probability",
        {"units": "1", "long_name": "probability of severe wear"},
    )


def probabilities_at_loads(
    ensemble: Ensemble, draws: Draws | None = None, conditions: Overrides = None
) -> xr.DataArray:
    """Probability of severe wear at the loads of the sweep, for the lines that every answer prints.

    Parameters as for `probabilities`.
    """
    velocities = np.geomspace(*ensemble.velocities, 4 * (STEPS - 1) + 1)
    return probabilities(ensemble, draws, ensemble.loads, velocities, conditions)


def risk_lines(plane: xr.DataArray) -> tuple[tuple[float, ...], Array]:
    """Velocities at which wear is severe with some probabilities, by load.

    Parameters
    ----------
    plane : DataArray, dims (load, velocity)
        Result of `probabilities`.

    Returns
    -------
    tuple of float, ndarray, shape (n_load, n_share)
        The probabilities, and the velocities [m/s]: 0 where they lie below those of the plane,
        infinite where they lie above them.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> shares, lines = pipeline.risk_lines(pipeline.probabilities(ensemble))
    >>> shares, lines.shape
    ((0.05, 0.5, 0.95), (45, 3))
    """
    velocities = plane["velocity"].values
    rows = np.maximum.accumulate(plane.values, axis=1)
    lines = [np.interp(QUANTILES, row, velocities, 0.0, math.inf) for row in rows]
    return QUANTILES, np.array(lines)


def table_of_lines(plane: xr.DataArray) -> Table:
    """`risk_lines` as a table; below 0, or infinite, beyond the velocities of the plane."""
    shares, lines = risk_lines(plane)
    lowest, *_, highest = plane["velocity"].values.tolist()

    def write(velocity: float) -> str:
        if math.isfinite(velocity):
            return f"{velocity:.3g}"
        return f"> {highest:.3g}" if velocity > 0 else f"< {lowest:.3g}"

    columns = (
        Column(str(share), f"velocity of {100 * share:g} %", "m/s", write=write) for share in shares
    )
    rows = np.where(lines > 0, lines, -math.inf).tolist()
    loads = plane["load"].values.tolist()
    return Table(
        (Column("load", "load", "N"), *columns),
        tuple((load, *row) for load, row in zip(loads, rows, strict=True)),
    )


def log_crossings(axis: Array, excess: Array) -> Array:
    """Logarithm of the first place along an axis where an excess (..., m) rises through 0.

    The axis (m,) are velocities [m/s] or loads [N], beyond which the excess goes on as a power.

    Examples
    --------
    >>> axis = np.array([1.0, 2.0, 4.0])
    >>> places = np.exp(log_crossings(axis, np.log(axis / np.array([[1.5], [8.0]]))))
    >>> print(f"{places[0]:.3f} {places[1]:.3f}")
    1.500 8.000
    """
    x, rising = np.log(axis), np.maximum.accumulate(excess, axis=-1)
    right = np.clip(np.sum(rising < 0, axis=-1), 1, len(x) - 1)[..., None]
    low, high = (np.take_along_axis(rising, right - 1 + i, axis=-1)[..., 0] for i in (0, 1))
    right = right[..., 0]
    slope = np.maximum((high - low) / (x[right] - x[right - 1]), _LEAST_SLOPE)
    log_velocities: Array = x[right - 1] - low / slope
    return log_velocities


def log_boundary(
    ensemble: Ensemble, inputs: Array, loads: Axis, with_error: bool = True
) -> tuple[Array, Array]:
    """Logarithm of the critical velocity by draw and load, and its standard error."""
    velocities = np.geomspace(*ensemble.velocities, STEPS)
    excess = ensemble.excesses(inputs, loads, velocities, with_error=with_error)
    log_velocities, x = log_crossings(velocities, excess.values), np.log(velocities)
    right = np.clip(np.searchsorted(x, log_velocities), 1, len(x) - 1)[..., None]
    low, high = (np.take_along_axis(excess.values, right - 1 + i, axis=-1)[..., 0] for i in (0, 1))
    slope = np.maximum((high - low) / (x[1] - x[0]), _LEAST_SLOPE)
    return log_velocities, np.take_along_axis(excess.error, right, axis=-1)[..., 0] / slope


def crossings(axis: Array, excess: Array) -> Array:
    """First place along an axis where an excess rises through 0; 0 below it, infinite beyond."""
    velocities = np.exp(log_crossings(axis, excess))
    return np.where(excess[..., 0] >= 0, 0.0, np.where(velocities > axis[-1], math.inf, velocities))


@dataclass(frozen=True, slots=True)
class Interval:
    """Values that 5, 50 and 95 % of the probability stay below.

    Attributes
    ----------
    low, middle, high : float
        The three values; of a boundary 0 or infinite where it lies below or above the sweep.

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
        Distance to the critical temperature [K]; negative where wear is severe.
    critical_velocity : Interval
        Velocity at this load at which wear turns severe [m/s].
    critical_load : Interval or None
        Likewise the load at this velocity [N]; None in a sweep of a single load.
    velocity_range, load_range : tuple of float
        The lowest and highest velocity [m/s] and load [N] of the sweep.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> answer = pipeline.margin_intervals(ensemble, "400 N", "2 m/s")
    >>> answer.distance.low < 0 < answer.distance.high
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
    ensemble: Ensemble,
    load: float | str,
    velocity: float | str,
    draws: Draws | None = None,
    conditions: Overrides = None,
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
    inputs, at_point = draws.inputs, risk(ensemble, load, velocity, draws, conditions)
    place = at_point.load, at_point.velocity
    temperature, critical = temperatures(ensemble, inputs, *place, conditions)
    velocities = np.geomspace(*ensemble.velocities, STEPS)
    across = _shifted(ensemble, ensemble.excess(inputs, at_point.load, velocities, conditions))
    upwards = None
    if len(ensemble.loads) > 1:
        loads = np.geomspace(ensemble.loads[0], ensemble.loads[-1], STEPS)
        along = ensemble.excesses(inputs, loads, [at_point.velocity], conditions)
        rows = _shifted(ensemble, Excess(*(part[..., 0] for part in along)))
        upwards = Interval.of(draws, crossings(loads, rows))
    return MarginIntervals(
        risk=at_point,
        decisive_temperature=Interval.of(draws, temperature),
        distance=Interval.of(draws, critical - temperature),
        critical_velocity=Interval.of(draws, crossings(velocities, across)),
        critical_load=upwards,
        velocity_range=ensemble.velocities,
        load_range=(float(ensemble.loads[0]), float(ensemble.loads[-1])),
    )


def temperatures(
    ensemble: Ensemble, inputs: Array, load: float, velocity: float, conditions: Overrides = None
) -> tuple[Array, Array]:
    """Deciding and critical temperature at an operating point by draw [K]."""
    friction, bulk, critical = (
        ensemble.values(path, inputs, conditions) for path in (FRICTION, BULK, CRITICAL)
    )
    excess = _shifted(ensemble, ensemble.excess(inputs, load, velocity, conditions))[:, 0]
    return bulk + friction * np.exp(excess + ensemble.log_limit(inputs, conditions)), critical


def _shifted(ensemble: Ensemble, excess: Excess) -> Array:
    """Excess with an error of the emulator drawn for each draw, one for all its places."""
    chance = np.random.default_rng(ensemble.design.seed).standard_normal(len(excess.values))
    return excess.values + chance[:, None] * excess.error
