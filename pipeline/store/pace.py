"""Rate of a sweep, from the times at which its points were finished."""

from __future__ import annotations

import numpy as np

from tribo.types import Array

_RECENT = 200  # points, of which the rate is taken
_BREAK = 20.0  # times the usual time between points, after which a run was interrupted


def pace(finished: Array) -> float | None:
    """Points per second, of the most recent ones and since the last interruption.

    Parameters
    ----------
    finished : ndarray
        Times at which points were finished [s], in any order.

    Returns
    -------
    float or None
        None if fewer than three points tell of it.

    Examples
    --------
    >>> pace(np.array([1000.0, 1002.0, 1004.0, 9000.0, 9000.5, 9001.0, 9001.5]))
    2.0
    """
    times = np.sort(finished)[-_RECENT:]
    gaps = np.diff(times)
    if gaps.size:
        (breaks,) = np.nonzero(gaps > _BREAK * max(np.median(gaps), np.finfo(float).tiny))
        times = times[breaks[-1] + 1 :] if breaks.size else times
    if times.size < 3 or times[-1] == times[0]:
        return None
    return float((times.size - 1) / (times[-1] - times[0]))
