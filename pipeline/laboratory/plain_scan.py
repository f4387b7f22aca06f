"""Heights of surfaces in plain arrays, as NumPy writes them."""

from __future__ import annotations

import tokenize
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribo import InputError
from tribo.errors import reason_of, require_file, require_positive
from tribo.types import Array

_MOST_HEIGHTS = 10**8  # heights of a surface; 0.8 GB


def read_heights(path: Path, unit: float) -> Array:
    """Heights [m] of a measured surface from ``.npy``, NaN where they are missing.

    Parameters
    ----------
    path : Path
        A two-dimensional array: a row for each y, in which x goes from column to column.
    unit : float
        Length of one unit of the file [m].

    Returns
    -------
    ndarray, shape (nx, ny)
        Heights by x and y, so with the rows of the file along their second axis.

    Raises
    ------
    InputError
        If the file cannot be read, is not a two-dimensional array of numbers, or holds inf; the
        message says where.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "heights.npy")
    ...     np.save(file, [[1.0, 2.0, 3.0]])
    ...     read_heights(file, unit=1e-6)
    array([[1.e-06],
           [2.e-06],
           [3.e-06]])
    """
    require_positive(unit=unit)
    require_file(path)
    try:
        heights = _read_array(path)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    except (ValueError, EOFError, tokenize.TokenError) as error:
        raise InputError(f"{path}: not a plain array of numbers: {error}") from error
    except Exception as error:  # a damaged file makes NumPy raise errors of any kind
        raise InputError(f"{path}: not a plain array of numbers: {error!r}") from error
    if heights.ndim != 2 or heights.size == 0 or heights.dtype.kind not in "fiu":
        raise InputError(
            f"{path}: an array of shape {heights.shape} and type {heights.dtype}; "
            "needed are two-dimensional real numbers, a row for each y"
        )
    with np.errstate(over="ignore"):
        scaled: Array = heights.astype(np.float64) * unit
    bad = np.argwhere(np.isinf(scaled))
    if bad.size:
        row, column = bad[0].tolist()
        raise InputError(
            f"{path}: {len(bad)} of {heights.size} heights are not finite, the first at "
            f"row {row}, column {column} (counted from 0); fill or crop them before"
        )
    return np.ascontiguousarray(scaled.T)


def _read_array(path: Path) -> NDArray[Any]:
    """The array of the file, unless it is a packed archive, or too large to be a surface."""
    with path.open("rb") as file:
        magic = file.read(len(np.lib.format.MAGIC_PREFIX))
    if magic != np.lib.format.MAGIC_PREFIX:
        raise ValueError("the file does not begin as NumPy writes arrays")
    if path.stat().st_size > 2 * 8 * _MOST_HEIGHTS:
        raise _too_large(path, f"{path.stat().st_size / 2**30:.1f} GiB")
    try:
        array: NDArray[Any] = np.load(path, allow_pickle=False)
    except MemoryError as error:
        raise ValueError(f"its header asks for more than there is memory: {error}") from error
    if array.size > _MOST_HEIGHTS:
        raise _too_large(path, f"{array.size} heights")
    return array


def _too_large(path: Path, size: str) -> InputError:
    return InputError(
        f"{path}: {size}; at most {_MOST_HEIGHTS} heights are read. Crop or average them before"
    )
