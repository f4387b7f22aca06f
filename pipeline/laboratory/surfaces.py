"""Measured surfaces: reading their files, turning them, taking off planes and filling holes."""

from __future__ import annotations

import importlib.util
import warnings
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pipeline.laboratory.plain_scan import read_heights
from pipeline.laboratory.spreadsheet import unpacked_size
from pipeline.laboratory.text_scan import TEXT, read_text
from pipeline.quantities import display, display_sides
from pipeline.scene.faults import Faults
from tribo import InputError
from tribo.errors import reason_of, require_file
from tribo.types import Array

_MOST_BYTES = 2**30  # that an archive may unpack to
_SAME = 0.01  # share of a length within which two say the same
_STEEPEST = 20.0  # tilt [°] that leaves no pixel of an instrument its height
_IMAGES = (".tif", ".tiff", ".png", ".jpg", ".jpeg", ".bmp", ".gif")


def axis_note(transpose: bool) -> str:
    """Direction of sliding in the file, in words."""
    lines, name = ("row", "y") if transpose else ("column", "x")
    return (
        f"x, the sliding direction, is along the {lines}s of the file: from {lines} to {lines}, or "
        f"the {name} that it names"
    )


@dataclass(frozen=True, slots=True)
class MeasuredSurface:
    """Heights [m], shape (nx, ny), outwards, NaN in holes; known sides of a pixel [m]."""

    heights: Array
    pixel_size: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()  # on what the file says and a user says otherwise

    def replace_pixels(self, sides: tuple[float, float]) -> MeasuredSurface:
        """The surface with other sides of a pixel than the file says [m]."""
        own, notes = self.pixel_size, self.notes
        if own and not np.allclose(own, sides, rtol=_SAME, atol=0):
            notes += (f"the given pixels count, not those of the file, {display_sides(own)}",)
        return MeasuredSurface(self.heights, sides, notes)


def read_surface(path: str | Path, height_unit: float | None = None) -> MeasuredSurface:
    """A measured surface from a plain array, text, or a file of SurfaceTopography's formats.

    In each x goes from column to column of the file, and a line of it is one of equal y.
    The length of one unit of the heights [m] goes before what the file says. Raise an `InputError`
    if it is missing, the file is no surface, or the extra for its format is not installed.
    """
    path = Path(path)
    if path.suffix.lower() in TEXT:
        return _read_text_file(path, height_unit)
    if path.suffix.lower() != ".npy":
        return _read_instrument(path, height_unit)
    if height_unit is None:
        raise InputError(f"{path}: a plain array has no unit of its own; give height_unit")
    return MeasuredSurface(read_heights(path, height_unit))


def _read_text_file(path: Path, height_unit: float | None) -> MeasuredSurface:
    """A surface of text, whose comments may say the unit and the size of its pixels."""
    require_file(path)
    try:
        heights, pixel_size, said = read_text(path)
    except InputError:
        knows_more = importlib.util.find_spec("SurfaceTopography") is not None
        if path.suffix.lower() not in (".csv", ".xyz") and knows_more:
            with suppress(InputError):  # an instrument's own text
                return _read_instrument(path, height_unit)
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    if (unit := height_unit or said) is None:
        raise InputError(f"{path}: the text says no unit of its heights; give height_unit")
    heights = heights * unit
    if (infinite := np.argwhere(np.isinf(heights))).size:
        column, row = infinite[0].tolist()
        raise InputError(
            f"{path}: the height at row {row}, column {column} (counted from 0) is infinite; write "
            "holes as NaN"
        )
    return MeasuredSurface(heights, pixel_size, _unit_note(said, height_unit))


def _unit_note(own: float | None, given: float | None) -> tuple[str, ...]:
    """A note where a unit [m] is given that is not the file's own."""
    if own is None or given is None or np.isclose(own, given, rtol=_SAME, atol=0):
        return ()
    return (f"the given height unit counts, {given:g} m, not that of the file, {own:g} m",)


