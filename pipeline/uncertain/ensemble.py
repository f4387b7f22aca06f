"""Samples of a sweep, and what follows from them for any inputs: `Ensemble.excess`.

The logarithm of the rise that decides is emulated over the inputs, the velocity and the wear number
(`pipeline.uncertain.emulator`), all loads at once, and interpolated between loads. Friction and
temperatures enter exactly: with the rise r at friction 1, wear is severe where

    ln r − ln((critical − bulk)/µ) > 0,

which is the excess, of which all answers are made.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.special import ndtr

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.dataset import end_of_point
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import decisive_rises
from pipeline.sweep.samples import WEAR_RATE, Design
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.emulator import Emulator, Groups, fitted
from tribo import InputError
from tribo.types import Array

FRICTION, BULK, CRITICAL, SHARE = (
    "friction.coefficient", "temperature.bulk", "temperature.critical", "temperature.failing_share",
)  # fmt: skip
CONDITIONS = {
    "friction": FRICTION,
    "bulk_temperature": BULK,
    "critical_temperature": CRITICAL,
    "wear_rate": WEAR_RATE,
}
"""Conditions that may be given in place of an input's draws, and the path of that input."""
# For the few draws of a wide distribution that cross what is possible, such as a negative friction.
_LEAST_RISE, _LEAST = 1.0, 1e-3  # [K], friction
_NODES = 9  # velocities between which the logarithm of the rise is a cubic
_BEND = 0.02  # of ln(rise), unknown between two loads alone: ten times that of the shipped scenes
_FEWEST = 16  # samples of which an emulator is made
_COLUMNS_OF_WIDTH = ("time", "contact_width")


