"""The deciding rise of a sweep at places so dense that a page can join them by straight lines."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.transition import interpolated
from tribo.types import Array, Mask

_PLACES = 60, 30  # velocities and loads at least, where there is room for them
_MOST = 400_000  # values of a table, 2 MB of a page
_FLAT = 0.05  # least exponent of a rise whose crossings are judged


def pieces_of(loads: int, velocities: int, others: int) -> tuple[int, int]:
    """Parts of each interval between velocities, and between loads.

    Examples
    --------
    >>> pieces_of(loads=12, velocities=19, others=25), pieces_of(12, 19, others=2000)
    ((4, 3), (1, 1))
    """
    counts = [velocities, loads]
    parts = [
        max(1, -(-least // max(count - 1, 1))) for least, count in zip(_PLACES, counts, strict=True)
    ]
    while (
        max(parts) > 1
        and others
        * np.prod([part * (count - 1) + 1 for part, count in zip(parts, counts, strict=True)])
        > _MOST
    ):
        parts[parts.index(max(parts))] -= 1
    return parts[0], parts[1]


def between(places: Array, parts: int) -> Array:
    """Places of an axis, and those that divide each interval into so many equal parts."""
    index = np.arange((len(places) - 1) * parts + 1) / parts
    return np.interp(index, np.arange(len(places)), places)


def along(values: Array, places: Array, parts: int, axis: int) -> Array:
    """Interpolate values between the places of an axis; those at them stay as they are."""
    if len(places) == 1:
        return values
    fine = np.apply_along_axis(
        lambda row: interpolated(places, row, between(places, parts)), axis, values
    )
    np.moveaxis(fine, axis, 0)[::parts] = np.moveaxis(values, axis, 0)
    return fine


def bridged(done: Mask, missing: Mask, parts: int) -> Mask:
    """Fine places along the last axis that are interpolated across points that are missing.

    Examples
    --------
    >>> bridged(np.array([True, False, True, True]), np.array([False, True, False, False]), 2)
    array([False,  True,  True,  True, False, False, False])
    """
    fine = np.zeros((*done.shape[:-1], (done.shape[-1] - 1) * parts + 1), dtype=bool)
    for place in zip(*np.nonzero(missing), strict=True):
        row, here = place[:-1], place[-1]
        before, after = np.flatnonzero(done[row][:here]), np.flatnonzero(done[row][here:])
        if before.size and after.size:
            fine[row][parts * before[-1] + 1 : parts * (here + after[0])] = True
    return fine


def error_of_lines(values: Array, places: Array, parts: int) -> float:
    """Largest relative error of crossings by straight lines of logarithms, along the last axis.

    By the middles of the parts, at which the curve itself is known.

    Examples
    --------
    >>> velocity = np.array([1.0, 2.0, 4.0])
    >>> error_of_lines(100 * velocity**0.7, velocity, 2) < 1e-12
    True
    >>> 1e-4 < error_of_lines(np.array([100.0, 150.0, 160.0]), velocity, 2) < 0.05
    True
    """
    if len(places) == 1:
        return 0.0
    double, fine = between(places, 2 * parts), along(values, places, 2 * parts, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = np.log(double), np.log(fine)
        slope = np.diff(y[..., ::2]) / np.diff(x[::2])
        weight = (x[1::2] - x[:-1:2]) / np.diff(x[::2])
        off = y[..., 1::2] - (y[..., :-1:2] + weight * np.diff(y[..., ::2]))
        errors = np.abs(off / slope)[slope > _FLAT]
    return float(np.max(errors[np.isfinite(errors)], initial=0.0))
