"""The samples of a sweep: what was drawn, what was simulated, and what follows for any others.

Between and beyond the velocities at which a sample was simulated, its rise is a power of the
velocity. What further samples would give is told by a polynomial through those that there are
(`pipeline.analysis.surrogate`); friction and temperatures enter exactly.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.dataset import end_of_point, values_of
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.interpolation import interpolated
from pipeline.analysis.surrogate import Surrogate, fitted
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.unknown import Unknown, drawn
from tribo import InputError
from tribo.types import Array

FRICTION, BULK, CRITICAL, SHARE = (
    "friction.coefficient", "temperature.bulk", "temperature.critical", "temperature.failing_share",
)  # fmt: skip
_EXACT = (FRICTION, BULK, CRITICAL)
# For the few draws of a wide distribution that cross what is possible, such as a negative friction.
_LEAST_RISE, _LEAST = 1.0, 1e-3  # [K], friction


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What is known of a sweep over samples.

    Attributes
    ----------
    title : str
        Title of the scene.
    unknown : tuple of Unknown
        Inputs that are not known exactly.
    seed : int
        Seed by which they were drawn.
    inputs : ndarray, shape (n_sample, n_unknown)
        Values drawn [SI], of the samples that were simulated.
    conditions : Conditions
        Friction, temperatures and failing share of the scene, as far as they are known.
    loads : ndarray, shape (n_load,)
        Normal loads on the whole pin [N].
    velocities : ndarray, shape (n_velocity,)
        Sliding velocities at which anything was simulated, above 0 [m/s].
    rises : ndarray, shape (n_sample, n_load, n_velocity)
        Decisive rise at friction 1 [K]; NaN where it was not simulated.
    widths : ndarray, shape (n_sample, n_load, n_velocity)
        Width of the contact at the end [m]; NaN where it was not simulated.
    measured : tuple of dict
        Measured transitions of the scene.
    missing : int
        Samples left out, since too little of them is done.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> [each.path for each in ensemble.unknown]
    ['friction.coefficient', 'temperature.critical']
    """

    title: str
    unknown: tuple[Unknown, ...]
    seed: int
    inputs: Array
    conditions: Conditions
    loads: Array
    velocities: Array
    rises: Array
    widths: Array
    measured: tuple[dict[str, Any], ...]
    missing: int

    @classmethod
    def of(cls, ds: xr.Dataset) -> Ensemble:
        """Read the samples of an opened sweep.

        Raises
        ------
        InputError
            If the sweep has no samples, or none of them is done.
        """
        about = attributes_of(ds)
        if not about.get("samples"):
            raise InputError(
                "the sweep has no samples; give [unknown] and sweep.samples in the scene, and run "
                "it into a new store"
            )
        if "disk_temperature" in about["conditions"]:
            raise InputError(
                "the samples are of bodies of unequal bulk temperatures, whose probabilities are "
                "not modelled; give one temperature.bulk in the scene, and run it into a new store"
            )
        unknown = tuple(Unknown.from_dict(each) for each in about["unknown"])
        count, seed = about["samples"], about["sample_seed"]
        values = drawn(unknown, seed, count)
        ds = ds.sel(velocity=ds["velocity"] > 0)
        if "sample" in ds.dims:
            ds = ds.sel(sample=slice(0, count - 1))
            values = np.stack([ds[each.path].values for each in unknown], axis=1)
        own = Conditions(**about["conditions"])
        shares = _column(unknown, values, SHARE, own.failing_share)
        if "sample" not in ds.dims and SHARE not in [each.path for each in unknown]:
            shares = shares[:1]  # one simulation, and one rise of it, serves all
        rises, widths = _read(ds, [replace(own, failing_share=share) for share in shares.tolist()])
        known = np.isfinite(rises).sum(axis=2).min(axis=1) >= 2
        if not known.any():
            raise InputError("no sample is done at every load yet; run the sweep to its end")
        return cls(
            title=str(about["title"]),
            unknown=unknown,
            seed=seed,
            inputs=values[known] if "sample" in ds.dims else values,
            conditions=own,
            loads=ds["load"].values,
            velocities=ds["velocity"].values,
            rises=rises[known],
            widths=widths[known],
            measured=tuple(about["measured"]),
            missing=int(np.count_nonzero(~known)),
        )

    @property
    def simulated(self) -> tuple[int, ...]:
        """Numbers of the unknown inputs that the rise depends on."""
        if len(self.rises) < len(self.inputs):  # one simulation serves all
            return ()
        return tuple(i for i, each in enumerate(self.unknown) if each.path not in _EXACT)

    def conditions_at(self, inputs: Array) -> tuple[Array, Array, Array]:
        """Friction, bulk and critical temperature [K] of some inputs, each of shape (n,).

        Raises
        ------
        InputError
            If no critical temperature is given.
        """
        given = self.conditions
        if CRITICAL not in [each.path for each in self.unknown]:
            given.known_critical_temperature()
        friction = _column(self.unknown, inputs, FRICTION, given.friction)
        bulk = _column(self.unknown, inputs, BULK, given.bulk_temperature)
        critical = given.critical_temperature or math.nan
        return friction, bulk, _column(self.unknown, inputs, CRITICAL, critical)

    def log_limit(self, inputs: Array, friction: float | None = None) -> Array:
        """Logarithm of the rise at friction 1 above which wear is severe, shape (n,)."""
        own, bulk, critical = self.conditions_at(inputs)
        mu = own if friction is None else friction
        found: Array = np.log(np.maximum(critical - bulk, _LEAST_RISE) / np.maximum(mu, _LEAST))
        return found

    @functools.cached_property
    def _axis(self) -> Array:
        """Logarithms of velocities on which rows are laid out."""
        ends = np.log(self.velocities[[0, -1]])
        axis: Array = np.linspace(ends[0], ends[1], 49)
        return axis

    @functools.cached_property
    def _log_rises(self) -> Array:
        """Logarithm of the rise by sample, load and velocity of `_axis`."""
        return self._laid_out(self.rises)

    @functools.cached_property
    def _log_widths(self) -> Array:
        """Logarithm of the contact's width by sample, load and velocity of `_axis`."""
        return self._laid_out(self.widths)

    def _laid_out(self, values: Array) -> Array:
        """Logarithm of values, of which few are known, at all velocities of `_axis`."""
        at = np.exp(self._axis)
        rows = [
            [interpolated(self.velocities, row, at, continued=True) for row in sample]
            for sample in values
        ]
        logarithms: Array = np.log(np.array(rows))
        return logarithms

    def surrogate(self, load: float, velocities: Sequence[float] | Array) -> Surrogate:
        """Fit the logarithm of the rise at one load and some velocities."""
        return self._fitted(self._log_rises, load, velocities)

    def surrogate_over_loads(self, loads: Sequence[float] | Array, velocity: float) -> Surrogate:
        """Fit the logarithm of the rise at some loads and one velocity."""
        columns = [self.outputs(float(load), [velocity]) for load in loads]
        return fitted(*self.simulated_inputs(), np.hstack(columns))

    def width_surrogate(self, load: float, velocities: Sequence[float] | Array) -> Surrogate:
        """Fit the logarithm of the contact's width at one load and some velocities."""
        return self._fitted(self._log_widths, load, velocities)

    def outputs(self, load: float, velocities: Sequence[float] | Array) -> Array:
        """Logarithm of the rise of each sample at one load and some velocities."""
        return self._outputs(self._log_rises, load, velocities)

    def simulated_inputs(self) -> tuple[tuple[Unknown, ...], Array]:
        """The inputs that the rise depends on, and their values by sample."""
        chosen = list(self.simulated)
        return tuple(self.unknown[i] for i in chosen), self.inputs[: len(self.rises), chosen]

    def _fitted(self, values: Array, load: float, velocities: Sequence[float] | Array) -> Surrogate:
        return fitted(*self.simulated_inputs(), self._outputs(values, load, velocities))

    def _outputs(self, values: Array, load: float, velocities: Sequence[float] | Array) -> Array:
        self.require_within(load, *np.atleast_1d(velocities))
        (same,) = np.nonzero(self.loads == load)
        if same.size:
            row = values[:, same[0]]
        elif len(self.loads) < 2:
            raise InputError(
                f"load is {load:g} N; the sweep has {self.loads[0]:g} N alone; "
                "give that, or add loads to the sweep"
            )
        else:
            row = _cubic(np.log(self.loads), np.swapaxes(values, 1, 2), math.log(load))
        return _cubic(self._axis, row, np.log(velocities))

    def require_within(self, load: float, *velocities: float) -> None:
        """Raise an `InputError` for what lies outside the sweep."""
        for name, unit, value, axis in (
            ("load", "N", load, self.loads),
            *(("velocity", "m/s", velocity, self.velocities) for velocity in velocities),
        ):
            if not axis[0] * (1 - 1e-9) <= value <= axis[-1] * (1 + 1e-9):
                raise InputError(
                    f"{name} is {value:g} {unit}; the samples have {axis[0]:g} to {axis[-1]:g} "
                    f"{unit}: give one within, or add to the sweep"
                )

    def excess(self, surrogate: Surrogate, inputs: Array, friction: float | None = None) -> Array:
        """Logarithm of the rise over its limit, shape (n, n_output): above 0 wear is severe."""
        rise = surrogate(inputs[:, list(self.simulated)])
        return rise - self.log_limit(inputs, friction)[:, None]

    def crossings(
        self, surrogate: Surrogate, axis: Array, inputs: Array, chance: Array | float = 0.0
    ) -> Array:
        """Logarithm of the critical velocity at one load, or of the critical load, shape (n,).

        Parameters
        ----------
        surrogate : Surrogate
            Surrogate of one load at the velocities of `axis`, or of one velocity at its loads.
        axis : ndarray
            Velocities [m/s] or loads [N], ascending. Beyond them the rise goes on as a power.
        inputs : ndarray, shape (n, n_unknown)
            Values of the unknown inputs [SI].
        chance : ndarray, shape (n,), optional
            What the surrogate is off by, over its error.
        """
        off = np.multiply.outer(chance, surrogate.error)
        excess = np.maximum.accumulate(self.excess(surrogate, inputs) + off, axis=1)
        x = np.log(axis)
        at = np.clip(np.sum(excess < 0, axis=1), 1, len(x) - 1)
        rows = np.arange(len(inputs))
        low, high = excess[rows, at - 1], excess[rows, at]
        slope = np.maximum((high - low) / (x[at] - x[at - 1]), 0.05)
        found: Array = x[at - 1] - low / slope
        return found


def _cubic(x: Array, rows: Array, at: Array | float) -> Array:
    """Rows of values over x, interpolated by the cubic that is monotone between the points."""
    values: Array = PchipInterpolator(x, rows, axis=-1)(at)
    return values


def _column(unknown: Sequence[Unknown], inputs: Array, path: str, otherwise: float) -> Array:
    """Values of one input; what the scene gives where it is known."""
    for each, column in zip(unknown, inputs.T, strict=True):
        if each.path == path:
            return np.asarray(column)
    return np.full(len(inputs), otherwise)


def _read(ds: xr.Dataset, conditions: Sequence[Conditions]) -> tuple[Array, Array]:
    """Decisive rise [K] and width of the contact [m] by sample, load and velocity."""
    ds = ds[["status", "time", "normal_load", "contact_width", "mean_rise", "rise_quantile"]]
    if "sample" not in ds.dims:
        ds = ds.expand_dims(sample=len(conditions))
    width = end_of_point(ds[["time", "contact_width"]])
    return decisive_rise(ds, conditions).values, values_of(width, "contact_width")
