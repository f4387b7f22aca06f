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
from pipeline.store.files import PARTIAL
from pipeline.store.inputs import split_arrays
from pipeline.store.layout import arrays_of, listed_points, row_axes
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
from pipeline.store.schema import FORMAT, INPUTS, MADE, POINT, is_coordinate, variables_of
from pipeline.store.versions import package_versions, provenance
from pipeline.sweep.codec import Arrays, CodecError, build, fits, sweep_text, text_sweep
from pipeline.sweep.limits import MOST_BYTES_OF_ROOT, MOST_PARTS_OF_ROOT, MOST_POINTS
from pipeline.sweep.model import Sweep
from pipeline.sweep.stored import misfits
from tribo import InputError

_AXES = {"float64": list[float], "int64": list[int], "str": list[str]}
"""Values along an axis, by the type of its variable."""
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


def find_closed_root(place: StorePlace, sweep: Sweep) -> tuple[Root | None, set[str]]:
    """The root as `find_root`, and names of the arrays that the store has, or will with a sweep.

    A `StoreError` is raised for a link under a name of a folder's, before anything is written.
    """
    root = find_root(place)
    arrays = {INPUTS, *variables_of(sweep), *(root.arrays if root else ())}
    if isinstance(place, Folder):
        with reaches(place):
            place.keys(arrays)
    return root, arrays


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
            f"at most {MOST_PARTS_OF_ROOT}; {_ELSEWHERE}"
        )
    try:
        document = json.loads(content)
        attributes, arrays = document["attributes"], dict(document[_CONSOLIDATED]["metadata"])
        text, facts = attributes["sweep"], json.loads(attributes["store"])
        version, expected = facts.pop("format"), facts.pop("hash")
        is_as_written = version != FORMAT or _hash(document) == expected
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        with reaches(place):
            has_points = _has_points(place.keys())
        if has_points:
            raise StoreError(f"{place}: {ROOT} is damaged; {_ELSEWHERE}") from None
        raise StoreError(
            f"{place} is not the store of a sweep; give a folder that irg run made"
        ) from None
    if not is_as_written:
        raise StoreError(f"{place}: {ROOT} is damaged: it is not what was written; {_ELSEWHERE}")
    if version != FORMAT:
        raise StoreError(
            f"{place} is of another version of this program: it has format {version}, and this one "
            f"reads {FORMAT}; {_ANEW}"
        )
    try:
        built: Facts = build(Facts, facts)
        _require_plain(arrays)
        root = Root(text_sweep(text, _inputs(place, arrays)), built, arrays)
        _require_fitting(root)
    except DamagedError as error:
        raise StoreError(f"{place}: the arrays of its scene are damaged; {_ELSEWHERE}") from error
    except (InputError, ValueError, KeyError, TypeError) as error:
        raise StoreError(
            f"{place} is of another version of this program, or damaged: {error}; {_ANEW}"
        ) from error
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
            f"bytes; {_ELSEWHERE}"
        )


def _require_plain(arrays: Mapping[str, Any]) -> None:
    """Raise a `CodecError` for arrays that are not as a store has them.

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
        raise CodecError("its arrays are not of Zarr 3, or not those of a store")


def _require_fitting(root: Root) -> None:
    """Raise a `CodecError` for arrays, axes or rows that are not those of the root's sweep."""
    wanted, axes, arrays = variables_of(root.sweep), root.axes, root.arrays
    labels = {name for name in wanted if is_coordinate(name) and name not in MADE}
    if unlike := sorted((arrays.keys() - {INPUTS}) ^ wanted.keys() or axes.keys() ^ labels):
        raise CodecError(f"the variable {unlike[0]} is unknown or missing")
    for name in sorted(labels):
        is_of_numbers = all(value == value for value in axes[name])  # and not of NaN
        if not (fits(axes[name], _AXES[wanted[name].dtype]) and is_of_numbers):
            raise CodecError(f"its axis {name} is not of the kind that a run writes")
    for name, variable in wanted.items():
        shape = [len(axes[dim]) for dim in variable.dims]
        is_of_axis = name not in labels or [len(axes[name])] == shape
        has_dims = arrays[name]["dimension_names"] == [*variable.dims]
        if not (has_dims and is_of_axis and arrays[name]["shape"] == shape):
            raise CodecError(f"the variable {name} does not have the sizes of its axes")
    if not _has_rows_of_scene(root):
        raise CodecError("its axes are not those of its scene")
    if (points := math.prod(arrays["status"]["shape"])) > MOST_POINTS:
        raise CodecError(f"it has {points:.4g} points, and a store at most {MOST_POINTS:.0e}")


def _has_rows_of_scene(root: Root) -> bool:
    """True if the rows of a store are those of its sweep, or points of a search among them."""
    if POINT not in root.axes:
        return all(root.axes[name] == values for name, values in row_axes(root.sweep).items())
    points = listed_points(root.sweep, root.axes)
    are_known = all(point.variant in root.sweep.variants for point in points)
    return are_known and len({*points}) == len(points)


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
