"""Documents of a store: the data of its sweep in the group ``about``, and metadata of Zarr.

This program derives all arrays from the data of the sweep, which have a digest. They are stored
twice: in the document `FACTS`, and in Zarr's copy of all metadata in the root. All other documents
are for other programs.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pipeline.limits import MAX_INPUTS
from pipeline.paths import path_hint, read_file, store_file, store_hint, sync
from pipeline.store import schema
from pipeline.store.arrays import Document, array_document, open_arrays
from pipeline.store.layout import Group, sizes_of
from pipeline.store.location import (
    NEW,
    OLD,
    ROOT,
    DamagedError,
    StoreError,
    io_errors,
    read_errors,
    sibling,
)
from pipeline.store.lock import holder_of
from pipeline.sweep.codec import ArrayError
from pipeline.sweep.plan import choose_stored_steps, with_sweep_of_tests
from pipeline.sweep.stored import plain_sweep, sweep_of_plain
from pipeline.sweep.sweep import Sweep
from tribo import InputError, TriboError
from tribo.types import Array

WRITER_PREFIX = "computed by "
"""Beginning of a line in the history of a store that names the versions of programs."""
GOAL_PREFIX = "run with --accuracy "
"""Beginning of a line in the history of a store."""
FACTS = f"{schema.ABOUT}/{ROOT}"
"""Key of the document with the data of the sweep, which makes a folder a store."""
_CONSOLIDATED = "consolidated_metadata"
_MAX_BYTES = 10**8  # of a document; 5000 rows with six entries take 2.5 MB
_WRONG_KIND = AttributeError, LookupError, OverflowError, TypeError, ValueError, RecursionError
"""Errors of data of another kind than this version reads, such as text in place of a number."""


@dataclass(frozen=True, eq=False)
class Root:
    """Content of a store: the points of its plane and, if it has tests, those of its tests."""

    groups: Sequence[Group]  # the plane first
    history: tuple[str, ...]  # versions of programs, and accuracy goals
    plain: Any  # data of the sweep as plain types

    @classmethod
    def from_sweep(
        cls, sweep: Sweep, history: Sequence[str], growths: int = 0, stored: Any = None
    ) -> Root:
        """Root of the store of a sweep that was replaced `growths` times.

        `stored` has the sweep's plain data and arrays if they were read from a store.
        """
        plain, arrays = stored or plain_sweep(sweep)
        plane, *others = with_sweep_of_tests(sweep)
        groups = [Group(plane, arrays, growths=growths)]
        groups += [Group(part, prefix=f"{schema.OF_TESTS}/", growths=growths) for part in others]
        return cls(groups, tuple(dict.fromkeys(history)), plain)

    @property
    def sweep(self) -> Sweep:
        """The sweep of the store."""
        return self.groups[0].sweep

    @property
    def growths(self) -> int:
        """Number of times that the store was replaced."""
        return self.groups[0].growths

    @property
    def layout(self) -> list[Any]:
        """Points, variables and scenes; a store goes on as it is if they stay the same."""
        return [(group.axes, {*group.arrays}, group.sweep.scene_hashes) for group in self.groups]

    @functools.cached_property
    def sweep_digest(self) -> str:
        """SHA-256 of the data of the sweep, by which a dataset is compared with its store."""
        return hashlib.sha256(json.dumps(self.plain, sort_keys=True).encode()).hexdigest()

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the dataset: texts for people, and the identity of its sweep."""
        return {
            "Conventions": "CF-1.11",
            "title": self.sweep.title,
            "source": "simulated by irg-transition",
            "history": "\n".join(self.history),
            "license": "BSD-3-Clause for the program; the data are their author's",
            "scene": self.sweep.text,
            "sweep_digest": self.sweep_digest,
            "stored_steps": choose_stored_steps(self.sweep).steps,
        }

    def documents(self) -> dict[str, Document]:
        """Documents of all arrays and groups, by key."""
        facts: Document = {
            "format": schema.FORMAT,
            "history": [*self.history],
            "growths": self.growths,
            "inputs": sizes_of(self.groups[0].inputs),
            "sweep": self.plain,
            "scene": self.sweep.text,
        }
        facts["digest"] = _digest(facts)
        documents = dict[str, Document]()
        for group in self.groups:
            documents |= {f"{group.prefix}{schema.ABOUT}": _group({}), **group.paths()}
        parents = dict.fromkeys(path.rpartition("/")[0] for path in documents)
        documents |= {path: _group({}) for path in parents if path}
        documents[schema.ABOUT] = _group(facts)
        keys = {f"{path}/{ROOT}": document for path, document in documents.items()}
        root = _group(self.attributes) | {_CONSOLIDATED: _consolidated(documents)}
        return {ROOT: root} | keys


