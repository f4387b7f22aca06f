"""Fields of points on a page: averaged over elements, and drawn as pictures."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from numpy.typing import NDArray
from PIL import Image

from pipeline.quantities import display, display_sides
from pipeline.store.schema import PLANE
from tribo.types import Array, Mask

FIELDS = ("pressure", "rise", "wear_depth")
_SIDE = 120  # most pixels of a picture along each axis
_LEVELS = 255
_COLOURS = "viridis_r", "inferno", "cividis_r"  # pressure, temperature and wear, as in figures


def packed_fields(
    ds: xr.Dataset, chosen: Iterable[tuple[int, ...]], bulk_ratio: float
) -> dict[str, Any]:
    """Pictures of pressure, temperature rise and wear depth at points, and extreme values.

    `chosen` has the indices (load, velocity) of the points. `bulk_ratio` is (disk's − pin's bulk
    temperature)/friction [K].

    Returns a dictionary. ``points`` has the list made by `packed_point` for each point, by the flat
    index of the point. ``scales`` are pictures of the three colour scales. If there are points,
    ``note`` is a caption, and ``aspect`` the width of a picture over its height.
    """
    points: dict[str, Any] = {}
    bar = np.arange(1, _LEVELS + 1, dtype=np.uint8)[:, None]
    scales = [_picture(bar, colours) for colours in _COLOURS]
    content: dict[str, Any] = {"points": points, "scales": scales}
    names = [name for name in (*FIELDS, "bulk_response") if name in ds]
    for indices in chosen:
        here = ds[names].isel(dict(zip(PLANE, indices, strict=True))).transpose("x", "y", ...)
        place = np.ravel_multi_index(indices, [ds.sizes[name] for name in PLANE])
        pressure, rise, wear_depth, *response = (here[name].values for name in names)
        if np.isnan(pressure).all():  # a further patch of a run with an accuracy
            continue
        if bulk_ratio:
            rise = rise + bulk_ratio * response[0] + max(0.0, -bulk_ratio)
        points[str(place)] = packed_point(pressure, rise, wear_depth)
        content |= _picture_facts(here)
    return content


def packed_point(pressure: Array, rise: Array, wear_depth: Array) -> list[Any]:
    """List of extreme values of three fields (x, y) at a point, then a picture of each field.

    The values are the highest pressure [Pa], the lowest and the highest rise [K] in the contact,
    and the greatest wear depth [m], of means over the elements of a pixel. The pictures show
    pressure, rise and wear depth, as base64 text. `rise` is the temperature above the bulk
    temperature of the colder body, divided by friction.
    """
    contact = pressure > 0
    block = _block(pressure.shape[0]), _block(pressure.shape[1])
    touching = _summed(contact.astype(float), block)
    elements = _summed(np.ones_like(pressure), block)
    p, h = (_summed(field, block) / elements for field in (pressure, wear_depth))
    low, high, warmth = _over_contact(rise, contact, touching, block)
    levels = _levels(p, 0.0, p.max(), 0), warmth, _levels(h, 0.0, h.max(), 0)
    pictures = map(_picture, levels, _COLOURS)
    return [float(p.max()), low, high, float(h.max()), *pictures]


def _picture(levels: NDArray[np.uint8], colours: str) -> str:
    """Base64 of a .png with colour `levels` (x, y), x to the right and y upwards; 0 is white.

    `colours` is the name of a Matplotlib colour map for the other levels.
    """
    shades = colormaps[colours](np.linspace(0, 1, _LEVELS), bytes=True)[:, :3]
    palette = np.vstack([np.full((1, 3), 255, dtype=np.uint8), shades])
    image = Image.fromarray(np.ascontiguousarray(levels.T[::-1]), "P")
    image.putpalette(palette.tobytes())
    written = io.BytesIO()
    image.save(written, "png", optimize=True)
    return base64.b64encode(written.getvalue()).decode()


def _over_contact(
    field: Array, contact: Mask, touching: Array, block: tuple[int, int]
) -> tuple[float, float, NDArray[np.uint8]]:
    """Lowest and highest of a field's means over blocks, and each block's mean as a colour level.

    Only elements in contact count; `touching` is their number in each block.
    """
    means = _summed(np.where(contact, field, 0.0), block) / np.maximum(touching, 1.0)
    finite = means[touching > 0]
    if not (finite.size and np.isfinite(finite).all()):
        return 0.0, 0.0, np.zeros(means.shape, dtype=np.uint8)
    low, high = float(finite.min()), float(finite.max())
    levels = np.where(touching > 0, _levels(means, low, high, 1), 0)
    return low, high, levels.astype(np.uint8)


def _block(elements: int) -> int:
    """Number of elements to average along an axis, to keep the picture small."""
    return -(-elements // _SIDE)


def _summed(field: Array, block: tuple[int, int]) -> Array:
    """Sums of a field over blocks of elements; the last block along an axis may be smaller."""
    starts = [np.arange(0, n, b) for n, b in zip(field.shape, block, strict=True)]
    return np.add.reduceat(np.add.reduceat(field, starts[0], axis=0), starts[1], axis=1)


def _levels(field: Array, low: float, high: float, least: int) -> NDArray[np.uint8]:
    """Colour levels of a field: `least` where its value is `low`, up to 255 where it is `high`."""
    scale = (_LEVELS - least) / (high - low) if high > low else 0.0
    levels: Array = np.clip(least + np.rint((field - low) * scale), least, _LEVELS)
    return levels.astype(np.uint8)


def _picture_facts(ds: xr.Dataset) -> dict[str, Any]:
    """Note on the pictures (window size, averaging), and their aspect ratio."""
    axes = ds["x"].values, ds["y"].values
    along, across = (
        float(x[-1] - x[0]) * len(x) / (len(x) - 1) if len(x) > 1 else None for x in axes
    )
    size = f"{display(along or 0.0, 'µm', 4)} along sliding"
    if across:
        size = display_sides((along or 0.0, across))
    surface = f" on surface {ds['realization'].item()}" if "realization" in ds.coords else ""
    block = [_block(len(x)) for x in axes]
    averaged = f", averaged over {block[0]} × {block[1]} elements" if max(block) > 1 else ""
    return {
        "note": f"At the end of the point{surface}: {size}; sliding to the right{averaged}. "
        "The temperature is that of the parts in contact.",
        "aspect": min(max(along / across, 0.4), 8.0) if along and across else 8.0,
    }
