"""Creation, opening and growth of a store; its root is written last.

A store grows only at the upper ends of its axes. Points that it cannot take need a new store, which
can take over the points of the old one.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from contextlib import contextmanager

from pipeline.scene.resume import join
from pipeline.scene.stored_text import sweep_text
from pipeline.store.arrays import Encoder
from pipeline.store.files import PARTIAL
from pipeline.store.layout import bytes_of_a_point, chunk_sizes, grown_axes
from pipeline.store.lock import Lock, locked
from pipeline.store.place import (
    ROOT,
    Folder,
    PathLike,
    StoreError,
    StorePlace,
    io_errors,
    place_of,
)
from pipeline.store.root import (
    CONSOLIDATED,
    Root,
    find_root,
    read_metadata,
    require_same_scene,
    with_others,
)
from pipeline.store.schema import path_of, variables_of
from pipeline.store.versions import in_words, package_versions
from pipeline.store.write import Store
from pipeline.sweep.identity import scene_ids
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.stages import Report, silent


@contextmanager
def writing(path: PathLike, sweep: Sweep, progress: Report = silent) -> Iterator[Store]:
    """Context manager: create the store of a sweep, or open it with room for the sweep's points.

    The points are marked as asked for, and files that an earlier run began to write are removed.
    Raises a `StoreMismatchError` if the store belongs to another scene. Raises a `StoreError` if
    something else is at `path`, another process writes to the store, or it cannot be read or
    written.
    """
    place = place_of(path)
    find_root(place)  # raises if this is no store, before a lock is put there
    with locked(place, progress) as lock:
        if isinstance(place, Folder):
            with io_errors(place, "written"):
                for file in [*place.path.rglob(f"*{PARTIAL}")]:
                    file.unlink()
        yield open_grown(place, sweep, lock)


def open_grown(place: StorePlace, sweep: Sweep, lock: Lock | None) -> Store:
    """Create or open a store, with room for a sweep's points, which are marked as asked for.

    `lock` is the store's lock, which this process must already hold. With None, later writes do
    not check that the lock is still in its place. Raises a `StoreMismatchError` if the store
    belongs to another scene, and a `StoreError` if it cannot grow, be read or be written.
    """
    if before := find_root(place):
        require_same_scene(place, before, sweep)
    root = _grown_root(place, before, sweep)
    groups = root.documents()
    last = {ROOT: groups.pop(ROOT)}
    if before is None or json.loads(last[ROOT]) != before.found:
        with io_errors(place, "written"):
            # If the process is killed while the metadata of arrays change, the root document that
            # remains must still describe the arrays.
            if before and "kind" not in before.found[CONSOLIDATED]:
                place.put({ROOT: before.documents()[ROOT]})
            parts = [(name, ..., values) for name, values in root.coordinates().items()]
            own = {path_of(name): array for name, array in root.arrays.items()}
            held = read_metadata(place) if root.found else {}
            documents = {f"{path}/{ROOT}": with_others(held.get(path), own[path]) for path in own}
            arrays = {key: json.dumps(document).encode() for key, document in documents.items()}
            place.put(Encoder(root.arrays)(parts) | arrays | groups)
            place.put(last)
    store = Store(place, root, lock)
    store.mark_asked(points(sweep))
    return store


def _grown_root(place: StorePlace, before: Root | None, sweep: Sweep) -> Root:
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
        own = {path_of(name) for name in before.variables}
        for path, array in before.found_metadata.items():
            if path not in own and not grown.isdisjoint(array.get("dimension_names") or ()):
                raise _no_room(place, f"{path}, an array added by a user, would not grow with it")
    block = before.block if before else chunk_sizes(sizes, bytes_of_a_point(wanted, axes))
    lines = [*(before.history if before else ()), f"computed by {in_words(package_versions())}"]
    return Root(
        sweep=kept,
        text=sweep_text(kept),
        axes=axes,
        ids=scene_ids(kept),
        block=block,
        history=[*dict.fromkeys(lines)],
        found=before.found if before else {},
    )


def _no_room(place: StorePlace, reason: str) -> StoreError:
    return StoreError(
        f"{place} cannot take these points: {reason}; write a new store, which takes over the "
        f"points of this one: irg run SCENE -o NEW --from {shlex.quote(str(place))}"
    )
