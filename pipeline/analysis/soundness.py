"""Refusal to read results from damaged points of a store."""

from __future__ import annotations

import itertools

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import own_wear_rate
from pipeline.sweep.variants import WEAR_RATE
from tribo.types import Array, Mask


def require_sound(ds: xr.Dataset, suspects: Mask, *dims: str) -> None:
    """Compare the data of some points, by the given dimensions, with their checksums, each once.

    Datasets of no store are left alone.

    Raises
    ------
    StoreError
        If one is damaged; it says which, and how to repair it.
    """
    reader = ds["status"].encoding.get("reader")
    if reader is None:
        return
    # The velocity at another wear rate is that of a contact of the store, scaled.
    rate = ds.attrs.get("wear_rate")
    scale = {"velocity": rate / own_wear_rate(ds)} if rate else {}
    places: dict[str, list[int | None]] = {}
    for name in reader.dims:
        values = np.atleast_1d(ds[name].values).tolist() if name in ds.coords else [None]
        places[name] = [
            None if value is None else reader.position(name, value * scale.get(name, 1))
            for value in values
        ]
    if rate:  # interpolated between all of them
        places |= {name: [*reader.positions(name)] for name in reader.dims if name == WEAR_RATE}
    indices = set()
    for found in np.argwhere(suspects).tolist():
        at = dict(zip(dims, found, strict=True))
        here = ([places[k][at[k]]] if k in at else places[k] for k in reader.dims)
        indices |= {index for index in itertools.product(*here) if None not in index}
    reader.require_sound(indices)


def deciding(is_done: Mask, rises: Array, limit: float | None, *dims: str) -> Mask:
    """Done points without a rise [K], and those beside which it crosses a limit [K].

    Examples
    --------
    >>> rises = np.array([[5.0, 7.0, 9.0, np.nan]])
    >>> deciding(np.full((1, 4), True), rises, 8.0, "load", "velocity").tolist()
    [[False, True, True, True]]
    """
    mask = is_done & np.isnan(rises)
    if limit is not None:
        for axis in range(rises.ndim):
            if dims[axis] in ("load", "velocity"):
                mask |= _beside(rises, limit, axis)
    return mask


def _beside(rises: Array, limit: float, axis: int) -> Mask:
    """Known points next to each other along an axis, of which one alone is above the limit.

    Examples
    --------
    >>> _beside(np.array([5.0, 7.0, np.nan, 9.0, 9.5]), 8.0, 0).tolist()
    [False, True, False, True, False]
    """
    mask = np.zeros(rises.shape, bool)
    lines, marks = np.moveaxis(rises, axis, -1), np.moveaxis(mask, axis, -1)
    for line in itertools.product(*map(range, lines.shape[:-1])):
        known = np.flatnonzero(np.isfinite(lines[line]))
        (turns,) = np.nonzero(np.diff(lines[line][known] > limit))
        marks[line][known[turns]] = marks[line][known[turns + 1]] = True
    return mask
