"""Large chunks of many points for what is finished, and back to small ones that can be written.

A sweep is written in chunks of some points, or of one; ten thousand points are many thousands of
files, which take long to open, copy and count. Compacting rewrites all but the fields in chunks of
many points. Both kinds of chunks have names of their own, so the new ones are written beside the
old, and the root of the store says at one stroke which of them count. Then the others are removed;
what a kill leaves of them does no harm, and goes the next time.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any

import numpy as np

from pipeline.store.chunks import ChunkedArray, chunks_of
from pipeline.store.files import files_in
from pipeline.store.folder import (
    ROOT,
    PathLike,
    Place,
    StoreError,
    folder_of,
    has_parts,
    locked,
    part_held,
    read_json,
    write_json,
)
from pipeline.store.layout import POINTS, in_chunks, separator_of, sizes_of
from pipeline.store.points import Store
from pipeline.store.root import commit_metadata, read_metadata
from pipeline.store.variables import (
    BULK_COLUMNS,
    BY_POINT,
    COLUMNS,
    COMPACT,
    DONE,
    KEPT_COMPACT,
    PENDING,
    POINTS_PER_CHUNK,
    RECORDS,
)


def compact_store(path: PathLike) -> None:
    """Rewrite what is finished, except for fields, in large chunks.

    A run that computes further points splits them again before it does, and compacts them after;
    should it be killed, the next run does.

    Raises
    ------
    StoreError
        If there is no store, it is in use, damaged, or cannot be written.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.compact_store("results/first_try.zarr")
    >>> pipeline.summary("results/first_try.zarr").done
    24
    """
    folder = folder_of(path)
    read_metadata(folder)  # before a lock is laid beside what is no store
    with locked(folder):
        lay_out(folder, COMPACT)


def lay_out(folder: Place, separator: str, shares: bool = True) -> None:
    """Bring a store to one kind of chunks or the other, while it is `locked`; see `prepare`.

    Raises what `compact_store` raises.
    """
    files = files_in(folder)
    attributes, arrays = read_metadata(folder)
    names = [name for name in (*RECORDS, *COLUMNS, *BULK_COLUMNS) if name in arrays]
    try:
        if separator_of(arrays["status"]) != separator:
            Store(folder).heal()
            has_locks = has_parts(folder)
            with part_held(folder) if has_locks else nullcontext():
                store = Store(folder)
                flags, _ = store.flags()
                shared = attributes.get(POINTS_PER_CHUNK) if shares and has_locks else None
                block = shared or [1] * flags.ndim
                for name in names:  # of chunks that do not count, there may be some from before
                    files.remove_all(f"{name}/c{separator}")
                    arrays[name] = _described(arrays[name], separator, block)
                    array = ChunkedArray.of(name, arrays[name])
                    if separator == COMPACT:
                        files.make_folders(_folders(array, flags))
                    files.put_many(_chunks(store, array, flags))
                attributes[KEPT_COMPACT] = True
                commit_metadata(folder, attributes, arrays)
        for name in names:
            if _read(folder / name / ROOT) != arrays[name]:
                write_json(folder / name / ROOT, arrays[name])
            files.remove_all(f"{name}/c{COMPACT if separator == BY_POINT else BY_POINT}")
    except OSError as error:
        raise StoreError(f"{folder} cannot be written: {error}") from error


def _read(file: Place) -> dict[str, Any] | None:
    """Metadata of an array, if they can be read."""
    try:
        return read_json(file)
    except (OSError, ValueError):
        return None


def _described(array: dict[str, Any], separator: str, block: list[int]) -> dict[str, Any]:
    """Metadata of an array with the other kind of chunks; small ones have a block of points."""
    shape, chunks = array["shape"], sizes_of(array)
    axes = len(block)
    velocities = max(1, min(shape[axes - 1], POINTS))
    loads = max(1, min(shape[axes - 2], POINTS // velocities))
    leading = [1] * (axes - 2) + [loads, velocities] if separator == COMPACT else block
    return array | in_chunks(leading + chunks[axes:], separator)


def _chunks(store: Store, array: ChunkedArray, flags: Any) -> Iterator[tuple[str, bytes]]:
    """The values of a store in the chunks of `array`, without those of pending points."""
    # Only points that are done must have their data; why a point failed is needed, too.
    needed = flags != PENDING if array.name == "message" else flags == DONE
    values = store.pick(array.name, [np.arange(n) for n in array.shape], needed)
    if array.name == "status":
        values = flags
    for place in _places(array, flags):
        sizes = zip(place, array.chunks, strict=False)
        yield from chunks_of(array, place, values[tuple(slice(i * n, i * n + n) for i, n in sizes)])


def _places(array: ChunkedArray, flags: Any) -> list[tuple[int, ...]]:
    """Chunks of points that are not all pending."""
    index = np.argwhere(flags != PENDING) // array.chunks[: flags.ndim]
    return [tuple(place) for place in np.unique(index, axis=0).tolist()]


def _folders(array: ChunkedArray, flags: Any) -> list[str]:
    """Folders of the chunks of an array."""
    rest = (0,) * (len(array.shape) - flags.ndim)
    further = list(np.ndindex(*array.counts(flags.ndim))) if rest else [()]
    keys = (array.key((*place, *along)) for place in _places(array, flags) for along in further)
    return sorted({key.rpartition("/")[0] for key in keys})
