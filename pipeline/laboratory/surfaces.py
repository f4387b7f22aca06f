"""Measured surfaces: read, orient and level them, and fill their holes."""

from __future__ import annotations

import os
import tokenize
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.laboratory.instruments import RawScan, read_instrument
from pipeline.paths import kind_of, open_regular, read_file, reason_of, user_path
from pipeline.quantities import display, display_sides
from pipeline.scene.faults import Faults
from tribo import InputError
from tribo.surface.areal import remove_form
from tribo.types import Array

_MOST_BYTES = 2**30  # largest file, unpacked
_SAME = 0.01  # relative difference below which two lengths agree
_INFINITE = 1e100  # height [m] that stands for none; squares of higher ones may overflow
_LONE = 30.0  # distance of an outlier from all other heights, in their standard deviations


def axis_note(transpose: bool) -> str:
    """Sentence that says how sliding runs in a surface's file.

    Sliding runs along the file's rows or, if `transpose`, along its columns.
    """
    lines, name = ("row", "y") if transpose else ("column", "x")
    return f"x, the sliding direction, goes from {lines} to {lines}, or along the file's {name}"


@dataclass(frozen=True, slots=True)
class MeasuredSurface:
    """Heights [m], shape (nx, ny), positive outwards, NaN in holes; sides of a pixel [m]."""

    heights: Array
    pixel_size: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()  # notes on holes, and on arguments that override the file
    steps: tuple[float, float] | None = None  # sides of a pixel in an unknown unit

    def replace_pixels(self, sides: tuple[float, float]) -> MeasuredSurface:
        """Copy with other sides of a pixel [m], whose ratio must be the same as in the file."""
        own, notes = self.pixel_size or self.steps, self.notes
        if own and abs(own[0] / own[1] * sides[1] / sides[0] - 1) > _SAME:
            known = display_sides(own) if self.pixel_size else f"as {own[0]:.4g} to {own[1]:.4g}"
            raise InputError(
                f"pixels of {display_sides(sides)} are given, but the file's are {known}; "
                "give the same ratio, or leave them out"
            )
        if self.pixel_size and not np.allclose(self.pixel_size, sides, rtol=_SAME, atol=0):
            notes += (f"the given pixels replace the file's {display_sides(self.pixel_size)}",)
        return replace(self, pixel_size=sides, notes=notes)


def read_surface(path: str | Path, height_unit: float | None = None) -> MeasuredSurface:
    """Read a measured surface from a plain array, text, or the file of an instrument.

    In every format x increases along the rows of the file, and y is equal in a row. `height_unit`,
    the length of one unit of height [m], replaces the file's unit. Infinite heights and isolated
    outliers become holes. Raises an `InputError` if the unit is missing, the file is not a surface,
    or the optional packages for its format are not installed.
    """
    path = user_path(path)
    raw = read_raw(path)
    unit = raw.unit if height_unit is None else height_unit
    if not unit or unit < 0:
        lacks = "" if raw.pixel else "; and pixel_size, if it is not given"
        raise InputError(f"{path}: the file states no unit of its heights; give height_unit{lacks}")
    notes = list[str]()
    if raw.unit and not np.isclose(raw.unit, unit, rtol=_SAME, atol=0):
        notes.append(f"the given height unit, {unit:g} m, replaces the file's, {raw.unit:g} m")
    heights = raw.heights.astype(np.float64) * unit
    infinite = np.abs(heights) > _INFINITE
    heights[infinite] = np.nan
    count = np.count_nonzero(infinite)
    notes += [f"{count} infinite heights are taken for holes"] if count else []
    notes += _remove_outliers(heights, unit)
    if raw.places is not None or min(heights.shape) < 2:
        _refuse_profile(path, heights)
    return MeasuredSurface(np.ascontiguousarray(heights), raw.pixel, tuple(notes), raw.steps)


def read_raw(path: Path) -> RawScan:
    """Read heights as in a file, whose content tells its format; errors as in `read_surface`."""
    try:
        os.close(open_regular(path))  # a FIFO would be waited for
        _require_size(path)
        content = read_file(path)
        if content.startswith(b"\x93NUMPY"):
            return _read_array(path)
        if kind_of(content) or content.startswith(b"PK"):
            return read_instrument(path)
        if path.suffix.lower() in (".txt", ".csv"):
            return _read_text(path)
        try:  # a text of an instrument, or one with an ending of its own
            return read_instrument(path)
        except InputError:
            with suppress(InputError):
                return _read_text(path)
            raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error


