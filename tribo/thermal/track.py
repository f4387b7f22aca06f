"""Heat that earlier passes under the pin have left in the track of the disk."""

from __future__ import annotations

import math

import numpy as np
import scipy

from tribo.types import Array

_SINGLE = 400  # passes that are summed one by one; of all earlier ones an integral is taken
_PANEL, _NODES = 2.0, 5  # ratio of the ages at the ends of a panel, and nodes in each


def track_warming(
    time: float,
    round_trip: float,
    loads: tuple[Array, Array],
    width: float,
    diffusivity: float,
    heat_capacity: float,
) -> float:
    """Warming of the track by earlier passes, for each unit of the heat per distance [K].

    A pass under a pin of width B lays the heat F dx per element of track, at friction 1 and if all
    of it flows into the disk. It is an instantaneous strip on a half-space, whose middle is, a time
    t later, warmer by (Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed., 1959, §10.3)

        θ = F/(B ρc √(πκt)) erf(B/(4√(κt)))

    The sum runs over passes at t = nT, n = 1, 2 …, T the time of one round [s], with the load F
    that the pin carried then: `loads` are times [s] and loads [N], linear in between and 0 at
    time 0. The length of the contact along the track cancels.

    Examples
    --------
    The paper's disk at 750 N and 1.25 m/s, with friction 0.1:

    >>> ramp = np.array([5.0]), np.array([750.0])
    >>> warming = track_warming(5.0, 0.34 / 1.25, ramp, 3.4e-3, 1.2275e-5, 3.666e6)
    >>> f"{0.1 * warming:.1f} K"
    '2.4 K'
    """
    count = math.floor(time / round_trip) if round_trip > 0 else 0
    if count < 1:
        return 0.0
    knots = np.append(0.0, loads[0]), np.append(0.0, loads[1])

    def left(passed: Array) -> Array:
        """Warming that a pass of some rounds ago has left."""
        age = passed * round_trip
        load = np.interp(time - age, *knots)
        spread = np.sqrt(diffusivity * age)
        strip: Array = scipy.special.erf(width / (4 * spread))
        warming: Array = load * strip / (width * heat_capacity * math.sqrt(math.pi) * spread)
        return warming

    warming = float(left(np.arange(1.0, min(count, _SINGLE) + 1)).sum())
    if count > _SINGLE:
        first, last = _SINGLE + 0.5, count + 0.5
        # In panels that end where the load bends, and have much the same age throughout.
        bends = (time - loads[0]) / round_trip
        even = np.geomspace(first, last, 2 + math.ceil(math.log(last / first) / math.log(_PANEL)))
        ends = np.union1d(even, bends[(bends > first) & (bends < last)])
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        halves = np.diff(ends)[:, None] / 2
        passed = np.minimum(ends[:-1, None] + halves * (nodes + 1), time / round_trip)
        warming += float((halves * weights * left(passed)).sum())
    return warming
