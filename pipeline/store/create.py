"""Create a store, open it to add points, and enlarge it.

A folder is written under another name and renamed when it is complete. The plane of a store is
fixed: if a run needs further points, a larger store is written and replaces it::

    NAME.zarr.irg-lock  is the lock of all of these
    NAME.zarr.irg-new   is written, with the points of NAME.zarr
    NAME.zarr       →   NAME.zarr.irg-old
    NAME.zarr.irg-new → NAME.zarr
    NAME.zarr.irg-old   is deleted

If the process dies, up to three copies are left. The next run reads all of them, continues the one
with most sound points, and deletes the others.
"""

from __future__ import annotations

import functools
import json
import re
import shlex
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from importlib import metadata

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.store.arrays import open_arrays, read_document, write_arrays, write_documents
from pipeline.store.copies import keep_best_copy, remove_folder, root_or_restored
from pipeline.store.damage import mend
from pipeline.store.files import link_files, sync
from pipeline.store.location import (
    NEW,
    OLD,
    ROOT,
    Bucket,
    DamagedError,
    Folder,
    Location,
    PathLike,
    StoreError,
    StoreMismatchError,
    io_errors,
    location_of,
)
from pipeline.store.lock import Lock, locked
from pipeline.store.resume import join, mismatches
from pipeline.store.root import FACTS, GOAL_PREFIX, WRITER_PREFIX, Root, find_root, stale_documents
from pipeline.store.schema import DONE, FAILED, FIELDS, PENDING, path_of
from pipeline.store.store import Store
from pipeline.store.transfer import transfer
from pipeline.sweep.case import TEST
from pipeline.sweep.plan import NO_TEST, points
from pipeline.sweep.sweep import Sweep

_CHUNK = re.compile(r"c(\.\d+)*")


@contextmanager
def writing(
    path: PathLike | None, sweep: Sweep, progress: Report = silent, accuracy: float | None = None
) -> Iterator[Store]:
    """Context manager: create the store of a sweep, or open it and add the sweep's points.

    The points are marked as needed, and damaged ones as pending. The `accuracy` goal of a run is
    noted in the store's history. Without a path the store is in memory, and is deleted with the
    last reference to it.

    Raises a `StoreMismatchError` if the store belongs to another scene. Raises a `StoreError` if
    something else is at `path`, another process writes to the store, or it cannot be read or
    written.
    """
    location, notes = location_of(path), [f"{GOAL_PREFIX}{100 * accuracy:g}%"] if accuracy else []
    if isinstance(location, Folder):
        with suppress(DamagedError):  # it may be restored below
            find_root(location)  # raises before a lock is created next to another program's files
        with locked(location, progress) as lock:
            keep_best_copy(location, sweep, progress)
            yield _open(location, sweep, lock, progress, notes)
        return
    if not location.is_writable:
        raise StoreError(f"{location} can only be read; write to a folder, or to s3://…")
    progress(Progress(f"{location} cannot be locked: make sure that only one run writes to it"))
    yield _open(location, sweep, None, progress, notes)


def enlarged(store: Store, sweep: Sweep) -> Store:
    """The store, enlarged for the points of a larger sweep; this process must hold its lock."""
    return _open(store.location, sweep, store.lock, silent)


def _open(
    location: Location,
    sweep: Sweep,
    lock: Lock | None,
    progress: Report,
    notes: Collection[str] = (),
) -> Store:
    """Create, enlarge or open the store of a sweep; `notes` are added to its history."""
    before = root_or_restored(location, sweep, progress)
    if before:
        _require_same_scene(location, before, sweep)
    joined = join(before.sweep if before else None, sweep)
    history = [*(before.history if before else ()), f"{WRITER_PREFIX}{versions()}", *notes]
    root = Root.from_sweep(joined, history, before.growths if before else (0, 0))
    root.require_small()
    if before and before.layout == root.layout:
        store = _update(location, root, lock, progress)
    elif isinstance(location, Folder):
        store = _replace(location, before, root, lock, progress)
    elif before:
        raise _not_extensible(location, "a plane on an object store cannot grow")
    else:
        with io_errors(location, "written"):
            _write_without_points(location, root)
        store = Store(location, root, lock)
    store.ask(points(sweep))
    if store.tests:
        rows = store.tests.sweep.case_table.by_name
        test_points = points(store.tests.sweep)
        store.tests.ask(point for point in test_points if rows[point.case][TEST] != NO_TEST)
    return store


def _require_same_scene(location: Location, root: Root, sweep: Sweep) -> None:
    """Raise a `StoreMismatchError` if a sweep cannot continue a store."""
    if differences := [*mismatches(root.sweep, sweep)]:
        advice = "use the values of the store, or write to another store"
        goals = [line for line in root.history if line.startswith(GOAL_PREFIX)]
        more = [f"to extend the store: irg {goals[-1].replace('with', 'SCENE')}"] if goals else []
        raise StoreMismatchError(
            "\n  ".join([f"{location} belongs to another scene: {advice}", *differences, *more])
        )


