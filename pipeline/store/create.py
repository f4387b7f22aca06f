"""Creation, opening and growth of a store; its root is written last.

A growth between values makes a larger store beside the old one, in whose place it is renamed. The
file of the lock is linked into the larger store, so that the lock stays held throughout.
"""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pipeline.store.files import PARTIAL, link_file, remove_file, sync
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
    Folder,
    PathLike,
    StoreError,
    StorePlace,
    is_of_store,
    larger,
    place_of,
    reaches,
    reads,
    smaller,
    writes,
)
from pipeline.store.root import (
    Facts,
    Root,
    find_closed_root,
    find_root,
    read_root,
    require_same_scene,
    root_document,
)
from pipeline.store.schema import AT_END, INPUTS, PENDING, STEPPED, is_coordinate, variables_of
from pipeline.store.versions import package_versions
from pipeline.store.write import Store
from pipeline.sweep.codec import Arrays, sweep_text
from pipeline.sweep.limits import MOST_POINTS
from pipeline.sweep.model import Sweep
from pipeline.sweep.stages import Report, silent
from pipeline.sweep.stored import join

_ROOM = 2  # reference loads up to which a bucket has room for the steps of a course


@contextmanager
def writing(path: PathLike, sweep: Sweep, progress: Report = silent) -> Iterator[Store]:
    """Create the store of a sweep, or open it and make room for what the sweep adds.

    Raise a `StoreMismatchError` if it belongs to another scene, a `StoreError` if something else is
    in its place, another process writes to it, or it cannot be read or written.
    """
    place = place_of(path, to_write=True)
    _, arrays = find_closed_root(place, sweep)  # before a lock is laid in what is no store
    with held(place, progress) as lock:
        if isinstance(place, Folder):
            with writes(place):
                for key in place.keys(arrays):
                    if key.endswith(PARTIAL):
                        remove_file(place.path, key)
                _remove_unfinished(place.path)
        yield grown(place, sweep, lock)


def grown(place: StorePlace, sweep: Sweep, lock: Lock | None) -> Store:
    """Open a store whose lock is held, with room for what a sweep adds; raise as `writing` does."""
    if root := find_root(place):
        require_same_scene(place, root, sweep)
    with writes(place):
        root = _grown_root(place, root, sweep, lock)
    store = Store(place, root, lock)
    store.ask(sweep)
    return store


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
    values: dict[str, Any] = axes | made_coordinates(kept, axes)
    if arrays:
        wanted[INPUTS] = inputs_variable(arrays)
        values |= {DIM: range(len(held := joined_arrays(arrays))), INPUTS: held}
    contents, metadata = documents(wanted, values, facts.points_per_chunk)
    root = Root(kept, facts, metadata)
    is_new = before is None or root_document(root) != root_document(before)
    if isinstance(place, Bucket) and before and not is_new:
        return before
    if before and is_inserted:
        if isinstance(place, Bucket):
            raise StoreError(
                f"{place} cannot take values between its own, or stations before them, since "
                "objects cannot be renamed; write to another store"
            )
        _replace_by_larger(Store(place, before, lock), place.path, root, contents)
        return read_root(place)
    if before:
        with reaches(place):  # also coordinates and metadata that were damaged
            contents = {key: new for key, new in contents.items() if new != place.read(key)}
    place.put(contents)
    if before and not is_new:
        return before
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
    beside.path.mkdir()
    link_file(path, LOCK, beside.path, LOCK)
    beside.put(contents)
    _copy(store, path, root, beside)
    for key, entry in Folder(path).entries(root.arrays):
        if is_of_store(key, root.arrays):
            continue
        if entry.is_dir(follow_symlinks=False):
            shutil.copytree(entry, beside.path / key, symlinks=True, copy_function=os.link)
        else:
            link_file(path, key, beside.path, key)
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
        for old_key in Folder(path).keys([name]):
            numbers = chunk_numbers(old_key.removeprefix(f"{name}/"))
            # Those beyond are of no point that the store knows.
            if numbers and all(i < len(of_dim) for i, of_dim in zip(numbers, moved, strict=False)):
                index = [of_dim[i] for of_dim, i in zip(moved, numbers, strict=False)]
                key = chunk_key(name, (*index, *numbers[len(index) :]))
                link_file(path, old_key, beside.path, key)