class Excess(NamedTuple):
    """Logarithm of the rise over its limit, by draw and velocity; above 0 wear is severe.

    Attributes
    ----------
    values : ndarray, shape (n, n_velocity)
    error : ndarray, shape (n, n_velocity)
        Standard error against a simulation with the same inputs.
    shared : ndarray, shape (n, n_velocity)
        Part of the error that draws near each other share, and more samples make smaller.
    """

    values: Array
    error: Array
    shared: Array

    @property
    def probability(self) -> Array:
        """Probability of severe wear, shape (n, n_velocity)."""
        severe: Array = ndtr(self.values / self.error)
        return severe


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Samples of a sweep.

    Attributes
    ----------
    title : str
        Title of the scene.
    unknown : tuple of Unknown
        Inputs that are not known exactly.
    design : Design
        Rule by which the samples follow, and the inputs that rises depend on.
    conditions : Conditions
        Friction, temperatures and failing share of the scene, as far as they are known.
    inputs : ndarray, shape (n_sample, n_input)
        Inputs of the samples, by those of the design [SI].
    sample_velocities : ndarray, shape (n_sample,)
        Velocity of each sample [m/s].
    contacts : ndarray of int, shape (n_sample,)
        Number of the contact that each sample shares with others.
    loads : ndarray, shape (n_load,)
        Normal loads on the whole pin [N].
    rises, widths : ndarray, shape (n_sample, n_load)
        Rise that decides at friction 1 [K], and width of the contact at the end [m].
    measured, tested : tuple of dict
        Transitions that were measured, and tests that stayed mild or turned severe.
    hold : float
        Duration at the full load [s].
    missing : int
        Samples left out, since some of their loads are not done.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> [quantity.path for quantity in ensemble.unknown]
    ['friction.coefficient', 'temperature.critical']
    """

    title: str
    unknown: tuple[Unknown, ...]
    design: Design
    conditions: Conditions
    inputs: Array
    sample_velocities: Array
    contacts: Groups
    loads: Array
    rises: Array
    widths: Array
    measured: tuple[dict[str, Any], ...]
    tested: tuple[dict[str, Any], ...] = ()
    hold: float = 0.0
    missing: int = 0

    @classmethod
    def of(
        cls, ds: xr.Dataset, share: float | None = None, criterion: str | None = None
    ) -> Ensemble:
        """Read the samples of an opened sweep.

        Parameters
        ----------
        ds : Dataset
            Dataset of `pipeline.open_sweep`.
        share, criterion : optional
            Failing share and kind of criterion in place of the scene's.

        Raises
        ------
        InputError
            If the sweep has no samples, or too few of them are done.
        """
        about = attributes_of(ds)
        if "sample" not in ds.dims:
            raise InputError(
                "the sweep has no samples; give [unknown] and sweep.samples in the scene, and run "
                "it into a new store"
            )
        design = Design.from_dict(about["scene"]["samples"])
        conditions = Conditions(**about["conditions"]).changed(share=share, criterion=criterion)
        ds = ds.sortby("load").isel(sample=slice(0, about["samples"]))
        numbers = ds["sample"].values
        inputs = np.array([ds[quantity.path].values for quantity in design.inputs]).T
        paths = [quantity.path for quantity in design.inputs]
        shares = inputs[:, paths.index(SHARE)] if SHARE in paths and share is None else None
        rises, widths = _rises(ds, conditions, shares), _widths(ds)
        done = np.isfinite(rises).all(axis=1)
        if np.count_nonzero(done) < min(_FEWEST, about["samples"]) or not done.any():
            raise InputError(
                f"{np.count_nonzero(done)} of {about['samples']} samples are done at every load, "
                "too few to judge by; run the sweep to its end"
            )
        return cls(
            title=str(about["title"]),
            unknown=tuple(Unknown.from_dict(quantity) for quantity in about["unknown"]),
            design=design,
            conditions=conditions,
            inputs=inputs.reshape(len(numbers), len(paths))[done],
            sample_velocities=ds["velocity"].values[done],
            contacts=(numbers // design.per_contact)[done],
            loads=ds["load"].values,
            rises=rises[done],
            widths=widths[done],
            measured=tuple(about["measured"]),
            tested=tuple(about["tested"]),
            hold=float(about["scene"]["loading"].get("hold", 0.0)),
            missing=int(np.count_nonzero(~done)),
        )

    @property
    def velocities(self) -> tuple[float, float]:
        """Lowest and highest velocity between which samples lie [m/s]."""
        return self.design.velocities

    def excess(
        self,
        draws: Array,
        load: float,
        velocity: Sequence[float] | Array | float,
        conditions: Mapping[str, float] | None = None,
    ) -> Excess:
        """Logarithm of the rise over the limit above which wear is severe.

        Parameters
        ----------
        draws : ndarray, shape (n, n_unknown)
            Values of the unknown inputs [SI].
        load : float
            Normal load on the whole pin [N].
        velocity : float or sequence of float
            Sliding velocities [m/s].
        conditions : mapping, optional
            Conditions by the names of `CONDITIONS`, in place of those drawn or of the scene.

        Raises
        ------
        InputError
            If the load or a velocity lies outside the sweep, or no critical temperature is known.
        """
        excesses = self.excesses(draws, [load], np.atleast_1d(velocity), conditions)
        return Excess(*(part[:, 0] for part in excesses))

    def excesses(
        self,
        draws: Array,
        loads: Sequence[float] | Array,
        velocities: Sequence[float] | Array,
        conditions: Mapping[str, float] | None = None,
        with_error: bool = True,
    ) -> Excess:
        """Excess at several loads, each of its arrays of shape (n, n_load, n_velocity).

        Other parameters are those of `excess`; without errors it is found faster.
        """
        parts = self._emulated(self._rise, draws, loads, velocities, conditions, with_error)
        limit = self.log_limit(draws, conditions)
        return parts._replace(values=parts.values - limit[:, None, None])

    def rows(
        self,
        draws: Array,
        loads: Sequence[float] | Array,
        velocities: Sequence[float] | Array,
        conditions: Mapping[str, float] | None = None,
    ) -> Iterator[Excess]:
        """Excess at one load after the other, each of its arrays of shape (n, n_velocity).

        Parameters are those of `excesses`, which takes the memory of all loads at once.
        """
        wanted = np.asarray(velocities, float)
        nodes = _nodes(wanted)
        at_nodes = self.excesses(draws, loads, nodes, conditions)
        for number in range(len(loads)):
            yield _at(wanted, nodes, Excess(*(part[:, number] for part in at_nodes)))

    def width(self, draws: Array, load: float, velocity: float) -> Excess:
        """Logarithm of the contact's width [m] in place of the excess, likewise."""
        parts = self._emulated(self._width, draws, [load], [velocity], None)
        return Excess(*(part[:, 0] for part in parts))

    def values(
        self, path: str, draws: Array, conditions: Mapping[str, float] | None = None
    ) -> Array:
        """Values of an input by draw, shape (n,): given, drawn, or those of the scene [SI]."""
        fixed = {CONDITIONS[name]: value for name, value in (conditions or {}).items()}
        if path in fixed:
            return np.full(len(draws), fixed[path])
        for quantity, column in zip(self.unknown, draws.T, strict=True):
            if quantity.path == path:
                return np.asarray(column)
        scene = {
            FRICTION: self.conditions.friction,
            BULK: self.conditions.bulk_temperature,
            SHARE: self.conditions.failing_share,
        }
        if path == CRITICAL:
            scene[path] = self.conditions.known_critical_temperature()
        if path not in scene:
            (entry,) = (quantity for quantity in self.design.inputs if quantity.path == path)
            scene[path] = float(entry.at(np.array([0.5]))[0])
        return np.full(len(draws), scene[path])

    def log_limit(self, draws: Array, conditions: Mapping[str, float] | None = None) -> Array:
        """Logarithm of the rise at friction 1 above which wear is severe, shape (n,)."""
        friction, bulk, critical = (
            self.values(path, draws, conditions) for path in (FRICTION, BULK, CRITICAL)
        )
        limit = np.maximum(critical - bulk, _LEAST_RISE) / np.maximum(friction, _LEAST)
        return np.asarray(np.log(limit))

    @functools.cached_property
    def _rise(self) -> Emulator:
        return self._fitted(self.rises)

    @functools.cached_property
    def _width(self) -> Emulator:
        return self._fitted(self.widths)

    def _fitted(self, values: Array) -> Emulator:
        features, dimensions = _features(self.design, self.inputs.T, self.sample_velocities)
        return fitted(features, dimensions, self.contacts, np.log(values))

    def _emulated(
        self,
        emulator: Emulator,
        draws: Array,
        loads: Sequence[float] | Array,
        velocities: Sequence[float] | Array,
        conditions: Mapping[str, float] | None,
        with_error: bool = True,
    ) -> Excess:
        wanted = np.asarray(velocities, float)
        self.require_within(loads, wanted)
        nodes = _nodes(wanted)
        columns = [self.values(quantity.path, draws, conditions) for quantity in self.design.inputs]
        weights, bends = map(np.array, zip(*map(self._between_loads, loads), strict=True))
        values, errors = [], []
        for velocity in nodes:
            features, _ = _features(self.design, columns, np.full(len(draws), velocity))
            if not with_error:
                values.append(emulator.values(features) @ weights.T)
                continue
            outputs, *both = emulator(features)
            values.append(outputs @ weights.T)
            errors.append([np.hypot(part[:, None], bends) for part in both])
        parts = [np.stack(values, axis=-1)]
        parts += [np.stack(part, axis=-1) for part in zip(*errors, strict=True)]
        errors_of_all = parts[1:] or [np.zeros_like(parts[0])] * 2
        return _at(wanted, nodes, Excess(parts[0], *errors_of_all))

    def _between_loads(self, load: float) -> tuple[Array, float]:
        """Weights of the outputs at each load by which to interpolate, and its error."""
        (same,) = np.nonzero(self.loads == load)
        if same.size:
            return np.eye(len(self.loads))[same[0]], 0.0
        x, log_load, degree = np.log(self.loads), math.log(load), min(3, len(self.loads) - 1)
        if degree == 1:
            weights = make_interp_spline(x, np.eye(2), k=1)(log_load)
            return weights, _BEND * 4 * float(weights[0] * weights[1])
        weights, rough = (make_interp_spline(x, np.eye(len(x)), k=k)(log_load) for k in (degree, 1))
        if degree == 3:
            rough = make_interp_spline(x[_around(x, log_load)], np.eye(3), k=2)(log_load)
            full = np.zeros(len(x))
            full[_around(x, log_load)] = rough
            rough = full
        off = np.log(self.rises) @ (weights - rough)
        return weights, float(np.sqrt(np.mean(off**2)))

    def require_within(
        self, loads: Sequence[float] | Array, velocities: Sequence[float] | Array
    ) -> None:
        """Raise an `InputError` for loads or velocities outside the sweep."""
        for name, unit, values, axis in (
            ("load", "N", loads, self.loads),
            ("velocity", "m/s", velocities, self.velocities),
        ):
            for value in values:
                if axis[0] * (1 - 1e-9) <= value <= axis[-1] * (1 + 1e-9):
                    continue
                ends = f"{axis[0]:g} to {axis[-1]:g} {unit}"
                if axis[0] == axis[-1]:
                    ends = f"{axis[0]:g} {unit} alone"
                raise InputError(
                    f"{name} is {value:g} {unit}; the samples have {ends}: give one within, or "
                    "add to the sweep"
                )

    def part(self, kept: Array) -> Ensemble:
        """The ensemble of some of the samples, by a mask."""
        return replace(
            self,
            inputs=self.inputs[kept],
            sample_velocities=self.sample_velocities[kept],
            contacts=self.contacts[kept],
            rises=self.rises[kept],
            widths=self.widths[kept],
        )


