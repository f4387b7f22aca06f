"""Zarr arrays of a store: their metadata, derived from the schema, and their chunks.

The metadata on the disk are for other programs; this program opens its arrays without them.
"""

from __future__ import annotations

import asyncio
import json
import math
import threading
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numcodecs
import numpy as np
import zarr
from zarr.abc.buffer import Buffer, BufferPrototype
from zarr.abc.store import ByteRequest
from zarr.buffer import cpu, default_buffer_prototype
from zarr.storage import LocalStore, MemoryStore

from pipeline.paths import read_file, store_file, sync
from pipeline.store.location import MEMORY, ROOT
from pipeline.store.schema import Variable, attributes_of, path_of

Document = dict[str, Any]
"""Content of a JSON document."""
Part = tuple[str, Any, Any]
"""Part of an array: the name of the array, slices of whole chunks, and their values."""

_ZSTD: dict[str, Any] = {"level": 1, "checksum": True}  # reading detects a changed byte
_MAX_TEXT_BYTES = 2**16  # bytes of a text; messages have up to 2000 characters
_MAX_CHECKSUMS = 256  # of a chunk: each takes time, and metadata have a limited size
_CHECKSUM_BYTES = 4  # that each checksum adds to a chunk
_OPENING = threading.Lock()
_FILLS = {"str": "", "bool": False, "int8": -1, "float32": "NaN", "float64": "NaN"}  # −1: no status


class FolderStore(LocalStore):
    """Zarr store of a folder, whose files are replaced as a whole and synced to the disk.

    `documents` has the metadata of its arrays, by key. Only regular files are read, and only chunks
    that unpack to at most `max_bytes`, by the path of their array; each ends with a number of
    `checksums`. `touched` has the folders with new files, whose names `write_arrays` syncs.
    """

    def __init__(self, root: Path, documents: Mapping[str, bytes]) -> None:
        super().__init__(root)
        self.documents = documents
        self.max_bytes: dict[str, int] = {}
        self.checksums = 0
        self.touched: set[Path] = set()

    async def get(
        self,
        key: str,
        prototype: BufferPrototype | None = None,
        byte_range: ByteRequest | None = None,
    ) -> Buffer | None:
        """Content of the document or file `key`; None if there is none."""
        make = (prototype or default_buffer_prototype()).buffer.from_bytes
        if key in self.documents:
            return make(self.documents[key])
        try:
            return make(await asyncio.to_thread(self._read_chunk, key))
        except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
            return None

    async def set(self, key: str, value: Buffer) -> None:
        """Create or replace the file `key`."""
        self.touched.add(await asyncio.to_thread(store_file, self.root, key, value.to_bytes()))

    def _read_chunk(self, key: str) -> bytes:
        max_bytes = self.max_bytes[key.rpartition("/")[0]]
        # Data that do not compress at all grow by less than this.
        content = read_file(self.root / key, 2 * max_bytes + _MAX_TEXT_BYTES)
        # This raises an error for a damaged chunk, of which kilobytes could unpack to gigabytes.
        frame = content[: len(content) - _CHECKSUM_BYTES * self.checksums]
        numcodecs.Zstd().decode(frame, np.empty(max_bytes, np.uint8))
        return content


def array_document(
    variable: Variable, sizes: Mapping[str, int], block: Mapping[str, int], growths: int
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
        # Each new store has another number of checksums, so that a dataset that plain xarray opened
        # before cannot decode the new chunks, which have other points at the same keys.
        "codecs": [first, {"name": "zstd", "configuration": _ZSTD}, *checksums],
        "attributes": attributes_of(variable),
        "dimension_names": [*dims],
        "zarr_format": 3,
        "node_type": "array",
    }


def open_arrays(
    location: Path, documents: Mapping[str, Document], prefix: str = ""
) -> dict[str, Any]:
    """Open the arrays of a store, by name; `documents` has their metadata.

    `prefix` is the path of their group with a slash at the end, or empty for the root.
    """
    paths = {name: prefix + path_of(name) for name in documents}
    contents = {
        f"{paths[name]}/{ROOT}": json.dumps(document).encode()
        for name, document in documents.items()
    }
    store: FolderStore | MemoryStore
    if location == MEMORY:
        buffers = {key: cpu.Buffer.from_bytes(content) for key, content in contents.items()}
        store = MemoryStore({**buffers})
    else:
        store = FolderStore(location, contents)
    # Chunks of fill values have to be written, or they would look lost. An array keeps the value
    # that this setting has when it is opened; the lock excludes a thread that resets it too early.
    with _OPENING, zarr.config.set({"array.write_empty_chunks": True}):
        arrays = {
            name: zarr.open_array(store, path=path, zarr_format=3) for name, path in paths.items()
        }
    if isinstance(store, FolderStore):
        store.max_bytes = {
            paths[name]: _size(array.dtype, array.chunks) for name, array in arrays.items()
        }
        store.checksums = len(next(iter(documents.values()))["codecs"]) - 2
    return arrays


def _size(dtype: np.dtype[Any], shape: Sequence[int]) -> int:
    """Largest size in bytes of values of a type and shape."""
    return (_MAX_TEXT_BYTES if dtype.kind in "TO" else dtype.itemsize) * math.prod(shape)


def write_arrays(arrays: Mapping[str, Any], parts: Iterable[Part]) -> None:
    """Write parts of arrays; return once they are on the disk."""

    def write(part: Part) -> None:
        name, block, values = part
        arrays[name][block] = values

    with ThreadPoolExecutor() as threads:
        _ = [*threads.map(write, parts)]
    store = next(iter(arrays.values())).store  # that of all of them
    while isinstance(store, FolderStore) and store.touched:
        sync(store.touched.pop())
