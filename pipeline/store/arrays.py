"""Zarr arrays of a store: their metadata, derived from the schema, and their chunks.

The metadata on the disk are for other programs; this program opens its arrays without them.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import zarr
from zarr.abc.store import ByteRequest, Store
from zarr.codecs import ZstdCodec
from zarr.core.buffer import Buffer, BufferPrototype, default_buffer_prototype
from zarr.core.sync import sync as run
from zarr.storage import LocalStore, MemoryStore, StorePath

from pipeline.paths import read_file
from pipeline.store.files import store_file, sync
from pipeline.store.location import MEMORY
from pipeline.store.schema import Variable, attributes_of, path_of

if TYPE_CHECKING:
    from zarr.core.array_spec import ArraySpec

Document = dict[str, Any]
"""Content of a JSON document."""
Part = tuple[str, Any, Any]
"""Part of an array: the name of the array, slices of whole chunks, and their values."""
_MAX_CHECKSUMS = 256  # of a chunk: each takes time, and metadata have a limited size

_ZSTD: dict[str, Any] = {"level": 1, "checksum": True}  # reading detects a changed byte
_MAX_TEXT_BYTES = 2**16  # bytes of a text; messages have up to 2000 characters
_FILLS = {"str": "", "bool": False, "int8": -1, "float32": "NaN", "float64": "NaN"}  # −1: no status


class FolderStore(LocalStore):
    """Zarr store of a folder, whose files are replaced as a whole and synced to the disk.

    Only regular files are read. `max_bytes` has the largest size of a chunk by the path of its
    array. `touched` has the folders with new files, whose names `write_arrays` syncs at its end.
    """

    def __init__(self, root: Path) -> None:
        super().__init__(root)
        self.max_bytes: dict[str, int] = {}
        self.touched: set[Path] = set()

    async def get(
        self,
        key: str,
        prototype: BufferPrototype | None = None,
        byte_range: ByteRequest | None = None,
    ) -> Buffer | None:
        """Content of the file `key`; None if there is none."""
        make = (prototype or default_buffer_prototype()).buffer.from_bytes
        max_bytes = self.max_bytes.get(key.rpartition("/")[0])
        try:
            return make(await asyncio.to_thread(read_file, self.root / key, max_bytes))
        except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
            return None

    async def set(self, key: str, value: Buffer) -> None:
        """Create or replace the file `key`."""
        self.touched.add(await asyncio.to_thread(store_file, self.root, key, value.to_bytes()))


def zarr_store(location: Path) -> FolderStore | MemoryStore:
    """Zarr store at a location."""
    return MemoryStore() if location == MEMORY else FolderStore(location)


def array_document(
    variable: Variable, sizes: Mapping[str, int], block: Mapping[str, int], growths: int = 0
) -> Document:
    """Zarr metadata of a variable, as Zarr writes them.

    `sizes` are the lengths of dimensions, `block` has the number of points in a chunk along each,
    and `growths` is the number of times that its store was replaced.
    """
    is_text, dims = variable.dtype == "str", variable.dims
    if is_text:
        first = {"name": "vlen-utf8", "configuration": {}}
    else:
        is_byte = np.dtype(variable.dtype).itemsize == 1
        first = {"name": "bytes"} | ({} if is_byte else {"configuration": {"endian": "little"}})
    checksums = [{"name": "crc32c"}] * (growths % _MAX_CHECKSUMS)
    return {
        "shape": [sizes[dim] for dim in dims],
        "data_type": "string" if is_text else variable.dtype,
        "chunk_grid": {
            "name": "regular",
            "configuration": {"chunk_shape": [block.get(dim, sizes[dim]) for dim in dims]},
        },
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": _FILLS.get(variable.dtype, 0),
        # Each new store has another number of checksums, so that a dataset opened before it cannot
        # decode the new chunks, which have other points at the same keys.
        "codecs": [first, {"name": "zstd", "configuration": _ZSTD}, *checksums],
        "attributes": attributes_of(variable),
        "dimension_names": [*dims],
        "zarr_format": 3,
        "node_type": "array",
    }


class _BoundedZstd(ZstdCodec):
    """Zarr's Zstd codec, limited to the bytes that a chunk of the array can have."""

    async def _decode_single(self, chunk_bytes: Buffer, chunk_spec: ArraySpec) -> Buffer:
        return await asyncio.to_thread(self._decode_sync, chunk_bytes, chunk_spec)

    def _decode_sync(self, chunk_bytes: Buffer, chunk_spec: ArraySpec) -> Buffer:
        # Without this limit, a damaged chunk of kilobytes could unpack to gigabytes.
        values = np.zeros(_size(chunk_spec.dtype.to_native_dtype(), chunk_spec.shape), np.uint8)
        self._zstd_codec.decode(chunk_bytes.to_bytes(), values)
        return chunk_spec.prototype.buffer.from_array_like(values)


def open_arrays(
    store: Store, documents: Mapping[str, Document], prefix: str = ""
) -> dict[str, Any]:
    """Open the arrays of a Zarr store, by name; `documents` has their metadata.

    `prefix` is the path of their group with a slash at the end, or empty for the root.
    """
    # Chunks of fill values have to be written, or they would look lost. Zarr's global setting for
    # this is shared by all threads, so that a thread could reset it for the others.
    settings: Any = {"write_empty_chunks": True}
    arrays = {}
    for name, document in documents.items():
        first, _, *checksums = document["codecs"]
        metadata: Any = {**document, "codecs": [first, _BoundedZstd(**_ZSTD), *checksums]}
        path = StorePath(store, prefix + path_of(name))
        array = arrays[name] = zarr.Array(zarr.AsyncArray(metadata, path, settings))
        if isinstance(store, FolderStore):
            # Data that do not compress at all grow by less than this.
            store.max_bytes[path.path] = 2 * _size(array.dtype, array.chunks) + _MAX_TEXT_BYTES
    return arrays


def _size(dtype: np.dtype[Any], shape: Sequence[int]) -> int:
    """Largest size in bytes of values of a type and shape."""
    return (_MAX_TEXT_BYTES if dtype.kind in "TO" else dtype.itemsize) * math.prod(shape)


def write_arrays(store: Store, arrays: Mapping[str, Any], parts: Iterable[Part]) -> None:
    """Write parts of arrays; return once they are on the disk."""
    run(_all(arrays[name].async_array.setitem(at, values) for name, at, values in parts))
    while isinstance(store, FolderStore) and store.touched:
        sync(store.touched.pop())


async def _all(tasks: Iterable[Any]) -> None:
    """Run all tasks concurrently; raise the first error once all have ended."""
    for result in await asyncio.gather(*tasks, return_exceptions=True):
        if isinstance(result, BaseException):
            raise result
