"""Creation of a store, its growth, and its opening by the one process that writes to it.

A new store is no store until its root is there, which is written last.

Growth of a store whose axes no longer ascend if values are put at their ends.

The larger store is made beside the old one, in order, and then put in its place by two renames.
Whoever opens the name between them finishes the second (`pipeline.store.place.place_of`). The file
of the lock is linked into the larger store, so that the lock stays held throughout.
"""

from __future__ import annotations

import itertools
import json
import math
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.store.attributes import describe, differences, grown_axes, root_attributes
from pipeline.store.files import PARTIAL, sync
from pipeline.store.layout import (
    arrays_of,
    block_of,
    blocks,
    bytes_of_a_point,
    documents,
)
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    LOCK,
    ROOT,
    Bucket,
    Folder,
    PathLike,
    Place,
    StoreError,
    StoreMismatchError,
    larger,
    place_of,
    smaller,
    writes,
)
from pipeline.store.root import MOST_POINTS, Root, find_root, read_root, root_document
from pipeline.store.schema import AT_END, PENDING, PLANE, STEPPED, is_coordinate, variables_of
from pipeline.store.verify import examined
from pipeline.store.write import Store
from pipeline.sweep.model import Sweep, named
from pipeline.sweep.stations import Stations
from tribo import QUANTILES
from tribo.types import Indices


@contextmanager
def writing(path: PathLike, sweep: Sweep) -> Iterator[Store]:
    """Create the store of a sweep, or open it and make room for what the sweep adds.

    What is in the store stays, whether or not the sweep still asks for it.

    Raises
    ------
    StoreMismatchError
        If the store belongs to another scene; the message says how the two differ.
    StoreError
        If there is something else in its place, another process writes to it, or it cannot be
        written.
    """
    place = place_of(path)
    find_root(place)  # before a lock is laid in what is no store
    with held(place) as lock:
        with writes(place):
            _remove_partial(place)
            if isinstance(place, Folder):
                remove_unfinished(place.path)
        yield grown(place, sweep, lock)


def grown(place: Place, sweep: Sweep, lock: Lock | None) -> Store:
    """Open a store whose lock is held, with room for what a sweep adds; raise as `writing` does."""
    root = find_root(place)
    if root:
        sweep = sweep.changed(stations=root.attributes["stations"])
    if root and (fault := next(_mismatches(root, sweep), None)):
        raise StoreMismatchError(f"{place} {fault}")
    with writes(place):
        root = _with_room(place, root, sweep, lock)
    try:
        store = Store(place, root, lock)
    except StoreError:  # statuses, or marks of what was asked for, are damaged
        examined(Store(place, root, lock, is_damaged=True), repair=True)
        store = Store(place, root, lock)
    store.ask(store.asked_by(sweep))
    return store


def _with_room(place: Place, before: Root | None, sweep: Sweep, lock: Lock | None) -> Root:
    """Root of a store with room for a sweep: the arrays are written first, then the root."""
    with_fields = "pressure" in before.arrays if before else sweep.record.fields
    wanted = variables_of(sweep, with_fields)
    stations = {"stations": json.dumps(Stations.of(sweep).as_dict())}
    wanted["step"] = wanted["step"]._replace(attributes=stations)
    axes = grown_axes(before.axes if before else {}, sweep)
    axes = {name: values for name, values in axes.items() if name in wanted}
    if not before and isinstance(place, Bucket):  # whose steps cannot be added to
        room = len(Stations.of(sweep).loads)
        axes["step"] = list(range(min(axes["step"][0], -room), 1))
    points = math.prod(len(axes[dim]) for dim in wanted["status"].dims)
    if points > MOST_POINTS:
        raise StoreError(
            f"{place} would have {points:.4g} points; a store has at most {MOST_POINTS:.0e}: give "
            "fewer loads or velocities"
        )
    attributes = root_attributes(sweep, before.attributes if before else None) | {"axes": axes}
    if before and attributes == before.attributes:
        return before
    if not before or not goes_on(before.axes, axes):
        sizes = {dim: len(axes[dim]) for dim in wanted["status"].dims}
        attributes["points_per_chunk"] = block_of(sizes, bytes_of_a_point(wanted, axes))
        attributes["generation"] = before.attributes["generation"] + 1 if before else 0
    contents, metadata = documents(wanted, axes, attributes["points_per_chunk"])
    if before and not goes_on(before.axes, axes):
        _replace_by_larger(place, before, lock, (attributes, contents, metadata))
        return read_root(place)
    place.put({k: new for k, new in contents.items() if not before or new != place.read(k)})
    place.put({ROOT: root_document(attributes, metadata)})
    if not before and isinstance(place, Folder):
        # Their names may come from a process that was killed before it synced them.
        for folder in place.path.parents[:2]:
            with suppress(PermissionError):
                sync(folder)
    return read_root(place)


