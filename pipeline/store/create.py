"""Creation, opening and growth of a store, and the restoring of its root, which is written last.

A growth between values makes a larger store beside the old one, in whose place it is renamed. The
file of the lock is linked into the larger store, so that the lock stays held throughout.
"""

from __future__ import annotations

import math
import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from pipeline.store.files import PARTIAL, sync
from pipeline.store.inputs import DIM, inputs_variable, joined_arrays
from pipeline.store.layout import (
    arrays_of,
    block_of,
    blocks,
    bytes_of_a_point,
    chunk_key,
    chunk_numbers,
    documents,
    grown_axes,
    made_coordinates,
)
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    LOCK,
    ROOT,
    Bucket,
    DamagedError,
    Folder,
    PathLike,
    StoreError,
    StoreMismatchError,
    StorePlace,
    keep_beside,
    larger,
    place_of,
    reaches,
    reads,
    smaller,
    writes,
)
from pipeline.store.root import (
    Facts,
    LostRootError,
    Root,
    are_rows,
    copied,
    copied_attributes,
    find_root,
    read_root,
    require_complete,
    require_likely,
    root_document,
)
from pipeline.store.schema import AT_END, INPUTS, PENDING, STEPPED, is_coordinate, variables_of
from pipeline.store.verify import agrees, repaired, require_right_root
from pipeline.store.versions import package_versions
from pipeline.store.write import Store
from pipeline.sweep.codec import Arrays, sweep_text
from pipeline.sweep.limits import MOST_POINTS
from pipeline.sweep.model import Sweep
from pipeline.sweep.stages import Progress, Report, silent
from pipeline.sweep.stored import join, misfits

_T = TypeVar("_T")
Repair = Callable[[Store], None]
_ROOM = 2  # reference loads up to which a bucket has room for the steps of a course


@contextmanager
def writing(
    path: PathLike, sweep: Sweep, progress: Report = silent, repair: Repair | None = None
) -> Iterator[Store]:
    """Create the store of a sweep, or open it and make room for what the sweep adds.

    A repair is called before anything else is changed. Raise a `StoreMismatchError` if it belongs
    to another scene, a `StoreError` if something else is in its place, another process writes to
    it, or it cannot be read or written.
    """
    place = place_of(path, to_write=True)
    find_root(place)  # before a lock is laid in what is no store
    with held(place, progress) as lock:
        if isinstance(place, Folder):
            with writes(place):
                for file in (place.path / (ROOT + PARTIAL), *place.path.glob(f"*/*{PARTIAL}")):
                    file.unlink(missing_ok=True)
                _remove_unfinished(place.path)
        yield grown(place, sweep, lock, repair)


def grown(
    place: StorePlace, sweep: Sweep, lock: Lock | None, repair: Repair | None = None
) -> Store:
    """Open a store whose lock is held, with room for what a sweep adds; raise as `writing` does."""
    if root := find_root(place):
        require_complete(place, root)
    if root and (differing := [*misfits(root.sweep, sweep)]):
        advice = "give it what the store has, or write to another store"
        raise StoreMismatchError(
            "\n  ".join([f"{place} belongs to another scene; {advice}", *differing])
        )
    if root and repair:
        repair(Store(place, root, lock, is_damaged=True))
    with writes(place):
        root = _grown_root(place, root, sweep, lock)
    store = _repaired_if_need_be(place, root, lock, lambda store: store)
    store.ask(sweep)
    return store


def _repaired_if_need_be(
    place: StorePlace, root: Root, lock: Lock | None, use: Callable[[Store], _T]
) -> _T:
    """What a function makes of an open store, which is repaired first if it is damaged."""
    try:
        return use(Store(place, root, lock))
    except DamagedError:
        repaired(Store(place, root, lock, is_damaged=True))
        return use(Store(place, root, lock))


