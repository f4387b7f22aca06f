"""Interpolation of values close to a power law, and where they reach a limit.

The logarithm of y is interpolated over that of x by a monotone cubic (PCHIP). It is exact for a
power law, and adds no crossings.

The interpolation error was measured on ramps of the IRG scene, every 0.25 m/s from 0.5 to 4 m/s. A
velocity halfway between two points is found to 0.11 % (root mean square). Below 1 m/s it is 0.16 %,
against 0.23 % of the same cubic in y over x, and 0.76 % of straight lines.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import scipy  # loads its parts when they are used

from tribo import Criterion
from tribo.types import Array

_NEAR = 1.01  # ratio of abscissae over which an exponent is taken
_FLAT = 0.25  # least exponent of a power law that is continued down to 0


def crossing(x: Array, y: Array, limit: float) -> float:
    """Place at which y first rises above a limit; NaN if it does not.

    Abscissae ascend, and points where y is NaN are skipped.

    Examples
    --------
    >>> velocity = np.array([0.0, 1.0, 2.0, 3.0])
    >>> f"{crossing(velocity, 100 * velocity**0.7, limit=100 * 1.5**0.7):.12f}"
    '1.500000000000'
    >>> crossing(velocity, 100 * velocity**0.7, limit=300.0)
    nan
    """
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

    If continued, the power law through the last two points goes on beyond them, where x and y are
    positive.

    Examples
    --------
    >>> interpolated(np.array([1.0, 4.0]), np.array([10.0, 20.0]), np.array([0.5, 2.0, 4.0]))
    array([        nan, 14.14213562, 20.        ])
    """
    result = np.full(places.shape, np.nan)
    is_finite = np.isfinite(y)
    if np.count_nonzero(is_finite) >= 2:
        x, y = x[is_finite], y[is_finite]
        inside = (places >= x[0]) & (places <= x[-1])
        result[inside] = _curve(x, y)(places[inside])
        if continued and (x > 0).all() and (y > 0).all():
            for beyond, (first, second) in ((places < x[0], (0, 1)), (places > x[-1], (-1, -2))):
                exponent = np.log(y[first] / y[second]) / np.log(x[first] / x[second])
                result[beyond] = y[first] * (places[beyond] / x[first]) ** exponent
    return result


def certain(x: Array, y: Array, places: Array, limit: float) -> Array:
    """Interpolate y, and continue it by a power law where that leaves the side of a limit as it is.

    It is continued below points that do not exceed the limit, and above points that do.

    Examples
    --------
    >>> x, y = np.array([1.0, 4.0]), np.array([10.0, 20.0])
    >>> certain(x, y, np.array([0.25, 4.0, 16.0]), limit=30.0)
    array([ 5., 20., nan])
    >>> certain(x, y, np.array([0.25, 4.0, 16.0]), limit=15.0)
    array([ 5., 20., 40.])
    """
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
    """Exponent d ln(y)/d ln(x) of the interpolated y at an abscissa, NaN where that is NaN.

    Examples
    --------
    >>> velocity = np.array([1.0, 2.0, 3.0])
    >>> f"{exponent(velocity, 100 * velocity**0.7, place=2.5):.12f}"
    '0.700000000000'
    """
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
