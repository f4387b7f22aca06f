"""Create a store, or open it to add points, or say why a sweep cannot continue it.

The points of a store are fixed. If a run needs further ones, or some are damaged, a new store is
written next to the old one, with all its sound points, and takes its place::

    NAME.zarr.irg-lock  is the lock of all of these
    NAME.zarr.irg-new   is written, with the points of NAME.zarr
    NAME.zarr       →   NAME.zarr.irg-old
    NAME.zarr.irg-new → NAME.zarr
    NAME.zarr.irg-old   is deleted

If the process dies on the way, NAME.zarr or NAME.zarr.irg-old has all finished points.
"""

from __future__ import annotations

import functools
import itertools
import math
import re
import shlex
import shutil
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

from pipeline.condition_kinds import CONDITIONS
from pipeline.messages import quoted
from pipeline.paths import PARTIAL, sync
from pipeline.progress import Progress, Report, silent
from pipeline.store.location import (
    MEMORY,
    NEW,
    OLD,
    ROOT,
    PathLike,
    StoreError,
    StoreMismatchError,
    io_errors,
    location_of,
    sibling,
)
from pipeline.store.lock import Lock, locked
from pipeline.store.points import find_damage, transfer
from pipeline.store.root import (
    FACTS,
    GOAL_PREFIX,
    WRITER_PREFIX,
    Root,
    find_root,
    write_documents,
)
from pipeline.store.schema import DONE, FAILED
from pipeline.store.store import Store
from pipeline.sweep.case import Variant
from pipeline.sweep.case_table import in_order
from pipeline.sweep.codec import differences, encode
from pipeline.sweep.plan import choose_stored_steps, points
from pipeline.sweep.sweep import Sweep, case_words
from pipeline.sweep.user_laws import UserObject
from tribo import InputError

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
    if location == MEMORY:
        yield _open(location, sweep, None, progress)
        return
    find_root(location)  # raises before a lock is created next to another program's files
    with locked(location, progress) as lock:
        _remove_leftovers(location)
        yield _open(location, sweep, lock, progress, notes)


def enlarged(store: Store, sweep: Sweep) -> Store:
    """The store, enlarged for the points of a larger sweep; this process must hold its lock."""
    return _open(store.location, sweep, store.lock, silent)


def find_sweep(path: PathLike) -> Sweep | None:
    """Read the sweep that a run continues; None if there is none, `StoreError` for other content.

    If a run was killed while it replaced its store, the sweep is that of the old one.
    """
    location = location_of(path)
    root = find_root(location) or find_root(sibling(location, OLD))
    return root.sweep if root else None


def _remove_leftovers(location: Path) -> None:
    """Delete what a killed run left; an old store that was not replaced yet is renamed back.

    Raises a `StoreError` for a link in the place of a folder, through which files would be written.
    """
    new, old = sibling(location, NEW), sibling(location, OLD)
    with io_errors(location, "written"):
        if old.exists() and not location.exists():
            old.rename(location)
            sync(location.parent)
        for folder in (new, old):
            _remove_folder(folder)
        for file in [*location.rglob("*")]:
            if file.is_symlink() and file.is_dir():
                raise StoreError(f"{file} is a link; replace it by the folder itself")
            if file.name.endswith(PARTIAL):
                file.unlink()


def _remove_folder(folder: Path) -> None:
    """Delete a folder, its root first: after a kill, what is left of it is no store."""
    if folder.exists():
        for key in (ROOT, FACTS):
            (folder / key).unlink(missing_ok=True)
        shutil.rmtree(folder)


def _open(
    location: Path,
    sweep: Sweep,
    lock: Lock | None,
    progress: Report,
    notes: Collection[str] = (),
) -> Store:
    """Create, enlarge or open the store of a sweep; `notes` are added to its history."""
    before = None if location == MEMORY else find_root(location)
    if before:
        _require_same_scene(location, before, sweep)
    joined = join(before.sweep if before else None, sweep)
    history = [*(before.history if before else ()), f"{WRITER_PREFIX}{versions()}", *notes]
    root = Root.from_sweep(joined, history, before.growths if before else 0)
    if location == MEMORY:
        store = _new_store(location, root, None)
    elif before and before.layout == root.layout and _is_sound(location, before):
        with io_errors(location, "written"):
            write_documents(location, root, location)
        store = Store(location, root, lock)
    else:
        store = _replace(location, before, root, lock, progress)
    store.need_only(points(sweep))
    for tests in store.groups[1:]:
        tests.need_only(points(tests.sweep))
    return store


