"""Kinds of plain data that the attributes of a store are, of which those of a stranger may lie.

A kind is a type hint, a tuple of kinds of which one fits, a list with the kind of its entries, or a
record: kinds by name, where a name ends with ``?`` if it may be missing, and ``...`` if others may
be there.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from pipeline.sweep.about import Measurement
from pipeline.sweep.samples import Design
from pipeline.sweep.selection import Selection
from pipeline.sweep.stations import Stations
from pipeline.sweep.surface import Lubrication
from pipeline.sweep.unknown import Unknown
from tribo import Fidelity
from tribo.simulation.corrections import Corrections

_LARGEST = {float: sys.float_info.max, int: 2**63 - 1}


def misfits(value: Any, kind: Any, path: str = "") -> Iterator[str]:
    """Paths of the values within plain data that are not of their kind.

    Numbers are finite, and a whole one is a real one, too.

    Examples
    --------
    >>> kind = {"loads": list[float], "title?": str | None}
    >>> [*misfits({"loads": [200, "x"], "title": 3}, kind)], [*misfits({"title": None}, kind)]
    (['.loads.1', '.title'], ['.loads'])
    """
    origin, inner = get_origin(kind), get_args(kind)
    if is_dataclass(kind):
        kind = _record_of(kind)
    if kind is Any or (origin is Literal and value in inner):
        return
    if isinstance(kind, dict):
        yield from _misfits_of_record(value, kind, path)
    elif origin is dict:
        others = dict.fromkeys(value, inner[1]) if isinstance(value, dict) else {}
        yield from _misfits_of_record(value, others, path)
    elif isinstance(kind, tuple) or origin in (Union, UnionType):
        kinds = kind if isinstance(kind, tuple) else inner
        found = [[*misfits(value, one, path)] for one in kinds]
        if all(found):
            yield max((paths[0] for paths in found), key=len)
    elif isinstance(kind, list) or origin in (list, tuple):
        yield from _misfits_of_list(value, inner or kind, path)
    elif not _is_one(value, kind):
        yield path


def _record_of(kind: Any) -> dict[Any, Any]:
    """What a dataclass is made from, as a record."""
    hints = get_type_hints(kind)
    return {
        field.name + "?" * (field.default is not MISSING): hints[field.name]
        for field in fields(kind)
        if field.init
    }


def _misfits_of_record(value: Any, record: Mapping[Any, Any], path: str) -> Iterator[str]:
    if not isinstance(value, dict):
        yield path
        return
    names = {name.removesuffix("?"): name for name in record if name is not ...}
    if ... not in record:
        yield from (f"{path}.{name}" for name in value if name not in names)
    for name, noted in names.items():
        if name in value:
            yield from misfits(value[name], record[noted], f"{path}.{name}")
        elif name == noted:
            yield f"{path}.{name}"


def _misfits_of_list(value: Any, inner: Any, path: str) -> Iterator[str]:
    """Those of a list whose entries are of one kind, or of one each."""
    is_of_one = len(inner) == 1 or inner[-1] is ...
    if not isinstance(value, list) or not (is_of_one or len(inner) == len(value)):
        yield path
        return
    kinds = [inner[0]] * len(value) if is_of_one else inner
    for number, (entry, kind) in enumerate(zip(value, kinds, strict=True)):
        yield from misfits(entry, kind, f"{path}.{number}")


def _is_one(value: Any, kind: Any) -> bool:
    kinds = (int, float) if kind is float else (type(None) if kind is None else kind,)
    return type(value) in kinds and (kind not in _LARGEST or abs(value) <= _LARGEST[kind])


_VERSIONS = {"tribo": str, "numpy": str, "scipy": str, "zarr": str}
_OF_SCENE = {
    "fidelity": {**_record_of(Fidelity), "type": str},
    "loading": {"hold?": float, ...: Any},
    "friction_heat": bool,
    "unequal_bulks": bool,
    "samples?": {**_record_of(Design), "inputs": dict[str, Unknown]},
    ...: Any,
}
_CONDITIONS = {
    "friction": (float, None),
    "bulk_temperature": (float, None),
    "critical_temperature": (float, None),
    "failing_share": (float, None),
    "criterion": str,
    "disk_temperature?": (float, None),
    "corrections?": (Corrections, None),
    "criterion_hash?": str,
}
_PLACE = {"load": float, "velocity": float}
_FOLLOWING = {
    "selection": {**_record_of(Selection), "points": [_PLACE]},
    "lubrication": Lubrication,
    "name": str,
    "title": str,
    "arguments": list[str],
    "preset": str | None,
    "conditions": _CONDITIONS,
    "friction_band": tuple[float, float] | None,
    "surface": str | None,
    "same_rig": bool,
    "measured": list[Measurement],
    "tested": list[Measurement],
    "library": [{"key": str, "value": str, "source": str}],
    "loads": list[float],
    "velocities": list[float],
}
"""Attributes that follow the scene file; the first two only where a scene has them."""
_LABEL = (float, str)
_ROW = {
    "values": [_LABEL],
    "written": [_LABEL],
    "scene": dict[str, Any],
    "attributes": {f"{name}?": (kind, None) for name, kind in _FOLLOWING.items()},
}
ATTRIBUTES: dict[Any, Any] = {
    **{name + "?" * (name in ("selection", "lubrication")): k for name, k in _FOLLOWING.items()},
    "Conventions": str,
    "format": int,
    "scene": _OF_SCENE,
    "scene_hash": str,
    "stations": Stations,
    "versions": _VERSIONS,
    "later_versions?": [{"since": str, "versions": _VERSIONS}],
    "worker_versions?": [{"since": str, "versions": dict[str, str]}],
    "boundary_only": bool,
    "coordinates?": str,
    "realizations": list[int],
    "wear_rates?": tuple[float, float],
    "samples?": int,
    "sample_seed?": int,
    "unknown?": list[Unknown],
    "fixed?": [{**_record_of(Unknown), "value": float}],
    "over?": list[str],
    "scenes?": [_ROW],
    "axes": {...: Any},
    "points_per_chunk": dict[str, int],
    "generation": int,
}
"""Attributes of the root of a store."""
AXES = {"float64": list[float], "int64": list[int], "string": list[str]}
"""Values along an axis, by the type of its array."""