def _require_size(path: Path) -> None:
    """Raise an `InputError` for a file that takes too much memory, also once it is unpacked."""
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise InputError(
            f"{path}: {size / 2**30:.1f} GiB; at most {_MOST_BYTES / 2**30:g} GiB are read. "
            "Crop or average the surface first"
        )


def _read_text(path: Path) -> RawScan:
    """Read a matrix of heights in text, a row for each y, with commas or blanks between them."""
    try:
        between = "," if "," in path.read_text(encoding="utf-8-sig").partition("\n")[0] else None
        return RawScan(np.loadtxt(path, delimiter=between, ndmin=2).T)
    except ValueError as error:
        raise InputError(f"{path}: not a plain matrix of numbers: {error}") from error


def _read_array(path: Path) -> RawScan:
    """Read heights (nx, ny), in the file's unit, from a .npy array (ny, nx); or a profile (n,)."""
    try:
        with path.open("rb") as file:
            array = np.lib.format.read_array(file, allow_pickle=False)
    except (ValueError, EOFError, tokenize.TokenError, MemoryError) as error:
        raise InputError(f"{path}: not a plain array of numbers: {error}") from error
    if array.ndim == 1 and array.size > 1 and array.dtype.kind in "fiu":
        line = array.astype(np.float64)[:, None]
        return RawScan(line, places=np.arange(array.size, dtype=float))
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "fiu":
        raise InputError(
            f"{path}: an array of shape {array.shape} and type {array.dtype}; needed are "
            "two-dimensional real numbers, a row for each y"
        )
    return RawScan(array.T.astype(np.float64))


def _remove_outliers(heights: Array, unit: float) -> list[str]:
    """Turn isolated outliers such as −9999 into holes, in place; note each in the file's `unit`."""
    notes = list[str]()
    values = heights[np.isfinite(heights)]
    while values.size > 2:
        far = values[np.argmax(np.abs(values - np.median(values)))]
        others = values[values != far]
        if not (others.size and np.abs(others - far).min() > _LONE * others.std() > 0):
            break
        count = values.size - others.size
        notes.append(f"{count} heights of {far / unit:.6g} are taken for holes")
        heights[heights == far] = np.nan
        values = others
    return notes


def _refuse_profile(path: Path, heights: Array) -> None:
    """Raise an `InputError`: `heights` [m] are of profiles, and not a map."""
    level = np.stack([line - np.nanmean(line) for line in np.atleast_2d(heights.T)])
    ra = display(float(np.nanmean(np.abs(level))), "µm", 3)
    raise InputError(
        f"{path}: a profile of {max(heights.shape)} heights, Ra {ra} unfiltered; a surface needs a "
        f"map of heights. Its roughness is printed by: irg surface {path}"
    )


def oriented(
    surface: MeasuredSurface, transpose: bool = False, flip: bool = False
) -> MeasuredSurface:
    """Exchange x and y of a surface if `transpose`; change the sign of its heights if `flip`."""
    heights, sides = surface.heights, surface.pixel_size
    if transpose:
        heights, sides = heights.T, sides and (sides[1], sides[0])
    heights = -heights if flip else heights
    steps = surface.steps and (surface.steps[::-1] if transpose else surface.steps)
    return MeasuredSurface(np.ascontiguousarray(heights), sides, surface.notes, steps)


def form_words(radii: tuple[float, float]) -> str:
    """Radii of curvature along x and y in words; empty if the surface is flat."""
    known = zip("xy", radii, strict=True)
    texts = (f"{display(r, 'mm', 3)} along {axis}" for axis, r in known if np.isfinite(r))
    return " and ".join(texts)


def filled(heights: Array) -> Array:
    """Copy heights (nx, ny) [m], and fill holes, which are NaN, by Laplace's equation.

    Each filled height is the mean of its neighbours. Raises an `InputError` if all are missing.
    """
    from scipy import sparse  # takes 0.1 s, and few surfaces have holes
    from scipy.sparse.linalg import spsolve

    missing = ~np.isfinite(heights)
    if missing.all():
        raise InputError("all heights are missing")
    if not missing.any():
        return heights.copy()
    # With a border of zeros each height has four neighbours, found by offsets in a flat array.
    is_hole, is_inside, known = (
        np.pad(array, 1).ravel()
        for array in (missing, np.ones_like(missing), np.where(missing, 0.0, heights))
    )
    holes, number, width = np.flatnonzero(is_hole), np.cumsum(is_hole) - 1, heights.shape[1] + 2
    beside = holes[:, None] + [width, -width, 1, -1]
    # In a hole each height is the mean of its neighbours (Laplace's equation).
    rows, sides = np.nonzero(is_hole[beside])
    links = rows, number[beside[rows, sides]]
    off = sparse.csc_matrix((-np.ones(len(rows)), links), shape=2 * (len(holes),))
    neighbours = is_inside[beside].sum(axis=1).astype(float)
    result = heights.copy()
    system = sparse.diags(neighbours, format="csc") + off
    result[missing] = spsolve(system, known[beside].sum(axis=1))
    return result


