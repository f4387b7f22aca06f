"""Creation, opening and growth of a store; its root is written last.

A store grows only at the upper ends of its axes. Points that it cannot take need a new store, which
can take over the points of the old one.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np

from pipeline.scene.resume import join
from pipeline.scene.stored_text import sweep_text
from pipeline.store.arrays import Encoder
from pipeline.store.files import PARTIAL
from pipeline.store.layout import Axes, bytes_of_a_point, chunk_sizes, grown_axes
from pipeline.store.lock import Lock, locked
from pipeline.store.place import (
    ROOT,
    Bucket,
    Folder,
    PathLike,
    StoreError,
    StorePlace,
    io_errors,
    place_of,
)
from pipeline.store.root import CONSOLIDATED, GOAL, Root, TestLayout, with_others
from pipeline.store.root_file import find_root, read_metadata, require_same_scene
from pipeline.store.schema import AT_END, PENDING, Variable, is_coordinate, variables_of
from pipeline.store.versions import in_words, package_versions
from pipeline.store.write import Store
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.points_of_tests import grown_slots, judges_holds, most_steps, wanted_slots
from pipeline.sweep.stages import Report, silent


@contextmanager
def writing(
    path: PathLike | None, sweep: Sweep, progress: Report = silent, accuracy: float | None = None
) -> Iterator[Store]:
    """Context manager: create the store of a sweep, or open it with room for the sweep's points.

    The points are marked as asked for, and files that an earlier run began to write are removed.
    Without a path the store is in memory, and goes with the last reference to it. An `accuracy`
    that is asked for is noted in the store's history.
    Raises a `StoreMismatchError` if the store belongs to another scene. Raises a `StoreError` if
    something else is at `path`, another process writes to the store, or it cannot be read or
    written.
    """
    place = place_of(path)
    if isinstance(place, Bucket) and not place.is_written:
        raise StoreError(f"{place} can only be read; write to a folder, or to an s3:// address")
    find_root(place)  # raises if this is no store, before a lock is put there
    with locked(place, progress) as lock:
        if isinstance(place, Folder):
            with io_errors(place, "written"):
                for file in [*place.path.rglob(f"*{PARTIAL}")]:
                    file.unlink()
        yield open_grown(place, sweep, lock, accuracy)


def open_grown(
    place: StorePlace, sweep: Sweep, lock: Lock | None, accuracy: float | None = None
) -> Store:
    """Create or open a store, with room for a sweep's points, which are marked as asked for.

    `lock` is the store's lock, which this process must already hold. With None, later writes do
    not check that the lock is still in its place. Raises a `StoreMismatchError` if the store
    belongs to another scene, and a `StoreError` if it cannot grow, be read or be written.
    """
    if before := find_root(place):
        require_same_scene(place, before, sweep)
    root = _grown_root(place, before, sweep, accuracy)
    groups = root.documents()
    last = {ROOT: groups.pop(ROOT)}
    if before is None or json.loads(last[ROOT]) != before.found:
        with io_errors(place, "written"):
            # If the process is killed while the metadata of arrays change, the root document that
            # remains must still describe the arrays.
            if before and "kind" not in before.found[CONSOLIDATED]:
                place.put({ROOT: before.documents()[ROOT]})
            if before and before.layout and root.layout and before.layout[1:] != root.layout[1:]:
                _empty_tests(Store(place, before, lock), root)
            chunks, held = dict[str, bytes](), read_metadata(place) if root.found else {}
            for group in filter(None, (root, root.tests)):
                parts = [(name, ..., values) for name, values in group.coordinates().items()]
                chunks |= Encoder(group.arrays, group.prefix)(parts)
                for path, array in group.paths().items():
                    document = with_others(held.get(path), array)
                    chunks[f"{path}/{ROOT}"] = json.dumps(document).encode()
            place.put(chunks | groups)
            place.put(last)
    store = Store(place, root, lock)
    store.mark_asked(points(sweep))
    if store.tests:
        store.tests.mark_asked(store.tests.root.points)
    return store


def _grown_tests(before: Root | None, sweep: Sweep) -> TestLayout | None:
    """Layout of the points of tests in a store with the tests of a sweep."""
    old = before.layout if before else None
    if not sweep.tests:
        return old and old._replace(slots=grown_slots(old.slots, sweep))
    judges_hold, slots = judges_holds(sweep), grown_slots(old.slots if old else (), sweep)
    steps = most_steps(sweep, slots, judges_hold)
    # Results stay where they are, unless the tests need more steps.
    if old and steps <= old.steps and judges_hold == old.judges_hold:
        return old._replace(slots=slots)
    return TestLayout(wanted_slots(sweep), steps, judges_hold)


def _empty_tests(store: Store, root: Root) -> None:
    """Remove all results of tests from a store, whose layout will be that of `root`."""
    if not (store.tests and root.tests):
        return
    tests = store.tests
    tests.forget(tests.points_at(np.nonzero(tests.flags != PENDING)))
    names = [name for name in root.tests.arrays if not is_coordinate(name)]
    fills = [(name, ..., root.tests.arrays[name]["fill_value"]) for name in names]
    store.place.put(Encoder(root.tests.arrays, root.tests.prefix)(fills))


def _grown_root(
    place: StorePlace, before: Root | None, sweep: Sweep, accuracy: float | None
) -> Root:
    """Root document with room for a sweep's points; `before` is the present one, if any."""
    kept = join(before.sweep if before else None, sweep)
    wanted = variables_of(kept)
    axes = grown_axes(before.axes if before else {}, kept, sweep)
    axes = {name: values for name, values in axes.items() if name in wanted}
    sizes = {dim: len(axes[dim]) for dim in wanted["status"].dims}
    if before:
        # Values are appended to axes, or the stored chunks would be those of other points.
        old = before.axes
        for name, values in axes.items():
            if name not in old or values[: len(old[name])] != old[name]:
                raise _no_room(place, f"{name} can only grow at its upper end")
        grown = {name for name, values in axes.items() if len(values) > len(old[name])}
        own = before.paths().keys() | (before.tests.paths().keys() if before.tests else ())
        for path, array in before.found_metadata.items():
            if path not in own and not grown.isdisjoint(array.get("dimension_names") or ()):
                raise _no_room(place, f"{path}, an array added by a user, would not grow with it")
    blocks = [before.block, before.field_block] if before else _chunks_of(wanted, axes, sizes)
    lines = [*(before.history if before else ()), f"computed by {in_words(package_versions())}"]
    if accuracy is not None:
        lines.append(f"{GOAL}{100 * accuracy:g}%")
    return Root(
        sweep=kept,
        text=sweep_text(kept),
        axes=axes,
        block=blocks[0],
        field_block=blocks[1],
        history=[*dict.fromkeys(lines)],
        layout=_grown_tests(before, sweep),
        found=before.found if before else {},
    )


def _chunks_of(
    wanted: Mapping[str, Variable], axes: Axes, sizes: Mapping[str, int]
) -> list[dict[str, int]]:
    """Number of points along each dimension in a chunk, and in a chunk of a field."""
    fields = [one for name, one in wanted.items() if name in AT_END]
    others = [one for name, one in wanted.items() if not (name in AT_END or is_coordinate(name))]
    block = chunk_sizes(sizes, bytes_of_a_point(others, axes))
    return [block, chunk_sizes(sizes, bytes_of_a_point(fields, axes)) if fields else block]


def _no_room(place: StorePlace, reason: str) -> StoreError:
    return StoreError(
        f"{place} cannot take these points: {reason}; write a new store, which takes over the "
        f"points of this one: irg run SCENE -o NEW --from {shlex.quote(str(place))}"
    )
