"""The root of a store: its sweep, facts and the metadata of its arrays, replaced at one stroke.

It has a hash of all.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.store.files import PARTIAL
from pipeline.store.inputs import DIM, split_arrays
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
from pipeline.store.schema import (
    COLUMNS,
    FORMAT,
    INPUTS,
    MADE,
    PLANE,
    RECORDS,
    VARIABLES,
    is_coordinate,
)
from pipeline.store.versions import package_versions, provenance
from pipeline.sweep.codec import Arrays, CodecError, build, fits, sweep_text, text_sweep
from pipeline.sweep.limits import MOST_BYTES_OF_ROOT, MOST_PARTS_OF_ROOT, MOST_POINTS
from pipeline.sweep.model import Sweep
from pipeline.sweep.stations import Stations
from tribo.errors import near_path

_AXES = {"float64": list[float], "int64": list[int], "string": list[str]}
"""Values along an axis, by the type of its array."""
_CONSOLIDATED = "consolidated_metadata"
_CODECS = {"bytes", "vlen-utf8", "zstd"}
ELSEWHERE = (
    "irg run with the scene that made it makes it again; or restore it from a backup, or write to "
    "another store"
)
_UNLIKE = "is of another version of this program, or damaged"


class LostRootError(StoreError):
    """The root of a store is lost or damaged, while its points are there."""


Versions = dict[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Description of a store, without its sweep."""

    generation: int  # how often its points have moved
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


