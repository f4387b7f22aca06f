"""Samples of a sweep, and the severity of wear for any values of the inputs: `Ensemble.excess`.

The criterion of severe wear compares a temperature rise of the contact with its limit. An emulator
(`pipeline.uncertain.emulator`) gives the logarithm of this rise as a function of inputs, velocity,
and wear rate × velocity, for all loads at once. Between loads the logarithm is interpolated.
Friction and temperatures enter exactly: with the rise r per unit friction coefficient, and the
friction coefficient µ, wear is severe where

    ln r − ln((critical − bulk temperature)/µ) > 0.

This excess is the basis of all answers.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Union

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from pipeline.analysis.dataset import Kind, require_one_scene
from pipeline.analysis.results import Results, results
from pipeline.quantities import snap
from pipeline.store.place import PathLike
from pipeline.store.read import Keeper
from pipeline.store.schema import MADE, STEPPED
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.conditions import FIELDS, PATHS, Conditions
from pipeline.sweep.model import Sweep
from pipeline.sweep.shown import shown
from pipeline.sweep.variants import VARIANT
from pipeline.uncertain.emulator import (
    Emulator,
    Groups,
    LeftOut,
    columns_until,
    decisive_rises,
    end_weight,
    features_of,
    fit_emulator,
    load_weights,
)
from pipeline.uncertain.inputs import BULK, CRITICAL, FRICTION, LEAST_FRICTION, SHARE
from pipeline.uncertain.samples import Design, Draw
from pipeline.uncertain.unknown import Fixed, Unknown, without
from tribo import InputError
from tribo.types import Array

Axis = Sequence[float] | Array
"""Loads [N] or velocities [m/s]."""
Samples = Union["Ensemble", Results, xr.Dataset, PathLike]
"""An `Ensemble`, the dataset of a sweep, or the path of its store."""
_FIELD_OF = {path: name for name, path in FIELDS.items()}
_LEAST_RISE = 1.0  # [K], for the few draws whose bulk is above the critical temperature
_NODES = 9  # velocities emulated; a cubic spline of ln(rise) joins them
_FEWEST = 12  # samples that an emulator needs


class Excess(NamedTuple):
    """ln(rise/limit) of n draws by load and velocity; wear is severe above 0.

    The limit is the temperature rise at which wear turns severe. The shape is (n, n_load,
    n_velocity); a single load or velocity has no axis.
    """

    values: Array
    error: Array  # standard error against a simulation with the same inputs

    def draw_error(self, seed: int) -> Array:
        """Return `values` plus a random emulator error: `error` × a normal number for each draw."""
        chance = np.random.default_rng(seed).standard_normal(len(self.values))
        return (self.values.T + chance * self.error.T).T


@shown
@dataclass(frozen=True, eq=False)
class Ensemble:
    """Samples of a sweep's unknown inputs, with an emulator of the contact's temperature rise.

    The emulator is fitted to the samples. It predicts the rise that the criterion compares with its
    limit, for any values of the inputs.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> [quantity.path for quantity in ensemble.unknown]
    ['friction.coefficient', 'temperature.critical']
    """

    title: str  #: Title of the scene.
    unknown: tuple[Unknown, ...]  #: Inputs that are not known exactly.
    design: Design  #: Rule that generates the samples, and the inputs that rises depend on.
    conditions: Conditions  #: Friction, temperatures and failing share, where known.
    inputs: Array  #: Inputs of the samples, in the design's order [SI], shape (n_sample, n_input).
    sample_velocities: Array  #: Velocity of each sample [m/s].
    contacts: Groups  #: Number of each sample's contact; several samples share one.
    loads: Array  #: Normal loads on the whole pin [N].
    #: Rises that the criterion judges, per unit friction coefficient [K], shape (n_sample, n_load).
    rises: Array
    tests: tuple[dict[str, Any], ...] = ()  #: Measured transitions, and tests with their outcome.
    hold: float = 0.0  #: Duration at the full load [s].
    #: The same rises at shorter holds [s], where tests have them and the samples allow it.
    rises_by_hold: Mapping[float, Array] = field(default_factory=dict)
    fixed: tuple[Fixed, ...] = ()  #: Inputs with a value that replaces their distribution.
    missing: int = 0  #: Samples left out because some of their loads are not computed.
    same_rig: bool = True  #: True if tests and scene share their friction: one machine.
    #: Relative error of critical velocities due to the samples' fidelity; None if unknown.
    velocity_error: float | None = None
    keeper: Keeper | None = None  #: Store where fits are kept.

    @classmethod
    def of(cls, ds: Samples) -> Ensemble:
        """Read the samples of a sweep.

        Parameters
        ----------
        ds : Dataset, str, path or Ensemble
            Dataset of `pipeline.open_sweep` or `pipeline.at`, or the path of a store. An
            `Ensemble` is returned unchanged.

        Raises
        ------
        InputError
            If the sweep has no samples, too few of them are done, or the dataset has several
            scenes or a single sample.
        """
        if isinstance(ds, Ensemble):
            return ds
        data = results(ds)
        if data.kind is not Kind.SAMPLES:
            raise InputError(
                "the sweep has no samples; give [unknown] and sweep.samples in the scene, and run "
                "it into a new store"
            )
        require_one_scene(data.entry_dims)
        if VARIANT not in data.front:
            raise InputError(
                "the dataset has a single sample, but answers need all samples; do not select by "
                f"{VARIANT}"
            )
        data.require_lists("load")
        sweep = data.sweep
        draw = Draw.of(sweep.variants.draw)
        design, conditions = draw.design, data.conditions
        paths = [quantity.path for quantity in design.inputs]
        taken = data.asked.any(axis=(1, 2))
        rows, loads = data.rows.isel(variant=taken), data.loads
        numbers = rows["sample"].values
        inputs = np.array([rows[quantity.path].values for quantity in design.inputs]).T
        is_drawn = SHARE in paths and SHARE not in {one.unknown.path for one in draw.fixed}
        shares = inputs[:, paths.index(SHARE)].tolist() if is_drawn else None
        of_rows = _row_conditions(conditions, sweep, rows["variant"].values.tolist(), shares)
        columns = {k: v[taken, :, 0] for k, v in data.columns.items() if k in STEPPED or k in MADE}
        rises = decisive_rises(columns, loads, of_rows)
        done = np.isfinite(rises.sum(axis=1))
        _require_enough(int(np.count_nonzero(done)), len(numbers))
        hold = float(getattr(sweep.scene.loading, "hold", 0.0))
        tests = tuple(test.as_dict() for test in sweep.tests)
        rises_by_hold = {
            other: decisive_rises(until, loads, of_rows)[done]
            for other in {float(test.get("hold", hold)) for test in tests}
            if other < hold and (until := columns_until(columns, loads, other, done)) is not None
        }
        return cls(
            title=sweep.title,
            unknown=draw.unknown,
            design=design,
            conditions=conditions,
            inputs=inputs.reshape(len(numbers), len(paths))[done],
            sample_velocities=rows["velocity"].values[done],
            contacts=(numbers // design.per_contact)[done],
            loads=loads,
            rises=rises[done],
            tests=tests,
            hold=hold,
            rises_by_hold=rises_by_hold,
            fixed=draw.fixed,
            missing=int(np.count_nonzero(~done)),
            same_rig=sweep.declared.friction.same_rig,
            velocity_error=velocity_error(sweep),
            keeper=data.keeper,
        )

    def judged_by(self, own: Mapping[str, float]) -> Ensemble:
        """Return the ensemble with conditions of an operating point in place of the scene's.

        `own` has some of ``friction``, ``bulk_temperature`` [K] and ``critical_temperature`` [K].
        An unknown input among them becomes a fixed input. The emulated rises stay the same. Raises
        an `InputError` if the conditions in `own` would change these rises.
        """
        if not own:
            return self
        conditions = self.conditions.row_conditions(own)
        curves = [one.has_friction_curve for one in (self.conditions, conditions)]
        if conditions.bulk_ratio != self.conditions.bulk_ratio or curves[0] != curves[1]:
            raise InputError(
                f"samples cannot be judged row by row at another {' and '.join(own)}: bodies "
                "have different bulk temperatures, or friction depends on velocity; give it for "
                "all rows, by options such as --friction"
            )
        values = {PATHS[name]: value for name, value in own.items() if name in PATHS}
        before = {one.unknown.path: one for one in self.fixed}
        inputs = (*(one.unknown for one in self.fixed), *self.unknown)
        given = [one for one in inputs if one.path in values]
        fixed = {one.path: Fixed(one, float(values[one.path])) for one in given}
        judged = replace(
            self,
            conditions=conditions,
            unknown=without(self.unknown, fixed.keys()),
            fixed=tuple((before | fixed).values()),
        )
        vars(judged)["_rise"] = self._rise  # per unit friction coefficient, thus the same
        return judged

    @property
    def velocities(self) -> tuple[float, float]:
        """Lowest and highest velocity of the samples [m/s]."""
        return self.design.velocities

    def excess(self, draws: Array, load: Axis | float, velocity: Axis | float) -> Excess:
        """Return ln(rise/limit) at loads and velocities, with its error; wear is severe above 0.

        `draws` (n, n_unknown) are values of the unknown inputs [SI]. Raises an `InputError` at a
        load [N] or velocity [m/s] outside the sweep, or if no critical temperature is known.
        """
        rise, error = self._emulate(draws, load, velocity)
        # Friction by velocity is known exactly, so it is applied here and not emulated.
        rise = rise + np.log(self.conditions.friction_factor(np.asarray(velocity, float)))
        return Excess((rise.T - self.log_limit(draws)).T, error)

    def require_unknown(self) -> None:
        """Raise an `InputError` if every input has a fixed value."""
        if not self.unknown:
            values = ", ".join(map(str, self.fixed))
            raise InputError(f"no input of the samples is unknown: {values}; leave one open")

    def values(self, path: str, draws: Array) -> Array:
        """Values [SI] of the input at `path`, one for each of n draws (n,).

        `draws` (n, n_unknown) are values of the unknown inputs. All draws have the same value of an
        input that is fixed or known.
        """
        values: dict[str, Any] = dict(zip([one.path for one in self.unknown], draws.T, strict=True))
        values |= {one.unknown.path: one.value for one in self.fixed}
        if path in values:
            value = values[path]
        elif path == CRITICAL:
            value = self.conditions.known_critical_temperature()
        elif (known := getattr(self.conditions, _FIELD_OF.get(path, ""), None)) is not None:
            value = known
        else:
            (entry,) = (one for one in self.design.inputs if one.path == path)
            value = float(entry.quantile(np.array([0.5]))[0])
        return np.full(len(draws), value)

    def log_limit(
        self,
        draws: Array,
        friction: float | Array | None = None,
        bulk: float | None = None,
        critical: float | Array | None = None,
        was_measured: bool = False,
    ) -> Array:
        """ln((critical − bulk temperature)/friction [K]) for each draw, shape (n,).

        It is the logarithm of the highest rise per unit friction coefficient without severe wear.
        `draws` (n, n_unknown) are values of the unknown inputs [SI]. `friction`, `bulk` [K] and
        `critical` [K] replace the values of the draws, if given. A friction that `was_measured`
        already includes the effect of temperature.
        """
        frictions = self.values(FRICTION, draws) if friction is None else friction
        bulks = self.values(BULK, draws) if bulk is None else bulk
        hottest = self.values(CRITICAL, draws) if critical is None else critical
        if not was_measured:
            frictions = frictions * np.exp(self.log_friction_factor(hottest))
        rise = np.maximum(hottest - bulks, _LEAST_RISE)
        return np.asarray(np.log(rise / np.maximum(frictions, LEAST_FRICTION)))

    def log_friction_factor(self, temperatures: float | Array) -> Array:
        """Logarithm of the factor by which contact temperature changes friction.

        It has a value for each of `temperatures` [K]. If friction does not depend on temperature,
        it is a single 0.
        """
        law = replace(self.conditions.friction_law, coefficient=1.0)
        return np.asarray(np.log(law.at(temperature=temperatures)))

    @functools.cached_property
    def ensembles_by_hold(self) -> dict[float, Ensemble]:
        """Ensembles by the time [s] for which the full load is held.

        They are this ensemble, and one for each shorter time of a test at which the samples have
        temperatures. Such an ensemble has the rises at the end of the shorter time.
        """
        return {self.hold: self} | {
            hold: replace(self, rises=rises, hold=hold, rises_by_hold={})
            for hold, rises in self.rises_by_hold.items()
        }

    @functools.cached_property
    def _rise(self) -> Emulator:
        table = self.conditions.friction_factor(self.sample_velocities)
        features = features_of(self.design, self.inputs.T, self.sample_velocities)
        values = np.log(self.rises / table[:, None])
        return fit_emulator(*features, self.contacts, values, self.keeper)

    def _emulate(
        self, draws: Array, load: Axis | float, velocity: Axis | float
    ) -> tuple[Array, Array]:
        """Predict ln(rise per unit friction coefficient [K]), and its standard error.

        Both are (n, n_load, n_velocity); a single load or velocity has no axis. `draws` (n,
        n_unknown) are values of the unknown inputs [SI]. Friction that varies with velocity is
        divided out of the rise.
        """
        emulator = self._rise
        loads, velocities = np.atleast_1d(load), np.atleast_1d(np.asarray(velocity, float))
        self.require_within(loads, velocities)
        nodes = velocities
        if len(velocities) > _NODES:
            nodes = np.geomspace(velocities.min(), velocities.max(), _NODES)
        columns = [self.values(quantity.path, draws) for quantity in self.design.inputs]
        between = (load_weights(self.loads, self.rises, one) for one in loads.tolist())
        weights, bends = map(np.array, zip(*between, strict=True))
        low, high = np.log(self.velocities)
        # Errors are larger at the ends of the velocities, as cross-validation shows.
        widening = 1 + end_weight((np.log(nodes) - low) / (high - low)) * (emulator.check.ends - 1)
        at_nodes = []
        for node, wider in zip(nodes, widening.tolist(), strict=True):
            features, _ = features_of(self.design, columns, np.full(len(draws), node))
            values, error = emulator(features, weights)
            at_nodes.append([values, wider * np.hypot(error, bends)])
        parts = [np.stack(part, axis=-1) for part in zip(*at_nodes, strict=True)]
        if len(velocities) > _NODES:
            x, wanted = np.log(nodes), np.log(velocities)
            parts = [CubicSpline(x, part, axis=-1)(wanted) for part in parts]
        shape = len(draws), *np.shape(load), *np.shape(velocity)
        values, error = (part.reshape(shape) for part in parts)
        return values, np.abs(error)

    @property
    def left_out(self) -> LeftOut:
        """Cross-validation of the emulator: how well it predicts samples that were left out."""
        return self._rise.check

    def require_within(self, loads: Axis, velocities: Axis) -> None:
        """Raise an `InputError` for loads or velocities outside the sweep."""
        for name, unit, values, axis in (
            ("load", "N", loads, self.loads),
            ("velocity", "m/s", velocities, self.velocities),
        ):
            for value in values:
                if axis[0] <= snap(value, axis[0], axis[-1]) <= axis[-1]:
                    continue
                ends = f"{axis[0]:g} to {axis[-1]:g} {unit}"
                if axis[0] == axis[-1]:
                    ends = f"{axis[0]:g} {unit} alone"
                raise InputError(
                    f"{name} is {value:g} {unit}; the samples have {ends}: give a value within, or "
                    "extend the sweep"
                )


def keep_fits(ds: xr.Dataset) -> None:
    """Fit the emulators of a store's samples, and keep the fits in the store for later commands."""
    data = results(ds)
    data.keeper.may_keep = True
    for scene in data.scenes:
        with suppress(InputError):  # too few samples are done
            for one in Ensemble.of(scene).ensembles_by_hold.values():
                _ = one._rise


def _row_conditions(
    conditions: Conditions, sweep: Sweep, rows: Sequence[int], shares: Sequence[float] | None
) -> list[Conditions]:
    """Conditions of each sample: `conditions` with the values that were drawn for the sample.

    Corrections of the rise, such as for an oil film, are those of the samples' variants in `sweep`,
    whose numbers are `rows`. `shares` has a drawn value of `Conditions.failing_share` for each
    sample. If None, this share was not drawn, and that of `conditions` remains.
    """
    own = (sweep.variant(((VARIANT, row),)).conditions for row in rows)
    of_rows = [replace(conditions, corrections=one.corrections) for one in own]
    if shares is not None:
        pairs = zip(of_rows, shares, strict=True)
        of_rows = [replace(one, failing_share=share) for one, share in pairs]
    return of_rows


def _require_enough(done: int, drawn: int) -> None:
    """Raise an `InputError` if too few of the `drawn` samples are `done` at all loads."""
    if done < max(1, min(_FEWEST, drawn)):
        raise InputError(
            f"{done} of {drawn} samples are done at every load, too few to judge by; run the sweep "
            "to its end"
        )
