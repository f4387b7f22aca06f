"""Read files of surface instruments: .x3p and .gwy here, other formats by SurfaceTopography."""

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
from xml.etree import ElementTree

import numpy as np

from pipeline.paths import kind_of, read_file
from pipeline.scene.units import UnitError, to_si
from tribo import InputError
from tribo.types import Array

_SAVE = "save the heights as .x3p, .npy or text"
_UNSURE_TMD = "readers of this format differ by a factor of 1000 in its heights"
_IMAGE = "an image, whose grey values are no heights of a known unit"
_HEADER = 512  # bytes of a .sur header; byte 334 gives the sizes of the next blocks
_VALUES = {"b": "?", "c": "u1", "i": "<i4", "q": "<i8", "d": "<f8"}
"""NumPy types of Gwyddion's components, by their letter; a capital letter is an array."""
_POINTS = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}


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
    """Read an instrument's file.

    Raises an `InputError` with the reason if the content cannot be read, and an `OSError` if the
    file cannot be opened.
    """
    content = read_file(path)
    if content.startswith(b"Binary TrueMap"):
        raise InputError(f"{path}: {_UNSURE_TMD}; {_SAVE}")
    if (kind := kind_of(content)) == "an image":
        raise InputError(f"{path}: {_IMAGE}; {_SAVE}")
    suffix = path.suffix.lower() or kind or "a file without an ending"
    own = _read_gwy if content.startswith(b"GWYP") else None
    own = _read_x3p if zipfile.is_zipfile(path) and b"main.xml" in content else own
    try:
        return own(path) if own else _read_by_library(path)
    except (InputError, OSError):
        raise
    except Exception as error:  # readers of damaged files raise errors of any kind
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise InputError(
            f"{path}: cannot be read as {suffix}: {reason.rstrip('.')}; {_SAVE}"
        ) from error


