"""Creation of a store, and its opening by the one process that writes to it."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from pipeline.store.attributes import (
    OPTIONAL,
    grown_axes,
    grown_entries,
    lasting_attributes,
    present_attributes,
    with_present_versions,
)
from pipeline.store.durable import PARTIAL, make_folder, replace_files, sync
from pipeline.store.identity import describe, differences
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    LOCK,
    ROOT,
    Folder,
    PathLike,
    Place,
    StoreError,
    StoreMismatchError,
    place_of,
    unwritable,
)
from pipeline.store.points import Places
from pipeline.store.root import Root, read_root, root_document
from pipeline.store.schema import (
    Variable,
    block_of,
    bytes_of_a_point,
    documents,
    metadata_of,
    variables,
)
from pipeline.store.write import Store, fill_new_steps
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
    with ExitStack() as stack:
        try:
            if place.exists():
                read_root(place)  # before a lock is laid in what is no store
            elif isinstance(place, Folder):
                _create_beside(place, sweep)
            lock = stack.enter_context(held(place))
            if isinstance(place, Folder):
                _remove_partial(place)
            elif not place.exists():
                contents, root = _new(sweep)
                place.put(contents)
                place.put(root)
        except OSError as error:
            raise unwritable(place, error) from error
        yield grown(place, sweep, lock)


@contextmanager
def repairing(path: PathLike) -> Iterator[Store]:
    """Open a store to repair it, while no other process writes to it; raise as `writing` does."""
    place = place_of(path)
    root = read_root(place)
    with ExitStack() as stack:
        try:
            lock = stack.enter_context(held(place))
        except OSError as error:
            raise unwritable(place, error) from error
        yield Store(place, root, lock, is_damaged=True)


def grown(place: Place, sweep: Sweep, lock: Lock | None) -> Store:
    """Open a store whose lock is held, with room for what a sweep adds; raise as `writing` does."""
    root = read_root(place)
    if fault := next(_mismatches(root, sweep), None):
        raise StoreMismatchError(f"{place} {fault}")
    with_fields = "pressure" in root.arrays
    axes = _present(grown_axes(root.axes, sweep), sweep, with_fields)
    attributes = {k: v for k, v in root.attributes.items() if k not in OPTIONAL}
    attributes |= present_attributes(sweep) | {"axes": axes} | grown_entries(sweep, attributes)
    # As the root gives them back: JSON knows no tuples.
    attributes = json.loads(json.dumps(with_present_versions(attributes)))
    if attributes != root.attributes:
        try:
            root = _rewritten(place, root, attributes, sweep)
        except OSError as error:
            raise unwritable(place, error) from error
    store = Store(place, root, lock)
    store.ask(store.asked_by(sweep))
    return store


def _rewritten(place: Place, root: Root, attributes: dict[str, Any], sweep: Sweep) -> Root:
    """Give a store other attributes and longer axes: the arrays first, then the root."""
    contents = _documents(attributes, sweep, "pressure" in root.arrays)
    arrays = metadata_of(contents)
    place.put({key: new for key, new in contents.items() if new != place.read(key)})
    if len(attributes["axes"]["step"]) > len(root.axes["step"]):
        fill_new_steps(place, Places(Root(attributes, arrays)))
    place.put({ROOT: root_document(attributes, arrays)})
    return read_root(place)


def _create_beside(place: Folder, sweep: Sweep) -> None:
    """Create a store beside its place, and rename it, unless another process was faster."""
    partial = Folder(place.path.with_name(place.path.name + PARTIAL))
    if not partial.is_unfinished():
        raise StoreError(
            f"{partial} is no store that was being made; move it, or write to another store"
        )
    make_folder(place.path.parent)
    with held(partial) as lock:
        if lock is None or not lock.is_in_place(partial.path / LOCK):
            return
        if place.exists():
            shutil.rmtree(partial.path)
            return
        partial.clear()
        contents, root = _new(sweep)
        replace_files(partial.path, contents | root)
        os.rename(partial.path, place.path)  # noqa: PTH104, also onto an empty folder
        sync(place.path.parent)


def _new(sweep: Sweep) -> tuple[dict[str, bytes], dict[str, bytes]]:
    """Contents of a new store, and its root, by their keys."""
    axes = _present(grown_axes({}, sweep), sweep, sweep.store_fields)
    wanted = _variables(sweep, sweep.store_fields)
    sizes = {dim: len(axes[dim]) for dim in wanted["status"].dims}
    attributes = lasting_attributes(sweep) | present_attributes(sweep)
    attributes |= grown_entries(sweep, attributes)
    attributes |= {
        "axes": axes,
        "points_per_chunk": block_of(sizes, bytes_of_a_point(wanted, axes)),
        "steps_per_chunk": len(axes["step"]),
    }
    contents = _documents(attributes, sweep, sweep.store_fields)
    return contents, {ROOT: root_document(attributes, metadata_of(contents))}


def _variables(sweep: Sweep, with_fields: bool) -> dict[str, Variable]:
    inputs = sweep.samples.design.inputs if sweep.samples else ()
    units = {quantity.path: quantity.unit for quantity in inputs}
    over = {axis.path: axis.unit for axis in sweep.over.axes} if sweep.over else {}
    return variables(
        [*sweep.axes], with_fields, sweep.unequal_bulks, bool(sweep.rates), units, over
    )


def _present(
    axes: Mapping[str, list[Any]], sweep: Sweep, with_fields: bool
) -> dict[str, list[Any]]:
    """Axes that a store has."""
    wanted = _variables(sweep, with_fields)
    return {name: values for name, values in axes.items() if name in wanted}


def _documents(attributes: Mapping[str, Any], sweep: Sweep, with_fields: bool) -> dict[str, bytes]:
    chunks = attributes["points_per_chunk"] | {"step": attributes["steps_per_chunk"]}
    return documents(_variables(sweep, with_fields), attributes["axes"], chunks)


def _mismatches(root: Root, sweep: Sweep) -> Iterator[str]:
    """Reasons why a store is not that of a sweep."""
    for name, what in (("realization", "the seeds"), ("sample", "the number")):
        if name in root.axes and name not in sweep.axes:
            yield (
                f"has an axis for sweep.{name}s, which the scene does not give; give {what} that "
                "are wanted, or write to another store"
            )
        if name not in root.axes and name in sweep.axes:
            yield (
                f"has no axis for sweep.{name}s, and the dimensions of a store stay what they were "
                "at its creation; write to another store"
            )
    stored, wanted = (list(names) for names in (root.attributes.get("over", []), _over(sweep)))
    if stored != wanted:
        have, gives = (", ".join(names) or "none" for names in (stored, wanted))
        yield (
            f"has axes for other entries of sweep.over: {have} in the store, {gives} in the scene; "
            "the dimensions of a store stay what they were at its creation; write to another store"
        )
        return
    different = [
        *_differences_of_scenes(root, sweep),
        *differences(root.axes["quantile"], list(QUANTILES), "quantile"),
    ]
    if different:
        yield "\n  ".join(["belongs to another scene; write to another store", *different])
    if root.axes.get("wear_rate", []) != list(sweep.rates):
        yield (
            "was created for other sweep.wear_rates, and its wear rates stay what they were then: "
            f"{_ends(root.axes.get('wear_rate', []))} in the store, {_ends(sweep.rates)} in the "
            "scene; write to another store"
        )
    if sweep.store_fields and "pressure" not in root.arrays:
        yield (
            "has no fields, since its scene did not ask for them when it was created; leave out "
            "sweep.store_fields, or write to another store"
        )


def _over(sweep: Sweep) -> list[str]:
    """Paths of the entries with several values."""
    return [axis.path for axis in sweep.over.axes] if sweep.over else []


def _differences_of_scenes(root: Root, sweep: Sweep) -> Iterator[str]:
    """Entries in which the scene of a store differs from a sweep, for the same values of `over`."""
    scene = root.attributes["scene"]
    if not sweep.over:
        yield from differences(scene, describe(sweep))
    stored = {tuple(entry["values"]): entry for entry in root.attributes.get("scenes", [])}
    for variant in sweep.entries:
        if entry := stored.get(tuple(value for _, value in variant)):
            key = f"scene with {', '.join(named(variant))}: scene"
            yield from differences(scene | entry["scene"], describe(sweep.variant(variant)), key)


def _ends(rates: Sequence[float]) -> str:
    """Write the lowest and the highest wear rate."""
    return f"{rates[0]:g} to {rates[-1]:g} m²/N" if rates else "none"


def _remove_partial(place: Folder) -> None:
    """Remove what a killed writer was writing."""
    for file in place.path.glob(f"*/*{PARTIAL}"):
        file.unlink(missing_ok=True)
    Path(place.path, ROOT + PARTIAL).unlink(missing_ok=True)
