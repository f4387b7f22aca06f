"""Areas of a scan that a scene simulates: cut out, levelled, filled and mirrored."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.quantities import display
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
    min_count = 1 if is_mirrored else 0
    return max(shape[0] // pixels[0], min_count), max(shape[1] // pixels[1], min_count)


def window_heights(
    scan: Array,
    table: Mapping[str, Any],
    pixels: tuple[int, int],
    sides: tuple[float, float],
    areas: Sequence[int],
) -> tuple[Array, list[str]]:
    """Heights [m] of the first of some `areas` of a scan, and notes on how they were changed.

    `table` has the entries of ``disk.roughness``; `pixels` and `sides` [m] are those of the window.
    The areas lie side by side in the middle of the scan, and are numbered from 0, along x first.
    """
    heights, notes = _area(scan, pixels, table["mirror"], areas)
    if table["level"]:
        heights, _, radii = remove_form(heights, sides)
        if radius_words := form_words(radii):
            notes.append(f"curvature removed: R {radius_words}")
    if np.isnan(heights).any():
        notes.append(f"{_missing_words(heights)} and were filled from their surroundings")
        heights = filled(heights, table["missing"])
    if heights.shape != pixels:
        notes.append(
            f"{heights.shape[0]} × {heights.shape[1]} heights were mirrored to fill the window of "
            f"{pixels[0]} × {pixels[1]}, so that the surface repeats itself and the error by "
            "surface sampling is larger"
        )
        missing_x, missing_y = np.subtract(pixels, heights.shape).tolist()
        heights = np.pad(heights, [(0, missing_x), (0, missing_y)], "symmetric")
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
            "fewer window.pixels or a larger scan, or mirror the scan at its edges, mirror = true"
        )
    if max(numbers) >= count:
        raise InputError(
            f"the scan has {count} areas of {size} heights, numbered from 0; there is no area "
            f"{max(numbers)}: give fewer sweep.realizations, or fewer window.pixels"
        )
    row, column = divmod(numbers[0], areas[0])
    slices = list[slice]()
    for axis, index in enumerate((column, row)):
        margin = (shape[axis] - areas[axis] * pixels[axis]) // 2
        start = max(0, margin + index * pixels[axis])
        slices.append(slice(start, start + pixels[axis]))
    area = heights[tuple(slices)]
    if area.shape == shape:
        return area, []
    return area, [
        f"the scan of {shape[0]} × {shape[1]} heights has {count} areas of the window's size; "
        f"{len(numbers)} are simulated (sweep.realizations)"
    ]


def _missing_words(heights: Array) -> str:
    """Number and share of missing heights in words."""
    missing = int(np.isnan(heights).sum())
    share = 100 * missing / heights.size
    return f"{missing} of {heights.size} heights ({share:.2g} %) are missing"


def filled(heights: Array, max_share: float) -> Array:
    """Heights [m] in which each missing one is the mean of its two to four neighbours.

    This is Laplace's equation. An `InputError` is raised if the share of missing heights is above
    `max_share`.
    """
    from scipy import sparse  # slow to import

    is_hole = np.isnan(heights)
    if is_hole.sum() > max_share * heights.size:
        first = np.argwhere(is_hole)[0].tolist()
        raise InputError(
            f"{_missing_words(heights)}, the first at x {first[0]}, y {first[1]} (counted from 0); "
            f"at most {100 * max_share:.2g} % are filled; measure again, or allow more (missing)"
        )
    x, y = np.nonzero(is_hole)
    hole_numbers = np.full(heights.shape, -1)
    hole_numbers[x, y] = np.arange(len(x))
    neighbour_count, known_sum = np.zeros(len(x)), np.zeros(len(x))
    holes, neighbour_holes = list[Indices](), list[Indices]()
    for step_x, step_y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        neighbour_x, neighbour_y = x + step_x, y + step_y
        is_inside = (neighbour_x >= 0) & (neighbour_y >= 0)
        is_inside &= (neighbour_x < heights.shape[0]) & (neighbour_y < heights.shape[1])
        numbers = np.flatnonzero(is_inside)
        neighbours = neighbour_x[is_inside], neighbour_y[is_inside]
        is_neighbour_hole = is_hole[neighbours]
        neighbour_count[numbers] += 1
        known_sum[numbers] += np.where(is_neighbour_hole, 0.0, heights[neighbours])
        holes.append(numbers[is_neighbour_hole])
        neighbour_holes.append(hole_numbers[neighbours][is_neighbour_hole])
    pairs = np.concatenate(holes), np.concatenate(neighbour_holes)
    adjacency = sparse.coo_array((np.ones(len(pairs[0])), pairs), (len(x), len(x)))
    laplace = (sparse.diags_array(neighbour_count) - adjacency).tocsc()
    filled_heights = heights.copy()
    filled_heights[is_hole] = sparse.linalg.spsolve(laplace, known_sum)
    return filled_heights


def form_words(radii: tuple[float, float]) -> str:
    """Radii of curvature along x and y [m] in words; empty if the surface is flat."""
    axis_radii = zip("xy", radii, strict=True)
    return " and ".join(
        f"{display(radius, 'mm', 3)} along {axis}"
        for axis, radius in axis_radii
        if np.isfinite(radius)
    )
