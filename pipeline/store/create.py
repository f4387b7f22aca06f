"""Create a store, enlarge it, and copy points of another store.

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
import os
import re
import shlex
import shutil
from collections import defaultdict
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from importlib import metadata
from typing import Any

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.store.arrays import open_arrays, read_document, write_arrays, write_documents
from pipeline.store.damage import Checked, checked_points, find_damage, mend
from pipeline.store.files import PARTIAL, link_files, sync
from pipeline.store.lock import Lock, locked
from pipeline.store.place import (
    NEW,
    OLD,
    ROOT,
    Bucket,
    DamagedError,
    Folder,
    PathLike,
    StoreError,
    StoreMismatchError,
    StorePlace,
    io_errors,
    place_of,
)
from pipeline.store.resume import join, mismatches
from pipeline.store.root import (
    FACTS,
    GOAL,
    WRITER,
    Root,
    find_root,
    has_results,
    restored_root,
    stale_documents,
    without_facts,
)
from pipeline.store.schema import DATA, DONE, FAILED, FIELDS, INPUTS, PENDING, path_of
from pipeline.store.store import Damage, Index, Store
from pipeline.sweep.case import TEST
from pipeline.sweep.plan import choose_stored_steps, points
from pipeline.sweep.points_of_tests import NO_TEST
from pipeline.sweep.sweep import Point, Sweep

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
    location, note = place_of(path), "" if accuracy is None else f"{GOAL}{100 * accuracy:g}%"
    if isinstance(location, Folder):
        with suppress(DamagedError):  # `_opened` may restore it
            find_root(location)  # raises before a lock is created next to another program's files
        with locked(location, progress) as lock:
            _keep_best_copy(location, sweep, progress)
            yield _opened(location, sweep, lock, progress, note)
        return
    if not location.is_written:
        raise StoreError(f"{location} can only be read; write to a folder, or to s3://…")
    progress(Progress(f"{location} cannot be locked: make sure that only one run writes to it"))
    yield _opened(location, sweep, None, progress, note)


def enlarged(store: Store, sweep: Sweep) -> Store:
    """The store, enlarged for the points of a larger sweep; this process must hold its lock."""
    return _opened(store.location, sweep, store.lock, silent)


def find_sweep(path: PathLike) -> Sweep | None:
    """Read the sweep that a run continues; None if there is none, `StoreError` for other content.

    A store that a run has to restore has none yet. If a growth was cut short between its renames,
    the sweep is that of a copy.
    """
    location = place_of(path)
    with suppress(DamagedError):
        if root := find_root(location):
            return root.sweep
    copies = map(location.sibling, (NEW, OLD)) if isinstance(location, Folder) else ()
    for copy in copies:
        with suppress(DamagedError):
            if root := _root_of_copy(copy):
                return root.sweep
    return None


def _opened(
    location: StorePlace,
    sweep: Sweep,
    lock: Lock | None,
    progress: Report,
    note: str = "",
) -> Store:
    """Create, enlarge or open the store of a sweep."""
    before = _root_or_restored(location, sweep, progress)
    if before and (differing := [*mismatches(before.sweep, sweep)]):
        advice = "use the values of the store, or write to another store"
        goals = [line for line in before.history if line.startswith(GOAL)]
        more = [f"the store is grown by: irg {goals[-1].replace('with', 'SCENE')}"] if goals else []
        raise StoreMismatchError(
            "\n  ".join([f"{location} belongs to another scene: {advice}", *differing, *more])
        )
    lines = [*(before.history if before else ()), f"{WRITER}{versions()}"]
    lines += [note] if note else []
    growths, field_growths = (
        (before.plane.growths, before.plane.field_growths) if before else (0, 0)
    )
    joined = join(before.sweep if before else None, sweep)
    root = Root.from_sweep(joined, lines, growths, field_growths)
    if before and _have_the_same_points(before, root):
        with io_errors(location, "written"):
            _update(location, root)
        store = Store(location, root, lock, None if isinstance(location, Bucket) else Damage())
        if store.damage and (count := sum(map(mend, store.groups))):
            progress(
                Progress(
                    f"{location} had {count} damaged points or files, which are computed again"
                )
            )
    elif isinstance(location, Folder):
        if before:  # open datasets must not read values of other points
            field_growths += not root.plane.continues_fields_of(before.plane)
            root = Root.from_sweep(root.sweep, lines, growths + 1, field_growths)
        store = _moved_in(location, before, root, lock, progress)
    elif before:
        raise _no_room(location, "on an object store a plane is fixed")
    else:
        with io_errors(location, "written"):
            _fill(location, root)
        store = Store(location, root, lock)
    store.damage = None
    store.ask(points(sweep))
    if store.tests:
        rows = store.tests.sweep.case_table.by_name
        test_points = points(store.tests.sweep)
        store.tests.ask(point for point in test_points if rows[point.case][TEST] != NO_TEST)
    return store


def _have_the_same_points(root: Root, other: Root) -> bool:
    """True if both have the same points, variables and number of steps."""
    return [(group.axes, {*group.arrays}) for group in root.groups] == [
        (group.axes, {*group.arrays}) for group in other.groups
    ]


def _fill(
    location: StorePlace,
    root: Root,
    before: StorePlace | None = None,
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
    write_documents(location, documents | {ROOT: without_facts(last[ROOT])})
    for group in root.groups:
        flags = np.full([group.sizes[dim] for dim in group.dims], PENDING, np.int8)
        parts = [("status", ..., flags)]
        parts += [
            (name, ..., values) for name, values in group.coordinates.items() if name not in stored
        ]
        write_arrays(location, open_arrays(location.zarr, group.arrays, group.prefix), parts)
    write_documents(location, last)


def _update(location: StorePlace, root: Root) -> None:
    """Write the documents of a store that differ from those of its root, `FACTS` last."""
    new = stale_documents(location, root)
    last = {key: new.pop(key) for key in [FACTS] if key in new}
    write_documents(location, new)
    write_documents(location, last)


# Folders


def _keep_best_copy(location: Folder, sweep: Sweep, progress: Report) -> None:
    """Of the copies that a killed run left, keep the one with most sound points at `location`.

    A copy is deleted only if it was read, or if another one that has no damage stays.
    """
    new, old = location.sibling(NEW), location.sibling(OLD)
    if not (new.path.exists() or old.path.exists()):
        _remove_partial_files(location)
        return
    counts, fault = dict[Folder, tuple[int, bool]](), None
    for copy in (location, new, old):
        try:
            if root := _root_of_copy(copy, sweep):
                counts[copy] = _count_sound_points(Store(copy, root, None, Damage()))
        except DamagedError as error:
            fault = error
    # The first of equal copies, which is `location` if it is among them.
    best = max(counts, key=lambda copy: counts[copy][0]) if counts else None
    if fault and not (best and counts[best][1]):
        raise fault
    with io_errors(location, "written"):
        if best and best != location:
            spare = new if best == old else old
            _remove(spare)
            if location.path.exists():
                location.path.rename(spare.path)
            best.path.rename(location.path)
            sync(location.path.parent)
            progress(Progress(f"{location} was restored from {best}, left by a run cut short"))
        for copy in (new, old):
            _remove(copy)
    _remove_partial_files(location)


def _root_of_copy(copy: Folder, sweep: Sweep | None = None) -> Root | None:
    """Root of a store or a copy of it; None without its root's documents or any results.

    Raises a `DamagedError` if it cannot be read, not even with the scene of its points.
    """
    with io_errors(copy):
        keys = copy.keys()
    if not {FACTS, ROOT} & keys or not has_results(keys):
        return None
    return _root_or_restored(copy, sweep, silent) if sweep else find_root(copy)


def _count_sound_points(store: Store) -> tuple[int, bool]:
    """Number of done points without damage, and whether a store has no damage at all."""
    count, is_clean = 0, True
    for group in store.groups:
        damage = find_damage(group)
        damaged_points = sum(bool(group.flags[index] == DONE) for index in damage.points)
        count += int(np.count_nonzero(group.flags == DONE)) - damaged_points
        is_clean &= not (damage.points or damage.files)
    return count, is_clean


def _remove(copy: Folder) -> None:
    """Delete a folder, its root first: after a kill, what is left of it is no store."""
    if copy.path.exists():
        for key in (FACTS, ROOT):
            (copy.path / key).unlink(missing_ok=True)
        shutil.rmtree(copy.path)


def _remove_partial_files(location: Folder) -> None:
    """Delete the files of a store that a killed run has not completed."""
    with io_errors(location, "written"):
        for file in [*location.path.rglob(f"*{PARTIAL}")]:
            file.unlink()


def _root_or_restored(location: StorePlace, sweep: Sweep, progress: Report) -> Root | None:
    """Root of a store; if both of its documents are lost, that of a scene with the same points.

    Raises the `DamagedError` of the root if the scene disagrees with any array or done point.
    """
    try:
        return find_root(location)
    except DamagedError:
        root = restored_root(location, join(None, sweep))
        if root is None:
            raise
        store = Store(location, root, None, Damage())
        for group in store.groups:
            damage = find_damage(group)
            if damage.points or damage.files.keys() - {INPUTS}:
                raise
        progress(Progress(f"the root of {location} is lost; it is restored from the scene"))
        return root


def _moved_in(
    location: Folder, before: Root | None, root: Root, lock: Lock | None, progress: Report
) -> Store:
    """Write the store of `root` with the points of the old one, and replace that at `location`."""
    new, old = location.sibling(NEW), location.sibling(OLD)
    if location.path.exists() and (foreign_files := sorted(_not_of(before, location))):
        raise _no_room(location, f"{foreign_files[0]}, which is not of this program, would be lost")
    # Growth by realizations leaves fields as they are.
    continues = before and root.plane.continues_fields_of(before.plane)
    stored = [*before.plane.fields] if before and continues else []
    with io_errors(new, "written"):
        _fill(new, root, location if before else None, stored)
        for path in map(path_of, stored):
            link_files(location.path / path, new.path / path, _CHUNK)
    if before:
        store, other = Store(new, root, lock, Damage()), Store(location, before, None, Damage())
        for group, other_group in zip(store.groups, other.groups, strict=False):
            _, unsound, lost = _take(group, other_group, (DONE, FAILED), stored)
            if lost:
                raise _no_room(location, f"{lost} of its points, which are done, would be lost")
            if unsound:
                progress(
                    Progress(f"{location} had {unsound} damaged points, which are computed again")
                )
    with io_errors(location, "written"):
        if location.path.exists():
            location.path.rename(old.path)
        new.path.rename(location.path)
        sync(location.path.parent)
        _remove(old)
    return Store(location, root, lock, Damage())


def _not_of(root: Root | None, location: Folder) -> Iterator[str]:
    """Names of the files and links below a folder that do not belong to its store."""
    keys = {*(root.documents() if root else ())}
    folders = [""]
    while folders:
        folder = folders.pop()
        for entry in os.scandir(location.path / folder):
            key = f"{folder}{entry.name}"
            is_chunk = _CHUNK.fullmatch(entry.name) and f"{folder}{ROOT}" in keys
            if entry.is_dir(follow_symlinks=False):
                folders.append(f"{key}/")
            elif entry.is_symlink() or not (is_chunk or key in keys):
                yield key


def _no_room(location: StorePlace, reason: str) -> StoreError:
    return StoreError(
        f"{location} cannot be extended: {reason}; write a new store and copy the points of this "
        f"one into it: irg run SCENE -o NEW --from {shlex.quote(str(location))}"
    )


# Points of another store


def copy_points(store: Store, other: Store) -> int:
    """Copy done points of `other` that are pending in `store`; return their number.

    Points of the two stores are the same if scene, load and velocity are the same, whatever their
    cases are called. Damaged points are not copied. Nothing is copied if the stores have results
    at different times, or `other` lacks a variable of `store`.
    """
    pairs = zip(store.groups, other.groups, strict=False)
    return sum(_take(group, other_group, (DONE,))[0] for group, other_group in pairs)


def _take(
    store: Store, other: Store, states: tuple[int, ...], stored: Collection[str] = ()
) -> tuple[int, int, int]:
    """Copy pending points that have one of the `states` in `other`.

    The files of the variables `stored` are in place. Return the numbers of points copied, damaged
    in `other`, and not pending in `store`.
    """
    if (
        choose_stored_steps(store.sweep) != choose_stored_steps(other.sweep)
        or store.arrays.keys() & DATA.keys() - other.arrays.keys()
        or store.sweep.fields not in (False, other.sweep.fields)
    ):
        return 0, 0, 0
    pending = defaultdict[tuple[Any, ...], list[Point]](list)
    for point in store.pending():
        pending[store.group.scene_hash(point), *point[:2]].append(point)
    copied, unsound, lost = 0, 0, 0
    other.damage = other.damage or Damage()
    for checked in checked_points(other):
        rows, targets, flags = list[int](), list[Index](), other.flags[tuple(checked.where.T)]
        for row, other_point in enumerate(other.group.points_at(tuple(checked.where.T))):
            same = pending.get((other.group.scene_hash(other_point), *other_point[:2]), ())
            unsound += bool(checked.faults[row] and same)
            lost += not (checked.faults[row] or same)
            for index in map(store.index, same if flags[row] in states else ()):
                # A point is simulated again if `other` lacks its fields.
                needs = store.group.with_fields[index] and flags[row] == DONE
                if not checked.faults[row] and not (needs and _lacks_fields(checked, row)):
                    rows.append(row)
                    targets.append(index)
        if rows:
            names = store.arrays.keys() - {"checksum"}
            values = {
                name: stored[rows]
                if isinstance(stored, np.ndarray)
                else [stored[row] for row in rows]
                for name, stored in checked.values.items()
                if name in names and stored is not None
            }
            store.write(np.array(targets), values, flags[rows], stored)
        copied += len(rows)
    return copied, unsound, lost


def _lacks_fields(checked: Checked, row: int) -> bool:
    return any(checked.values[name][row] is None for name in FIELDS if name in checked.values)


@functools.cache
def versions() -> str:
    """Versions of the packages that compute and store, such as "numpy 2.1, scipy 1.15"."""
    names = ("irg-transition", "numpy", "scipy", "zarr")
    texts = []
    for name in names:
        with suppress(metadata.PackageNotFoundError):  # not installed
            texts.append(f"{name} {metadata.version(name)}")
    return ", ".join(texts)
