"""The root of a store: its attributes and the metadata of all its arrays, replaced at one stroke.

A hash over the whole document tells whether it is what was written, another hash does the same for
the conditions, which no checksum of a point covers and which decide every answer.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import sys
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

from pipeline.store.lock import holder_of
from pipeline.store.place import (
    ROOT,
    Folder,
    PathLike,
    Place,
    StoreError,
    is_beginning,
    place_of,
    reaches,
)
from pipeline.store.schema import FORMAT, is_coordinate
from pipeline.sweep.about import Measurement
from pipeline.sweep.samples import Design
from pipeline.sweep.selection import Selection
from pipeline.sweep.stations import Stations
from pipeline.sweep.surface import Lubrication
from pipeline.sweep.unknown import Unknown
from tribo import Fidelity
from tribo.errors import near_path
from tribo.simulation.corrections import Corrections

_GREATEST = {float: sys.float_info.max, int: 2**63 - 1}


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
    return type(value) in kinds and (kind not in _GREATEST or abs(value) <= _GREATEST[kind])


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


MOST_POINTS = 10_000_000
"""Points that a store may have."""
_LARGEST = 2**28  # bytes of a root
_HASH, _OF_CONDITIONS = "root_hash", "conditions_hash"
_CONSOLIDATED = "consolidated_metadata"
_CODECS = {"bytes", "vlen-utf8", "zstd"}
_ELSEWHERE = (
    "irg run with the scene that made it makes it again; or restore it from a backup, or write to "
    "another store"
)


class LostRootError(StoreError):
    """The root of a store of which points are there is lost or damaged."""


class Root(NamedTuple):
    """Attributes of a store and the metadata of each array, as of the last change of its shape."""

    attributes: dict[str, Any]
    arrays: dict[str, Any]

    @property
    def axes(self) -> dict[str, list[Any]]:
        """Values along each dimension and of each input drawn, in the order of the store."""
        axes: dict[str, list[Any]] = self.attributes["axes"]
        return axes


def read_root(place: Place) -> Root:
    """Read the root of a store.

    Raise a `StoreError` if there is no store, or its root is lost, damaged or of another version.
    """
    root = find_root(place)
    if root is None and isinstance(place, Folder) and place.path.is_dir():
        with reaches(place):
            raise _unfinished(place) if place.keys() else _no_store(place)
    if root is None:
        near = near_path(place.path) if isinstance(place, Folder) else ""
        raise StoreError(f"{place} does not exist{near}; give a store that irg run made")
    return root


def find_root(place: Place) -> Root | None:
    """Read the root of a store; None if there is none, nor anything else; else as `read_root`."""
    with reaches(place):
        if isinstance(place, Folder):
            if place.path.is_file():
                raise StoreError(f"{place} is a file, not a store; give a folder that irg run made")
            _require_small(place.path / ROOT)
        content = place.read(ROOT)
        keys = place.keys() if content is None else set()
    if content is not None:
        return _parsed(place, content)
    if _has_points(keys):
        raise LostRootError(f"{place} has lost its {ROOT}; {_ELSEWHERE}")
    if not all(map(is_beginning, keys)):
        raise _no_store(place)
    return None


def read_attributes(path: PathLike) -> dict[str, Any] | None:
    """Attributes of a store, None if nothing is there; raises as `read_root` does."""
    root = find_root(place_of(path))
    return root.attributes if root else None


def root_document(attributes: Mapping[str, Any], arrays: Mapping[str, Any]) -> bytes:
    """Content of the root, as Zarr consolidates it.

    Zarr would write the attributes first and the metadata of the arrays later; a kill in between
    would leave a root that describes no store.
    """
    document = {
        "zarr_format": 3,
        "node_type": "group",
        "attributes": attributes,
        _CONSOLIDATED: {"kind": "inline", "must_understand": False, "metadata": arrays},
    }
    hashes = {_OF_CONDITIONS: _hash(_conditions(attributes)), _HASH: _hash(document)}
    document["attributes"] = {**attributes, **hashes}
    return json.dumps(document, allow_nan=False).encode()


def _parsed(place: Place, content: bytes) -> Root:
    try:
        root = json.loads(content)
        attributes, arrays = root["attributes"], root[_CONSOLIDATED]["metadata"]
        version, expected = attributes["format"], attributes.pop(_HASH, None)
        judged = attributes.pop(_OF_CONDITIONS, None)
        is_as_written = _hash(root) == expected
        conditions_are = _hash(_conditions(attributes)) == judged
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        if _has_points(place.keys()):
            raise LostRootError(f"{place}: {ROOT} is damaged; {_ELSEWHERE}") from None
        raise StoreError(
            f"{place} is not the store of a sweep; give a folder that irg run made"
        ) from None
    if is_as_written and version != FORMAT:
        raise StoreError(
            f"{place} has format {version}, and this program reads format {FORMAT}; make it anew: "
            "irg run its scene into another folder with -o, or after moving this one away"
        )
    if not (is_as_written and conditions_are):
        what = "it is" if conditions_are else "friction, temperatures or criterion in it are"
        raise LostRootError(
            f"{place}: {ROOT} is damaged: {what} not what was written; {_ELSEWHERE}"
        )
    root = Root(attributes, arrays)
    require_likely(place, root)
    return root


def _require_small(file: Path) -> None:
    """Refuse a root of more text than memory may have; a million points need 2 MB."""
    if file.is_file() and (size := file.stat().st_size) > _LARGEST:
        raise StoreError(
            f"{file.parent} is not the store of a sweep, or its {ROOT} is damaged: it has "
            f"{size:.2g} bytes; {_ELSEWHERE}"
        )


def require_likely(place: Place, root: Root) -> None:
    """Refuse a root of more points, other arrays or attributes of other kinds than a store has.

    The arrays are made as large as it says, before a chunk of them is read. Codecs of Zarr 2 may
    unpickle chunks, those of Zarr 3 are looked up among all that is installed, and a name with a
    slash would lead out of the store.
    """
    try:
        sizes = {name: len(values) for name, values in root.axes.items()}
        fits = all(
            array["zarr_format"] == 3
            and array["shape"] == [sizes[dim] for dim in array["dimension_names"]]
            and {codec["name"] for codec in array["codecs"]} <= _CODECS
            and (name not in sizes if not is_coordinate(name) else [sizes[name]] == array["shape"])
            and 0 not in array["chunk_grid"]["configuration"]["chunk_shape"]
            and "/" not in name
            for name, array in root.arrays.items()
        )
        fits &= {"checksum", "load", *sizes} <= root.arrays.keys()
        points = math.prod(root.arrays["status"]["shape"])
    except (KeyError, TypeError, AttributeError):
        fits, points = False, 0
    if not fits:
        raise StoreError(
            f"{place}: {ROOT} is damaged: its arrays are not of Zarr 3, or not those of a "
            f"store, of the sizes of its axes; {_ELSEWHERE}"
        )
    kinds = ATTRIBUTES | {"axes": {n: AXES.get(str(root.arrays[n]["data_type"])) for n in sizes}}
    if wrong := next(misfits(root.attributes, kinds), None):
        raise StoreError(
            f"{place}: {ROOT} is damaged: its attribute {wrong[1:]} is missing, or not of the kind "
            f"that a run writes; {_ELSEWHERE}"
        )
    if not _are_rows(root):
        raise StoreError(
            f"{place}: {ROOT} is damaged: its attributes over and scenes are not those of its "
            f"axes; {_ELSEWHERE}"
        )
    if points > MOST_POINTS:
        raise StoreError(
            f"{place}: {ROOT} tells of {points:.4g} points, and a store has at most "
            f"{MOST_POINTS:.0e}; {_ELSEWHERE}"
        )


def _are_rows(root: Root) -> bool:
    """True if there is a scene for each combination of the values of entries that have several."""
    names, rows = root.attributes.get("over", []), root.attributes.get("scenes", [])
    if not (names or rows):
        return True
    axes = [root.axes.get(name, []) for name in names]
    return (
        len(rows) == math.prod(map(len, axes))
        and {tuple(row["values"]) for row in rows} == set(itertools.product(*axes))
        and all(len(row["written"]) == len(names) for row in rows)
    )


def _has_points(keys: set[str]) -> bool:
    """True if a store has any status, by its keys."""
    return any(key.startswith("status/c.") for key in keys)


def _conditions(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """What each scene of a store is judged by."""
    others = [scene["attributes"] for scene in attributes.get("scenes", [])]
    return {name: attributes.get(name) for name in ("conditions", "friction_band")} | {"of": others}


def _hash(document: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _unfinished(place: Place) -> StoreError:
    """Error for a store whose creation goes on, or was cut short."""
    if holder := holder_of(place):
        return StoreError(f"{place} is being made by {holder}; try again in a few seconds")
    return StoreError(f"{place} was left unfinished as it was made; run its scene again")


def _no_store(place: Place) -> StoreError:
    return StoreError(
        f"{place} is not a store: there is no {ROOT}; give a folder that irg run made, or to run a "
        "scene into, one that is not there yet"
    )
