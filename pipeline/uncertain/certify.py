"""Direct simulations of draws, without the emulator, and those of a certificate."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import run_point
from pipeline.sweep.severity import worst_rises
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.certificate import COUNT, Certificate
from pipeline.uncertain.emulator import END, kept_name, remember
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import FRICTION, prior
from tribo import InputError
from tribo.types import Array

_DRAWS = 256  # of which those count whose boundary lies within the sweep
_SEED = 31415
_OUTER = 0.05  # share of the velocities at either end, in which runs are at the end
_CLOSE = 1e-3  # of ln(velocity), to which a boundary is sought
_STEP = 0.03  # of ln(velocity), twice as far each time, until a boundary lies between

SceneWith = Callable[[Mapping[str, Any]], Sweep]
"""Gives the scene of the samples with entries by their paths, as a scene file has them."""


def log_rise(sweep: Sweep, load: float, velocity: float) -> float:
    """Logarithm of the rise that decides at friction 1, by a simulation from the start on."""
    columns = run_point(sweep.changed(steps="end"), load, velocity).columns
    return math.log(float(worst_rises(columns, load, sweep.conditions)))


def as_in_a_scene(ensemble: Ensemble, row: Sequence[float] | Array) -> dict[str, Any]:
    """Inputs drawn and fixed as entries of a scene, without friction: rises are at friction 1."""
    pairs = [*zip(ensemble.unknown, np.asarray(row).tolist(), strict=True)]
    pairs += [(one.unknown, one.value) for one in ensemble.fixed]
    return {one.path: _entry(one, value) for one, value in pairs if one.path != FRICTION}


def _entry(unknown: Unknown, value: float) -> float | int | str:
    unit = unknown.shown
    if unit.name != "1":
        return f"{float(unit.of(value))!r} {unit.name}"
    return int(value) if unknown.kind == "list" and value == int(value) else float(value)


def certify(
    ensemble: Ensemble,
    scene_with: SceneWith,
    progress: Callable[[int, int], None] | None = None,
) -> Certificate:
    """Find boundaries of random inputs by simulations, and keep the emulator's errors there."""
    inputs = prior(ensemble.unknown, ensemble.design.seed + _SEED, _DRAWS).inputs
    chance = np.random.default_rng([ensemble.design.seed, _SEED])
    ends = np.log(ensemble.loads[[0, -1]]).tolist()
    low, high = np.log(ensemble.velocities).tolist()
    rows: list[tuple[float, ...]] = []
    for row, log_load in zip(inputs, chance.uniform(ends[0], ends[1], _DRAWS), strict=True):
        if len(rows) == COUNT:
            break
        load = math.exp(log_load)
        (((place,),), ((error,),)) = log_boundary(ensemble, row[None], [load])
        if not low <= place <= high:
            continue
        if progress:
            progress(len(rows), COUNT)
        sweep = scene_with(as_in_a_scene(ensemble, row))
        limit = float(ensemble.log_limit(row[None])[0])
        found = boundary_near(partial(_log_excess, sweep, load, limit), place, (low, high))
        if found is None:
            continue
        amid, outer = chance.uniform(END, 1 - END, 2), _OUTER * chance.uniform()
        shares = np.array([*amid, outer if len(rows) % 2 else 1 - outer])
        velocities = np.exp(low + (high - low) * shares).tolist()
        loads = [float(chance.choice(ensemble.loads)), load, float(chance.choice(ensemble.loads))]
        scores = (
            _score(ensemble, row, sweep, *place) for place in zip(loads, velocities, strict=True)
        )
        rows.append((load, math.exp(found), math.exp(place), float(error), *scores))
    if not rows:
        raise InputError("no boundary of random inputs lies within the sweep; give more velocities")
    certificate = Certificate(*zip(*rows, strict=True))
    if ensemble.keeper is not None and len(rows) == COUNT:
        name = kept_name("certificate", ensemble.inputs, ensemble.rises)
        remember(ensemble.keeper, name, asdict(certificate))
    return certificate


def _log_excess(sweep: Sweep, load: float, limit: float, log_velocity: float) -> float:
    return log_rise(sweep, load, math.exp(log_velocity)) - limit


def _score(ensemble: Ensemble, row: Array, sweep: Sweep, load: float, velocity: float) -> float:
    """Difference of an emulated rise from a simulated one, over its stated error."""
    excess = ensemble.excess(row[None], load, velocity)
    emulated = excess.values[0] + ensemble.log_limit(row[None])[0]
    return float((emulated - log_rise(sweep, load, velocity)) / excess.error[0])


def boundary_near(
    excess: Callable[[float], float], place: float, ends: tuple[float, float]
) -> float | None:
    """Place near another beyond which an excess, which may jump, is positive; None if beyond."""
    excess = cache(excess)
    step = _STEP if excess(place) < 0 else -_STEP
    near = far = place
    while excess(far) * excess(place) > 0:
        near, far = far, min(max(far + step, ends[0]), ends[1])
        if far == near:
            return None
        step *= 2
    return float(brentq(excess, near, far, xtol=_CLOSE))
