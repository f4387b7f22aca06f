"""The root of a store: its attributes and the metadata of all its arrays, replaced at one stroke.

A hash over the whole document tells whether it is what was written, another hash does the same for
the conditions, which no checksum of a point covers and which decide every answer.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.store.kinds import ATTRIBUTES, AXES, misfits
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
from tribo.errors import near_path

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