def window_heights(
    table: Mapping[str, Any], window: Mapping[str, Any], file: Path, faults: Faults
) -> Array | None:
    """Heights of a measured surface [m] for the scene's window; None if it has no usable heights.

    `table` and `window` are the entries ``disk.roughness`` and ``window`` of the scene. Faults and
    notes are added to `faults`; a wrong size of pixels is a fault, but does not make the result
    None. Raises an `InputError` if the file cannot be read.
    """
    surface = oriented(read_surface(file, table["height_unit"]), table["transpose"], table["flip"])
    if table["pixel_size"]:
        surface = surface.replace_pixels(table["pixel_size"])
    pixels, sides = window.get("pixels"), window.get("pixel_size")
    if surface.pixel_size and sides and not np.allclose(surface.pixel_size, sides, rtol=0.01):
        size = " × ".join(display(side, "µm") for side in surface.pixel_size)
        problem = f"the pixels of disk.roughness.file are {size}; give those"
        faults.refuse("window.pixel_size", problem)
    heights: Array | None = surface.heights
    if table["crop"] is not None and pixels:
        heights = _cropped(surface.heights, table, pixels, faults)
    notes = surface.notes
    if heights is not None and table["level"]:
        heights, _, radii = remove_form(heights, sides or (1.0, 1.0))
        curved = form_words(radii) if sides else ""
        notes += (f"curvature removed: R {curved}",) if curved else ()
    if heights is None or (heights := _fill_holes(heights, table["missing"], faults)) is None:
        return None
    if table["repeat"] != "no" and pixels and np.less(heights.shape, pixels).any():
        is_mirrored = table["repeat"] == "mirror"  # continuous; tiles have steps, but keep a lay
        faults.note(
            "disk.roughness.file",
            f"{heights.shape[0]} × {heights.shape[1]} heights were "
            f"{'mirrored' if is_mirrored else 'tiled'} to fill the window of {pixels[0]} × "
            f"{pixels[1]}, so that the surface repeats itself",
        )
        more = np.maximum(0, np.subtract(pixels, heights.shape)).tolist()
        heights = np.pad(heights, [(0, n) for n in more], "symmetric" if is_mirrored else "wrap")
    levelled_words = ", levelled" if table["level"] else ""
    noted = f"{file.name}{levelled_words}; {axis_note(table['transpose'])}"
    for note in (*notes, noted):
        faults.note("disk.roughness.file", note)
    return heights


def _cropped(
    heights: Array, table: Mapping[str, Any], pixels: tuple[int, int], faults: Faults
) -> Array | None:
    """Cut the window's patch out of a scan's heights [m]; None, with a fault, if it is outside."""
    (i, j), (rows, columns) = table["crop"], pixels
    if table["repeat"] != "no":
        left = np.subtract(heights.shape, table["crop"])
        rows, columns = np.minimum(pixels, np.maximum(left, 1)).tolist()
    if i + rows > heights.shape[0] or j + columns > heights.shape[1]:
        faults.refuse(
            "disk.roughness.crop",
            f"a patch of {rows} × {columns} heights in x and y from {i}, {j} on extends beyond "
            f"the surface of {heights.shape[0]} × {heights.shape[1]}; begin at lower numbers, or "
            "give fewer window.pixels",
        )
        return None
    return heights[i : i + rows, j : j + columns]


def _fill_holes(heights: Array, missing: str, faults: Faults) -> Array | None:
    """Copy heights [m] with holes (NaN) filled; None, with a fault, if they cannot be."""
    holes = np.argwhere(~np.isfinite(heights))
    if not len(holes):
        return heights
    if len(holes) == heights.size:
        faults.refuse("disk.roughness.file", "all heights are missing; give another file")
        return None
    share = f"{len(holes)} of {heights.size} heights ({100 * len(holes) / heights.size:.2g} %)"
    if missing == "refuse":
        i, j = holes[0].tolist()
        problem = (
            f"{share} are missing, the first at x {i}, y {j} (counted from 0); crop them, or "
            'give "fill"'
        )
        faults.refuse("disk.roughness.missing", problem)
        return None
    words = f"{share} are missing and were filled from their surroundings"
    faults.note("disk.roughness.file", words)
    return filled(heights)
