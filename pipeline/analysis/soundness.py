"""Damage of a store is told where a result would be read from it, not passed over in silence."""

from __future__ import annotations

import itertools

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import values_of
from pipeline.analysis.wear_rate import own_wear_rate
from pipeline.store.schema import DONE
from tribo.types import Array, Mask


def require_sound(ds: xr.Dataset, rises: Array, limit: float | None, *dims: str) -> None:
    """Compare the data of points that decide with their checksums, each once.

    These are done points whose deciding rise is not known, and those beside which the rise crosses
    the limit [K]. Rises [K] have the given dimensions. Datasets of no store are left alone.

    Raises
    ------
    StoreError
        If one is damaged; it says which, and how to repair it.
    """
    reader = ds["status"].encoding.get("reader")
    if reader is None:
        return
    suspects = (values_of(ds, "status") == DONE) & np.isnan(rises)
    if limit is not None:
        for axis in range(rises.ndim):
            if dims[axis] in ("load", "velocity"):
                suspects |= _beside(rises, limit, axis)
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
    indices = set()
    for found in np.argwhere(suspects).tolist():
        at = dict(zip(dims, found, strict=True))
        index = tuple(places[name][at.get(name, 0)] for name in reader.dims)
        if None not in index:
            indices.add(index)
    reader.require_sound(indices)


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