def _grown_root(place: StorePlace, before: Root | None, sweep: Sweep, lock: Lock | None) -> Root:
    """Root of a store with room for a sweep: the arrays are written first, then the root."""
    kept, arrays = join(before and before.sweep, sweep), Arrays()
    sweep_text(kept, arrays)
    wanted = variables_of(kept)
    axes = grown_axes(before.axes if before else {}, kept, sweep.plane)
    axes = {name: values for name, values in axes.items() if name in wanted}
    if not before and isinstance(place, Bucket):  # whose steps cannot be added to
        room = _ROOM * kept.scene.fidelity.increments if len(axes["step"]) > 1 else 0
        axes["step"] = list(range(min(axes["step"][0], -room), 1))
    sizes = {dim: len(axes[dim]) for dim in wanted["status"].dims}
    points = math.prod(sizes.values())
    if points > MOST_POINTS:
        raise StoreError(
            f"{place} would have {points:.4g} points; a store has at most {MOST_POINTS:.0e}: give "
            "fewer loads or velocities"
        )
    chunk = block_of(sizes, bytes_of_a_point(wanted, axes))
    is_inserted = before and any(axes[name][: len(old)] != old for name, old in before.axes.items())
    facts = Facts(generation=0, axes=axes, points_per_chunk=chunk, versions=package_versions())
    if before:
        facts = replace(before.facts.note_versions(), axes=axes)
    if before and is_inserted:
        facts = replace(facts, points_per_chunk=chunk, generation=facts.generation + 1)
    root = Root(kept, facts, {})
    wanted["step"] = wanted["step"]._replace(attributes=copied_attributes(root))
    values: dict[str, Any] = axes | made_coordinates(kept, axes)
    if arrays:
        wanted[INPUTS] = inputs_variable(arrays)
        values |= {DIM: range(len(held := joined_arrays(arrays))), INPUTS: held}
    contents, metadata = documents(wanted, values, facts.points_per_chunk)
    root = root._replace(arrays=metadata)
    if before and root_document(root) == root_document(before):
        return before
    if before and is_inserted:
        if isinstance(place, Bucket):
            raise StoreError(
                f"{place} cannot take values between its own, or stations before them, since "
                "objects cannot be renamed; write to another store"
            )
        path = place.path
        _repaired_if_need_be(
            place, before, lock, lambda store: _replace_by_larger(store, path, root, contents)
        )
        return read_root(place)
    place.put({k: new for k, new in contents.items() if not before or new != place.read(k)})
    place.put({ROOT: root_document(root)})
    if not before and isinstance(place, Folder):
        # Their names may come from a process that was killed before it synced them.
        for folder in place.path.parents[:2]:
            with suppress(PermissionError):
                sync(folder)
    return read_root(place)


def _replace_by_larger(store: Store, path: Path, root: Root, contents: Mapping[str, bytes]) -> None:
    """Replace a store by a larger one with this root, and these documents and coordinates."""
    _remove_unfinished(path)
    beside = Folder(larger(path))
    (beside.path / LOCK).parent.mkdir(parents=True)
    (beside.path / LOCK).hardlink_to(path / LOCK)
    beside.put(contents)
    _copy(store, path, root, beside)
    for kept in path.iterdir():  # of the user, or by a repair
        other = beside.path / kept.name
        if kept.name in (ROOT, ROOT + PARTIAL) or other.exists():
            continue
        if kept.is_dir() and not kept.is_symlink():
            shutil.copytree(kept, other, symlinks=True, copy_function=os.link)
        else:
            os.link(kept, other, follow_symlinks=False)
    beside.put({ROOT: root_document(root)})
    sync(path.parent)
    store.require_lock()  # whoever holds another one has removed some of what was made beside
    path.rename(smaller(path))
    try:
        beside.path.rename(path)
    except OSError:
        if not (path / ROOT).exists():  # unless another process has finished it
            raise
    sync(path.parent)
    _remove_unfinished(path)


def _remove_unfinished(path: Path) -> None:
    """Remove what a growth that was killed has left beside a store, whose lock is held."""
    for folder in (larger(path), smaller(path)):
        if folder.exists():
            shutil.rmtree(folder)


