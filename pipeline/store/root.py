"""The root of a store: its sweep, facts and the metadata of its arrays, replaced at one stroke.

It has a hash of all.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.paths import near_path
from pipeline.scene.kept import SweepTextError, sweep_text, text_sweep
from pipeline.scene.resume import misfits
from pipeline.store.files import PARTIAL
from pipeline.store.inputs import split_arrays
from pipeline.store.layout import arrays_of
from pipeline.store.lock import holder_of
from pipeline.store.place import (
    LOCK,
    ROOT,
    DamagedError,
    Folder,
    PathLike,
    StoreError,
    StoreMismatchError,
    StorePlace,
    place_of,
    reaches,
    reads,
)
from pipeline.store.schema import (
    ABOUT,
    AT_ENDS,
    FORMAT,
    INPUTS,
    MADE,
    SCENE_ID,
    VARIABLES,
    is_coordinate,
    path_of,
    variables_of,
)
from pipeline.store.versions import package_versions, provenance
from pipeline.sweep.limits import MOST_BYTES_OF_ROOT, MOST_PARTS_OF_ROOT, MOST_POINTS
from pipeline.sweep.model import Sweep
from tribo import InputError
from tribo.types import Array

_CONSOLIDATED = "consolidated_metadata"
_CODECS = ["bytes", "zstd"], ["vlen-utf8", "zstd"]
_TYPES = {"bool", "int8", "int32", "int64", "float32", "float64", "string"}
_LARGEST = 2**27  # values of a chunk: 64 points of a thousand steps, with unequal bulks
_ANEW = "run its scene into another store"
_ELSEWHERE = f"restore it from a backup, or {_ANEW}"


Versions = dict[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Description of a store, without its sweep."""

    axes: dict[str, list[Any]]  # values along each dimension, and of columns that follow from one
    points_per_chunk: dict[str, int]
    versions: Versions  # those of the packages that began it
    later_versions: dict[str, Versions] = field(default_factory=dict)  # by the time they came
    worker_versions: dict[str, Versions] = field(default_factory=dict)

    def note_versions(self) -> Facts:
        """The facts, with the versions of this process noted if they are not the last ones."""
        *_, last = self.versions, *self.later_versions.values()
        if last == package_versions():
            return self
        return replace(self, later_versions=self.later_versions | {now(): package_versions()})


def now() -> str:
    """The present time."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


Document = dict[str, Any]
"""What a file of JSON says."""


class Root(NamedTuple):
    """The sweep of a store, what it says of itself, and the metadata of each array.

    `ids` are those of the rows of the sweep, in the order of its table. `others` has attributes and
    metadata that are not of the store, as users add them, and stays as it is.
    """

    sweep: Sweep
    facts: Facts
    ids: list[int]
    arrays: Document
    others: Document

    @property
    def axes(self) -> dict[str, list[Any]]:
        """Values along each dimension and of each input drawn, in the order of the store."""
        return self.facts.axes

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the dataset: words for people, and the texts of the sweep and its ids."""
        facts = self.facts
        return {
            "Conventions": "CF-1.11",
            "title": self.sweep.about.title,
            **provenance(facts.versions, facts.later_versions, facts.worker_versions),
            "sweep": sweep_text(self.sweep),
            SCENE_ID: json.dumps(self.ids),
        }


def read_root(place: StorePlace) -> Root:
    """Read a root; raise a `StoreError` if it is missing, lost, damaged or of another version.

    Nothing makes it again: the line says what to do.
    """
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
        raise StoreError(f"{place} has lost its {ROOT}; {_ELSEWHERE}")
    if not all(map(_is_beginning, keys)):
        raise _no_store(place)
    return None


def read_sweep(path: PathLike) -> Sweep:
    """The sweep of a store; raises as `read_root` does."""
    return read_root(place_of(path)).sweep


def find_sweep(path: PathLike) -> Sweep | None:
    """The sweep of a store, None if nothing is there; raises as `read_root` does."""
    root = find_root(place_of(path))
    return root.sweep if root else None


