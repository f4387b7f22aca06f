"""The list of the files of a store as a run left them, so that the next one reads what differs."""

from __future__ import annotations

import json
import os
from contextlib import suppress

from pipeline.store.place import Folder
from pipeline.store.schema import AT_END
from pipeline.store.write import Store

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
