"""Documents of a store; the group ``about`` has the data of the sweep, with a digest.

Zarr's copy of all metadata in the root has the same data. Either of the two is enough to read a
store; a run corrects the other one. All other documents are for other programs.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pipeline.limits import MAX_INPUTS
from pipeline.paths import path_hint, store_hint
from pipeline.store.arrays import (
    Document,
    array_document,
    find_excess,
    growths_of,
    open_arrays,
    read_document,
)
from pipeline.store.files import PARTIAL
from pipeline.store.layout import Group, sizes_of
from pipeline.store.location import (
    NEW,
    OLD,
    ROOT,
    Bucket,
    DamagedError,
    Folder,
    Location,
    StoreError,
    io_errors,
    read_errors,
)
from pipeline.store.lock import holder_of
from pipeline.store.schema import (
    ABOUT,
    FORMAT,
    INPUT_DIM,
    INPUTS,
    OF_FIELDS,
    OF_TESTS,
    inputs_variable,
    is_coordinate,
    path_of,
    split_arrays,
)
from pipeline.sweep.codec import ArrayError
from pipeline.sweep.plan import choose_stored_steps, sweep_of_tests
from pipeline.sweep.stored import plain_sweep, require_few, sweep_of_plain
from pipeline.sweep.sweep import Sweep
from tribo import InputError, TriboError
from tribo.types import Array

WRITER_PREFIX = "computed by "
"""Beginning of a line in the history of a store that names the versions of programs."""
GOAL_PREFIX = "run with --accuracy "
"""Beginning of a line in the history of a store."""
FACTS = f"{ABOUT}/{ROOT}"
"""Key of the document with the data of the sweep, which makes a folder a store."""
_MAX_PROPORTION = 0.75  # of the limits of documents that are read, up to which they are written
_CONSOLIDATED = "consolidated_metadata"
_WRONG_KIND = AttributeError, LookupError, OverflowError, TypeError, ValueError
"""Errors of data of another kind than this version reads, such as text in place of a number."""
_LOST = (
    "irg run restores it with the scene of all its points; otherwise restore it from a backup, or "
    "run the scene into another store"
)


@dataclass(frozen=True, eq=False)
class Root:
    """Content of a store: the points of its plane and of its tests."""

    plane: Group
    tests: Group | None  # None without tests
    history: tuple[str, ...]  # versions of programs, and accuracy goals
    plain: Any  # data of the sweep as plain types

    @classmethod
    def from_sweep(
        cls,
        sweep: Sweep,
        history: Sequence[str],
        growths: tuple[int, int] = (0, 0),
        stored: Any = None,
    ) -> Root:
        """Root of the store of a sweep; `growths` are those of all points and of fields.

        `stored` has the sweep's plain data and arrays if they were read from a store.
        """
        tests, (plain, arrays) = None, stored or plain_sweep(sweep)
        if sweep.tests or sweep.former_tests:
            tests = Group(sweep_of_tests(sweep), prefix=f"{OF_TESTS}/", growths=growths[0])
        plane = Group(sweep, arrays, "", *growths)
        return cls(plane, tests, tuple(dict.fromkeys(history)), plain)

    @property
    def sweep(self) -> Sweep:
        """The sweep of the store."""
        return self.plane.sweep

    @property
    def groups(self) -> list[Group]:
        """The plane, and the tests if there are any."""
        return [self.plane, *([self.tests] if self.tests else [])]

    @property
    def layout(self) -> list[Any]:
        """Points, variables and steps; a store is updated in place if they stay the same."""
        return [(group.axes, {*group.arrays}) for group in self.groups]

    @property
    def growths(self) -> tuple[int, int]:
        """How often a larger store replaced a smaller one, and how often its fields changed."""
        return self.plane.growths, self.plane.field_growths

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

    def require_small(self) -> None:
        """Raise an `InputError` if the documents of the store would be too large to be read.

        Some room is left for arrays that users add.
        """
        require_few(self.plain)
        if problem := find_excess(json.dumps(self.documents()[ROOT]).encode(), _MAX_PROPORTION):
            raise InputError(
                f"the data of the sweep are too large for a store: {problem}; give fewer rows, "
                "tests or columns, or shorter words"
            )

    def documents(self) -> dict[str, Document]:
        """Documents of all arrays and groups, by key; the last is that of the group ``about``."""
        facts: Document = {
            "format": FORMAT,
            "history": [*self.history],
            "growths": [*self.growths],
            "inputs": sizes_of(self.plane.inputs),
            "sweep": self.plain,
            "scene": self.sweep.text,
        }
        facts["digest"] = _digest(facts)
        documents = dict[str, Document]()
        for group in self.groups:
            documents |= {f"{group.prefix}{ABOUT}": _group({}), **group.paths()}
        if self.sweep.fields:
            documents[OF_FIELDS] = _group({})
        if self.tests:
            documents[OF_TESTS] = _group({})
        documents[ABOUT] = _group(facts)
        # Zarr finds the members of a group only if they are consecutive.
        members = {
            path: documents[path] for path in sorted(documents, key=lambda p: p.rpartition("/")[0])
        }
        consolidated = {"kind": "inline", "must_understand": False, "metadata": members}
        keys = {f"{path}/{ROOT}": document for path, document in documents.items()}
        return {ROOT: _group(self.attributes) | {_CONSOLIDATED: consolidated}} | keys


def _group(attributes: Document) -> Document:
    return {"zarr_format": 3, "node_type": "group", "attributes": attributes}


def _digest(facts: Mapping[str, Any]) -> str:
    """SHA-256 of the facts without their digest."""
    contents = [
        facts[name] for name in ("format", "history", "inputs", "growths", "sweep", "scene")
    ]
    return hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()


# Reading


def read_root(location: Location) -> Root:
    """Read the root of a store; `StoreError` if it is missing, damaged or of another version."""
    if root := find_root(location):
        return root
    if holder := holder_of(location):
        raise StoreError(f"{location} is being created by {holder}; try again in a few seconds")
    hint = ""
    if isinstance(location, Folder) and not location.path.exists():
        if any(location.sibling(ending).path.exists() for ending in (NEW, OLD)):
            raise StoreError(f"a run ended while it created {location}; run its scene again")
        hint = path_hint(location.path) or store_hint(location.path)
    raise StoreError(
        f"no store at {location}{hint}; run a scene first, or give the path of a store"
    )


def find_root(location: Location) -> Root | None:
    """Read the root of a store; None if there is nothing, `StoreError` for other content.

    Raises a `DamagedError` if both documents with the data of the sweep are lost or damaged.
    """
    if isinstance(location, Folder) and location.path.exists() and not location.path.is_dir():
        raise StoreError(f"{location} is not a store: {_describe_content(location, set())}")
    fault: StoreError | None = None
    for key in (FACTS, ROOT):
        try:
            with io_errors(location):
                try:
                    content = read_document(location, key)
                except ValueError as error:
                    raise _damaged(location, key, error) from error
            if content is not None:
                return _parse(location, key, content)
        except StoreError as error:
            # A damaged `ROOT` alone may be of another program.
            if key == FACTS or not isinstance(error, DamagedError):
                fault = fault or error
    if fault:
        raise fault
    with io_errors(location):
        keys = location.keys()
    is_of_program = f"{ABOUT}/checksum/{ROOT}" in keys
    # On an object store, a creation that was cut short leaves documents without results.
    is_begun = is_of_program and isinstance(location, Bucket) and not has_results(keys)
    if is_begun or not keys:
        return None
    if is_of_program:
        raise DamagedError(f"{location}: its {FACTS} is lost; {_LOST}")
    raise StoreError(f"{location} is not a store: {_describe_content(location, keys)}")


def has_results(keys: Iterable[str]) -> bool:
    """True if the keys of a store have a chunk of a variable that only points have."""
    arrays = {key.rpartition("/")[0] for key in keys if not key.endswith((ROOT, PARTIAL))}
    names = {array.rpartition("/")[2] for array in arrays}
    return not all(is_coordinate(name) or name == "status" for name in names)


def restored_root(location: Location, sweep: Sweep) -> Root | None:
    """Root of a store whose data of the sweep are lost, if it has the arrays of this sweep."""
    try:
        growths, field_growths = (
            growths_of(json.loads(read_document(location, f"{path}/{ROOT}") or b"{}"))
            for path in ("status", path_of("pressure") if sweep.fields else "status")
        )
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    root = Root.from_sweep(sweep, (), (growths, field_growths))
    return None if stale_documents(location, root).keys() - {ROOT, FACTS} else root


def _parse(location: Location, key: str, content: bytes) -> Root:
    """Root from the document `key`, `FACTS` or `ROOT`.

    Raises a `DamagedError` for a damaged document, a `StoreError` for one of another version.
    """
    try:
        document = json.loads(content)
        facts = (document if key == FACTS else document[_CONSOLIDATED]["metadata"][ABOUT])[
            "attributes"
        ]
        version, history = facts["format"], facts["history"]
        writer = [f"{line}" for line in history if f"{line}".startswith(WRITER_PREFIX)][-1]
        is_intact = version == FORMAT and facts["digest"] == _digest(facts)
    except (ValueError, KeyError, IndexError, TypeError, RecursionError) as error:
        raise _damaged(location, key, f"{type(error).__name__} {error}") from error
    if version != FORMAT:
        reason = f"its format is {version!r:.20}, this version reads {FORMAT}"
        raise _of_other_version(location, writer, reason)
    if not is_intact:
        raise _damaged(location, key, "it is not what was written")
    try:
        growths, field_growths = facts["growths"]
        arrays = _read_inputs(location, facts["inputs"], growths)
        sweep = replace(sweep_of_plain(facts["sweep"], arrays), text=facts["scene"])
        sweep.require_few_points()
        stored = facts["sweep"], arrays
        return Root.from_sweep(sweep, history, (growths, field_growths), stored)
    except StoreError:
        raise
    except ArrayError as error:
        raise _damaged(location, key, error) from error
    except (TriboError, *_WRONG_KIND) as error:  # the digest shows that the facts are as written
        raise _of_other_version(location, writer, error) from error


def _damaged(location: Location, key: str, reason: object) -> DamagedError:
    return DamagedError(f"{location}: its {key} is damaged ({f'{reason}'[:300]}); {_LOST}")


def _of_other_version(location: Location, writer: str, reason: object) -> StoreError:
    return StoreError(
        f"{location} was written by another version of this program ({writer:.200}): "
        f"{f'{reason}'[:300]}; read it with that version, or run the scene into another store"
    )


def _read_inputs(location: Location, sizes: dict[str, int], growths: int) -> dict[str, Array]:
    """Arrays from the scene's files by SHA-256; `sizes` has the number of values of each."""
    if not sizes:
        return {}
    if (count := sum(sizes.values())) > MAX_INPUTS:
        raise InputError(f"it contains {count:.3g} numbers of the scene's files")
    (variable,) = inputs_variable(sizes).values()
    document = array_document(variable, {INPUT_DIM: sum(sizes.values())}, {}, growths)
    array = open_arrays(location.zarr, {INPUTS: document})[INPUTS]
    with read_errors(location, INPUTS):
        return split_arrays(array[:], variable.attributes)


