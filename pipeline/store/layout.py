"""How the arrays of a store lie in chunks, and whether metadata describe that."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.store.variables import (
    BULK_COLUMNS,
    BY_POINT,
    COLUMNS,
    COMPACT,
    LEADING,
    RECORDS,
    Variable,
    is_coordinate,
    variables,
)

GROWING = (*LEADING, "load", "velocity", "step")
"""Dimensions along which a store grows."""
GROWING_CHUNK = 256
"""Size of the chunks of their coordinates."""
POINTS = 1024
"""Approximate number of points in a chunk of a compact store."""

LEVEL = 1
"""Level at which Zstandard compresses every chunk."""

_MOST = 32  # points in a chunk of a store that is not compact
_FULL = 16  # points in a chunk, if a sweep has as many
_SHARED = {*RECORDS, *COLUMNS, *BULK_COLUMNS}  # variables whose chunks hold several points
_LONGEST = 10**7  # dimension that is believed
_TO_BYTES: dict[str, dict[str, Any]] = {
    "str": {"name": "vlen-utf8", "configuration": {}},
    "int8": {"name": "bytes"},
}
_LITTLE_ENDIAN = {"name": "bytes", "configuration": {"endian": "little"}}
_NEEDED = {
    "scene": dict,
    "scene_hash": str,
    "versions": dict,
    "name": str,
    "title": str,
    "conditions": dict,
    "loads": list,
    "velocities": list,
}
_CONDITIONS = ("friction", "bulk_temperature", "failing_share")  # a critical one may be unknown


def block_of(loads: int, axes: int) -> list[int]:
    """Points in a chunk of a new store along each of the `axes` that tell points apart.

    These are the loads of a velocity, which one task computes after the other; of neighbouring
    velocities as well, where there are few loads. More would cost more to write anew for a point.

    Examples
    --------
    >>> block_of(loads=12, axes=2), block_of(loads=1, axes=3), block_of(loads=40, axes=2)
    ([12, 2], [1, 1, 16], [20, 1])
    """
    share = math.ceil(loads / math.ceil(loads / _MOST))
    return [1] * (axes - 2) + [share, math.ceil(_FULL / share)]


def new_chunks(
    name: str, variable: Variable, shape: list[int], block: list[int] | None
) -> list[int]:
    """Sizes of the chunks of a new variable.

    Fields have a chunk for each point, the other variables one for each block of points, or for
    each point if there are no blocks.
    """
    if is_coordinate(name):
        return [GROWING_CHUNK] if variable.dims[0] in GROWING else shape
    own = variable.dims.index("velocity") + 1  # the dimensions that choose a point
    return (block if block and name in _SHARED else [1] * own) + shape[own:]


def data_type_of(variable: Variable) -> str:
    """What Zarr calls the type of a variable."""
    return "string" if variable.dtype == "str" else variable.dtype


def codecs_of(variable: Variable) -> list[dict[str, Any]]:
    """What turns the values of a chunk into the content of its file, as Zarr's metadata say it."""
    compressed = {"name": "zstd", "configuration": {"level": LEVEL, "checksum": True}}
    return [_TO_BYTES.get(variable.dtype, _LITTLE_ENDIAN), compressed]


def in_chunks(sizes: list[int], separator: str) -> dict[str, Any]:
    """The part of an array's metadata that says how large chunks are, and how they are named."""
    return {
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": sizes}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": separator}},
    }


def sizes_of(array: Mapping[str, Any]) -> list[int]:
    """Sizes of an array's chunks, by its metadata."""
    sizes: list[int] = array["chunk_grid"]["configuration"]["chunk_shape"]
    return sizes


def separator_of(array: Mapping[str, Any]) -> str:
    """What separates the numbers in the names of an array's chunks, by its metadata."""
    separator: str = array["chunk_key_encoding"]["configuration"]["separator"]
    return separator


def faults_of(attributes: Mapping[str, Any], arrays: Mapping[str, Any]) -> Iterator[str]:
    """Say what in a store's attributes and metadata is not as a sweep writes it.

    Whatever else is raised on the way is a fault as well.
    """
    for name, kind in _NEEDED.items():
        if not isinstance(attributes[name], kind):
            yield f"the attribute {name} is damaged"
    conditions = attributes["conditions"]
    critical = conditions["critical_temperature"]
    numbers = [conditions[name] for name in _CONDITIONS] + [critical] * (critical is not None)
    if not all(map(math.isfinite, numbers)):
        yield "the attribute conditions is damaged"
    leading = next((name for name in LEADING if name in arrays), None)
    inputs = {name: "" for name in arrays if "." in name}
    known = variables(leading, with_fields=True, of_bulks=True, inputs=inputs)
    if unknown := [name for name in arrays if name not in known]:
        yield f"{unknown[0]} is not a variable of a sweep"
    needed = ["status", "load", "velocity", *COLUMNS]
    needed += [*BULK_COLUMNS, "bulk_ratio"] if "bulk_ratio" in arrays else []
    if missing := [name for name in needed if name not in arrays]:
        yield f"the metadata of {missing[0]} are missing"
    lengths = {name: len(values) for name, values in attributes.get("axes", {}).items()}
    for name in attributes.get("axes", {}):
        if not all(math.isfinite(value) for value in attributes["axes"][name]):
            yield f"the axis {name} is damaged"
    for name, array in arrays.items():
        if not _is_as_written(name, known[name], array, lengths):
            yield f"the metadata of {name} are damaged"
    for name in ("load", "velocity"):
        if "axes" in attributes and not set(attributes["axes"][name]) >= set(
            attributes[_many(name)]
        ):
            yield f"the attribute {_many(name)} is damaged"


def _many(name: str) -> str:
    return {"load": "loads", "velocity": "velocities"}[name]


def _is_as_written(
    name: str, variable: Variable, array: Mapping[str, Any], lengths: dict[str, int]
) -> bool:
    """Whether the metadata of a variable are such as a sweep writes; its sizes go to `lengths`."""
    shape, chunks = array["shape"], sizes_of(array)
    dims = list(variable.dims)
    if not (array["dimension_names"] == dims and len(shape) == len(chunks) == len(dims)):
        return False
    if not all(type(size) is int for size in (*shape, *chunks)):
        return False
    as_elsewhere = all(
        0 < size <= _LONGEST and lengths.setdefault(dim, size) == size
        for dim, size in zip(dims, shape, strict=True)
    )
    if is_coordinate(name):
        fit = 0 < chunks[0] <= max(GROWING_CHUNK, shape[0])
    else:
        own = dims.index("velocity") + 1
        fit = all(0 < size <= full for size, full in zip(chunks[own:], shape[own:], strict=True))
        most = POINTS if separator_of(array) == COMPACT else _MOST
        fit &= 0 < math.prod(chunks[:own]) <= (most if name in _SHARED else 1)
        if name in _SHARED:  # in all of them a chunk holds the same points
            shared = zip(dims[:own], chunks, strict=False)
            fit &= all(lengths.setdefault(f"{dim} of a chunk", n) == n for dim, n in shared)
    return (
        as_elsewhere
        and fit
        and separator_of(array) in (BY_POINT, COMPACT)
        and array["data_type"] == data_type_of(variable)
        and _names(array["codecs"]) == _names(codecs_of(variable))
        and array["node_type"] == "array"
    )


def _names(codecs: list[dict[str, Any]]) -> list[str]:
    return [codec["name"] for codec in codecs]