class Root(NamedTuple):
    """The sweep of a store, what it says of itself, and the metadata of each array."""

    sweep: Sweep
    facts: Facts
    arrays: dict[str, Any]

    @property
    def axes(self) -> dict[str, list[Any]]:
        """Values along each dimension and of each input drawn, in the order of the store."""
        return self.facts.axes

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the dataset: words for people, and the texts of sweep and store."""
        facts = self.facts
        return {
            "Conventions": "CF-1.11",
            "title": self.sweep.about.title,
            **provenance(facts.versions, facts.later_versions, facts.worker_versions),
            "sweep": sweep_text(self.sweep, {}),
            "store": json.dumps({"format": FORMAT, **asdict(facts), "hash": ""}),
        }


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


def read_sweep(path: PathLike) -> Sweep:
    """The sweep of a store; raises as `read_root` does."""
    return read_root(place_of(path)).sweep


def find_sweep(path: PathLike) -> Sweep | None:
    """The sweep of a store, None if nothing is there; raises as `read_root` does."""
    root = find_root(place_of(path))
    return root.sweep if root else None


def root_document(root: Root) -> bytes:
    """Content of the root as Zarr consolidates it, which would write it in two steps."""
    document = {
        "zarr_format": 3,
        "node_type": "group",
        "attributes": root.attributes,
        _CONSOLIDATED: {"kind": "inline", "must_understand": False, "metadata": root.arrays},
    }
    return sealed(document)


def sealed(document: dict[str, Any]) -> bytes:
    """The document of a root, with the hash of all of it in the text on its store."""
    return json.dumps(_hashed(document, _hash(document)), allow_nan=False).encode()


def _hashed(document: dict[str, Any], digest: str) -> dict[str, Any]:
    """The document of a root with a hash in the text on its store."""
    attributes = document["attributes"]
    text = json.dumps(json.loads(attributes["store"]) | {"hash": digest})
    return document | {"attributes": attributes | {"store": text}}


def _parsed(place: StorePlace, content: bytes) -> Root:
    if (parts := content.count(b"[") + content.count(b"{")) > MOST_PARTS_OF_ROOT:
        raise StoreError(
            f"{place}: {ROOT} is damaged: it has {parts} lists and tables, and that of a store has "
            f"at most {MOST_PARTS_OF_ROOT}; {ELSEWHERE}"
        )
    try:
        document = json.loads(content)
        attributes, arrays = document["attributes"], dict(document[_CONSOLIDATED]["metadata"])
        facts = json.loads(attributes.get("store", "{}")) or {"hash": "", **attributes}
        version, expected = facts.pop("format"), facts.pop("hash")
        is_as_written = "store" not in attributes or _hash(document) == expected
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        with reaches(place):
            has_points = _has_points(place.keys())
        if has_points:
            raise LostRootError(f"{place}: {ROOT} is damaged; {ELSEWHERE}") from None
        raise StoreError(
            f"{place} is not the store of a sweep; give a folder that irg run made"
        ) from None
    if not is_as_written:
        raise LostRootError(f"{place}: {ROOT} is damaged: it is not what was written; {ELSEWHERE}")
    if version != FORMAT:
        raise StoreError(
            f"{place} has format {version}, and this program reads format {FORMAT}; make it anew: "
            "irg run its scene into another folder with -o, or after moving this one away"
        )
    try:
        built: Facts = build(Facts, facts)
    except CodecError as error:
        raise _root_error(place, f"{_UNLIKE}: {error}") from error
    _require_known(place, built, arrays)
    require_likely(place, built, arrays)
    try:
        root = Root(text_sweep(attributes["sweep"], _inputs(place, arrays)), built, arrays)
    except (CodecError, DamagedError) as error:
        fault = "is damaged" if isinstance(error, DamagedError) else _UNLIKE
        raise LostRootError(f"{place}: {ROOT} {fault}: {error}; {ELSEWHERE}") from error
    if not are_rows(root):
        raise _root_error(place, "is damaged: its axes are not those of its sweep")
    return root


def _inputs(place: StorePlace, arrays: Mapping[str, Any]) -> Arrays:
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
            f"bytes; {ELSEWHERE}"
        )


def require_likely(place: StorePlace, facts: Facts, arrays: Mapping[str, Any]) -> None:
    """Refuse a root of more points, other arrays or axes than a store has."""
    if fault := root_fault(facts, arrays):
        raise _root_error(place, fault)


def _root_error(place: StorePlace, fault: str) -> StoreError:
    return StoreError(f"{place}: {ROOT} {fault}; {ELSEWHERE}")


_WHO = ("versions", "later_versions", "worker_versions")


def copied_attributes(root: Root) -> dict[str, str]:
    """Attributes of the array `step`, from which a root takes this if it is made again."""
    versions = {name: getattr(root.facts, name) for name in _WHO}
    stations = root.sweep.record.stations
    return {
        "versions": json.dumps(versions),
        "stations": json.dumps(stations and asdict(stations)),
    }


def copied(place: StorePlace, names: Iterable[str]) -> tuple[Stations, Facts, dict[str, Any]]:
    """What arrays of these names have of a root.

    Raise a `DamagedError` if they do not belong together.
    """
    try:
        with reaches(place):
            read = {name: place.read(f"{name}/{ROOT}") for name in names}
        if lost := [name for name, content in read.items() if content is None]:
            raise ValueError(f"{lost[0]}/{ROOT} is lost")
        arrays = {name: json.loads(content or b"") for name, content in read.items()}
        along = {k: v for k, v in arrays.items() if is_coordinate(k) and k not in _NO_AXES}
        if not all(map(_is_plain, along.values())):
            raise ValueError("their axes are not those of a store")
        axes = {}
        for name, array in arrays_of(place, along, read_only=True).items():
            with reads(place, name):
                axes[name] = array[:].tolist()
        status = arrays["status"]
        chunk = status["chunk_grid"]["configuration"]["chunk_shape"]
        block = zip(status["dimension_names"], chunk, strict=True)
        copies = arrays["step"]["attributes"]
        stations = json.loads(copies["stations"])
        facts = {"generation": 0, "axes": axes, "points_per_chunk": dict(block)}
        return (
            build(Stations, stations | {"holds": tuple(stations["holds"])}),
            build(Facts, facts | json.loads(copies["versions"])),
            arrays,
        )
    except (CodecError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise DamagedError(f"{place}: the arrays make no root: {error}") from error


def _require_known(place: StorePlace, facts: Facts, arrays: Mapping[str, Any]) -> None:
    """Refuse a root with a variable that no store of this version has."""
    if unknown := sorted(arrays.keys() - {*VARIABLES, *facts.axes, INPUTS}):
        raise StoreError(
            f"{place} is of another version of this program, with the variable {unknown[0]}; read "
            "it with that version, or write to another store"
        )


def require_complete(place: StorePlace, root: Root) -> None:
    """Refuse to add to a store that lacks a variable which every store of this version has."""
    if lacking := [name for name in (*RECORDS, *COLUMNS) if name not in root.arrays]:
        raise StoreError(
            f"{place} is of another version of this program, without the variable {lacking[0]}; "
            "continue it with that version, or write to another store"
        )


_NO_AXES = {INPUTS, *MADE}  # coordinates without values in the root


def root_fault(facts: Facts, arrays: Mapping[str, Any]) -> str:
    """Fault of a root; empty if it may be that of a store.

    The arrays are made as large as it says, before a chunk of them is read. Codecs of Zarr 2 may
    unpickle chunks, those of Zarr 3 are looked up among all that is installed, and a name with a
    slash would lead out of the store.
    """
    axes = facts.axes
    try:
        sizes = {name: len(values) for name, values in axes.items()}
        if INPUTS in arrays:
            sizes[DIM] = arrays[INPUTS]["shape"][0]
        fits_axes = {"checksum", "load", *axes} <= arrays.keys() and all(
            _is_plain(array)
            and array["shape"] == [sizes[dim] for dim in array["dimension_names"]]
            and (name not in axes if not is_coordinate(name) else _is_axis(name, array, axes))
            and 0 not in array["chunk_grid"]["configuration"]["chunk_shape"]
            and array["attributes"].keys() >= {"long_name"}
            and "/" not in name
            for name, array in arrays.items()
        )
        points = math.prod(arrays["status"]["shape"])
        unfit = [k for k in axes if not _are_labels(axes[k], str(arrays[k]["data_type"]))]
    except (KeyError, TypeError, AttributeError):
        fits_axes, points, unfit = False, 0, []
    if not fits_axes:
        return (
            "is damaged: its arrays are not of Zarr 3, or not those of a store, of the sizes of "
            "its axes"
        )
    if unfit:
        return f"is damaged: its axis {unfit[0]} is missing, or not of the kind that a run writes"
    if points > MOST_POINTS:
        return f"tells of {points:.4g} points, and a store has at most {MOST_POINTS:.0e}"
    return ""


def _are_labels(values: list[Any], kind: str) -> bool:
    """True for values of an axis of a type; NaN are those of a chunk that is lost."""
    return fits(values, _AXES.get(kind, list[Any])) and all(value == value for value in values)


def _is_axis(name: str, array: Mapping[str, Any], axes: Mapping[str, list[Any]]) -> bool:
    """True for metadata of a coordinate with values in the root, or of the arrays of the scene."""
    return name in _NO_AXES or [len(axes[name])] == array["shape"]


def _is_plain(array: Mapping[str, Any]) -> bool:
    """True for metadata of an array with codecs of a store; each axis may be an array."""
    codecs = {codec["name"] for codec in array["codecs"]}
    is_short = all(size <= MOST_POINTS for size in array["shape"])
    return array["zarr_format"] == 3 and codecs <= _CODECS and is_short


def are_rows(root: Root) -> bool:
    """True if the sweep has the rows that the axes of the store ask for, and each its own label."""
    table, axes = root.sweep.variants, root.axes
    dims = [dim for dim in root.arrays["status"]["dimension_names"] if dim not in PLANE]
    names = [column.name for column in table.columns if column.name not in PLANE]
    return (
        dims == [*table.axes]
        and {*names} <= axes.keys()
        and all(axes[name] == [*labels] for name, labels in table.axes.items())
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


def _hash(document: dict[str, Any]) -> str:
    """Hash of the document of a root, as it is without one."""
    text = json.dumps(_hashed(document, ""), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _no_store(place: StorePlace) -> StoreError:
    return StoreError(
        f"{place} is not a store: there is no {ROOT}; give a folder that irg run made, or to run a "
        "scene into, one that is not there yet"
    )
