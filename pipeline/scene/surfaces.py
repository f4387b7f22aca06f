"""Measured surfaces: read as instruments write them, cropped, levelled and filled for a scene.

Arrays in ``.npy`` and ``.csv`` are read by `tribo.read_heights`, all other files by
SurfaceTopography, which knows some forty formats of profilers and microscopes. It is an extra,
``pip install irg-transition[surfaces]``, loaded when a file needs it.
"""

from __future__ import annotations

import importlib
import warnings
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tribo import InputError, read_heights
from tribo.files import require_file
from tribo.types import Array

PLAIN = (".csv", ".npy")
"""Endings of plain arrays, which give neither a unit nor the size of a pixel."""
_MOST_BYTES = 2**30  # that an archive may unpack to


@dataclass(frozen=True, slots=True)
class Surface:
    """A measured surface.

    Attributes
    ----------
    heights : ndarray, shape (nx, ny)
        Heights, positive outwards; NaN where the instrument has none [m].
    pixel_size : tuple of float or None
        Sides of a pixel along x and y; None where the file does not give them [m].
    """

    heights: Array
    pixel_size: tuple[float, float] | None = None


def read_surface(path: str | Path, height_unit: float | None = None) -> Surface:
    """Read a measured surface.

    Parameters
    ----------
    path : str or Path
        Plain array, or a file of any format that SurfaceTopography reads.
    height_unit : float, optional
        Length of one unit of the file's heights, where the file does not give it or is wrong [m].

    Raises
    ------
    InputError
        If the file cannot be read, is not a surface, or its unit is not known; or if the extra
        that its format needs is not installed.
    """
    path = Path(path)
    if path.suffix.lower() in PLAIN:
        if height_unit is None:
            raise InputError(f"{path}: a plain array has no unit of its own; give height_unit")
        return Surface(read_heights(path, height_unit, allow_missing=True))
    _require_small_file(path)
    try:
        formats: Any = importlib.import_module("SurfaceTopography.IO")
    except ImportError as error:
        raise InputError(
            f"{path}: not a plain array, which ends in .npy or .csv; if an instrument wrote it, "
            "SurfaceTopography may know its format: get that with "
            'pip install "irg-transition[surfaces]", or save the heights as .npy'
        ) from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its own house-keeping
            topography = formats.open_topography(str(path)).topography()
            return _converted(path, topography, height_unit)
    except InputError:
        raise
    except Exception as error:  # readers of damaged files raise errors of any kind
        reason = str(error).strip().splitlines()[:1] or [type(error).__name__]
        if type(error).__name__ == "CannotDetectFileFormat":
            reason = ["its format is not known; save the heights as .npy or .csv"]
        elif "physical_sizes" in reason[0]:  # an option of the library, which a scene does not have
            reason = ["it does not say how large its pixels are; save the heights as .npy or .csv"]
        raise InputError(f"{path}: cannot be read as a surface: {reason[0]}") from error


def _require_small_file(path: Path) -> None:
    """Refuse what has no end, and an archive that unpacks to more than a surface can be."""
    require_file(path)
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > _MOST_BYTES:
            raise InputError(
                f"{path}: unpacks to {size / 2**30:.1f} GiB; at most {_MOST_BYTES / 2**30:g} GiB "
                "are read. Crop or average the surface before"
            )


def _converted(path: Path, topography: Any, height_unit: float | None) -> Surface:
    """Copy what a topography of the library holds, in metres."""
    if topography.dim != 2 or not topography.is_uniform:
        raise InputError(
            f"{path}: a profile, or unevenly spaced; give a map of heights on a regular grid"
        )
    if topography.unit is None:
        if height_unit is None:
            raise InputError(
                f"{path}: the file does not give the unit of its heights; give height_unit"
            )
        heights, pixel_size = topography.heights() * height_unit, None
    else:
        heights = None if height_unit is None else topography.heights() * height_unit
        topography = topography.to_unit("m")
        heights = topography.heights() if heights is None else heights
        dx, dy = topography.pixel_size
        pixel_size = float(dx), float(dy)
    copied = np.ma.filled(np.ma.masked_invalid(np.ma.array(heights, dtype=np.float64)), np.nan)
    return Surface(np.ascontiguousarray(copied), pixel_size)


Flip = Literal["no", "x", "y", "heights"]


def oriented(surface: Surface, transpose: bool = False, flip: Flip = "no") -> Surface:
    """Turn a surface that an instrument wrote in another orientation.

    Parameters
    ----------
    surface : Surface
        Surface as read.
    transpose : bool
        Exchange x and y, of the pixels too.
    flip : {"no", "x", "y", "heights"}
        Reverse an axis; or the heights, as of a replica, whose summits were valleys.

    Examples
    --------
    >>> surface = Surface(np.array([[1.0, 2.0, 3.0]]), (1e-6, 2e-6))
    >>> oriented(surface, transpose=True, flip="heights")
    Surface(heights=array([[-1.],
           [-2.],
           [-3.]]), pixel_size=(2e-06, 1e-06))
    """
    heights, sides = surface.heights, surface.pixel_size
    if transpose:
        heights, sides = heights.T, sides and (sides[1], sides[0])
    if flip == "heights":
        heights = -heights
    elif flip != "no":
        heights = np.flip(heights, "xy".index(flip))
    return Surface(np.ascontiguousarray(heights), sides)


