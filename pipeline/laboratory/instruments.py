"""Read files of surface instruments by SurfaceTopography."""

from __future__ import annotations

import importlib
import io
import re
import struct
import warnings
import zipfile
import zlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline.paths import kind_of, read_file
from tribo import InputError
from tribo.types import Array

_SAVE = "save the heights as .x3p, .npy or text"
_UNSURE_TMD = "readers of this format differ by a factor of 1000 in its heights"
_IMAGE = "an image, whose grey values are no heights of a known unit"
_HEADER = 512  # bytes of a .sur header; byte 334 gives the sizes of the next blocks


class RawScan(NamedTuple):
    """Heights as in a file; pixel size and unit are None if the file does not state them.

    `steps` are the sides of a pixel in an unknown unit, if the file has only these.
    """

    heights: Array  # shape (nx, ny), NaN in holes; a profile has ny = 1
    pixel: tuple[float, float] | None = None  # sides [m]
    unit: float | None = None  # one unit of the heights [m]
    steps: tuple[float, float] | None = None  # sides of a pixel in an unknown unit
    places: Array | None = None  # of the heights of profiles (n, n_profile), shape (n,)
    place_unit: float | None = None  # one unit of the places [m]


def read_instrument(path: Path) -> RawScan:
    """Read an instrument's file in any format that the library SurfaceTopography knows.

    Raises an `InputError` with the reason if the content cannot be read, and an `OSError` if the
    file cannot be opened.
    """
    content = read_file(path)
    if content.startswith(b"Binary TrueMap"):
        raise InputError(f"{path}: {_UNSURE_TMD}; {_SAVE}")
    if (kind := kind_of(content)) == "an image":
        raise InputError(f"{path}: {_IMAGE}; {_SAVE}")
    suffix = path.suffix.lower() or kind or "a file without an ending"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings of the library do not concern the user
            return _read_by_library(path, content)
    except (InputError, OSError):
        raise
    except Exception as error:  # readers of damaged files raise errors of any kind
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise InputError(
            f"{path}: cannot be read as {suffix}: {reason.rstrip('.')}; {_SAVE}"
        ) from error


def _read_by_library(path: Path, content: bytes) -> RawScan:
    try:
        formats: Any = importlib.import_module("SurfaceTopography.IO")
    except ImportError as error:
        raise InputError(
            f"{path}: {kind_of(content) or 'a text'}; SurfaceTopography may know its format: "
            f'get that with "pip install SurfaceTopography", or {_SAVE}'
        ) from error
    source: Any = str(path)
    form = "gwy" if content.startswith(b"GWYP") else None
    if content.startswith(b"DSCOMPRESSED"):
        source = io.BytesIO(_unpacked_sur(content))
    elif zipfile.is_zipfile(path) and b"main.xml" in content:
        source, form = _plain_x3p(path), "x3p"
    try:
        reader = formats.open_topography(source, format=form)
    except Exception as error:
        raise InputError(f"{path}: {_why_unreadable(formats, path, error)}; {_SAVE}") from error
    if not reader.channels:
        raise InputError(f"{path}: no channel of heights in a unit of length; {_SAVE}")
    if reader.default_channel.physical_sizes is None:
        raise InputError(f"{path}: states no sizes; {_SAVE}")
    topography = reader.topography()
    if topography.dim == 1:
        size = float(topography.to_unit("m").physical_sizes[0]) if topography.unit else None
        length = size and size / float(topography.physical_sizes[0])
        line = np.asarray(topography.heights(), dtype=float)[:, None]
        return RawScan(line, unit=length, places=topography.positions(), place_unit=length)
    if not topography.is_uniform:
        raise InputError(f"{path}: unevenly spaced; give an even map of heights")
    masked: Any = np.ma.masked_invalid(np.ma.array(topography.heights(), dtype=float))
    heights: Array = np.ma.filled(masked, np.nan)
    if topography.unit is None:
        return RawScan(heights, None, None)
    size = topography.to_unit("m").pixel_size
    unit = float(size[0]) / float(topography.pixel_size[0])
    return RawScan(heights, (float(size[0]), float(size[1])), unit)


def _why_unreadable(formats: Any, path: Path, error: Exception) -> str:
    """Why SurfaceTopography cannot read a file: its error, or that it has no reader for it."""
    if type(error).__name__ != "CannotDetectFileFormat":
        return (str(error).strip().splitlines() or [type(error).__name__])[0].rstrip(".")
    for reader in formats.readers:
        if path.suffix.lower()[1:] in (reader.file_extensions() or ()):
            try:
                reader(str(path))
            except Exception as own:  # of any kind
                return f"damaged {path.suffix} file: {(str(own).splitlines() or [repr(own)])[0]}"
    return f"SurfaceTopography has no reader for {path.suffix or 'files without an ending'}"


def _plain_x3p(path: Path) -> io.BytesIO:
    """An .x3p file as the library reads it: not in a folder, and of the revision of 2000."""
    plain = io.BytesIO()
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(plain, "w") as copy:
        names = archive.namelist()
        main = next(name for name in names if name.rpartition("/")[2] == "main.xml")
        folder = main.removesuffix("main.xml")
        for name in (one for one in names if one.startswith(folder) and one[-1] != "/"):
            member = archive.read(name)
            if name == main:
                member = re.sub(rb"(<Revision>)[^<]*", rb"\1ISO5436 - 2000", member)
            copy.writestr(name.removeprefix(folder), member)
    plain.seek(0)
    return plain


def _unpacked_sur(content: bytes) -> bytes:
    """Decompress the content of a compressed .sur file."""
    comment, private = struct.unpack_from("<hh", content, 334)
    begin = _HEADER + comment + private
    (count,) = struct.unpack_from("<I", content, begin)
    sizes = struct.unpack_from(f"<{2 * count}I", content, begin + 4)
    place, parts = begin + 4 + 8 * count, list[bytes]()
    if sum(sizes[::2]) > 2**30:
        raise InputError("unpacks to more than 1 GiB; crop or average the surface first")
    for raw, packed in zip(sizes[::2], sizes[1::2], strict=True):
        parts.append(zlib.decompressobj().decompress(content[place : place + packed], raw))
        place += packed
    return b"DIGITAL SURF" + content[12:begin] + b"".join(parts)