def _copy(store: Store, path: Path, root: Root, beside: Folder) -> None:
    """Copy the stored values of points to their places in the arrays of a larger store."""
    arrays = arrays_of(beside, root.arrays, read_only=False)
    moved = [pd.Index(root.axes[dim]).get_indexer(store.axes[dim]) for dim in store.dims]
    where = np.zeros(arrays["status"].shape, bool)
    where[np.ix_(*moved)] = (store.flags != PENDING) | (store.asked != 0)
    shared = [name for name in arrays if not (name in AT_END or is_coordinate(name))]
    for _, block in blocks(where, arrays["status"].chunks):
        old = tuple(
            np.flatnonzero((of_dim >= part.start) & (of_dim < part.stop))
            for of_dim, part in zip(moved, block, strict=True)
        )
        new = [of_dim[numbers] for of_dim, numbers in zip(moved, old, strict=True)]
        for name in shared:
            with reads(store.place, name):
                values = store.arrays[name].oindex[old]
            # Stations are counted back from the end.
            last = [slice(-values.shape[len(old)], None)] if name in STEPPED else []
            arrays[name].oindex[(*new, *last)] = values
    for name in arrays.keys() & AT_END.keys():  # a file for each point, which takes its new name
        for file in (path / name).glob("c.*"):
            numbers = chunk_numbers(file.name)
            # Those beyond are of no point that the store knows.
            if numbers and all(i < len(of_dim) for i, of_dim in zip(numbers, moved, strict=False)):
                index = [of_dim[i] for of_dim, i in zip(moved, numbers, strict=False)]
                key = chunk_key(name, (*index, *numbers[len(index) :]))
                (beside.path / key).hardlink_to(file)


def restore_root(path: PathLike, sweep: Sweep, progress: Report = silent) -> bool:
    """Make a lost root again from the scene and the files of the arrays; True if it was lost.

    A root that does not belong to its arrays counts as lost, except in a bucket, which is not
    searched. Raise a `StoreMismatchError`, and write nothing, if the checksums of the points say
    that another sweep made the store: each includes the hash of what was simulated.
    """
    place = place_of(path, to_write=True)
    try:
        for fault in _faults_beside_root(place):
            progress(Progress(f"{fault}; irg verify {path} --repair writes it again"))
    except LostRootError:
        with held(place):
            try:
                _faults_beside_root(place)
            except LostRootError as error:  # still, and no other process has made it meanwhile
                root = _remade(place, sweep, error)
                with writes(place):
                    keep_beside(place, [ROOT])
                    place.put({ROOT: root_document(root)})
        progress(Progress(f"the root of {path} was lost, damaged or old, and is made again"))
        return True
    return False


def _faults_beside_root(place: StorePlace) -> tuple[str, ...]:
    """Faults of what arrays copy of a root; raise a `LostRootError` if that is lost."""
    root = find_root(place)
    return require_right_root(place, root) if root and isinstance(place, Folder) else ()


def _remade(place: StorePlace, sweep: Sweep, lost: StoreError) -> Root:
    """The root as the sweep says, if the points of the store agree."""
    with reaches(place):
        with_fields = place.read(f"pressure/{ROOT}") is not None
    kept = join(None, sweep.changed(fields=with_fields))
    arrays = Arrays()
    sweep_text(kept, arrays)
    names = [*variables_of(kept), *([INPUTS] if arrays else [])]
    try:
        stations, facts, metadata = copied(place, names)
    except DamagedError as error:
        raise StoreError(f"{lost}; it cannot be made again: {error}") from error
    # Whoever opened it before opens it again.
    facts = replace(facts, generation=int(time.time()))
    # The scene may ask for more values than there are.
    table = kept.variants.within(facts.axes)
    root = Root(kept.changed(stations=stations, variants=table), facts, metadata)
    if are_rows(root):
        require_likely(place, facts, metadata)
        if agrees(Store(place, root, is_damaged=True)):
            return root
    raise StoreMismatchError(
        f"{place} has lost its {ROOT}, or it is of another version of this program, and its points "
        "are not those of this scene; give the scene that made it, with all its values, go on with "
        "that version, or write to another store"
    )