def _describe_content(location: Location, keys: set[str]) -> str:
    """Say what is at a path that is no store, and what to do."""
    if not keys and str(location).endswith(".toml"):
        return "it is a scene file; run it with irg run, then give the resulting store"
    if inner := sorted(key for key in keys if key.endswith(f"/{FACTS}")):
        return f"it is a folder of stores; choose one, such as {inner[0].split('/')[0]}"
    for folder in location.path.parents if isinstance(location, Folder) else ():
        if (folder / FACTS).is_file():
            return f"it is a part of the store {folder}; give the path of the store"
    if ROOT in keys:
        return (
            f"it is of another program, or has lost its {FACTS}; run the scene into another store"
        )
    kind = "a folder with other files" if keys else "not a folder"
    return f"it is {kind}; give the folder written by irg run, or a new one"


def stale_documents(location: Location, root: Root) -> dict[str, Document]:
    """Corrected documents, by key, of those that differ from the root's.

    Attributes and arrays that users added are kept. On an object store, only the documents of the
    dataset and of ``about`` are compared, since each costs a request.
    """
    stale = dict[str, Document]()
    for key, right in root.documents().items():
        if isinstance(location, Bucket) and key not in (ROOT, FACTS):
            continue
        try:
            complete = _with_additions(
                stored := json.loads(read_document(location, key) or b"{}"), right
            )
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            stored, complete = {}, right
        if complete != stored:
            stale[key] = complete
    return stale


def _with_additions(stored: Document, right: Document) -> Document:
    """The document `right` with what users added to the `stored` one."""
    complete = stored | right | {"attributes": stored.get("attributes", {}) | right["attributes"]}
    # Zarr drops the copy of all metadata if an array is added.
    if stored and _CONSOLIDATED in right:
        complete[_CONSOLIDATED] = stored.get(_CONSOLIDATED)
        if old := (stored.get(_CONSOLIDATED) or {}).get("metadata", {}):
            members = right[_CONSOLIDATED]["metadata"].items()
            merged = {path: _with_additions(old.get(path, {}), member) for path, member in members}
            complete[_CONSOLIDATED] = right[_CONSOLIDATED] | {"metadata": old | merged}
    return complete