def _nodes(velocities: Array) -> Array:
    """Velocities at which to emulate, where many are wanted."""
    if len(velocities) <= _NODES:
        return velocities
    return np.geomspace(velocities.min(), velocities.max(), _NODES)


def _at(velocities: Array, nodes: Array, excess: Excess) -> Excess:
    """Excess at velocities, from that at nodes."""
    if nodes is velocities:
        return excess
    x, wanted = np.log(nodes), np.log(velocities)
    values, *errors = (CubicSpline(x, part, axis=-1)(wanted) for part in excess)
    return Excess(values, *map(np.abs, errors))


def _around(x: Array, position: float) -> slice:
    """The three nodes nearest to a place."""
    first = int(np.clip(np.searchsorted(x, position) - 1, 0, len(x) - 3))
    if first > 0 and abs(position - x[first - 1]) < abs(x[first + 2] - position):
        first -= 1
    return slice(first, first + 3)


def _features(
    design: Design, columns: Sequence[Array] | Array, velocities: Array
) -> tuple[Array, Groups]:
    """Features of an emulator, each with a spread of about 1, and the input of each.

    An input out of a list has one for each of its values. In place of the wear rate k stands the
    wear number kV, which contacts depend on.
    """
    low, high = np.log(design.velocities)
    spread = (high - low) / math.sqrt(12)
    along = (np.log(velocities) - (low + high) / 2) / spread
    features, dimensions = [along], [0]
    for number, (quantity, column) in enumerate(zip(design.inputs, columns, strict=True), 1):
        if quantity.kind == "list":
            features += [np.where(column == value, 1.0, 0.0) for value in quantity.parameters]
            dimensions += [number] * len(quantity.parameters)
            continue
        ends = quantity.at(ndtr(np.array([-1.0, 1.0])))
        values, ends = (np.log(column), np.log(ends)) if quantity.is_relative else (column, ends)
        scaled, width = values - ends.mean(), float(ends[1] - ends[0]) / 2
        if quantity.path == WEAR_RATE:
            scaled, width = scaled + spread * along, math.hypot(width, spread)
        features.append(scaled / width)
        dimensions.append(number)
    return np.stack(features, axis=1), np.array(dimensions)


def _rises(ds: xr.Dataset, conditions: Conditions, shares: Array | None) -> Array:
    """Decisive rise by sample and load [K]."""
    order = ("sample", "load", "step", "quantile")
    columns = {
        str(name): ds[name].transpose(*order, missing_dims="ignore").values
        for name in ds.data_vars
        if "step" in ds[name].dims
    }
    loads = ds["load"].values[:, None]
    if shares is None:
        return decisive_rises(columns, loads, conditions)
    rows = [
        decisive_rises(
            {name: values[i] for name, values in columns.items()},
            loads,
            replace(conditions, failing_share=share),
        )
        for i, share in enumerate(shares.tolist())
    ]
    return np.array(rows)


def _widths(ds: xr.Dataset) -> Array:
    """Width of the contact at the end by sample and load [m]."""
    end = end_of_point(ds[list(_COLUMNS_OF_WIDTH)])
    widths: Array = end["contact_width"].transpose("sample", "load").values
    return widths