def _read_x3p(path: Path) -> RawScan:
    """Read a surface of ISO 25178-72 (.x3p): a matrix in a binary member, or a list in XML."""
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        main = next(name for name in names if name.rpartition("/")[2] == "main.xml")
        root = ElementTree.fromstring(archive.read(main))
        x_axis, y_axis, z_axis = (root.find(f".//{{*}}{name}") for name in ("CX", "CY", "CZ"))
        sizes = [_text(root, name) for name in ("SizeX", "SizeY", "SizeZ")]
        kind = _text(root, "FeatureType")
        if kind != "SUR" or not sizes[0]:
            what = "a profile" if kind == "PRF" else "no matrix of heights"
            raise InputError(f"{path}: {what} (FeatureType {kind}); give a map of heights")
        nx, ny, layers = (int(size or 1) for size in sizes)
        if layers > 1:
            raise InputError(f"{path}: {layers} layers; give a file with one")

        def member(name: str, size: int) -> bytes:
            with archive.open(main.removesuffix("main.xml") + _text(root, name)) as stream:
                return stream.read(size)  # more than these would only fill memory

        if _text(root, "PointDataLink"):
            form = np.dtype(_POINTS[_text(z_axis, "DataType", "D")])
            values = np.frombuffer(member("PointDataLink", nx * ny * form.itemsize), form)
        else:
            cells = [(one.text or "").split(";")[-1] for one in root.findall(".//{*}Datum")]
            values = np.array([float(cell) if cell.strip() else np.nan for cell in cells])
        if values.size != nx * ny:
            raise InputError(f"{path}: {values.size} heights instead of {nx} × {ny}; {_SAVE}")
        step, offset = (float(_text(z_axis, *x)) for x in (("Increment", "1"), ("Offset", "0")))
        heights = values.astype(float).reshape(ny, nx) * step + offset
        if _text(root, "ValidPointsLink"):
            bits = np.frombuffer(member("ValidPointsLink", -(-nx * ny // 8)), np.uint8)
            is_valid = np.unpackbits(bits, bitorder="little")[: nx * ny].reshape(ny, nx)
            heights[is_valid == 0] = np.nan
    if any(_text(axis, "AxisType", "I") != "I" for axis in (x_axis, y_axis)):
        raise InputError(f"{path}: heights are not on a regular grid; give a regular grid")
    x, y = (abs(float(_text(axis, "Increment", "0"))) for axis in (x_axis, y_axis))
    return RawScan(heights.T, (x, y) if x and y else None, 1.0)


def _text(element: Any, name: str, usual: str = "") -> str:
    """Text of the child `name` of an XML element; `usual` if there is no such child."""
    return (element.findtext(f".//{{*}}{name}") or usual).strip()


def _read_gwy(path: Path) -> RawScan:
    """Read a Gwyddion file: the first channel with a length unit, else the first without a unit."""
    content = read_file(path)
    _, held, _ = _gwy_object(content, 4)
    fields = [
        held[name][1] for name in sorted(held)
        if re.fullmatch(r"/\d+/data", name) and held[name][0] == "GwyDataField"
    ]  # fmt: skip
    units = [_gwy_unit(one.get("si_unit_z")) for one in fields]
    if not fields or all(unit == 0 for unit in units):
        raise InputError(f"{path}: no channel of heights; {_SAVE}")
    best = min(range(len(fields)), key=lambda k: (units[k] == 0, units[k] is None, k))
    one, across = fields[best], _gwy_unit(fields[best].get("si_unit_xy"))
    nx, ny = one["xres"], one["yres"]
    pixel = (one["xreal"] / nx * across, one["yreal"] / ny * across) if across else None
    return RawScan(one["data"].reshape(ny, nx).T, pixel, units[best])


def _gwy_unit(unit: Any) -> float | None:
    """Length of a Gwyddion unit [m]; None if no unit is given, 0 if it is not a length."""
    text = unit[1].get("unitstr", "") if unit else ""
    try:
        return to_si(f"1 {text}", "1 m") if text else None
    except UnitError:
        return 0.0


def _gwy_object(content: bytes, place: int) -> tuple[str, dict[str, Any], int]:
    """Read the Gwyddion object at byte `place`.

    Returns the object's name, its components by name, and the number of the byte after it.
    """

    def text(begin: int) -> tuple[str, int]:
        end = content.index(b"\0", begin)
        return content[begin:end].decode(errors="replace"), end + 1

    name, place = text(place)
    (size,) = struct.unpack_from("<I", content, place)
    place, stop, fields = place + 4, place + 4 + size, dict[str, Any]()
    while place < stop:
        key, place = text(place)
        kind, place, count = chr(content[place]), place + 1, 1
        if kind.isupper():
            (count,), place = struct.unpack_from("<I", content, place), place + 4
        if kind.lower() in _VALUES:
            values = np.frombuffer(content, _VALUES[kind.lower()], count, place)
            fields[key] = values if kind.isupper() else values[0].item()
            place += values.nbytes
        for _ in range(count if kind in "sSoO" else 0):
            if kind in "sS":
                fields[key], place = text(place)
            else:
                label, inner, place = _gwy_object(content, place)
                fields[key] = label, inner
    return name, fields, stop


def _read_by_library(path: Path) -> RawScan:
    """Read a surface in any format that the library SurfaceTopography knows."""
    content = read_file(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # its warnings do not concern the user
        try:
            formats: Any = importlib.import_module("SurfaceTopography.IO")
        except ImportError as error:
            raise InputError(
                f"{path}: {kind_of(content) or 'a text'}; SurfaceTopography may know its format: "
                "get that with "
                f'"pip install SurfaceTopography", or {_SAVE}'
            ) from error
        source: Any = str(path)
        if content.startswith(b"DSCOMPRESSED"):
            source = io.BytesIO(_unpacked_sur(content))
        try:
            reader = formats.open_topography(source)
        except Exception as error:
            raise InputError(f"{path}: {_why_unreadable(formats, path, error)}; {_SAVE}") from error
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
    """Why SurfaceTopography cannot read a file: its error, or that it has no reader for the file.

    `formats` is its module of readers, and `error` was raised by the first attempt.
    """
    if type(error).__name__ != "CannotDetectFileFormat":
        return (str(error).strip().splitlines() or [type(error).__name__])[0]
    for reader in formats.readers:
        if path.suffix.lower()[1:] in (reader.file_extensions() or ()):
            try:
                reader(str(path))
            except Exception as own:  # of any kind
                return f"damaged {path.suffix} file: {(str(own).splitlines() or [repr(own)])[0]}"
    return f"SurfaceTopography has no reader for {path.suffix or 'files without an ending'}"


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
