"""Large chunks of many points for what is finished, and back to chunks of one point each.

A sweep is written point by point, in files that no two processes share; ten thousand points are
hundreds of thousands of files, which take long to open, copy and count. Compacting rewrites all
but the fields in chunks of many points. Both kinds of chunks have names of their own, so they are
written beside the others, and the root of the store says at one stroke which of them count. Then
the others are removed; what a kill leaves of them does no harm, and goes the next time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import zarr
from zarr import AsyncArray
from zarr.storage import StorePath

from pipeline.store.files import Files, RemoteFiles, files_in
from pipeline.store.folder import (
    ROOT,
    PathLike,
    Place,
    StoreError,
    commit_metadata,
    folder_of,
    locked,
    read_json,
    read_metadata,
    write_json,
)
from pipeline.store.points import Store
from pipeline.store.together import together
from pipeline.store.variables import BY_POINT, COLUMNS, COMPACT, PENDING, RECORDS

__all__ = ["compact_store", "lay_out"]

_POINTS = 1024  # in a chunk, about


def compact_store(path: PathLike) -> None:
    """Rewrite what is finished in large chunks, but the fields.

    A run that computes further points splits them again before it does, and compacts them after.

    Raises
    ------
    StoreError
        If there is no store, it is in use, damaged, or cannot be written.
    """
    folder = folder_of(path)
    read_metadata(folder)  # before a lock is laid beside what is no store
    with locked(folder):
        lay_out(folder, COMPACT)


def lay_out(folder: Place, separator: str) -> None:
    """Bring a store to one kind of chunks or the other, while it is `locked`.

    Raises as `compact_store`.
    """
    files = files_in(folder)
    attributes, arrays = read_metadata(folder)
    names = [name for name in (*RECORDS, *COLUMNS) if name in arrays]
    try:
        if arrays["status"]["chunk_key_encoding"]["configuration"]["separator"] != separator:
            store = Store(folder, mode="r")
            for name in names:  # of chunks that do not count, there may be some from before
                files.remove_all(f"{name}/c{separator}")
                arrays[name] = _described(arrays[name], separator, len(store.axes_of_points))
            _rewrite(files, store, {name: arrays[name] for name in names})
            commit_metadata(folder, attributes, arrays)
        for name in names:
            if read_json(folder / name / ROOT) != arrays[name]:
                write_json(folder / name / ROOT, arrays[name])
            files.remove_all(f"{name}/c{COMPACT if separator == BY_POINT else BY_POINT}")
    except OSError as error:
        raise StoreError(f"{folder} cannot be written: {error}") from error


def _described(array: dict[str, Any], separator: str, axes: int) -> dict[str, Any]:
    """Metadata of an array with the other kind of chunks, of which a point has `axes` numbers."""
    shape, chunks = array["shape"], array["chunk_grid"]["configuration"]["chunk_shape"]
    velocities = max(1, min(shape[axes - 1], _POINTS))
    loads = max(1, min(shape[axes - 2], _POINTS // velocities))
    leading = [1] * (axes - 2) + [loads, velocities] if separator == COMPACT else [1] * axes
    grid = {"name": "regular", "configuration": {"chunk_shape": leading + chunks[axes:]}}
    encoding = {"name": "default", "configuration": {"separator": separator}}
    return array | {"chunk_grid": grid, "chunk_key_encoding": encoding}


def _rewrite(files: Files | RemoteFiles, store: Store, arrays: dict[str, Any]) -> None:
    """Write the values of a store anew; of points that are pending there are none to keep."""
    status = np.array(list(store.status().values()))
    known = status.reshape([len(axis) for axis in store.axes_of_points.values()]) != PENDING
    for name, metadata in arrays.items():
        with zarr.config.set({"array.write_empty_chunks": True}):
            array = AsyncArray.from_dict(StorePath(files, name), metadata)
        values = store.values(name)
        values[~known] = array.metadata.fill_value
        sizes = array.chunks[: known.ndim]
        corners = {
            tuple((index // np.array(sizes) * sizes).tolist()) for index in np.argwhere(known)
        }
        blocks = [
            tuple(
                slice(i, min(i + size, end))
                for i, size, end in zip(at, sizes, known.shape, strict=True)
            )
            for at in sorted(corners)
        ]
        together(array.setitem(block, values[block]) for block in blocks)
        files.sync()
