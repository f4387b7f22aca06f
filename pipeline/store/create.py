"""Creation of a store, and its opening by the one process that writes to it.

A new store is no store until its root is there, which is written last.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from pipeline.store.attributes import grown_axes, root_attributes
from pipeline.store.files import PARTIAL, sync
from pipeline.store.identity import describe, differences
from pipeline.store.layout import (
    arrays_of,
    block_of,
    bytes_of_a_point,
    documents,
    fill_new_steps,
)
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    ROOT,
    Folder,
    PathLike,
    Place,
    StoreError,
    StoreMismatchError,
    place_of,
    writes,
)
from pipeline.store.root import MOST_POINTS, Root, find_root, read_root, root_document
from pipeline.store.schema import variables_of
from pipeline.store.write import Store
from pipeline.sweep.model import Sweep, named
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
        yield grown(place, sweep, lock)


def grown(place: Place, sweep: Sweep, lock: Lock | None) -> Store:
    """Open a store whose lock is held, with room for what a sweep adds; raise as `writing` does."""
    root = find_root(place)
    if root and (fault := next(_mismatches(root, sweep), None)):
        raise StoreMismatchError(f"{place} {fault}")
    with writes(place):
        root = _with_room(place, root, sweep)
    store = Store(place, root, lock)
    store.ask(store.asked_by(sweep))
    return store


def _with_room(place: Place, before: Root | None, sweep: Sweep) -> Root:
    """Root of a store with room for a sweep: the arrays are written first, then the root."""
    with_fields = "pressure" in before.arrays if before else sweep.record.fields
    wanted = variables_of(sweep, with_fields)
    axes = grown_axes(before.axes if before else {}, sweep)
    axes = {name: values for name, values in axes.items() if name in wanted}
    points = math.prod(len(axes[dim]) for dim in wanted["status"].dims)
    if points > MOST_POINTS:
        raise StoreError(
            f"{place} would have {points:.4g} points; a store has at most {MOST_POINTS:.0e}: give "
            "fewer loads or velocities"
        )
    attributes = root_attributes(sweep, before.attributes if before else None) | {"axes": axes}
    if not before:
        sizes = {dim: len(axes[dim]) for dim in wanted["status"].dims}
        attributes["points_per_chunk"] = block_of(sizes, bytes_of_a_point(wanted, axes))
        attributes["steps_per_chunk"] = len(axes["step"])
    elif attributes == before.attributes:
        return before
    block = attributes["points_per_chunk"] | {"step": attributes["steps_per_chunk"]}
    contents, metadata = documents(wanted, axes, block)
    place.put({k: new for k, new in contents.items() if not before or new != place.read(k)})
    if before:
        fill_new_steps(arrays_of(place, metadata, read_only=False), len(before.axes["step"]))
    place.put({ROOT: root_document(attributes, metadata)})
    if not before and isinstance(place, Folder):
        # Their names may come from a process that was killed before it synced them.
        for folder in place.path.parents[:2]:
            with suppress(PermissionError):
                sync(folder)
    return read_root(place)


def _mismatches(root: Root, sweep: Sweep) -> Iterator[str]:
    """Reasons why a store is not that of a sweep."""
    dims = root.arrays["status"]["dimension_names"]
    stored, wanted = dims[: dims.index("load")], [*sweep.variants.axes]
    if stored != wanted:
        have, gives = (", ".join(names) or "none" for names in (stored, wanted))
        yield (
            f"has other axes, by sweep.over, realizations or samples: {have} in the store, {gives} "
            "in the scene; they stay what they were at its creation: give the same ones, or write "
            "to another store"
        )
        return
    rates = root.axes.get("wear_rate", [])
    different = [
        *_differences_of_scenes(root, sweep),
        *differences(root.axes["cooler_share"], list(QUANTILES), "cooler_share"),
        *differences(rates, list(sweep.rates), "sweep.wear_rates [m²/N]"),
    ]
    if different:
        yield "\n  ".join(["belongs to another scene; write to another store", *different])
    if sweep.record.fields and "pressure" not in root.arrays:
        yield (
            "has no fields, since its scene did not ask for them when it was created; leave out "
            "sweep.store_fields, or write to another store"
        )
    names = variables_of(sweep, "pressure" in root.arrays).keys()
    if differing := ", ".join(sorted(names ^ root.arrays.keys())):
        yield f"was made by a version with other variables ({differing}); write to another store"


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
