"""The root of a store: its attributes and the metadata of its arrays, replaced at one stroke.

It has a hash of all, and one of the conditions, which no checksum of a point covers.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.store.files import PARTIAL
from pipeline.store.layout import arrays_of
from pipeline.store.lock import holder_of
from pipeline.store.place import (
    LOCK,
    ROOT,
    DamagedError,
    Folder,
    PathLike,
    StoreError,
    StorePlace,
    place_of,
    reaches,
    reads,
)
from pipeline.store.schema import FORMAT, is_coordinate
from pipeline.sweep.about import Measurement
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.plain import made, record_of
from pipeline.sweep.samples import Design
from pipeline.sweep.selection import Selection
from pipeline.sweep.stations import Stations
from pipeline.sweep.surface import Lubrication
from pipeline.sweep.unknown import Unknown
from tribo import Fidelity
from tribo.errors import near_path

_VERSIONS = {"tribo": str, "numpy": str, "scipy": str, "zarr": str}
_OF_SCENE = {
    "fidelity": {**record_of(Fidelity), "type": str},
    "loading": {"hold?": float, ...: Any},
    "friction_heat": bool,
    "unequal_bulks": bool,
    "samples?": {**record_of(Design), "inputs": dict[str, Unknown]},
    ...: Any,
}
_CONDITIONS = {**record_of(Conditions), "criterion_hash?": str}
del _CONDITIONS["own_criterion?"]
_FOLLOWING = {
    "selection": {**record_of(Selection), "points": [{"load": float, "velocity": float}]},
    "lubrication": Lubrication,
    "name": str,
    "title": str,
    "arguments": list[str],
    "preset": str | None,
    "conditions": _CONDITIONS,
    "friction_band": tuple[float, float] | None,
    "sample_corrections": dict[str, list[Any]],
    "surface": str | None,
    "same_rig": bool,
    "measured": list[Measurement],
    "tested": list[Measurement],
    "library": [{"key": str, "value": str, "source": str}],
    "loads": list[float],
    "velocities": list[float],
}
"""Attributes that follow the scene file; some only where a scene has them."""
_RARE = ("selection", "lubrication", "sample_corrections")
_ROW = {
    "values": list[float | str],
    "written": list[float | str],
    "scene": dict[str, Any],
    "attributes": {f"{name}?": (kind, type(None)) for name, kind in _FOLLOWING.items()},
}
ATTRIBUTES: dict[Any, Any] = {
    **{name + "?" * (name in _RARE): kind for name, kind in _FOLLOWING.items()},
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
    "samples?": int,
    "sample_seed?": int,
    "unknown?": list[Unknown],
    "fixed?": [{**record_of(Unknown), "value": float}],
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
ELSEWHERE = (
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


def read_root(place: StorePlace) -> Root:
    """Read a root; raise a `StoreError` if it is missing, lost, damaged or of another version."""
    root = find_root(place)
    if root is not None:
        return root
    if not (isinstance(place, Folder) and place.path.is_dir()):
        near = near_path(place.path) if isinstance(place, Folder) else ""
        raise StoreError(f"{place} does not exist{near}; give a store that irg run made")
    with reaches(place):
        if not place.keys():
            raise _no_store(place)
    if holder := holder_of(place):
        raise StoreError(f"{place} is being made by {holder}; try again in a few seconds")
    raise StoreError(f"{place} was left unfinished as it was made; run its scene again")


def find_root(place: StorePlace) -> Root | None:
    """Read the root of a store; None if there is none, nor anything else; else as `read_root`."""
    with reaches(place):
        if isinstance(place, Folder):
            _require_small_file(place.path)
        content = place.read(ROOT)
        keys = place.keys() if content is None else set()
    if content is not None:
        return _parsed(place, content)
    if _has_points(keys):
        raise LostRootError(f"{place} has lost its {ROOT}; {ELSEWHERE}")
    if not all(map(_is_beginning, keys)):
        raise _no_store(place)
    return None


def read_attributes(path: PathLike) -> dict[str, Any] | None:
    """Attributes of a store, None if nothing is there; raises as `read_root` does."""
    root = find_root(place_of(path))
    return root.attributes if root else None


def root_document(attributes: Mapping[str, Any], arrays: Mapping[str, Any]) -> bytes:
    """Content of the root as Zarr consolidates it, which would write it in two steps."""
    document = {
        "zarr_format": 3,
        "node_type": "group",
        "attributes": attributes,
        _CONSOLIDATED: {"kind": "inline", "must_understand": False, "metadata": arrays},
    }
    hashes = {_OF_CONDITIONS: _hash(_conditions(attributes)), _HASH: _hash(document)}
    document["attributes"] = {**attributes, **hashes}
    return json.dumps(document, allow_nan=False).encode()


def _parsed(place: StorePlace, content: bytes) -> Root:
    try:
        root = json.loads(content)
        attributes, arrays = root["attributes"], root[_CONSOLIDATED]["metadata"]
        version, expected = attributes["format"], attributes.pop(_HASH, None)
        judged = attributes.pop(_OF_CONDITIONS, None)
        is_as_written = _hash(root) == expected
        conditions_are = _hash(_conditions(attributes)) == judged
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        with reaches(place):
            has_points = _has_points(place.keys())
        if has_points:
            raise LostRootError(f"{place}: {ROOT} is damaged; {ELSEWHERE}") from None
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
        raise LostRootError(f"{place}: {ROOT} is damaged: {what} not what was written; {ELSEWHERE}")
    root = Root(attributes, arrays)
    require_likely(place, root)
    return root


def _require_small_file(folder: Path) -> None:
    """Refuse a root of more text than memory may have; a million points need 2 MB."""
    if folder.is_file():
        raise StoreError(f"{folder} is a file, not a store; give a folder that irg run made")
    file = folder / ROOT
    if file.is_file() and (size := file.stat().st_size) > _LARGEST:
        raise StoreError(
            f"{folder} is not the store of a sweep, or its {ROOT} is damaged: it has {size:.2g} "
            f"bytes; {ELSEWHERE}"
        )


def require_likely(place: StorePlace, root: Root) -> None:
    """Refuse a root of more points, other arrays or attributes of other kinds than a store has."""
    fault = _fault(root)
    if not (fault or are_rows(root)):
        fault = "is damaged: its attributes over and scenes are not those of its axes"
    if fault:
        raise StoreError(f"{place}: {ROOT} {fault}; {ELSEWHERE}")


_WHO = ("versions", "later_versions", "worker_versions")


def copied_attributes(attributes: Mapping[str, Any]) -> dict[str, str]:
    """Attributes of the array `step`, from which a root takes the versions if it is made again."""
    versions = {name: attributes[name] for name in _WHO if name in attributes}
    return {"versions": json.dumps(versions)}


def copied(place: StorePlace, names: Iterable[str]) -> Root:
    """What arrays of these names have of a root: axes, stations and versions, and their metadata.

    Raise a `DamagedError` if they do not belong together.
    """
    try:
        with reaches(place):
            read = {f"{name}/{ROOT}": place.read(f"{name}/{ROOT}") for name in names}
        if lost := [key for key, content in read.items() if content is None]:
            raise ValueError(f"{lost[0]} is lost")
        arrays = {name: json.loads(read[f"{name}/{ROOT}"] or b"") for name in names}
        axes: dict[str, Any] = {name: () for name in arrays if is_coordinate(name)}
        along = {name: arrays[name] for name in axes}
        if not all(map(_is_plain, along.values())):
            raise ValueError("their axes are not those of a store")
        for name, array in arrays_of(place, along, read_only=True).items():
            with reads(place, name):
                axes[name] = array[:].tolist()
        status = arrays["status"]
        chunk = status["chunk_grid"]["configuration"]["chunk_shape"]
        block = zip(status["dimension_names"], chunk, strict=True)
        copies = arrays["step"]["attributes"]
        versions = json.loads(copies["versions"])
        return Root(
            {name: versions[name] for name in _WHO if name in versions}
            | {"stations": json.loads(copies["stations"])}
            | {"axes": axes, "points_per_chunk": dict(block)},
            arrays,
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise DamagedError(f"{place}: the arrays make no root: {error}") from error


def is_likely(root: Root) -> bool:
    """True for a root that may be that of a store, but for values of entries that it lacks."""
    return not _fault(root)


def _fault(root: Root) -> str:
    """Fault of a root; empty if it may be that of a store.

    The arrays are made as large as it says, before a chunk of them is read. Codecs of Zarr 2 may
    unpickle chunks, those of Zarr 3 are looked up among all that is installed, and a name with a
    slash would lead out of the store.
    """
    try:
        sizes = {name: len(values) for name, values in root.axes.items()}
        fits = {"checksum", "load", *sizes} <= root.arrays.keys() and all(
            _is_plain(array)
            and array["shape"] == [sizes[dim] for dim in array["dimension_names"]]
            and (name not in sizes if not is_coordinate(name) else [sizes[name]] == array["shape"])
            and 0 not in array["chunk_grid"]["configuration"]["chunk_shape"]
            and array["attributes"].keys() >= {"long_name"}
            and "/" not in name
            for name, array in root.arrays.items()
        )
        points = math.prod(root.arrays["status"]["shape"])
    except (KeyError, TypeError, AttributeError):
        fits, points = False, 0
    if not fits:
        return (
            "is damaged: its arrays are not of Zarr 3, or not those of a store, of the sizes of "
            "its axes"
        )
    kinds = ATTRIBUTES | {"axes": {n: AXES.get(str(root.arrays[n]["data_type"])) for n in sizes}}
    try:
        made(kinds, root.attributes)
    except ValueError as wrong:
        kind = "is missing, or not of the kind that a run writes"
        return f"is damaged: its attribute {wrong} {kind}"
    if points > MOST_POINTS:
        return f"tells of {points:.4g} points, and a store has at most {MOST_POINTS:.0e}"
    return ""


def _is_plain(array: Mapping[str, Any]) -> bool:
    """True for metadata of an array with codecs of a store, of which each axis may be one."""
    codecs = {codec["name"] for codec in array["codecs"]}
    is_short = all(size <= MOST_POINTS for size in array["shape"])
    return array["zarr_format"] == 3 and codecs <= _CODECS and is_short


def are_rows(root: Root) -> bool:
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


def _is_beginning(key: str) -> bool:
    """True for what a creation cut short may leave: metadata, coordinates or the lock, no root."""
    if key.startswith(LOCK) or key == ROOT + PARTIAL:
        return True
    name, _, rest = key.removesuffix(PARTIAL).partition("/")
    return rest == ROOT or (rest.startswith("c.") and is_coordinate(name))


def _has_points(keys: set[str]) -> bool:
    """True if a store has any status, by its keys."""
    return any(key.startswith("status/c.") for key in keys)


def _conditions(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """What each scene of a store is judged by."""
    others = [scene["attributes"] for scene in attributes.get("scenes", [])]
    names = ("conditions", "friction_band", "sample_corrections")
    return {name: attributes[name] for name in names if name in attributes} | {"of": others}


def _hash(document: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _no_store(place: StorePlace) -> StoreError:
    return StoreError(
        f"{place} is not a store: there is no {ROOT}; give a folder that irg run made, or to run a "
        "scene into, one that is not there yet"
    )