def _group(attributes: Document) -> Document:
    return {"zarr_format": 3, "node_type": "group", "attributes": attributes}


def _consolidated(documents: Mapping[str, Document]) -> Document:
    """Zarr's copy of all metadata, from the documents by the path of their array or group."""
    # Zarr finds the members of a group only if they are consecutive.
    paths = sorted(documents, key=lambda path: path.rpartition("/")[0])
    members = {path: documents[path] for path in paths}
    return {"kind": "inline", "must_understand": False, "metadata": members}


def _digest(facts: Mapping[str, Any]) -> str:
    """SHA-256 of the facts without their digest."""
    contents = {name: value for name, value in facts.items() if name != "digest"}
    return hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()


# Documents on the disk


def write_documents(location: Path, root: Root, previous: Path) -> None:
    """Write the documents of a root that are missing or differ; return once they are on the disk.

    Attributes that users added to the store `previous` stay; if it is the same, their arrays, too.
    """
    documents = root.documents()
    stored = {key: _read_document(previous, key) for key in documents}
    for key in documents.keys() - {FACTS}:  # whose attributes have a digest
        document = documents[key]
        document["attributes"] = stored[key].get("attributes", {}) | document["attributes"]
    if location == previous:
        # Zarr drops the copy of all metadata if an array is added.
        members = _added_documents(location, documents) | documents[ROOT][_CONSOLIDATED]["metadata"]
        documents[ROOT][_CONSOLIDATED] = _consolidated(members)
    changed = {
        key: json.dumps(document).encode()
        for key, document in documents.items()
        if location != previous or document != stored[key]
    }
    with ThreadPoolExecutor() as threads:
        folders = threads.map(store_file, [location] * len(changed), changed, changed.values())
        _ = [*threads.map(sync, {*folders})]


def _added_documents(location: Path, documents: Collection[str]) -> dict[str, Document]:
    """Metadata of the arrays and groups that users added, by path."""
    files = (file for file in sorted(location.rglob(f"*/{ROOT}")) if not file.is_symlink())
    keys = {
        str(file.relative_to(location)): str(file.parent.relative_to(location)) for file in files
    }
    added = {
        path: _read_document(location, key) for key, path in keys.items() if key not in documents
    }
    return {path: document for path, document in added.items() if document}


def damaged_documents(location: Path, root: Root) -> list[str]:
    """Keys of the documents that lack something, whatever users added to them."""
    documents = root.documents().items()
    return [key for key, right in documents if not _contains(_read_document(location, key), right)]


def _contains(stored: Any, right: Any) -> bool:
    if not (isinstance(stored, dict) and isinstance(right, dict)):
        return bool(stored == right)
    names = [name for name in right if name != _CONSOLIDATED or stored.get(name)]
    return all(name in stored and _contains(stored[name], right[name]) for name in names)


def _read_document(location: Path, key: str) -> Document:
    """A document on the disk; empty if it is missing or damaged."""
    try:
        document: Document = json.loads(read_file(location / key, _MAX_BYTES))
        return document if isinstance(document["attributes"], dict) else {}
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError, *_WRONG_KIND):
        return {}


def read_root(location: Path) -> Root:
    """Read the root of a store; `StoreError` if it is missing, damaged or of another version."""
    if root := find_root(location):
        return root
    if holder := holder_of(location):
        raise StoreError(f"{location} is being created by {holder}; try again in a few seconds")
    if any(sibling(location, ending).exists() for ending in (NEW, OLD)):
        raise StoreError(f"a run ended while it created {location}; run its scene again")
    hint = "" if location.exists() else path_hint(location) or store_hint(location)
    raise StoreError(
        f"no store at {location}{hint}; run a scene first, or give the path of a store"
    )


