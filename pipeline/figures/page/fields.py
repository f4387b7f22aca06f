"""Fields of points as a page holds them: averaged, in 255 levels, compressed."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tribo.types import Array, Mask

FIELDS = ("pressure", "rise", "wear_depth")
POINT = ("realization", "load", "velocity")
"""Dimensions of the points of a page, as far as its sweep has them."""
_SIDE = 120  # elements along each axis, at most
_LEVELS = 255


def packed_fields(ds: xr.Dataset, chosen: Iterable[tuple[int, ...]]) -> dict[str, Any]:
    """Pack pressure, rise and wear depth of points chosen by surface, load and velocity.

    Gives ``shape`` after averaging, ``block`` the elements averaged along each axis, ``extent`` of
    the window [m], and by place the ``points``: highest pressure [Pa], lowest and highest rise [K],
    greatest depth [m], lowest and highest response to unequal bulk temperatures, and the base64 of
    the compressed levels of the fields.
    """
    points: dict[str, Any] = {}
    content: dict[str, Any] = {"points": points}
    axes = [name for name in POINT if name in ds.dims]
    names = [name for name in (*FIELDS, "bulk_response") if name in ds]
    for indices in chosen:
        here = ds[names].isel(dict(zip(axes, indices, strict=True))).transpose("x", "y", ...)
        place = np.ravel_multi_index(indices, [ds.sizes[name] for name in axes])
        shape, points[str(place)] = packed_point(*(here[name].values for name in names))
        if "shape" not in content:
            block = [_block(n) for n in here["pressure"].shape]
            content |= {"shape": list(shape), "block": block, "extent": _extent(here)}
    return content


def packed_point(
    pressure: Array, rise: Array, wear_depth: Array, bulk_response: Array | None = None
) -> tuple[tuple[int, int], list[Any]]:
    """Pack the fields of one point; what is warm is averaged over what is in contact alone."""
    contact = pressure > 0
    block = _block(pressure.shape[0]), _block(pressure.shape[1])
    touching = _summed(contact.astype(float), block)
    elements = _summed(np.ones_like(pressure), block)
    p, h = (_summed(field, block) / elements for field in (pressure, wear_depth))
    low, high, warmth = _over_contact(rise, contact, touching, block)
    levels = [_levels(p, 0.0, p.max(), 0), warmth, _levels(h, 0.0, h.max(), 0)]
    ends = [0.0, 0.0]
    if bulk_response is not None:
        *ends, response = _over_contact(bulk_response, contact, touching, block)
        levels.append(response)
    packed = zlib.compress(np.array(levels, dtype=np.uint8).tobytes())
    scales = [float(p.max()), low, high, float(h.max()), *ends]
    return p.shape, [*scales, base64.b64encode(packed).decode()]


def _over_contact(
    field: Array, contact: Mask, touching: Array, block: tuple[int, int]
) -> tuple[float, float, NDArray[np.uint8]]:
    """Lowest and highest mean over what touches in a block, and levels; 0 where nothing does."""
    means = _summed(np.where(contact, field, 0.0), block) / np.maximum(touching, 1.0)
    finite = means[touching > 0]
    if not (finite.size and np.isfinite(finite).all()):
        return 0.0, 0.0, np.zeros(means.shape, dtype=np.uint8)
    low, high = float(finite.min()), float(finite.max())
    levels = np.where(touching > 0, _levels(means, low, high, 1), 0)
    return low, high, levels.astype(np.uint8)


def _block(elements: int) -> int:
    """Number of elements to average, so that no more than fit into a picture are left."""
    return -(-elements // _SIDE)


def _summed(field: Array, block: tuple[int, int]) -> Array:
    """Sum over blocks, the last of which may be cut short."""
    starts = [np.arange(0, n, b) for n, b in zip(field.shape, block, strict=True)]
    return np.add.reduceat(np.add.reduceat(field, starts[0], axis=0), starts[1], axis=1)


def _levels(field: Array, low: float, high: float, least: int) -> NDArray[np.uint8]:
    """Write a field in levels from `least` at `low` to the highest at `high`."""
    scale = (_LEVELS - least) / (high - low) if high > low else 0.0
    levels: Array = np.clip(least + np.rint((field - low) * scale), least, _LEVELS)
    return levels.astype(np.uint8)


def _extent(ds: xr.Dataset) -> list[float | None]:
    """Sides of the window along x and y [m]; None along an axis of one element."""
    axes = ds["x"].values, ds["y"].values
    return [float(x[-1] - x[0]) * len(x) / (len(x) - 1) if len(x) > 1 else None for x in axes]
