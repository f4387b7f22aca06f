"""A certificate of samples: boundaries of random inputs that were found directly.

Each is sought by simulations alone, at a load of its own anywhere between the ends of the sweep.
How far the emulator's are off is kept in the store.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from pipeline.sweep.criterion import worst_rises
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import run_point
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import prior
from tribo import InputError
from tribo.types import Array

SceneWith = Callable[[Mapping[str, Any]], Sweep]
"""Gives the scene of the samples with entries by their paths, as a scene file has them."""


def log_rise(sweep: Sweep, load: float, velocity: float) -> float:
    """Logarithm of the rise that decides at friction 1, by a simulation from the start on."""
    columns = run_point(sweep, load, velocity).columns
    return math.log(float(worst_rises(columns, load, sweep.conditions)))


def as_in_a_scene(ensemble: Ensemble, row: Sequence[float] | Array) -> dict[str, Any]:
    """Inputs of a draw, and those that are fixed, as entries of a scene file by their paths."""
    pairs = [*zip(ensemble.unknown, np.asarray(row).tolist(), strict=True)]
    pairs += [(one.unknown, one.value) for one in ensemble.fixed]
    return {one.path: _entry(one, value) for one, value in pairs}


def _entry(unknown: Unknown, value: float) -> float | int | str:
    unit = unknown.shown
    if unit.name != "1":
        return f"{float(unit.of(value))!r} {unit.name}"
    return int(value) if unknown.kind == "list" and value == int(value) else float(value)


COUNT = 25
"""Boundaries of a certificate."""
_DRAWS = 256  # of which those count whose boundary lies within the sweep
_SEED = 31415
_CLOSE = 2e-3  # of ln(rise), to which a boundary is sought
_STEPS = 20
_SCORE = 1.645  # standard errors within which 90 % lie
_LEAST_SLOPE, _MOST_SLOPE = 0.2, 2.0  # of ln(rise) over ln(velocity), between which steps are taken


@dataclass(frozen=True, slots=True)
class Certificate:
    """Boundaries found directly, beside those of the emulator.

    Attributes
    ----------
    loads : tuple of float
        Normal loads [N].
    found, emulated : tuple of float
        Critical velocities, by simulations and by the emulator [m/s].
    errors : tuple of float
        Standard errors of the emulator's, as it states them, relative.

    Examples
    --------
    >>> print(Certificate((400.0, 500.0), (2.0, 1.8), (2.04, 1.8), (0.01, 0.01)))
    2 boundaries of random inputs found directly: the emulator's are 1.4 % off, its 90 % hold 1
    """

    loads: tuple[float, ...]
    found: tuple[float, ...]
    emulated: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def off(self) -> Array:
        """How far the emulator's velocities are off, relative."""
        off: Array = np.log(np.array(self.emulated) / np.array(self.found))
        return off

    @property
    def error(self) -> float:
        """Root mean square of how far they are off."""
        return float(np.sqrt(np.mean(self.off**2)))

    @property
    def held(self) -> int:
        """Number of boundaries that the emulator's bands of 90 % hold."""
        return int(np.sum(np.abs(self.off) <= _SCORE * np.array(self.errors)))

    def as_dict(self) -> dict[str, object]:
        """Return the summary and all boundaries as plain data."""
        return {"error": self.error, "held": self.held, "count": len(self.found)} | asdict(self)

    def __str__(self) -> str:
        return (
            f"{len(self.found)} boundaries of random inputs found directly: the emulator's are "
            f"{100 * self.error:.2g} % off, its 90 % hold {self.held}"
        )


def certificate_of(ensemble: Ensemble) -> Certificate | None:
    """The certificate that is kept with samples; None if there is none."""
    if ensemble.keeper is None:
        return None
    with suppress(ValueError, TypeError):
        rows = json.loads(ensemble.keeper.kept(_name(ensemble)) or b"")
        return Certificate(**{name: tuple(map(float, values)) for name, values in rows.items()})
    return None


def certify(
    ensemble: Ensemble,
    scene_with: SceneWith,
    count: int = COUNT,
    progress: Callable[[int, int], None] | None = None,
) -> Certificate:
    """Find boundaries of random inputs directly, and keep how far the emulator's are off.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    scene_with : callable
        See `SceneWith`.
    count : int
        Number of boundaries.
    progress : callable, optional
        Called with the boundaries found and their number.
    """
    inputs = prior(ensemble.unknown, ensemble.design.seed + _SEED, _DRAWS).inputs
    chance = np.random.default_rng([ensemble.design.seed, _SEED])
    ends = np.log(ensemble.loads[[0, -1]]).tolist()
    loads = np.exp(chance.uniform(ends[0], ends[1], _DRAWS))
    low, high = np.log(ensemble.velocities)
    rows: list[tuple[float, float, float, float]] = []
    for row, load in zip(inputs, loads.tolist(), strict=True):
        if len(rows) == count:
            break
        (((place,),), ((error,),)) = log_boundary(ensemble, row[None], [load])
        if not low <= place <= high:
            continue
        if progress:
            progress(len(rows), count)
        sweep = scene_with(as_in_a_scene(ensemble, row))
        limit = float(ensemble.log_limit(row[None])[0])
        found = _boundary(partial(log_rise, sweep, load), limit, place, (low, high))
        if found is not None:
            rows.append((load, math.exp(found), math.exp(place), float(error)))
    if not rows:
        raise InputError("no boundary of random inputs lies within the sweep; give more velocities")
    certificate = Certificate(*zip(*rows, strict=True))
    if ensemble.keeper is not None and len(rows) == COUNT:
        ensemble.keeper.keep(_name(ensemble), json.dumps(asdict(certificate)).encode())
    return certificate


def _boundary(
    rise: Callable[[float], float], limit: float, place: float, ends: tuple[float, float]
) -> float | None:
    """Logarithm of the velocity at which a rise reaches its limit; None if beyond the ends.

    The rise is a function of the velocity, the place and the ends are logarithms of velocities.
    """
    excess, slope = rise(math.exp(place)) - limit, 0.7
    for _ in range(_STEPS):
        if abs(excess) < _CLOSE:
            break
        following = min(max(place - excess / slope, ends[0]), ends[1])
        if following == place:
            return None
        other = rise(math.exp(following)) - limit
        slope = min(max((other - excess) / (following - place), _LEAST_SLOPE), _MOST_SLOPE)
        place, excess = following, other
    return place - excess / slope


def _name(ensemble: Ensemble) -> str:
    """Name under which the certificate of just these samples is kept."""
    data = ensemble.inputs.tobytes() + ensemble.rises.tobytes()
    return f"certificate-{hashlib.sha256(data).hexdigest()[:16]}"