def root_documents(root: Root) -> dict[str, bytes]:
    """Documents of the groups of a store, by key: the root, as Zarr consolidates it, comes last.

    Zarr itself would write it in two steps. It has all that the others have, which are there for
    programs that consolidate it anew.
    """
    attributes = root.attributes
    about = {"format": FORMAT, **asdict(root.facts)}
    about["digest"] = _digest(attributes, about, root.arrays)
    groups = {ABOUT: _group(about), AT_ENDS: _group({})}
    whole = root.others["metadata"] | groups
    whole |= {path_of(name): array for name, array in root.arrays.items()}
    # Zarr finds the members of a group only where they stand side by side.
    paths = sorted(whole, key=lambda path: path.rpartition("/")[0])
    metadata = {path: whole[path] for path in paths}
    consolidated = {"kind": "inline", "must_understand": False, "metadata": metadata}
    groups[""] = _group(root.others["attributes"] | attributes) | {_CONSOLIDATED: consolidated}
    return {
        f"{name}/{ROOT}".removeprefix("/"): json.dumps(group, allow_nan=False).encode()
        for name, group in groups.items()
    }


def _group(attributes: Document) -> Document:
    return {"zarr_format": 3, "node_type": "group", "attributes": attributes}


def _digest(attributes: Document, about: Document, arrays: Document) -> str:
    """Hash of what a store reads of its root; not of words, nor of what users have added."""
    numbers = {
        name: {**array, "attributes": _inner_attributes(name, array)}
        for name, array in arrays.items()
        if name == INPUTS or not is_coordinate(name)
    }
    about = {name: value for name, value in about.items() if name != "digest"}
    read = [attributes["sweep"], attributes[SCENE_ID], about, numbers]
    return hashlib.sha256(json.dumps(read, sort_keys=True).encode()).hexdigest()


def _inner_attributes(name: str, array: Document) -> Document:
    """Attributes of an array without which its values cannot be read."""
    return array["attributes"] if name == INPUTS else {}


def _own_arrays(metadata: Document) -> Document:
    """Metadata of the arrays of points and of the scene, by the names of the variables."""
    names = [INPUTS, *(name for name in VARIABLES if not is_coordinate(name))]
    return {name: metadata[path_of(name)] for name in names if path_of(name) in metadata}


def _parsed(place: StorePlace, content: bytes) -> Root:
    if (parts := content.count(b"[") + content.count(b"{")) > MOST_PARTS_OF_ROOT:
        raise StoreError(
            f"{place}: {ROOT} is damaged: it has {parts} lists and tables, and that of a store has "
            f"at most {MOST_PARTS_OF_ROOT}; {_ELSEWHERE}"
        )
    try:
        document = json.loads(content)
        attributes, metadata = document["attributes"], document[_CONSOLIDATED]["metadata"]
        about = dict(metadata[ABOUT]["attributes"])
        version, expected = about["format"], about.pop("digest")
        arrays = _own_arrays(metadata)
        is_as_written = version != FORMAT or _digest(attributes, about, arrays) == expected
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise _unreadable(place, content) from None
    if version != FORMAT:
        raise _of_another_format(place, version)
    if not is_as_written:
        raise StoreError(f"{place}: {ROOT} is damaged: it is not what was written; {_ELSEWHERE}")
    del about["format"]
    try:
        built = Facts(**about)
        require_plain(arrays)
        sweep, ids = text_sweep(attributes["sweep"], _inputs(place, arrays)), attributes[SCENE_ID]
        wanted = variables_of(sweep).keys() - {*MADE, SCENE_ID}
        if unlike := sorted((arrays.keys() - {INPUTS} | built.axes.keys()) ^ wanted):
            raise SweepTextError(f"the variable {unlike[0]} is unknown or missing")
        if (points := math.prod(arrays["status"]["shape"])) > MOST_POINTS:
            raise SweepTextError(
                f"it has {points:.4g} points, and a store at most {MOST_POINTS:.0e}"
            )
    except DamagedError as error:
        raise StoreError(f"{place}: the arrays of its scene are damaged; {_ELSEWHERE}") from error
    except (InputError, ValueError, KeyError, TypeError) as error:
        raise StoreError(
            f"{place} is of another version of this program, or damaged: {error}; {_ANEW}"
        ) from error
    root = Root(sweep, built, json.loads(ids), arrays, {})
    others = {name: attributes[name] for name in attributes.keys() - root.attributes.keys()}
    return root._replace(others={"attributes": others, "metadata": metadata})


