"""Creation of a store, and its opening by the one process that writes to it.

A new store is no store until its root is there, which is written last.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from pipeline.store.attributes import describe, differences, grown_axes, root_attributes
from pipeline.store.files import PARTIAL, sync
from pipeline.store.grow import goes_on, remove_unfinished, replace_by_larger
from pipeline.store.layout import (
    block_of,
    bytes_of_a_point,
    documents,
)
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    ROOT,
    Bucket,
    Folder,
    PathLike,
    Place,
    StoreError,
    StoreMismatchError,
    place_of,
    writes,
)
from pipeline.store.root import MOST_POINTS, Root, find_root, read_root, root_document
from pipeline.store.schema import PLANE, variables_of
from pipeline.store.verify import examined
from pipeline.store.write import Store
from pipeline.sweep.model import Sweep, named
from pipeline.sweep.stations import Stations
from tribo import QUANTILES


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
