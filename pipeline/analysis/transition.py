"""The transition to severe wear along a line of points, and as much of it as was computed.

Between points the logarithm of the rise is interpolated over that of the velocity or the load by a
monotone cubic (PCHIP). It is exact for a power law, and adds no crossings. On ramps of the IRG
scene, every 0.25 m/s from 0.5 to 4 m/s, it found a velocity halfway between to 0.11 % (root mean
square), below 1 m/s to 0.16 %; the same cubic in y over x to 0.23 %, straight lines to 0.76 %.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import scipy  # loads its parts when they are used
import xarray as xr

from pipeline.analysis.dataset import stored_sweep
from tribo import Criterion
from tribo.types import Array, Mask

CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW, SEVERAL = range(7)
"""Values of the variables ``outcome_at_load`` and ``outcome_at_velocity``."""

BEYOND = (ABOVE, BELOW)
"""Outcomes that more points would tell."""


@functools.cache
def outcomes(axis: str) -> Mapping[int, str]:
    """Meanings of the outcomes along ``"velocity"`` or ``"load"``, in the words used everywhere."""
    return {
        CROSSES: "crosses",
        MILD: "mild throughout",
        SEVERE: "severe throughout",
        UNKNOWN: "not known yet",
        ABOVE: f"mild at every {axis} computed",
        BELOW: f"severe at every {axis} computed",
        SEVERAL: f"not decided: severe at some {axis} and mild at a higher one",
    }


UNITS = {"velocity": "m/s", "load": "N"}


@dataclass(frozen=True, slots=True)
class Crossing:
    """The first crossing from mild to severe wear along a line of points."""

    place: float  # velocity [m/s] or load [N]; NaN where there is none
    outcome: int  # key of `outcomes`
    computed: tuple[float, float]  # lowest and highest that is done; NaN where none is
    bridged: int = 0  # points asked for and not done between the two done ones next to it

    @classmethod
    def along(
        cls,
        x: Array,
        rise: Array,
        limit: float,
        ends: tuple[float, float],
        is_missing: Mask | None = None,
        is_done: Mask | None = None,
    ) -> Crossing:
        """Find the transition along velocities [m/s] or loads [N], which ascend.

        Rises [K] are NaN where they are not known; they are done there, or go on where that leaves
        wear as it is. Ends are those of the sweep's own range.
        """
        is_done = np.isfinite(rise) if is_done is None else is_done
        done = x[is_done]
        computed = (float(done[0]), float(done[-1])) if done.size else (math.nan, math.nan)
        if _is_mild_again(rise, limit):
            return cls(math.nan, SEVERAL, computed)
        place = crossing(x, rise, limit)
        if math.isfinite(place):
            is_missing = np.zeros_like(is_done) if is_missing is None else is_missing
            held, missing = x[is_done & ~is_missing], x[is_missing]
            below, above = held[held <= place], held[held >= place]
            across = 0
            if below.size and above.size:
                across = int(np.sum((missing > below[-1]) & (missing < above[0])))
            return cls(place, CROSSES, computed, across)
        if not done.size:
            outcome = UNKNOWN
        elif Criterion.is_severe(rise[is_done][0], limit):
            outcome = SEVERE if computed[0] <= ends[0] else BELOW
        else:
            outcome = MILD if computed[1] >= ends[1] else ABOVE
        return cls(place, outcome, computed)


def _is_mild_again(rise: Array, limit: float) -> bool:
    """Wear is severe somewhere along a line, and mild beyond."""
    known = rise[np.isfinite(rise)]
    severe = Criterion.is_severe(known, limit)
    return bool(severe.any() and Criterion.is_mild(known[np.argmax(severe) :], limit).any())


def in_words(outcome: str, computed: Iterable[float], along: str) -> str:
    """One of `outcomes` along ``"velocity"`` or ``"load"``, with how far was computed."""
    low, high = (f"{end:.4g} {UNITS[along]}" for end in computed)
    words = outcomes(along)
    ends = {words[ABOVE]: f" (to {high})", words[BELOW]: f" (from {low})"}
    return outcome + ends.get(outcome, "")


def range_of(ds: xr.Dataset, axis: str) -> tuple[float, float]:
    """Lowest and highest velocity [m/s] or load [N] of a scene, without a 0 that has no point."""
    present = ds[axis].values.tolist()
    plane = stored_sweep(ds).plane
    of_scene = plane.loads if axis == "load" else plane.velocities
    asked = [value for value in of_scene if value or 0.0 in present] or present
    return float(min(asked)), float(max(asked))


ENTRIES = {
    "friction": "friction.coefficient",
    "bulk_temperature": "temperature.bulk",
    "critical_temperature": "temperature.critical",
    "failing_share": "temperature.failing_share",
    "criterion": "temperature.criterion",
}
"""Entries of the scene format that give the conditions."""


_NEAR = 1.01  # ratio of abscissae over which an exponent is taken
_PARTS = 64  # of an interval of velocities, between which friction is taken as it is there
_FLAT = 0.25  # least exponent of a power law that is continued down to 0


def crossing(x: Array, y: Array, limit: float) -> float:
    """Place at which y first rises above a limit along ascending x; NaN if it does not."""
    is_finite = np.isfinite(y)
    x, y = x[is_finite], y[is_finite]
    reached = np.flatnonzero(y >= limit)
    if not reached.size:
        return math.nan
    first = int(reached[0])
    if y[first] == limit:
        return float(x[first])
    if first == 0:
        return math.nan
    curve, (below, above) = _curve(x, y), x[first - 1 : first + 1].tolist()
    if curve(below) >= limit:  # by rounding
        return float(below)
    if curve(above) <= limit:
        return float(above)
    options = {"xtol": 1e-15, "maxiter": 1000}
    return float(scipy.optimize.brentq(lambda x: curve(x) - limit, below, above, **options))


def interpolated(x: Array, y: Array, places: Array, continued: bool = False) -> Array:
    """Interpolate y at places along x; NaN beyond the outermost points that are finite.

    y may have columns, if they are finite at the same points and all are positive there, as x is.
    If continued, the power law through the last two points goes on beyond them, where x and y are
    positive.
    """
    result = np.full((*places.shape, *y.shape[1:]), np.nan)
    is_finite = np.isfinite(y.reshape(len(y), -1)[:, 0])
    if np.count_nonzero(is_finite) >= 2:
        x, y = x[is_finite], y[is_finite]
        inside = (places >= x[0]) & (places <= x[-1])
        result[inside] = _curve(x, y)(places[inside])
        if continued and (x > 0).all() and (y > 0).all():
            for beyond, (first, second) in ((places < x[0], (0, 1)), (places > x[-1], (-1, -2))):
                exponent = np.log(y[first] / y[second]) / np.log(x[first] / x[second])
                result[beyond] = y[first] * (places[beyond] / x[first]) ** exponent
    return result


def along_friction(
    velocities: Array, rises: Array, factor: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """Velocities [m/s] close together, and rises [K] there with friction by velocity.

    Between two velocities the friction is known, and only the heat is interpolated: rises are
    divided by the factor of their friction, and multiplied by that of each place.
    """
    steps = np.arange((len(velocities) - 1) * _PARTS + 1) / _PARTS
    places = np.interp(steps, np.arange(len(velocities)), velocities)
    between = interpolated(velocities, rises / factor(velocities), places) * factor(places)
    between[::_PARTS] = rises
    return places, between


def spread(mask: Mask) -> Mask:
    """A mask of velocities at those of `along_friction`, False between them."""
    fine = np.zeros((len(mask) - 1) * _PARTS + 1, dtype=bool)
    fine[::_PARTS] = mask
    return fine


def certain(x: Array, y: Array, places: Array, limit: float) -> Array:
    """Interpolate y, and extrapolate it by a power law where that cannot cross a limit."""
    within, finite = interpolated(x, y, places), np.flatnonzero(np.isfinite(y))
    if len(finite) < 2:
        return within
    first, last = finite[[0, -1]]
    beyond = interpolated(x, y, places, continued=True)
    if Criterion.is_mild(y[first], limit):
        within = np.where(places < x[first], np.minimum(beyond, y[first]), within)
    if Criterion.is_severe(y[last], limit):
        within = np.where(places > x[last], np.maximum(beyond, y[last]), within)
    return within


def exponent(x: Array, y: Array, place: float) -> float:
    """Exponent d ln(y)/d ln(x) of the interpolated y at an abscissa, NaN where that is NaN."""
    is_finite = np.isfinite(y)
    if not place > 0 or np.count_nonzero(is_finite) < 2:
        return math.nan
    x, y = x[is_finite], y[is_finite]
    ends = np.clip([place / _NEAR, place * _NEAR], x[0], x[-1])
    low, high = _curve(x, y)(ends)
    return math.log(high / low) / math.log(ends[1] / ends[0]) if low > 0 else math.nan


def _curve(x: Array, y: Array) -> Callable[[Array], Array]:
    """Monotone cubic through points, of the logarithms where they are positive."""
    if (x > 0).all() and (y > 0).all():
        power_law = scipy.interpolate.PchipInterpolator(np.log(x), np.log(y))
        return lambda places: np.exp(power_law(np.log(places)))
    if x[0] == 0 and y[0] == 0 and len(x) > 2 and (y[1:] > 0).all():
        # From the first point down to 0, the power law goes on with which the others begin; a
        # flat one would leap up at 0.
        cubic = scipy.interpolate.PchipInterpolator(np.log(x[1:]), np.log(y[1:]))
        slope = float(cubic(cubic.x[0], 1))
        if slope > _FLAT:

            def from_rest(places: Array) -> Array:
                foot = y[1] * (np.minimum(places, x[1]) / x[1]) ** slope
                beyond: Array = np.exp(cubic(np.log(np.maximum(places, x[1]))))
                return np.where(places < x[1], foot, beyond)

            return from_rest
    straight: Callable[[Array], Array] = scipy.interpolate.PchipInterpolator(x, y)
    return straight