def cropped(heights: Array, first: tuple[int, int], shape: tuple[int, int]) -> Array:
    """Cut a patch out of a surface.

    Parameters
    ----------
    heights : ndarray, shape (mx, my)
        Heights of the whole surface [m].
    first : tuple of int
        Row and column at which the patch begins, counted from 0.
    shape : tuple of int
        Rows and columns of the patch.

    Raises
    ------
    InputError
        If the patch reaches beyond the surface.

    Examples
    --------
    >>> cropped(np.arange(12.0).reshape(3, 4), first=(1, 2), shape=(2, 2))
    array([[ 6.,  7.],
           [10., 11.]])
    """
    (i, j), (nx, ny) = first, shape
    if i + nx > heights.shape[0] or j + ny > heights.shape[1]:
        raise InputError(
            f"a patch of {nx} × {ny} heights from row {i}, column {j} reaches beyond the surface "
            f"of {heights.shape[0]} × {heights.shape[1]}"
        )
    return heights[i : i + nx, j : j + ny].copy()


def repeated(heights: Array, shape: tuple[int, int], how: Literal["mirror", "tile"]) -> Array:
    """Go on with a surface beyond its ends, until it has as many heights.

    Mirrored it stays continuous; as tiles it steps at every seam, but keeps its lay.

    Parameters
    ----------
    heights : ndarray, shape (mx, my)
        Heights of the surface [m].
    shape : tuple of int
        Rows and columns wanted; a surface with more keeps them.
    how : {"mirror", "tile"}
        Mirror image of the repetition before, or the same again.

    Examples
    --------
    >>> repeated(np.array([[1.0, 2.0, 3.0]]), (1, 7), "mirror")
    array([[1., 2., 3., 3., 2., 1., 1.]])
    >>> repeated(np.array([[1.0, 2.0, 3.0]]), (1, 7), "tile")
    array([[1., 2., 3., 1., 2., 3., 1.]])
    """
    more = [
        (0, max(0, wanted - present)) for wanted, present in zip(shape, heights.shape, strict=True)
    ]
    if how == "mirror":
        return np.pad(heights, more, mode="symmetric")
    return np.pad(heights, more, mode="wrap")


def levelled(heights: Array) -> Array:
    """Heights above their least-squares plane [m]; NaN stays NaN.

    Examples
    --------
    >>> i, j = np.indices((4, 5))
    >>> bool(np.abs(levelled(3.0 + 2.0 * i - 0.5 * j)).max() < 1e-12)
    True
    """
    measured = np.isfinite(heights)
    i, j = np.indices(heights.shape) / max(heights.shape)
    terms = np.stack([np.ones(heights.shape), i, j], axis=-1)
    plane, *_ = np.linalg.lstsq(terms[measured], heights[measured], rcond=None)
    level: Array = heights - terms @ plane
    return level


def filled(heights: Array) -> Array:
    """Replace NaN by the harmonic function that continues the heights around it.

    It is a membrane spanned over each hole, which adds neither peaks nor valleys.

    Raises
    ------
    InputError
        If there is no height at all.

    Examples
    --------
    >>> surface = np.add.outer(np.arange(4.0), np.arange(4.0))
    >>> holed = surface.copy()
    >>> holed[1:3, 1:3] = np.nan
    >>> bool(np.allclose(filled(holed), surface))
    True
    """
    from scipy import sparse  # takes 0.1 s, and few surfaces have holes
    from scipy.sparse.linalg import spsolve

    missing = ~np.isfinite(heights)
    if missing.all():
        raise InputError("all heights are missing")
    if not missing.any():
        return heights.copy()
    count = int(missing.sum())
    number = np.full(heights.shape, -1)
    number[missing] = np.arange(count)
    rows, columns, weights = [np.empty(0, int)], [np.empty(0, int)], [np.empty(0)]
    neighbours, around = np.zeros(count), np.zeros(count)
    for axis in (0, 1):
        low = tuple(slice(None, -1) if k == axis else slice(None) for k in (0, 1))
        high = tuple(slice(1, None) if k == axis else slice(None) for k in (0, 1))
        for here, there in ((low, high), (high, low)):
            hole = missing[here]
            inside, other, height = number[here][hole], number[there][hole], heights[there][hole]
            neighbours += np.bincount(inside, minlength=count)
            to_known = other < 0
            around += np.bincount(inside[to_known], height[to_known], minlength=count)
            rows.append(inside[~to_known])
            columns.append(other[~to_known])
            weights.append(-np.ones(int((~to_known).sum())))
    off = sparse.csc_matrix(
        (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))),
        shape=(count, count),
    )
    result = heights.copy()
    result[missing] = spsolve(sparse.diags(neighbours, format="csc") + off, around)
    return result