def _unreadable(place: StorePlace, content: bytes) -> StoreError:
    """What is wrong with a root that does not say what a store is."""
    with reaches(place):
        has_points = _has_points(place.keys())
    if has_points:
        return StoreError(f"{place}: {ROOT} is damaged; {_ELSEWHERE}")
    return StoreError(f"{place} is not the store of a sweep; give a folder that irg run made")


def _of_another_format(place: StorePlace, version: Any) -> StoreError:
    return StoreError(
        f"{place} is of another version of this program: it has format {version}, and this one "
        f"reads {FORMAT}; {_ANEW}"
    )


def _inputs(place: StorePlace, arrays: Mapping[str, Any]) -> dict[str, Array]:
    """Arrays of the scene that a store has."""
    if INPUTS not in arrays:
        return {}
    array = arrays_of(place, {INPUTS: arrays[INPUTS]}, read_only=True)[INPUTS]
    with reads(place, INPUTS):
        return split_arrays(array[:], array.attrs)


def _require_small_file(folder: Path) -> None:
    """Refuse a root of more text than memory may have; a million points need 2 MB."""
    if folder.is_file():
        raise StoreError(f"{folder} is a file, not a store; give a folder that irg run made")
    file = folder / ROOT
    if file.is_file() and (size := file.stat().st_size) > MOST_BYTES_OF_ROOT:
        raise StoreError(
            f"{folder} is not the store of a sweep, or its {ROOT} is damaged: it has {size:.2g} "
            f"bytes; {_ELSEWHERE}"
        )


def require_plain(arrays: Mapping[str, Any]) -> None:
    """Raise a `SweepTextError` for arrays that are not as a store has them.

    They are made as large as they say, before a chunk of them is read. Codecs of Zarr 2 may
    unpickle chunks, and those of Zarr 3 are looked up among all that is installed.
    """
    try:
        are_plain = all(
            array["zarr_format"] == 3
            and [codec["name"] for codec in array["codecs"]] in _CODECS
            and array["data_type"] in _TYPES
            and all(size <= MOST_POINTS for size in array["shape"])
            and 0 < math.prod(array["chunk_grid"]["configuration"]["chunk_shape"]) <= _LARGEST
            for array in arrays.values()
        )
    except (KeyError, TypeError, AttributeError):
        are_plain = False
    if not are_plain:
        raise SweepTextError("its arrays are not of Zarr 3, or not those of a store")


def require_same_scene(place: StorePlace, root: Root, sweep: Sweep) -> None:
    """Raise a `StoreMismatchError` if a sweep cannot go on with the store of a root."""
    if differing := [*misfits(root.sweep, sweep)]:
        advice = "give it what the store has, or write to another store"
        raise StoreMismatchError(
            "\n  ".join([f"{place} belongs to another scene; {advice}", *differing])
        )


def _is_beginning(key: str) -> bool:
    """True for what a creation cut short may leave: metadata, coordinates or the lock, no root."""
    if key.startswith(LOCK) or key == ROOT + PARTIAL:
        return True
    name, _, rest = key.removesuffix(PARTIAL).rpartition("/")
    return rest == ROOT or (rest.startswith("c.") and is_coordinate(name))


def _has_points(keys: set[str]) -> bool:
    """True if a store has any status, by its keys."""
    return any(key.startswith("status/c.") for key in keys)


def _no_store(place: StorePlace) -> StoreError:
    return StoreError(
        f"{place} is not a store: there is no {ROOT}; give a folder that irg run made, or to run a "
        "scene into, one that is not there yet"
    )