def _update(location: Location, root: Root, lock: Lock | None, progress: Report) -> Store:
    """Open a store that has all points of `root`, correct its documents, and mend its damage."""
    with io_errors(location, "written"):
        documents = stale_documents(location, root)
        facts = {FACTS: documents.pop(FACTS)} if FACTS in documents else {}
        write_documents(location, documents)
        write_documents(location, facts)
    if isinstance(location, Bucket):  # reading all data takes too long
        return Store(location, root, lock)
    store = Store(location, root, lock, may_be_damaged=True)
    if count := sum(map(mend, store.groups)):
        words = f"{location} had {count} damaged points or files, which are computed again"
        progress(Progress(words))
    return store


def _write_without_points(
    location: Location,
    root: Root,
    before: Location | None = None,
    stored: Collection[str] = (),
) -> None:
    """Write all of a store without points; the data of its sweep, which make it one, come last.

    Attributes that users gave to the store `before` stay. The files of the variables `stored` are
    in place.
    """
    documents = root.documents()
    for key, document in documents.items():
        with suppress(ValueError, KeyError, TypeError, RecursionError):  # a damaged document
            old_document = json.loads(read_document(before, key) or b"{}") if before else {}
            document["attributes"] = old_document["attributes"] | document["attributes"]
    last = {key: documents.pop(key) for key in (FACTS, ROOT)}
    write_documents(location, documents)
    for group in root.groups:
        arrays = open_arrays(location.zarr, group.arrays, group.prefix)
        values = {"status": np.full(group.shape, PENDING, np.int8)} | group.coordinates
        parts = [(name, ..., values[name]) for name in values.keys() - {*stored}]
        write_arrays(location, arrays, parts)
    write_documents(location, last)


# Folders


def _replace(
    location: Folder, before: Root | None, root: Root, lock: Lock | None, progress: Report
) -> Store:
    """Write the store of `root` with the points of the old one, and replace that at `location`."""
    new, old = location.sibling(NEW), location.sibling(OLD)
    if foreign_key := next(_foreign_keys(location, before), None):
        problem = f"{foreign_key}, which is not of this program, would be lost"
        raise _not_extensible(location, problem)
    stored = list[str]()
    if before:
        # The keys of chunks of fields stay the same if a growth adds only realizations.
        keeps_fields = before.plane.fields.items() <= root.plane.fields.items()
        stored = [*FIELDS] if keeps_fields and before.sweep.fields else []
        growths, field_growths = before.growths
        # Datasets that are open must not read values of other points.
        next_growths = growths + 1, field_growths + (not keeps_fields)
        root = Root.from_sweep(root.sweep, root.history, next_growths)
    with io_errors(new, "written"):
        _write_without_points(new, root, location if before else None, stored)
        for path in map(path_of, stored):
            link_files(location.path / path, new.path / path, _CHUNK)
    if before:
        targets = Store(new, root, lock).groups
        sources = Store(location, before, may_be_damaged=True).groups
        for target, source in zip(targets, sources, strict=False):
            _, damaged, left_over = transfer(target, source, (DONE, FAILED), stored)
            if left_over:
                problem = f"{left_over} of its points, which are done, would be lost"
                raise _not_extensible(location, problem)
            if damaged:
                words = f"{location} had {damaged} damaged points, which are computed again"
                progress(Progress(words))
    with io_errors(location, "written"):
        if location.path.exists():
            location.path.rename(old.path)
        new.path.rename(location.path)
        sync(location.path.parent)
        remove_folder(old)
    return Store(location, root, lock)


def _foreign_keys(location: Folder, root: Root | None) -> Iterator[str]:
    """Keys of the files and links below a folder that do not belong to its store."""
    documents = root.documents() if root else {}
    for key in sorted(location.keys()):
        path, _, name = key.rpartition("/")
        is_chunk = _CHUNK.fullmatch(name) and f"{path}/{ROOT}" in documents
        if not (is_chunk or key in documents) or (location.path / key).is_symlink():
            yield key


def _not_extensible(location: Location, reason: str) -> StoreError:
    return StoreError(
        f"{location} cannot be extended: {reason}; write a new store and copy the points of this "
        f"one into it: irg run SCENE -o NEW --from {shlex.quote(str(location))}"
    )


@functools.cache
def versions() -> str:
    """Versions of the packages that compute and store, such as "numpy 2.1, scipy 1.15"."""
    names = ("irg-transition", "numpy", "scipy", "zarr")
    texts = []
    for name in names:
        with suppress(metadata.PackageNotFoundError):  # not installed
            texts.append(f"{name} {metadata.version(name)}")
    return ", ".join(texts)
