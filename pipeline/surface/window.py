"""The patch of a scan that a scene's window takes: cropped, levelled, filled and continued."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.quantities import display, display_sides
from pipeline.surface.scan import Scan
from tribo import InputError
from tribo.surface.areal import remove_form
from tribo.types import Array


def window_heights(
    scan: Scan, table: Mapping[str, Any], pixels: tuple[int, int], sides: tuple[float, float]
) -> tuple[Array, list[str]]:
    """Heights [m] of a scan for a window, and notes on what was done to them.

    `table` has the entries of ``disk.roughness``; `pixels` and `sides` [m] are those of the window.
    """
    if not np.allclose(scan.pixel_size, sides, rtol=0.01):
        raise InputError(
            f"its pixels are {display_sides(scan.pixel_size)}; give those, window.pixel_size"
        )
    heights = _cropped(scan.heights, table, pixels)
    notes = [*scan.notes]
    if table["level"]:
        heights, _, radii = remove_form(heights, sides)
        curved = form_words(radii)
        notes += [f"curvature removed: R {curved}"] if curved else []
    patch = Scan(heights, scan.pixel_size)
    if patch.missing:
        heights = filled(patch, table["missing"])
        notes.append(f"{patch.missing_words} and were filled from their surroundings")
    if table["repeat"] != "no" and np.less(heights.shape, pixels).any():
        notes.append(
            f"{heights.shape[0]} × {heights.shape[1]} heights were mirrored to fill the window of "
            f"{pixels[0]} × {pixels[1]}, so that the surface repeats itself"
        )
        more = np.maximum(0, np.subtract(pixels, heights.shape)).tolist()
        heights = np.pad(heights, [(0, n) for n in more], "symmetric")
    return np.ascontiguousarray(heights), notes


def filled(scan: Scan, most: float) -> Array:
    """Heights [m] with the missing ones as the mean of their neighbours (Laplace's equation).

    An `InputError` if more than a share `most` is missing.
    """
    if scan.missing > most * scan.heights.size:
        first = np.argwhere(np.isnan(scan.heights))[0].tolist()
        raise InputError(
            f"{scan.missing_words}, the first at x {first[0]}, y {first[1]} (counted from 0); "
            f"at most {100 * most:.2g} % are filled: measure again, or allow more by missing"
        )
    if not scan.missing:
        return scan.heights
    try:
        from SurfaceTopography import Topography
    except ImportError as error:
        raise InputError(
            f'{scan.missing_words}; to fill them, pip install "irg-transition[surfaces]"'
        ) from error
    sides = np.multiply(scan.heights.shape, scan.pixel_size)
    holed = Topography(np.ma.masked_invalid(scan.heights), tuple(sides))
    heights: Array = np.asarray(holed.interpolate_undefined_data().heights())
    return heights


def form_words(radii: tuple[float, float]) -> str:
    """Radii of curvature along x and y [m] in words; empty if the surface is flat."""
    known = zip("xy", radii, strict=True)
    texts = (f"{display(r, 'mm', 3)} along {axis}" for axis, r in known if np.isfinite(r))
    return " and ".join(texts)


def _cropped(heights: Array, table: Mapping[str, Any], pixels: tuple[int, int]) -> Array:
    if table["crop"] is None:
        return heights
    (i, j), (rows, columns) = table["crop"], pixels
    if table["repeat"] != "no":
        left = np.subtract(heights.shape, table["crop"])
        rows, columns = np.minimum(pixels, np.maximum(left, 1)).tolist()
    if i + rows > heights.shape[0] or j + columns > heights.shape[1]:
        raise InputError(
            f"a patch of {rows} × {columns} heights in x and y from {i}, {j} on (crop) extends "
            f"beyond the surface of {heights.shape[0]} × {heights.shape[1]}; begin at lower "
            "numbers, or give fewer window.pixels"
        )
    return heights[i : i + rows, j : j + columns]