def _replace_by_larger(place: Place, before: Root, lock: Lock | None, larger: Any) -> None:
    """Put a larger store in the place of one; first repair this if it cannot be read."""
    if not isinstance(place, Folder):
        raise StoreError(
            f"{place} cannot take values between its own, or stations before them, since objects "
            "cannot be renamed; write to another store"
        )
    try:
        replace_by_larger(Store(place, before, lock), *larger)
    except StoreError:
        examined(Store(place, before, lock, is_damaged=True), repair=True)
        replace_by_larger(Store(place, before, lock), *larger)


def _mismatches(root: Root, sweep: Sweep) -> Iterator[str]:
    """Reasons why a store is not that of a sweep."""
    dims = root.arrays["status"]["dimension_names"]
    stored, wanted = [dim for dim in dims if dim not in PLANE], [*sweep.variants.axes]
    if stored != wanted:
        have, gives = (", ".join(names) or "none" for names in (stored, wanted))
        yield (
            f"has other axes, by sweep.over, wear_rates, realizations or samples: {have} in the "
            f"store, {gives} in the scene; they stay what they were at its creation: give the same "
            "ones, or write to another store"
        )
        return
    different = [
        *_differences_of_scenes(root, sweep),
        *differences(root.axes["cooler_share"], list(QUANTILES), "cooler_share"),
    ]
    if different:
        yield "\n  ".join(["belongs to another scene; write to another store", *different])
    yield from _gaps(root, sweep)
    steps, stored_steps = sweep.record.steps, root.attributes["stations"]["steps"]
    if steps is not None and steps != stored_steps:
        yield (
            f"has sweep.steps = {json.dumps(stored_steps)}, and the scene {json.dumps(steps)}; "
            "they stay what they were at its creation: leave them out, or write to another store"
        )
    if sweep.record.fields and "pressure" not in root.arrays:
        yield (
            "has no fields, since its scene did not ask for them when it was created; leave out "
            "sweep.store_fields, or write to another store"
        )
    names = variables_of(sweep, "pressure" in root.arrays).keys()
    if differing := ", ".join(sorted(names ^ root.arrays.keys())):
        yield f"was made by a version with other variables ({differing}); write to another store"
    for column, values in sweep.variants.coordinates.items():
        held = dict(zip(root.axes[column.along], root.axes[column.name], strict=True))
        for label in values.keys() & held.keys():
            if held[label] != values[label]:
                yield (
                    f"has {column.name} {held[label]} at {column.along} {label}, and the scene "
                    f"{values[label]}; rows stay what they were: add others behind them, or write "
                    "to another store"
                )


def _gaps(root: Root, sweep: Sweep) -> Iterator[str]:
    """Tell of a combination of the values of entries that neither a store nor a sweep has."""
    names = root.attributes.get("over", [])
    stored = [tuple(row["values"]) for row in root.attributes.get("scenes", [])]
    known = {*stored, *(tuple(value for _, value in name) for name in sweep.variants.given)}
    axes = [dict.fromkeys(values) for values in zip(*known, strict=True)]
    gap = next((one for one in itertools.product(*axes) if one not in known), None)
    if gap is not None:
        words = ", ".join(f"{name} {value}" for name, value in zip(names, gap, strict=True))
        yield (
            f"would lack combinations of values, such as {words} (in SI); give each entry of "
            "sweep.over all of its values, those of the store included"
        )


def _differences_of_scenes(root: Root, sweep: Sweep) -> Iterator[str]:
    """Entries in which the scene of a store differs from a sweep, for the same values of `over`."""
    scene = root.attributes["scene"]
    held = root.attributes.get("scenes", [{"values": [], "scene": {}}])
    stored = {tuple(entry["values"]): scene | entry["scene"] for entry in held}
    for name in sweep.variants.given:
        key = f"scene with {', '.join(named(name))}: scene" if name else "scene"
        if known := stored.get(tuple(value for _, value in name)):
            yield from differences(known, describe(sweep, name), key)


def _remove_partial(place: Place) -> None:
    """Remove what a killed writer was writing."""
    if isinstance(place, Folder):
        for file in (place.path / (ROOT + PARTIAL), *place.path.glob(f"*/*{PARTIAL}")):
            file.unlink(missing_ok=True)


