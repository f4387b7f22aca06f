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
        max(heights // side, int(is_mirrored)) for heights, side in zip(shape, pixels, strict=True)
    )
    return along_x, along_y


def window_heights(
    scan: Scan,
    table: Mapping[str, Any],
    pixels: tuple[int, int],
    sides: tuple[float, float],
    areas: Sequence[int] = (0,),
) -> tuple[Array, list[str]]:
    """Heights [m] of the first of some `areas` of a scan, and notes on how they were changed.

    `table` has the entries of ``disk.roughness``; `pixels` and `sides` [m] are those of the window.
    The areas lie side by side in the middle of the scan, and are numbered from 0, along x first.
    """
    if not np.allclose(scan.pixel_size, sides, rtol=0.01):
        raise InputError(
            f"its pixels are {display_sides(scan.pixel_size)}; give those, window.pixel_size"
        )
    heights, notes = _area(scan.heights, pixels, table["mirror"], areas)
    notes = [*scan.notes, *notes]
    if table["level"]:
        heights, _, radii = remove_form(heights, sides)
        radius_words = form_words(radii)
        notes += [f"curvature removed: R {radius_words}"] if radius_words else []
    area = Scan(heights, scan.pixel_size)
    if area.missing:
        heights = filled(area, table["missing"])
        notes.append(f"{area.missing_words} and were filled from their surroundings")
    if heights.shape != pixels:
        notes.append(
            f"{heights.shape[0]} × {heights.shape[1]} heights were mirrored to fill the window of "
            f"{pixels[0]} × {pixels[1]}, so that the surface repeats itself and the error by "
            "surface sampling is larger"
        )
        padding = np.subtract(pixels, heights.shape).tolist()
        heights = np.pad(heights, [(0, n) for n in padding], "symmetric")
    return np.ascontiguousarray(heights), notes


def _area(
    heights: Array, pixels: tuple[int, int], is_mirrored: bool, numbers: Sequence[int]
) -> tuple[Array, list[str]]:
    """Heights of the first of the areas with `numbers`, and a note if the scan has more areas."""
    shape, size = heights.shape, f"{pixels[0]} × {pixels[1]}"
    areas = areas_of(shape, pixels, is_mirrored)
    if not (count := math.prod(areas)):
        raise InputError(
            f"the scan has {shape[0]} × {shape[1]} heights along x and y, the window {size}; give "
            "fewer window.pixels, or mirror the scan at its edges, mirror = true"
        )
    if max(numbers) >= count:
        raise InputError(
            f"the scan has {count} areas of {size} heights, numbered from 0; there is no area "
            f"{max(numbers)}: give fewer sweep.realizations, or fewer window.pixels"
        )
    position = numbers[0] % areas[0], numbers[0] // areas[0]
    starts = [
        max(0, (n - m * p) // 2 + k * p)
        for n, m, p, k in zip(shape, areas, pixels, position, strict=True)
    ]
    area = heights[tuple(slice(start, start + p) for start, p in zip(starts, pixels, strict=True))]
    note = f"the scan of {shape[0]} × {shape[1]} heights has {count} areas of the window's size; "
    note += f"{len(numbers)} are simulated (sweep.realizations)"
    return area, [note] if area.shape != shape else []


def filled(scan: Scan, max_share: float) -> Array:
    """Heights [m] with the missing ones as the mean of their neighbours (Laplace's equation).

    An `InputError` if the share of missing heights is above `max_share`.
    """
    if scan.missing > max_share * scan.heights.size:
        first = np.argwhere(np.isnan(scan.heights))[0].tolist()
        raise InputError(
            f"{scan.missing_words}, the first at x {first[0]}, y {first[1]} (counted from 0); "
            f"at most {100 * max_share:.2g} % are filled; measure again, or allow more (missing)"
        )
    return _harmonic(scan.heights) if scan.missing else scan.heights


def _harmonic(heights: Array) -> Array:
    """Heights in which each missing one is the mean of its two to four neighbours."""
    from scipy import sparse  # slow to import

    is_hole, unknowns = np.isnan(heights), np.full(heights.shape, -1)
    i, j = np.nonzero(is_hole)
    unknowns[i, j] = hole_numbers = np.arange(len(i))
    degree, known_sum = np.zeros(len(i)), np.zeros(len(i))
    rows, columns = list[Indices](), list[Indices]()
    for step_i, step_j in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        neighbour_i, neighbour_j = i + step_i, j + step_j
        is_inside = (neighbour_i >= 0) & (neighbour_j >= 0)
        is_inside &= (neighbour_i < heights.shape[0]) & (neighbour_j < heights.shape[1])
        rows_inside = hole_numbers[is_inside]
        neighbour = neighbour_i[is_inside], neighbour_j[is_inside]
        degree[rows_inside] += 1
        known_sum[rows_inside] += np.where(is_hole[neighbour], 0.0, heights[neighbour])
        rows.append(rows_inside[is_hole[neighbour]])
        columns.append(unknowns[neighbour][is_hole[neighbour]])
    pairs = np.concatenate(rows), np.concatenate(columns)
    adjacency = sparse.coo_array((np.ones(len(pairs[0])), pairs), (len(i), len(i)))
    filled_heights = heights.copy()
    laplace = (sparse.diags_array(degree) - adjacency).tocsc()
    filled_heights[is_hole] = sparse.linalg.spsolve(laplace, known_sum)
    return filled_heights


def form_words(radii: tuple[float, float]) -> str:
    """Radii of curvature along x and y [m] in words; empty if the surface is flat."""
    axis_radii = zip("xy", radii, strict=True)
    texts = (f"{display(r, 'mm', 3)} along {axis}" for axis, r in axis_radii if np.isfinite(r))
    return " and ".join(texts)
