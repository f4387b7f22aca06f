"""Creation, opening and growth of a store; its root is written last.

It grows at the upper ends of its axes alone. What it cannot take goes into a new store, which takes
over the points of the old one.
"""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any

from pipeline.scene.kept import files_of
from pipeline.scene.resume import join
from pipeline.store.files import PARTIAL, remove_file, sync
from pipeline.store.inputs import DIM, inputs_variable, joined_arrays
from pipeline.store.layout import (
    Axes,
    block_of,
    bytes_of_a_point,
    documents,
    grown_axes,
    made_coordinates,
    spread_ids,
)
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    ROOT,
    Bucket,
    Folder,
    PathLike,
    StoreError,
    StorePlace,
    place_of,
    reaches,
    writes,
)
from pipeline.store.root import (
    Facts,
    Root,
    find_root,
    read_root,
    require_same_scene,
    root_documents,
)
from pipeline.store.schema import INPUTS, POINT, SCENE_ID, path_of, variables_of
from pipeline.store.versions import package_versions
from pipeline.store.write import Store
from pipeline.sweep.identity import scene_ids
from pipeline.sweep.limits import MOST_POINTS
from pipeline.sweep.model import Sweep
from pipeline.sweep.stages import Report, silent


@contextmanager
def writing(path: PathLike, sweep: Sweep, progress: Report = silent) -> Iterator[Store]:
    """Create the store of a sweep, or open it and make room for what the sweep adds.

    Raise a `StoreMismatchError` if it belongs to another scene, a `StoreError` if something else is
    in its place, another process writes to it, or it cannot be read or written.
    """
    place = place_of(path)
    find_root(place)  # before a lock is laid in what is no store
    with held(place, progress) as lock:
        if isinstance(place, Folder):
            with writes(place):
                for key in sorted(place.keys()):
                    if key.endswith(PARTIAL):
                        remove_file(place.path, key)
        yield grown(place, sweep, lock)


def grown(place: StorePlace, sweep: Sweep, lock: Lock | None) -> Store:
    """Open a store whose lock is held, with room for what a sweep adds; raise as `writing` does."""
    if root := find_root(place):
        require_same_scene(place, root, sweep)
    with writes(place):
        root = _grown_root(place, root, sweep)
    store = Store(place, root, lock)
    store.ask(sweep)
    return store


def _grown_root(place: StorePlace, before: Root | None, sweep: Sweep) -> Root:
    """Root of a store with room for a sweep: the arrays are written first, then the root."""
    if before and (POINT in before.axes) != (sweep.chosen is not None):
        raise _no_room(place, "a plane and a search of its boundary have a store each")
    kept = join(before and before.sweep, sweep)
    arrays = files_of(kept)
    wanted = variables_of(kept)
    axes = grown_axes(before.axes if before else {}, kept, sweep)
    axes = {name: values for name, values in axes.items() if name in wanted}
    sizes = {dim: len(axes[dim]) for dim in wanted["status"].dims}
    points = math.prod(sizes.values())
    if points > MOST_POINTS:
        raise StoreError(
            f"{place} would have {points:.4g} points; a store has at most {MOST_POINTS:.0e}: give "
            "fewer loads or velocities"
        )
    if before:
        _require_room(place, before, axes)
        facts = replace(before.facts.note_versions(), axes=axes)
    else:
        chunk = block_of(sizes, bytes_of_a_point(wanted, axes))
        facts = Facts(axes=axes, points_per_chunk=chunk, versions=package_versions())
    ids = scene_ids(kept, {})
    values: dict[str, Any] = axes | made_coordinates(kept, axes)
    values[SCENE_ID] = spread_ids(kept, axes, ids)
    if arrays:
        wanted[INPUTS] = inputs_variable(arrays)
        values |= {DIM: range(len(held := joined_arrays(arrays))), INPUTS: held}
    contents, metadata = documents(wanted, values, facts.points_per_chunk)
    others = before.others if before else {"attributes": {}, "metadata": {}}
    root = Root(kept, facts, ids, metadata, others)
    groups = root_documents(root)
    is_new = before is None or groups != root_documents(before)
    document = groups.pop(ROOT)
    contents |= groups
    if isinstance(place, Bucket) and before and not is_new:
        return before
    if before:
        with reaches(place):  # also coordinates and metadata that were damaged
            found = {key: place.read(key) for key in contents}
        contents = {key: keep_others(found[key], new) for key, new in contents.items()}
        contents = {key: new for key, new in contents.items() if new != found[key]}
    place.put(contents)
    if before and not is_new:
        return before
    place.put({ROOT: document})
    if not before and isinstance(place, Folder):
        # Their names may come from a process that was killed before it synced them.
        for folder in place.path.parents[:2]:
            with suppress(PermissionError):
                sync(folder)
    return read_root(place)


def keep_others(found: bytes | None, new: bytes) -> bytes:
    """A document of metadata with attributes that others have added to the one that was found."""
    with suppress(ValueError, KeyError, TypeError):  # a chunk, or damaged
        old, document = json.loads(found or b""), json.loads(new)
        whole = document | {"attributes": old["attributes"] | document["attributes"]}
        if whole != document:  # there are others
            return found if found and whole == old else json.dumps(whole).encode()
    return new


def _require_room(place: StorePlace, before: Root, axes: Axes) -> None:
    """Raise a `StoreError` if axes do not begin with those that a store has."""
    old = before.axes
    unlike = (name for name, values in axes.items() if not _begins(values, old.get(name)))
    if name := next(unlike, None):
        raise _no_room(place, f"{name} would not grow at its upper end")
    grown = {name for name, values in axes.items() if len(values) > len(old[name])}
    own = {path_of(name) for name in variables_of(before.sweep)}
    for path, array in before.others["metadata"].items():
        dims = array.get("dimension_names") if isinstance(array, dict) else None
        if path not in own and not grown.isdisjoint(dims or ()):
            raise _no_room(place, f"{path}, which is not of the store, would not grow with it")


def _begins(values: Sequence[Any], first: Sequence[Any] | None) -> bool:
    """True if values begin with the first ones."""
    return first is not None and list(values[: len(first)]) == list(first)


def _no_room(place: StorePlace, reason: str) -> StoreError:
    return StoreError(
        f"{place} has no room for this: {reason}; write a new store, which takes the points of "
        f"this one: irg run SCENE -o NEW --from {shlex.quote(str(place))}"
    )
