"""Schema of the dataset of a sweep: its variables, their dimensions, chunks and documents."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tribo import WarningKind

FORMAT = 1
"""Version of the layout."""
PENDING, DONE, FAILED = 0, 1, 2
"""Values of the variable ``status``."""
COMPRESSION: dict[str, Any] = {"level": 1, "checksum": True}
"""Settings of zstd."""


class Variable(NamedTuple):
    """Dimensions, unit, meaning, NumPy type and further attributes of a variable."""

    dims: tuple[str, ...]
    units: str | None
    long_name: str
    dtype: str = "float64"
    attributes: Mapping[str, Any] = {}


_POINT = ("load", "velocity")
_STEP = (*_POINT, "step")
_FIELD = (*_POINT, "x", "y")
_RISE = "per unit friction coefficient"


def _of_contact(units: str, long_name: str) -> Variable:
    """A variable at every step that depends on the size of the elements."""
    comment = (
        "Depends on the size of the elements: a rough surface on larger ones touches on more of "
        "the window at a lower pressure. In the paper's system the preset 'standard' has 14 to "
        "17 % more contact than the pixels themselves, 'draft' 40 to 50 %. NaN at steps on the "
        "coarser grid of the history."
    )
    return Variable(_STEP, units, long_name, attributes={"comment": comment})


def _field(units: str, long_name: str) -> Variable:
    """A field at the end of each point, in single precision: half the size, 1e-7 off."""
    return Variable(_FIELD, units, long_name, "float32")


COORDINATES = {
    "realization": Variable(("realization",), "1", "seed of the random surface", "int64"),
    "sample": Variable(("sample",), "1", "number of the sample of unknown inputs", "int64"),
    "load": Variable(("load",), "N", "normal load on the pin at the end of the ramp"),
    "velocity": Variable(("velocity",), "m/s", "sliding velocity"),
    "step": Variable(("step",), "1", "step of the ramp", "int64"),
    "quantile": Variable(("quantile",), "1", "share of the contact area that is cooler"),
    "bulk_ratio": Variable(
        ("bulk_ratio",), "K", "bulk temperature of the disk less that of the pin, over friction"
    ),
    "wear_rate": Variable(
        ("wear_rate",), "m^2/N", "specific wear rate at which a point's contacts have other heat"
    ),
    "x": Variable(("x",), "m", "position along the sliding direction"),
    "y": Variable(("y",), "m", "position across the sliding direction"),
}
COLUMNS = {
    "time": Variable(_STEP, "s", "time since the start of the ramp"),
    "normal_load": Variable(_STEP, "N", "normal load on the pin"),
    "sliding_distance": Variable(_STEP, "m", "sliding distance since the start of the ramp"),
    "contact_fraction": _of_contact("1", "share of the window in contact"),
    "contact_width": _of_contact("m", "width of the contact along the sliding direction"),
    "max_pressure": _of_contact("Pa", "highest contact pressure"),
    "mean_pressure": _of_contact("Pa", "mean pressure over the contact"),
    "saturated_fraction": _of_contact("1", "share of the contact at the hardness"),
    "wear_depth_max": Variable(_STEP, "m", "greatest wear depth of the pin"),
    "wear_volume": Variable(_STEP, "m^3", "worn volume of the whole pin"),
    "iterations": Variable(_STEP, "1", "iterations of the contact solver"),
    "residual": Variable(_STEP, "1", "residual of the contact solver"),
    "max_rise": Variable(_STEP, "K", f"highest temperature rise of the contact {_RISE}"),
    "mean_rise": Variable(_STEP, "K", f"mean temperature rise of the contact {_RISE}"),
    "pin_heat_share": Variable(_STEP, "1", "share of the friction heat that enters the pin"),
    "rise_quantile": Variable(
        (*_STEP, "quantile"), "K", f"quantile of the temperature rise of the contact {_RISE}"
    ),
}
FIELDS = {
    "pressure": _field("Pa", "contact pressure at the end of the ramp"),
    "rise": _field("K", f"temperature rise of the pin at the end of the ramp {_RISE}"),
    "wear_depth": _field("m", "wear depth of the pin at the end of the ramp"),
}
BULK_COLUMNS = {
    "mean_bulk_response": Variable(
        _STEP, "1", "mean rise of the contact for each kelvin by which the disk's bulk is warmer"
    ),
    "bulk_rise_quantile": Variable(
        (*_STEP, "bulk_ratio", "quantile"),
        "K",
        f"quantile of the contact's rise above the pin's bulk at a bulk ratio, {_RISE}",
    ),
}
"""Variables of scenes with unequal bulk temperatures besides `COLUMNS`."""
RATE_COLUMNS = {
    "rise_quantile_at_wear_rate": Variable(
        (*_STEP, "wear_rate", "quantile"),
        "K",
        f"quantile of the rise at the velocity times own over other wear rate, {_RISE}",
    ),
    "mean_rise_at_wear_rate": Variable(
        (*_STEP, "wear_rate"),
        "K",
        f"mean rise of the contact at the velocity times own over other wear rate, {_RISE}",
    ),
    "pin_heat_share_at_wear_rate": Variable(
        (*_STEP, "wear_rate"),
        "1",
        "share of the heat that enters the pin at the velocity times own over other wear rate",
    ),
}
"""Variables of sweeps that answer for several wear rates besides `COLUMNS`."""
BULK_FIELDS = {
    "bulk_response": _field(
        "1", "rise of the pin for each kelvin by which the disk's bulk is warmer"
    ),
}
"""Variables of such scenes besides `FIELDS`."""
RECORDS = {
    "status": Variable(
        _POINT,
        None,
        "state of the point",
        "int8",
        {"flag_values": [PENDING, DONE, FAILED], "flag_meanings": "pending done failed"},
    ),
    "wall_time": Variable(_POINT, "s", "duration of the point's computation"),
    "finished_at": Variable(
        _POINT, "s", "time of the end of its computation, since 1970-01-01 UTC"
    ),
    "message": Variable(_POINT, None, "reason of a failure, or warnings", "str"),
    "warning_flags": Variable(
        _POINT,
        None,
        "kinds of warnings",
        "int32",
        {
            "flag_masks": [int(kind) for kind in WarningKind],
            "flag_meanings": " ".join(kind.label.replace(" ", "_") for kind in WarningKind),
        },
    ),
    "asked": Variable(_POINT, None, "1 if the last run asked for the point, else 0", "int8"),
    "checksum": Variable(_POINT, None, "BLAKE2b-64 of the point's place and data", "uint64"),
    "record_checksum": Variable(
        _POINT, None, "BLAKE2b-64 of its place, times, message and warnings", "uint64"
    ),
}

VARIABLES = COORDINATES | RECORDS | COLUMNS | BULK_COLUMNS | RATE_COLUMNS | FIELDS | BULK_FIELDS
"""All that a store may hold."""
STEPPED = COLUMNS | BULK_COLUMNS | RATE_COLUMNS
"""Variables at each step."""
AT_END = FIELDS | BULK_FIELDS
"""Variables at the end of a point."""


LEADING = ("realization", "sample")
"""Dimensions of which one may stand in front of the others."""

_INPUT = Variable(("sample",), None, "value of an input that is not known exactly")
_VELOCITY = Variable(("sample",), "m/s", "sliding velocity of the sample")


def is_coordinate(name: str) -> bool:
    """True if a variable is a coordinate: of a dimension, or an input by its path."""
    return name in COORDINATES or name not in VARIABLES


def variables(
    leading: Sequence[str],
    with_fields: bool,
    of_bulks: bool,
    of_rates: bool,
    inputs: Mapping[str, str],
    over: Mapping[str, str | None],
) -> dict[str, Variable]:
    """Variables of a store.

    Parameters
    ----------
    leading : sequence of str
        Dimensions in front of load and velocity.
    with_fields : bool
        True to keep the fields at the end of each point.
    of_bulks : bool
        True if the bodies differ in bulk temperature.
    of_rates : bool
        True if the points answer for several wear rates.
    inputs : mapping
        Unit of each input that is drawn, by its path in the scene.
    over : mapping
        Unit of each entry with several values, by its path; None for words.
    """
    absent = {name for name in LEADING if name not in leading}
    if not with_fields:
        absent |= {"x", "y", *AT_END}
    if not of_bulks:
        absent |= {"bulk_ratio", *BULK_COLUMNS, *BULK_FIELDS}
    if not of_rates:
        absent |= {"wear_rate", *RATE_COLUMNS}
    present = {name: variable for name, variable in VARIABLES.items() if name not in absent}
    # Each sample has one velocity.
    absent_dims = {"velocity"} if "sample" in leading else set[str]()
    dims = {
        name: (*leading, *(dim for dim in variable.dims if dim not in absent_dims))
        for name, variable in present.items()
    }
    table = {
        name: variable if name in COORDINATES else variable._replace(dims=dims[name])
        for name, variable in present.items()
    }
    if "sample" in leading:
        table["velocity"] = _VELOCITY
    entries = {
        path: Variable((path,), unit, f"{path} of the scene", "str" if unit is None else "float64")
        for path, unit in over.items()
    }
    return entries | {path: _INPUT._replace(units=unit) for path, unit in inputs.items()} | table


def block_of(sizes: Mapping[str, int], bytes_of_a_point: int) -> dict[str, int]:
    """Points in a chunk along each dimension that tells points apart.

    These are some hundred points, fewer where they are large: all loads, which one task computes
    after the other, then neighbouring velocities, then surfaces or samples.

    Parameters
    ----------
    sizes : mapping
        Points along each of these dimensions.
    bytes_of_a_point : int
        Size of a point in the largest variable [B].

    Examples
    --------
    >>> block_of({"load": 12, "velocity": 30}, 6000)
    {'load': 12, 'velocity': 30}
    >>> block_of({"load": 12, "velocity": 8334}, 2880)
    {'load': 12, 'velocity': 85}
    >>> block_of({"sample": 1000, "load": 4}, 1200)
    {'sample': 256, 'load': 4}
    """
    room = min(max(_LARGEST // bytes_of_a_point, _FEWEST), _MOST)
    block = dict.fromkeys(sizes, 1)
    block["load"] = min(sizes["load"], room)
    if "velocity" in sizes:  # to which a search adds others later
        block["velocity"] = max(1, min(max(sizes["velocity"], 16), room // block["load"]))
    for name in set(sizes) - {"load", "velocity"}:
        block[name] = max(1, min(sizes[name], room // math.prod(block.values())))
    return block


_LARGEST = 2**22  # bytes of a chunk
_FEWEST, _MOST = 64, 1024  # points in a chunk
_GROWING = 4096  # entries in a chunk of a coordinate that grows


def documents(
    wanted: Mapping[str, Variable],
    axes: Mapping[str, list[float]],
    block: Mapping[str, int],
) -> dict[str, bytes]:
    """Metadata of the arrays of a store and the chunks of its coordinates, as Zarr writes them.

    Parameters
    ----------
    wanted : mapping
        Variables of the store.
    axes : mapping
        Values along each dimension, and of each input.
    block : mapping
        Points in a chunk along each dimension that tells points apart, and the steps in one.

    Returns
    -------
    dict
        Contents of keys.
    """
    import zarr
    from zarr.codecs import ZstdCodec
    from zarr.storage import MemoryStore

    memory: dict[str, Any] = {}
    group = zarr.open_group(MemoryStore(memory), mode="w")
    for name, variable in wanted.items():
        shape = [len(axes[dim]) for dim in variable.dims]
        chunks = {**dict(zip(variable.dims, shape, strict=True)), **block}
        if is_coordinate(name):
            chunks |= {dim: _GROWING for dim in variable.dims if dim == "step" or is_of_points(dim)}
        elif name in AT_END:
            chunks |= {dim: 1 for dim in variable.dims if is_of_points(dim)}
        is_real = variable.dtype.startswith("float")
        units = {} if variable.units is None else {"units": variable.units}
        array = group.create_array(
            name,
            shape=shape,
            chunks=tuple(chunks[dim] for dim in variable.dims),
            dtype=str if variable.dtype == "str" else variable.dtype,
            fill_value="" if variable.dtype == "str" else np.nan if is_real else 0,
            compressors=ZstdCodec(**COMPRESSION),
            dimension_names=variable.dims,
            attributes={"long_name": variable.long_name, **units, **variable.attributes},
            chunk_key_encoding={"name": "default", "separator": "."},
        )
        if is_coordinate(name):
            array[:] = np.array(axes[name], variable.dtype)
    memory.pop("zarr.json")
    return {key: content.to_bytes() for key, content in memory.items()}


def metadata_of(documents: Mapping[str, bytes]) -> dict[str, Any]:
    """Metadata of each array, by its name."""
    ending = "/zarr.json"
    return {
        key.removesuffix(ending): json.loads(content)
        for key, content in documents.items()
        if key.endswith(ending)
    }


def chunk_name(numbers: Iterable[int]) -> str:
    """Name of a chunk in the folder of its array.

    Examples
    --------
    >>> chunk_name((0, 2))
    'c.0.2'
    """
    return ".".join(map(str, ("c", *numbers)))


def chunks_of(array: Mapping[str, Any]) -> list[int]:
    """Sizes of an array's chunks, by its metadata."""
    sizes: list[int] = array["chunk_grid"]["configuration"]["chunk_shape"]
    return sizes


def bytes_of_a_point(wanted: Mapping[str, Variable], axes: Mapping[str, list[float]]) -> int:
    """Size of a point in the largest variable that points share chunks of [B]."""
    return max(
        8 * math.prod(len(axes[dim]) for dim in variable.dims if not is_of_points(dim))
        for name, variable in wanted.items()
        if name in STEPPED
    )


def is_of_points(dim: str) -> bool:
    """True if a dimension tells points apart."""
    return dim not in ("step", "quantile", "bulk_ratio", "wear_rate", "x", "y")