def _require_same_scene(location: Path, root: Root, sweep: Sweep) -> None:
    """Raise a `StoreMismatchError` if a sweep cannot continue a store."""
    if differences := [*mismatches(root.sweep, sweep)]:
        advice = "use the values of the store, or write to another store"
        goals = [line for line in root.history if line.startswith(GOAL_PREFIX)]
        more = [f"to extend the store: irg {goals[-1].replace('with', 'SCENE')}"] if goals else []
        raise StoreMismatchError(
            "\n  ".join([f"{location} belongs to another scene: {advice}", *differences, *more])
        )


def _is_sound(location: Path, root: Root) -> bool:
    store = Store(location, root, may_be_damaged=True)
    return not any(find_damage(group) != ({}, []) for group in store.groups)


def _new_store(location: Path, root: Root, lock: Lock | None) -> Store:
    store = Store(location, root, lock, is_new=True)
    for group in store.groups:
        group.create()
    return store


def _replace(
    location: Path, before: Root | None, root: Root, lock: Lock | None, progress: Report
) -> Store:
    """Write the store of `root` with the points of the old one, and replace that at `location`."""
    new, old = sibling(location, NEW), sibling(location, OLD)
    if before:
        if foreign_key := next(_foreign_keys(location, before), None):
            raise StoreError(
                f"{location} cannot be extended or repaired: {foreign_key}, which is not of this "
                "program, would be lost; write a new store and copy the points of this one: "
                f"irg run SCENE -o NEW --from {shlex.quote(str(location))}"
            )
        # Datasets that are open must not read values of other points.
        root = Root.from_sweep(root.sweep, root.history, before.growths + 1)
    with io_errors(new, "written"):
        write_documents(new, root, location)
    store = _new_store(new, root, lock)
    if before:
        count, sources = 0, Store(location, before, may_be_damaged=True).groups
        for target, source in zip(store.groups, sources, strict=False):
            _, damaged_count = transfer(target, source, (DONE, FAILED))
            count += damaged_count + len(source.unreadable)
        if count:
            words = f"{location} had {count} damaged points or files, which are computed again"
            progress(Progress(words))
    with io_errors(location, "written"):
        if location.exists():
            location.rename(old)
        new.rename(location)
        sync(location.parent)
        _remove_folder(old)
    return Store(location, root, lock)


def _foreign_keys(location: Path, root: Root) -> Iterator[str]:
    """Paths of files and links below a folder that do not belong to its store."""
    documents = root.documents()
    for file in sorted(location.rglob("*")):
        path, key = file.parent.relative_to(location), str(file.relative_to(location))
        is_chunk = _CHUNK.fullmatch(file.name) and f"{path}/{ROOT}" in documents
        if file.is_symlink() or not (is_chunk or key in documents or file.is_dir()):
            yield key


@functools.cache
def versions() -> str:
    """Versions of the packages that compute and store, such as "numpy 2.1, scipy 1.15"."""
    names = ("irg-transition", "numpy", "scipy", "zarr")
    texts = []
    for name in names:
        with suppress(metadata.PackageNotFoundError):  # not installed
            texts.append(f"{name} {metadata.version(name)}")
    return ", ".join(texts)


_ENTRIES = {
    "pixels.shape": "window.pixels", "pixels.spacing": "window.pixel_size",
    "roughness": "disk.roughness", "pin.material": "material of the pin",
    "disk": "material of the disk",
    **{name: condition.entry for name, condition in CONDITIONS.items()},
}  # fmt: skip
"""Entries of the scene file by the beginning of an object's path, if they differ."""

_FIELDS_ASCENDING: tuple[Any, ...] = False, True, "steps"
"""Values of ``sweep.fields``, from no fields to those of all steps."""


