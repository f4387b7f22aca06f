"""Where the film of an oil carries more of the load than the model allows.

y_film = ln(12 η U I/q₂₀) is computed at each point from its stored inlet, at the bulk temperature
and with the oil of the answer, and interpolated as the rise is. Above 0 the place is outside.
"""

from __future__ import annotations

import functools

import numpy as np

from pipeline.analysis.curve import Curve
from pipeline.analysis.outcomes import Turns
from pipeline.analysis.results import Results
from pipeline.analysis.rises import Places, Rises, places_of
from pipeline.sweep.conditions import Conditions
from tribo import Scene
from tribo.simulation.film import film_excess
from tribo.types import Array, Mask

OUTSIDE = "outside"
"""Verdict where a film carries more than a fifth of the load."""
OUTSIDE_WORDS = "outside the model: the oil film carries more than a fifth of the load"


def is_outside(rises: Rises, loads: Places, velocities: Places) -> Mask:
    """True for those of k places where a film carries more than a fifth of the load (k,)."""
    loads, velocities = places_of(loads, velocities)
    plane = _plane(rises)
    if plane is None:
        return np.zeros(loads.shape, bool)
    each, back = np.unique(velocities, return_inverse=True)
    rows = Curve(rises.source.velocities, plane)(each, continued=True)[:, back]
    found = Curve(rises.source.loads, rows.T)(loads[:, None])[:, 0]
    return np.asarray(np.nan_to_num(found) > 1)


def inside_alone(rises: Rises, axis: str, places: Array, found: Array) -> tuple[Array, Mask]:
    """Critical values along `axis` at `places` of the other axis, NaN outside; and where that is.

    `axis` is "velocity" or "load".
    """
    at = (found, places) if axis == "load" else (places, found)
    known = np.isfinite(found)
    outside = np.zeros(found.shape, bool)
    outside[known] = is_outside(rises, *(one[known] for one in at))
    return np.where(outside, np.nan, found), outside


def critical_inside(rises: Rises, axis: str, places: Array, turns: Turns) -> tuple[Array, Mask]:
    """Critical values as `inside_alone` gives them, and which lines are outside.

    A line without a crossing is outside if both of its computed ends are.
    """
    found, outside = inside_alone(rises, axis, places, turns.critical)
    ends = [inside_alone(rises, axis, places, end)[1] for end in turns.computed]
    return found, outside | (np.isnan(turns.critical) & ends[0] & ends[1])


def turns_inside(rises: Rises, axis: str, places: Array, turns: Turns) -> tuple[Array, list[str]]:
    """Critical values as `critical_inside`, and for each of them the outcome in words."""
    found, outside = critical_inside(rises, axis, places, turns)
    told = zip(turns.texts(axis), outside, strict=True)
    return found, [OUTSIDE_WORDS if there else text for text, there in told]


def is_test_outside(data: Results, place: int, own: Conditions) -> bool:
    """True if a film carries too much at a point of a test, under the test's conditions."""
    held, oil = data.tests, data.sweep.lubricant
    values = [held.columns.get(name) for name in ("film_inlet", "film_pressure")]
    if oil is None or values[0] is None or values[1] is None or not data.sweep.base.has_film:
        return False
    test = data.stored.tests[int(held.numbers[place])]
    inlet, pressure = float(values[0][place]), float(values[1][place])
    if not np.isfinite(inlet * pressure):
        return False
    scene: Scene = test.case.scene
    at = float(held.loads[place]), float(held.velocities[place])
    return film_excess(scene, oil, *at, own.mean_bulk_temperature, inlet, pressure) > 0


@functools.lru_cache(maxsize=64)
def _plane(rises: Rises) -> Array | None:
    """exp(y_film) at each point (n_load, n_velocity), the mean over patches; None if not known."""
    data = rises.source
    oil, inlets = data.sweep.lubricant, data.columns.get("film_inlet")
    pressures = data.columns.get("film_pressure")
    if oil is None or inlets is None or pressures is None or not data.sweep.base.has_film:
        return None
    shape = -1, len(data.loads), len(data.velocities)
    if not np.isfinite(inlets).any():
        return None
    bulk, found = rises.conditions.mean_bulk_temperature, np.full(shape[1:], np.nan)
    several = np.log(inlets.reshape(shape)), np.log(pressures.reshape(shape))
    for (k, j), _ in np.ndenumerate(found):
        inlet, pressure = (one[np.isfinite(one[:, k, j]), k, j] for one in several)
        if inlet.size and data.velocities[j] > 0:
            held = float(np.exp(inlet.mean())), float(np.exp(pressure.mean()))
            place = float(data.loads[k]), float(data.velocities[j])
            found[k, j] = np.exp(film_excess(data.sweep.scene, oil, *place, bulk, *held))
    return found