def find_root(location: Path) -> Root | None:
    """Read the root of a store; None if there is nothing, `StoreError` for other content.

    The data of the sweep are read from their copy if their own document is lost or damaged. Raises
    a `DamagedError` if both are.
    """
    errors = list[StoreError]()
    with io_errors(location):
        if folder := next((path for path in location.parents if (path / FACTS).is_file()), None):
            raise StoreError(
                f"{location} is inside the store {folder}; give the path of the store itself, or "
                "one outside it"
            )
        if not location.exists() or (location.is_dir() and not any(location.iterdir())):
            return None
        for content in _stored_facts(location):
            try:
                return _parse(location, content)
            except StoreError as error:
                errors.append(error)
    if errors:
        raise errors[0]
    raise StoreError(f"{location} is not a store: {_describe_content(location)}")


def _stored_facts(location: Path) -> Iterator[bytes]:
    """Yield the document `FACTS` if it is there, then its copy in the document of the root."""
    if (location / FACTS).is_file():
        yield read_file(location / FACTS, _MAX_BYTES)
    with suppress(*_WRONG_KIND):
        copies = _read_document(location, ROOT)[_CONSOLIDATED]["metadata"]
        yield json.dumps(copies[schema.ABOUT]).encode()


def _describe_content(location: Path) -> str:
    """Say what is at a path that is no store, and what to do."""
    if location.suffix == ".toml":
        return "it is a scene file; run it with irg run, then give the resulting store"
    if (location / ROOT).exists() or (location / "status" / ROOT).exists():
        return (
            f"it is of another program, or has lost {FACTS} and its copy in {ROOT}; restore it "
            "from a backup, or run the scene into another store"
        )
    if inner := sorted(location.glob(f"*/{FACTS}")):
        return f"it is a folder of stores; choose one, such as {inner[0].parents[1].name}"
    kind = "a folder with other files" if location.is_dir() else "not a folder"
    return f"it is {kind}; give the folder written by irg run, or a new one"


def _parse(location: Path, content: bytes) -> Root:
    """Root from the document `FACTS`.

    Raises a `DamagedError` for a damaged document, a `StoreError` for one of another version.
    """
    try:
        facts = json.loads(content)["attributes"]
        version, history = facts["format"], facts["history"]
        writer = [f"{line}" for line in history if f"{line}".startswith(WRITER_PREFIX)][-1]
        is_intact = version == schema.FORMAT and facts["digest"] == _digest(facts)
    except _WRONG_KIND as error:
        raise _damaged(location, f"{type(error).__name__} {error}") from error
    if version != schema.FORMAT:
        reason = f"its format is {version!r:.20}, this version reads {schema.FORMAT}"
        raise _of_other_version(location, writer, reason)
    if not is_intact:
        raise _damaged(location, "it is not what was written")
    try:
        arrays = _read_inputs(location, facts["inputs"], facts["growths"])
        sweep = replace(sweep_of_plain(facts["sweep"], arrays), text=facts["scene"])
        sweep.require_few_points()
        return Root.from_sweep(sweep, history, facts["growths"], (facts["sweep"], arrays))
    except StoreError:
        raise
    except ArrayError as error:
        raise _damaged(location, error) from error
    except (TriboError, *_WRONG_KIND) as error:  # the digest shows that the facts are as written
        raise _of_other_version(location, writer, error) from error


def _damaged(location: Path, reason: object) -> DamagedError:
    return DamagedError(
        f"{location}: its {FACTS} and the copy in {ROOT} are damaged ({f'{reason}'[:300]}); "
        "restore one of them from a backup, or run the scene into another store"
    )


def _of_other_version(location: Path, writer: str, reason: object) -> StoreError:
    return StoreError(
        f"{location} was written by another version of this program ({writer:.200}): "
        f"{f'{reason}'[:300]}; read it with that version, or run the scene into another store"
    )


def _read_inputs(location: Path, sizes: dict[str, int], growths: int) -> dict[str, Array]:
    """Arrays from the scene's files by SHA-256; `sizes` has the number of values of each."""
    if not sizes:
        return {}
    if (count := sum(sizes.values())) > MAX_INPUTS:
        raise InputError(f"it contains {count:.3g} numbers of the scene's files")
    (variable,) = schema.inputs_variable(sizes).values()
    document = array_document(variable, {schema.INPUT_DIM: count}, {}, growths)
    array = open_arrays(location, {schema.INPUTS: document})[schema.INPUTS]
    with read_errors(location, schema.INPUTS):
        return schema.split_arrays(array[:], variable.attributes)
