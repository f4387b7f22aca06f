"""A root that was lost or damaged, made again from its scene and from what lies beside it.

The coordinates and the metadata of each array have files of their own. The rest is the scene's, and
whether that scene made the store is told by the checksums of its points, of which each includes the
hash of what was simulated.

The list of the files of a store as a run left them, so that the next one reads what differs.
"""

from __future__ import annotations

import json
import os
import time
from contextlib import suppress
from typing import Any

from pipeline.store.attributes import root_attributes
from pipeline.store.layout import arrays_of
from pipeline.store.lock import held
from pipeline.store.place import (
    ROOT,
    Folder,
    PathLike,
    Place,
    StoreError,
    StoreMismatchError,
    place_of,
    reads,
    writes,
)
from pipeline.store.root import LostRootError, Root, find_root, require_likely, root_document
from pipeline.store.schema import AT_END, is_coordinate, variables_of
from pipeline.store.verify import examined
from pipeline.store.write import Store
from pipeline.sweep.model import Sweep


def restore_root(path: PathLike, sweep: Sweep) -> bool:
    """Make a root that is lost again, and return whether it was.

    Raise a `StoreMismatchError`, and write nothing, if the sweep did not make the store.
    """
    place = place_of(path)
    try:
        find_root(place)
    except LostRootError as error:
        with held(place):
            root = _remade(place, sweep, error)
            with writes(place):
                place.put({ROOT: root_document(root.attributes, root.arrays)})
        return True
    return False


def _remade(place: Place, sweep: Sweep, lost: StoreError) -> Root:
    """The root as the sweep says, if the points of the store agree."""
    with_fields = place.read(f"pressure/{ROOT}") is not None
    try:
        arrays = {name: _metadata(place, name) for name in variables_of(sweep, with_fields)}
        opened = arrays_of(place, arrays, read_only=True)
        axes = {name: _values(place, name, opened) for name in arrays if is_coordinate(name)}
        stations = json.loads(arrays["step"]["attributes"]["stations"])
    except (ValueError, KeyError, TypeError, StoreError) as error:
        raise StoreError(f"{lost}; it cannot be made again: {error}") from error
    sweep = sweep.changed(stations=stations)
    status = opened["status"]
    attributes = root_attributes(sweep, None) | {
        "axes": axes,
        "stations": stations,
        "points_per_chunk": dict(zip(status.metadata.dimension_names, status.chunks, strict=True)),
        "generation": int(time.time()),  # whoever opened it before opens it again
    }
    root = Root(json.loads(json.dumps(attributes)), arrays)
    require_likely(place, root)
    try:
        verification = examined(Store(place, root, is_damaged=True), repair=False)
        agrees = verification.done > 0 or not verification.damaged
    except KeyError:  # of values that the sweep does not have
        agrees = False
    if not agrees:
        raise StoreMismatchError(
            f"{place} has lost its {ROOT}, and its points are not those of this scene; give the "
            "scene that made it, with all its values, or write to another store"
        )
    return root


def _metadata(place: Place, name: str) -> Any:
    content = place.read(f"{name}/{ROOT}")
    if content is None:
        raise KeyError(f"{name}/{ROOT} is lost")
    return json.loads(content)


def _values(place: Place, name: str, arrays: dict[str, Any]) -> list[Any]:
    with reads(place, name):
        return [*map(_plain, arrays[name][:].tolist())]


def _plain(value: Any) -> Any:
    return value if isinstance(value, int | float) else str(value)


_LIST = "status/seen"
_Numbers = tuple[int, ...]


def note_files(store: Store) -> None:
    """Write the list of the files of a store, whose lock is held."""
    if isinstance(store.place, Folder):
        store.place.put({_LIST: json.dumps(_files(store.place)).encode()})


def changed_chunks(store: Store) -> set[_Numbers] | None:
    """Chunks of points with a file that differs from the list in name, size or time.

    None if there is no list, so that any may differ. A file that was restored is older than the one
    of the list, and differs, too.
    """
    assert isinstance(store.place, Folder)
    try:
        listed = json.loads(store.place.read(_LIST) or b"")
        differing = {name for name, _ in set(map(_row, listed.items())) ^ _rows(store.place)}
    except (ValueError, TypeError, AttributeError):
        return None
    chunks = set()
    for key in differing:
        name, _, rest = key.partition("/")
        first, *numbers = rest.split(".")
        if first == "c" and name in store.arrays and all(number.isdigit() for number in numbers):
            index = tuple(map(int, numbers[: len(store.dims)]))
            if name in AT_END:
                index = tuple(i // n for i, n in zip(index, store.block, strict=True))
            chunks.add(index)
    return chunks


def _rows(folder: Folder) -> set[tuple[str, tuple[int, int]]]:
    return set(map(_row, _files(folder).items()))


def _row(item: tuple[str, list[int]]) -> tuple[str, tuple[int, int]]:
    name, (size, written) = item
    return name, (size, written)


def _files(folder: Folder) -> dict[str, list[int]]:
    """Size and time of each chunk of a store [B, ns]."""
    files = {}
    for array in os.scandir(folder.path):
        with suppress(NotADirectoryError), os.scandir(array) as entries:
            for entry in entries:
                if entry.name.startswith("c."):
                    state = entry.stat()
                    files[f"{array.name}/{entry.name}"] = [state.st_size, state.st_mtime_ns]
    return files
