"""Read files of instruments by the library SurfaceTopography."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tribo import InputError
from tribo.types import Array

PROFILE = (
    "a profile; the Ra and RSm that its instrument prints are enough: irg surface --ra RA --rsm RSM"
)
POINTS = "a list of points x, y, z; make it a matrix, a row for each y"
EXPORT = "export the heights as .npy or as a matrix in text, without headings"
MIN_SIDE = 9  # heights along a side of a map; less are columns of a table


class HeightFile(NamedTuple):
    """Heights in a file's unit, shape (nx, ny); unit and sides [m] are None if it has none."""

    heights: Array
    unit: float | None = None
    pixel_size: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()


def read_instrument_file(path: Path, kind: str) -> HeightFile:
    """Read a file in any format that SurfaceTopography knows."""
    kind = kind or path.suffix.lower() or "file"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings of the library do not concern the user
            from SurfaceTopography.IO import open_topography

            return _from_library(open_topography(str(path)))
    except ImportError as error:
        raise InputError(
            f"{kind}: get its reader by pip install SurfaceTopography, or {EXPORT}"
        ) from error
    except InputError:
        raise
    except Exception as error:  # readers of damaged files raise errors of any kind
        reason = _library_message(error, path.suffix.lower())
        raise InputError(f"{kind}: {reason}; {EXPORT}") from error


def _library_message(error: Exception, suffix: str) -> str:
    """Why SurfaceTopography cannot read a file with an ending such as ".plux"."""
    text, error_name = str(error).strip(), type(error).__name__
    if error_name == "CannotDetectFileFormat":  # its text lists the errors of all readers
        pattern = rf"tried {re.escape(suffix[1:])}reader:\s*(.*)"
        reader_message = re.search(pattern, text, re.IGNORECASE)
        if not suffix or not reader_message:
            return "SurfaceTopography has no reader for it"
        text = reader_message[1]
    elif isinstance(error, LookupError) or not text:
        text = f"{error_name} {text}".strip()
    if re.fullmatch(r"'[^']*'", text):  # the key of a table
        text = f"{text} is missing"
    return f"SurfaceTopography cannot read it ({text.splitlines()[0].rstrip('.')})"


def _from_library(reader: Any) -> HeightFile:
    """Heights of the default channel of a reader of SurfaceTopography."""
    channel = reader.default_channel
    if channel.physical_sizes is None:
        raise InputError(f"a file without the size of its pixels; {EXPORT}")
    require_size(channel.nb_grid_pts)
    topography = reader.topography()
    if topography.dim != 2:
        raise InputError(f"no map of heights, but {PROFILE}")
    if type(reader).__name__ == "XYZReader" or not topography.is_uniform:
        raise InputError(f"no map of heights, but {POINTS}")
    if type(reader).__name__ == "TMDReader":
        raise InputError(f"readers of .tmd differ by a factor of 1000 in its heights; {EXPORT}")
    heights: Any = np.ma.masked_invalid(np.ma.array(topography.heights(), dtype=float))
    heights = np.ma.filled(heights, np.nan)
    if min(heights.shape) < MIN_SIDE:
        size = " × ".join(map(str, heights.shape))
        raise InputError(f"{size} heights are too few; give {MIN_SIDE} along each side")
    notes: tuple[str, ...] = ()
    if len(reader.channels) > 1:
        names = ", ".join(file_channel.name for file_channel in reader.channels)
        notes = (f"{channel.name} is read, of the channels {names}",)
    if topography.unit is None:
        return HeightFile(heights, notes=notes)
    x, y = map(float, topography.to_unit("m").pixel_size)
    return HeightFile(heights, x / float(topography.pixel_size[0]), (x, y), notes)


def require_size(shape: Sequence[int]) -> None:
    """Raise an `InputError` for more heights than can be processed."""
    max_count = 2**24  # 4096 × 4096; the form of more takes gigabytes
    if math.prod(shape) > max_count:
        size = " × ".join(map(str, shape))
        raise InputError(f"{size} heights are too many; cut out {max_count} at most")