def join(before: Sweep | None, sweep: Sweep) -> Sweep:
    """Sweep of a store that is continued: plane and cases of both, other data from `sweep`.

    Which steps and fields are stored stays as in the sweep `before`.
    """
    if before is None:
        return replace(sweep, stored_steps=choose_stored_steps(sweep))
    joined = replace(
        sweep,
        stored_steps=before.stored_steps,
        fields=before.fields,
        loads=_union("sweep.loads", before.loads, sweep.loads),
        velocities=_union("sweep.velocities", before.velocities, sweep.velocities),
        variants=_joined_variants(before, sweep),
    )
    old, new = before.case_table, sweep.case_table
    factors = _union("sweep.load_factors", old.load_factors, new.load_factors)
    if [*old.axes] != [*new.axes]:  # the scene has all cases of the store
        return replace(joined, case_table=replace(new, load_factors=factors))
    union = replace(old.union(new), load_factors=factors)
    cases = tuple((sweep if name in new.by_name else before).case(name) for name in union.names)
    return replace(joined, case_table=union, cases=cases)


def _joined_variants(before: Sweep, sweep: Sweep) -> tuple[Variant, ...]:
    """Variants of both sweeps, in the order of the store; equal ones are those of `sweep`."""
    by_point = {
        (variant.entry, variant.factor, variant.load, variant.velocity, variant.of_case): variant
        for variant in (*before.variants, *sweep.variants)
    }
    return tuple(by_point.values())


def _union(name: str, old: Sequence[float], new: Sequence[float]) -> tuple[float, ...]:
    """Union in ascending order; `InputError` for two values that are equal within rounding."""
    values = in_order([*old, *new])
    for low, high in itertools.pairwise(values):
        if math.isclose(low, high, rel_tol=1e-9):
            in_store, in_scene = (low, high) if low in old else (high, low)
            raise InputError(
                f"{name}: {in_scene!r} in the scene equals {in_store!r} in the store within "
                f"rounding; give {in_store!r}"
            )
    return tuple(values)


def mismatches(stored: Sweep, sweep: Sweep) -> Iterator[str]:
    """Reasons why a sweep cannot continue a store of the sweep `stored`; empty if it can."""
    old, new = stored.case_table, sweep.case_table
    old_hashes, new_hashes = (compared.scene_hashes for compared in (stored, sweep))
    if [*old.axes] != [*new.axes] and not {*old_hashes.values()} <= {*new_hashes.values()}:
        have, gives = (", ".join(table.axes) or "none" for table in (old, new))
        yield f"axes: {have} in the store, {gives} in the scene, which lacks cases of the store"
        return
    for name in old_hashes.keys() & new_hashes.keys():
        before, after = old.by_name[name], new.by_name[name]
        different = [
            _difference_text(k, before[k], after[k]) for k in before if before[k] != after.get(k)
        ]
        if old_hashes[name] != new_hashes[name]:
            scenes = (compared.case(name).scene for compared in (stored, sweep))
            different += changes_in_words(*scenes)
        if different:
            row = f"scene with {', '.join(case_words(name))}: " if name else ""
            yield from (f"{row}{words}" for words in different)
            break  # one differing case is enough
    if (steps := sweep.steps) not in (None, choose_stored_steps(stored).steps):
        yield _difference_text("sweep.steps", choose_stored_steps(stored).steps, steps)
    if _FIELDS_ASCENDING.index(sweep.fields) > _FIELDS_ASCENDING.index(stored.fields):
        yield _difference_text("sweep.fields", quoted(stored.fields), quoted(sweep.fields))
    try:
        join(stored, sweep)
    except InputError as error:
        yield str(error)


def changes_in_words(old: Any, new: Any) -> Iterator[str]:
    """Yield differences between two scenes or conditions, in words, with numbers in SI."""
    plain = (encode(value, with_defaults=True) for value in (old, new))
    for path, before, after in differences(*plain):
        first = next(
            (entry for entry in _ENTRIES if path == entry or path.startswith(f"{entry}.")), ""
        )
        yield _difference_text(_ENTRIES.get(first, "") + path[len(first) :], before, after)


def _difference_text(path: str, old: Any, new: Any) -> str:
    return f"{path}: {_value_text(old)} in the store, {_value_text(new)} in the scene"


def _value_text(value: Any) -> str:
    match value:
        case None:
            return "none"
        case {"is": "UserLaw" | "UserSurface"}:
            names = "name", "values", "code", "text"
            return repr(UserObject(**{name: value[name] for name in names}))
        case {"is": "number", "text": text} | {"is": "array", "digest": text} | {"is": text}:
            return str(text)
        case float():
            return f"{value:g}"
    return str(value)