def _read_instrument(path: Path, height_unit: float | None) -> MeasuredSurface:
    """A surface of one of SurfaceTopography's formats."""
    _require_small_file(path)
    if path.suffix.lower() in _IMAGES:
        raise InputError(
            f"{path}: an image, whose grey values are no heights of a known unit; export the "
            "heights from the instrument's software as .x3p, .sur, text or .npy"
        )
    try:
        formats: Any = importlib.import_module("SurfaceTopography.IO")
    except ImportError as error:
        raise InputError(
            f"{path}: not a plain array, which ends in .npy or .csv; if an instrument wrote it, "
            "SurfaceTopography may know its format: get that with "
            '"pip install SurfaceTopography", or save the heights as .npy'
        ) from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it warns of its own house-keeping
            topography = formats.open_topography(str(path)).topography()
            return _converted(path, topography, height_unit)
    except InputError:
        raise
    except Exception as error:  # readers of damaged files raise errors of any kind
        reason = str(error).strip().splitlines()[:1] or [type(error).__name__]
        if type(error).__name__ == "CannotDetectFileFormat":
            reason = ["its format is not known; save the heights as .npy or .csv"]
        elif "physical_sizes" in reason[0]:  # an option of the library, which a scene does not have
            said = "it is cut off, or does not say how large its pixels are"
            reason = [f"{said}; save the heights as .npy or .csv"]
        raise InputError(f"{path}: cannot be read as a surface: {reason[0]}") from error


def _require_small_file(path: Path) -> None:
    """Raise for a file without an end, and for an archive that unpacks to more than a surface."""
    require_file(path)
    size = unpacked_size(path) if zipfile.is_zipfile(path) else 0
    if size > _MOST_BYTES:
        raise InputError(
            f"{path}: unpacks to {size / 2**30:.1f} GiB; at most {_MOST_BYTES / 2**30:g} GiB are "
            "read. Crop or average the surface first"
        )


def _converted(path: Path, topography: Any, height_unit: float | None) -> MeasuredSurface:
    """Copy what a topography of the library holds, in metres."""
    if topography.dim != 2 or not topography.is_uniform:
        raise InputError(
            f"{path}: a profile, or unevenly spaced; give a map of heights on a regular grid"
        )
    pixel_size, own, heights = None, None, topography.heights() * (height_unit or 1.0)
    if topography.unit is not None:
        in_metres = topography.to_unit("m")
        pixel_size = float(in_metres.pixel_size[0]), float(in_metres.pixel_size[1])
        own = pixel_size[0] / float(topography.pixel_size[0])
        heights = in_metres.heights() if height_unit is None else heights
    elif height_unit is None:
        raise InputError(
            f"{path}: the file does not give the unit of its heights; give height_unit"
        )
    copied = np.ma.filled(np.ma.masked_invalid(np.ma.array(heights, dtype=np.float64)), np.nan)
    return MeasuredSurface(np.ascontiguousarray(copied), pixel_size, _unit_note(own, height_unit))


Flip = Literal["no", "x", "y", "heights"]


def oriented(
    surface: MeasuredSurface, transpose: bool = False, flip: Flip = "no"
) -> MeasuredSurface:
    """A surface with x and y exchanged, pixels too, and then an axis or the heights reversed."""
    heights, sides = surface.heights, surface.pixel_size
    if transpose:
        heights, sides = heights.T, sides and (sides[1], sides[0])
    if flip == "heights":
        heights = -heights
    elif flip != "no":
        heights = np.flip(heights, "xy".index(flip))
    return MeasuredSurface(np.ascontiguousarray(heights), sides, surface.notes)


def levelled(heights: Array) -> Array:
    """Heights above their least-squares plane [m]; NaN stays NaN."""
    measured = np.isfinite(heights)
    i, j = np.indices(heights.shape) / max(heights.shape)
    terms = np.stack([np.ones(heights.shape), i, j], axis=-1)
    plane, *_ = np.linalg.lstsq(terms[measured], heights[measured], rcond=None)
    level: Array = heights - terms @ plane
    return level


