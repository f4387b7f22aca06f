"""Areas of a scan that a scene simulates: cut out, levelled, filled and mirrored."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.quantities import display, display_sides
from pipeline.surface.scan import Scan
from tribo import InputError
from tribo.surface.areal import remove_form
from tribo.types import Array, Indices


def areas_of(shape: tuple[int, ...], pixels: tuple[int, int], is_mirrored: bool) -> tuple[int, int]:
    """Numbers of areas of the window's size that a scan has side by side along x and y.

    A scan that is smaller than the window has none, or one if it is mirrored.

    Examples
    --------
    >>> areas_of((1000, 300), (480, 480), False), areas_of((1000, 300), (480, 480), True)
    ((2, 0), (2, 1))
    """
    along_x, along_y = (
        max(count // wanted, int(is_mirrored)) for count, wanted in zip(shape, pixels, strict=True)
    )
    return along_x, along_y


def window_heights(
    scan: Scan,
    table: Mapping[str, Any],
    pixels: tuple[int, int],
    sides: tuple[float, float],
    wanted: Sequence[int] = (0,),
) -> tuple[Array, list[str]]:
    """Heights [m] of the first of the `wanted` areas of a scan, and notes on what was done to them.

    `table` has the entries of ``disk.roughness``; `pixels` and `sides` [m] are those of the window.
    The areas lie side by side in the middle of the scan, and are numbered from 0, along x first.
    """
    if not np.allclose(scan.pixel_size, sides, rtol=0.01):
        raise InputError(
            f"its pixels are {display_sides(scan.pixel_size)}; give those, window.pixel_size"
        )
    heights, notes = _area(scan.heights, pixels, table["mirror"], wanted)
    notes = [*scan.notes, *notes]
    if table["level"]:
        heights, _, radii = remove_form(heights, sides)
        curved = form_words(radii)
        notes += [f"curvature removed: R {curved}"] if curved else []
    part = Scan(heights, scan.pixel_size)
    if part.missing:
        heights = filled(part, table["missing"])
        notes.append(f"{part.missing_words} and were filled from their surroundings")
    if heights.shape != pixels:
        notes.append(
            f"{heights.shape[0]} × {heights.shape[1]} heights were mirrored to fill the window of "
            f"{pixels[0]} × {pixels[1]}, so that the surface repeats itself: a single area "
            "understates the error by surface sampling"
        )
        more = np.subtract(pixels, heights.shape).tolist()
        heights = np.pad(heights, [(0, n) for n in more], "symmetric")
    return np.ascontiguousarray(heights), notes


def _area(
    heights: Array, pixels: tuple[int, int], is_mirrored: bool, wanted: Sequence[int]
) -> tuple[Array, list[str]]:
    """Heights of the first of the `wanted` areas of a scan, and a note if the scan has more."""
    shape, size = heights.shape, f"{pixels[0]} × {pixels[1]}"
    areas = areas_of(shape, pixels, is_mirrored)
    if not (count := math.prod(areas)):
        raise InputError(
            f"the scan has {shape[0]} × {shape[1]} heights along x and y, the window {size}; give "
            "fewer window.pixels, or mirror the scan at its edges, mirror = true"
        )
    if max(wanted) >= count:
        raise InputError(
            f"the scan has {count} areas of {size} heights, numbered from 0; there is no area "
            f"{max(wanted)}: give fewer sweep.realizations, or fewer window.pixels"
        )
    place = wanted[0] % areas[0], wanted[0] // areas[0]
    begins = [
        max(0, (n - m * p) // 2 + k * p)
        for n, m, p, k in zip(shape, areas, pixels, place, strict=True)
    ]
    cut = heights[tuple(slice(at, at + p) for at, p in zip(begins, pixels, strict=True))]
    note = f"the scan of {shape[0]} × {shape[1]} heights has {count} areas of the window's size; "
    note += f"{len(wanted)} are simulated (sweep.realizations)"
    return cut, [note] * (cut.shape != shape)


def filled(scan: Scan, most: float) -> Array:
    """Heights [m] with the missing ones as the mean of their neighbours (Laplace's equation).

    An `InputError` if more than a share `most` is missing.
    """
    if scan.missing > most * scan.heights.size:
        first = np.argwhere(np.isnan(scan.heights))[0].tolist()
        raise InputError(
            f"{scan.missing_words}, the first at x {first[0]}, y {first[1]} (counted from 0); "
            f"at most {100 * most:.2g} % are filled; measure again, or allow more (missing)"
        )
    return _harmonic(scan.heights) if scan.missing else scan.heights


def _harmonic(heights: Array) -> Array:
    """Heights in which each missing one is the mean of its two to four neighbours."""
    from scipy import sparse  # slow to import

    holes, number = np.isnan(heights), np.full(heights.shape, -1)
    i, j = np.nonzero(holes)
    number[i, j] = every = np.arange(len(i))
    degree, known = np.zeros(len(i)), np.zeros(len(i))
    rows, columns = list[Indices](), list[Indices]()
    for step_i, step_j in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        near_i, near_j = i + step_i, j + step_j
        inside = (near_i >= 0) & (near_j >= 0)
        inside &= (near_i < heights.shape[0]) & (near_j < heights.shape[1])
        own, near = every[inside], (near_i[inside], near_j[inside])
        degree[own] += 1
        known[own] += np.where(holes[near], 0.0, heights[near])
        rows.append(own[holes[near]])
        columns.append(number[near][holes[near]])
    pairs = np.concatenate(rows), np.concatenate(columns)
    beside = sparse.coo_array((np.ones(len(pairs[0])), pairs), (len(i), len(i)))
    whole = heights.copy()
    laplace = (sparse.diags_array(degree) - beside).tocsc()
    whole[holes] = sparse.linalg.spsolve(laplace, known)
    return whole


def form_words(radii: tuple[float, float]) -> str:
    """Radii of curvature along x and y [m] in words; empty if the surface is flat."""
    known = zip("xy", radii, strict=True)
    texts = (f"{display(r, 'mm', 3)} along {axis}" for axis, r in known if np.isfinite(r))
    return " and ".join(texts)