_ABSENT = -1


def goes_on(before: Mapping[str, Sequence[Any]], after: Mapping[str, Sequence[Any]]) -> bool:
    """True if values are added to axes at their ends alone.

    Examples
    --------
    >>> goes_on({"load": [1.0, 2.0]}, {"load": [1.0, 2.0, 3.0]})
    True
    >>> goes_on({"step": [-1, 0]}, {"step": [-2, -1, 0]})
    False
    """
    return all(list(after[name][: len(values)]) == list(values) for name, values in before.items())


def replace_by_larger(
    store: Store,
    attributes: Mapping[str, Any],
    contents: Mapping[str, bytes],
    metadata: Mapping[str, Any],
) -> None:
    """Replace a store by a larger one with these attributes, documents and metadata of arrays."""
    assert isinstance(store.place, Folder)
    path = store.place.path
    remove_unfinished(path)
    beside = Folder(larger(path))
    (beside.path / LOCK).parent.mkdir(parents=True)
    (beside.path / LOCK).hardlink_to(path / LOCK)
    beside.put(contents)
    _copy(store, arrays_of(beside, metadata, read_only=False), attributes["axes"], beside.path)
    beside.put({ROOT: root_document(attributes, metadata)})
    sync(path.parent)
    store.require_lock()  # whoever holds another one has removed some of what was made beside
    path.rename(smaller(path))
    try:
        beside.path.rename(path)
    except OSError:
        if not (path / ROOT).exists():  # unless a reader has finished it
            raise
    sync(path.parent)
    remove_unfinished(path)


def remove_unfinished(path: Path) -> None:
    """Remove what a growth that was killed has left beside a store, whose lock is held."""
    for folder in (larger(path), smaller(path)):
        if folder.exists():
            shutil.rmtree(folder)


def _copy(
    store: Store, arrays: Mapping[str, Any], axes: Mapping[str, Sequence[Any]], folder: Path
) -> None:
    """Copy what is stored of points to their places in larger arrays."""
    places = [_places(store.axes[dim], axes[dim]) for dim in store.dims]
    begun = store.flags != PENDING
    shape = arrays["status"].shape
    where = np.zeros(shape, bool)
    inverse = [{int(old): new for new, old in enumerate(along)} for along in places]
    for index in np.argwhere(begun | (store.asked != 0)):
        where[tuple(along[int(i)] for along, i in zip(inverse, index, strict=True))] = True
    size = arrays["status"].chunks
    for name, array in arrays.items():
        if name in AT_END:
            _link(store, name, inverse, folder)
        elif not is_coordinate(name):
            for _, block in blocks(where, size):
                array[block] = _part(store, name, array, block, places)


def _places(before: Sequence[Any], after: Sequence[Any]) -> Indices:
    """Place in the old axis of each value of the new one, where it has one."""
    numbers = {value: number for number, value in enumerate(before)}
    return np.array([numbers.get(value, _ABSENT) for value in after])


def _part(
    store: Store, name: str, array: Any, block: tuple[slice, ...], places: Sequence[Indices]
) -> Any:
    """A chunk of a larger array, with what the store has of it."""
    part = array[block]
    along = [of_dim[one] for of_dim, one in zip(places, block, strict=True)]
    present = [np.flatnonzero(one != _ABSENT) for one in along]
    if not all(one.size for one in present):
        return part
    old = tuple(one[at] for one, at in zip(along, present, strict=True))
    values = store.read_at(name, old)
    if name in STEPPED:  # which are counted back from the end
        part[(*np.ix_(*present), slice(-values.shape[len(old)], None))] = values
    else:
        part[np.ix_(*present)] = values
    return part


def _link(store: Store, name: str, inverse: Sequence[Mapping[int, int]], folder: Path) -> None:
    """Link the files of a field, one for each point, to their new names."""
    assert isinstance(store.place, Folder)
    with suppress(FileNotFoundError), os.scandir(store.place.path / name) as entries:
        for entry in entries:
            first, *numbers = entry.name.split(".")
            if first != "c" or not all(number.isdigit() for number in numbers):
                continue
            index, rest = numbers[: len(inverse)], numbers[len(inverse) :]
            new = [str(of_dim[int(i)]) for of_dim, i in zip(inverse, index, strict=True)]
            (folder / name / ".".join(["c", *new, *rest])).hardlink_to(entry.path)