def tilts(heights: Array, level: Array, sides: tuple[float, float]) -> tuple[float, float]:
    """Angles by which a plane that was taken off rises along x and y [°]."""
    corner = (heights - level)[:2, :2]
    rises = np.diff(corner, axis=0)[0, 0] / sides[0], np.diff(corner, axis=1)[0, 0] / sides[1]
    x, y = np.degrees(np.arctan(rises)).tolist()
    return x, y


def tilt_doubts(angles: tuple[float, float]) -> tuple[str, ...]:
    """A doubt where a scan is steeper than any that an instrument can measure [°]."""
    if (steepest := max(map(abs, angles))) <= _STEEPEST:
        return ()
    return (
        f"the scan is tilted by {steepest:.3g}°: check the unit of the heights and the size of the "
        "pixels",
    )


def filled(heights: Array) -> Array:
    """Heights with a membrane over each hole, the harmonic function that continues them [m]."""
    from scipy import sparse  # takes 0.1 s, and few surfaces have holes
    from scipy.sparse.linalg import spsolve

    missing = ~np.isfinite(heights)
    if missing.all():
        raise InputError("all heights are missing")
    if not missing.any():
        return heights.copy()
    # Within a border of nothing each height has four neighbours, as numbers in a flat array.
    is_hole, is_inside, known = (
        np.pad(array, 1).ravel()
        for array in (missing, np.ones_like(missing), np.where(missing, 0.0, heights))
    )
    holes, number, width = np.flatnonzero(is_hole), np.cumsum(is_hole) - 1, heights.shape[1] + 2
    beside = holes[:, None] + [width, -width, 1, -1]
    # In each hole, the number of neighbours times the height is the sum of theirs.
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
    """Heights of a measured surface as the window needs them; None if that is impossible."""
    surface = oriented(read_surface(file, table["height_unit"]), table["transpose"], table["flip"])
    pixels, sides = window.get("pixels"), window.get("pixel_size")
    if surface.pixel_size and sides and not np.allclose(surface.pixel_size, sides, rtol=0.01):
        size = " × ".join(display(side, "µm") for side in surface.pixel_size)
        problem = f"the pixels of disk.roughness.file are {size}; give those"
        faults.refuse("window.pixel_size", problem)
    heights: Array | None = surface.heights
    if table["crop"] is not None and pixels:
        heights = _cropped(surface.heights, table, pixels, faults)
    if heights is None or (heights := _fill_holes(heights, table["missing"], faults)) is None:
        return None
    said = surface.notes
    if table["level"]:
        level = levelled(heights)
        if sides and min(heights.shape) > 1:
            said += tilt_doubts(tilts(heights, level, sides))
        heights = level
    if table["repeat"] != "no" and pixels and np.less(heights.shape, pixels).any():
        is_mirrored = table["repeat"] == "mirror"  # stays continuous; tiles step, but keep a lay
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
    for note in (*said, noted):
        faults.note("disk.roughness.file", note)
    return heights


def _cropped(
    heights: Array, table: Mapping[str, Any], pixels: tuple[int, int], faults: Faults
) -> Array | None:
    """The patch of the window; as much of it as there is, if it is to be repeated."""
    (i, j), (rows, columns) = table["crop"], pixels
    if table["repeat"] != "no":
        left = np.subtract(heights.shape, table["crop"])
        rows, columns = np.minimum(pixels, np.maximum(left, 1)).tolist()
    if i + rows > heights.shape[0] or j + columns > heights.shape[1]:
        faults.refuse(
            "disk.roughness.crop",
            f"a patch of {rows} × {columns} heights by x and y from {i}, {j} on reaches beyond "
            f"the surface of {heights.shape[0]} × {heights.shape[1]}; begin at lower numbers, or "
            "give fewer window.pixels",
        )
        return None
    return heights[i : i + rows, j : j + columns]


def _fill_holes(heights: Array, missing: str, faults: Faults) -> Array | None:
    """Heights with any holes filled; None if the scene refuses them, or all is a hole."""
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
            f"{share} are missing, the first at x {i}, y {j} (counted from 0); crop them off, or "
            'give "fill"'
        )
        faults.refuse("disk.roughness.missing", problem)
        return None
    words = f"{share} are missing and were filled from around them"
    faults.note("disk.roughness.file", words)
    return filled(heights)
