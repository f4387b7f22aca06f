"""Zarr arrays of a store: their metadata, which follow from the schema, and their chunks by key.

The metadata on the disk are for other programs; this program opens its arrays without them.
"""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import zarr
from zarr.abc.store import Store
from zarr.codecs import ZstdCodec
from zarr.core.sync import sync
from zarr.storage import MemoryStore, StorePath

from pipeline.store.folder import FolderStore
from pipeline.store.place import ROOT
from pipeline.store.schema import COMPRESSION, Variable, attributes_of, is_of_points, path_of

if TYPE_CHECKING:
    from zarr.abc.buffer import Buffer
    from zarr.core.array_spec import ArraySpec

Document = dict[str, Any]
"""Content of a JSON document."""

_GROWING = 4096  # entries in a chunk of a coordinate that grows
_MOST_OF_TEXT = 2**16  # bytes of a text: messages have 2000 characters, and labels fewer


class _BoundedZstd(ZstdCodec):
    """Zarr's Zstd codec, which unpacks no more bytes than a chunk of the array can have."""

    async def _decode_single(self, chunk_bytes: Buffer, chunk_spec: ArraySpec) -> Buffer:
        return await asyncio.to_thread(self._decode_sync, chunk_bytes, chunk_spec)

    def _decode_sync(self, chunk_bytes: Buffer, chunk_spec: ArraySpec) -> Buffer:
        # Without this limit a damaged chunk of some kilobytes could unpack to gigabytes.
        content = np.zeros(_size(chunk_spec.dtype.to_native_dtype(), chunk_spec.shape), np.uint8)
        self._zstd_codec.decode(chunk_bytes.to_bytes(), content)
        return chunk_spec.prototype.buffer.from_array_like(content)


def array_documents(
    wanted: Mapping[str, Variable], sizes: Mapping[str, int], block: Mapping[str, int]
) -> dict[str, Document]:
    """Zarr metadata of the variables `wanted`, as JSON documents by name.

    `sizes` are the lengths of dimensions, `block` has the number of points in a chunk along each
    dimension.
    """
    memory: dict[str, Any] = {}
    group = zarr.open_group(MemoryStore(memory), mode="w")
    for name, variable in wanted.items():
        shape = [sizes[dim] for dim in variable.dims]
        chunks = {**dict(zip(variable.dims, shape, strict=True)), **block}
        if variable.dims == (name,) and is_of_points(name):
            chunks[name] = _GROWING
        is_real = variable.dtype.startswith("float")
        group.create_array(
            path_of(name),
            shape=shape,
            chunks=tuple(chunks[dim] for dim in variable.dims),
            dtype=str if variable.dtype == "str" else variable.dtype,
            fill_value="" if variable.dtype == "str" else np.nan if is_real else 0,
            compressors=ZstdCodec(**COMPRESSION),
            dimension_names=variable.dims,
            attributes=attributes_of(variable),
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    return {name: json.loads(memory[f"{path_of(name)}/{ROOT}"].to_bytes()) for name in wanted}


def open_arrays(
    store: Store, documents: Mapping[str, Document], prefix: str = ""
) -> dict[str, Any]:
    """Open the arrays of a Zarr store, by name; `documents` has their metadata.

    `prefix` is the path of the group that has them, with a slash, or empty for the root.
    """
    arrays = _open_async_arrays(store, documents, prefix)
    return {name: zarr.Array(array) for name, array in arrays.items()}


def _open_async_arrays(
    store: Store, documents: Mapping[str, Document], prefix: str
) -> dict[str, Any]:
    # Chunks of fill values have to be written, or they would look lost. Zarr's own setting for this
    # belongs to all threads: a thread that ends would change it for the others.
    settings: Any = {"write_empty_chunks": True}
    arrays = {}
    for name, document in documents.items():
        metadata: Any = {**document, "codecs": [document["codecs"][0], _BoundedZstd(**COMPRESSION)]}
        place = StorePath(store, prefix + path_of(name))
        array = arrays[name] = zarr.AsyncArray(metadata, place, settings)
        if isinstance(store, FolderStore):
            # What does not compress at all grows by less than this.
            store.most[place.path] = 2 * _size(array.dtype, array.chunks) + _MOST_OF_TEXT
    return arrays


def _size(dtype: np.dtype[Any], shape: Sequence[int]) -> int:
    """Most bytes of values of a type and shape."""
    return (_MOST_OF_TEXT if dtype.kind in "TO" else dtype.itemsize) * math.prod(shape)


class Encoder:
    """Encodes parts of arrays as Zarr chunks."""

    def __init__(self, documents: Mapping[str, Document], prefix: str = "") -> None:
        self._memory: dict[str, Any] = {}
        self._arrays = _open_async_arrays(MemoryStore(self._memory), documents, prefix)

    def __call__(self, parts: Iterable[tuple[str, Any, Any]]) -> dict[str, bytes]:
        """Encode `parts`; return the bytes of each chunk by the chunk's key.

        A part is (name of the array, slices of whole chunks, values).
        """
        self._memory.clear()
        sync(self._set([*parts]))
        return {key: chunk.to_bytes() for key, chunk in self._memory.items()}

    async def _set(self, parts: Sequence[tuple[str, Any, Any]]) -> None:
        """Give Zarr all parts in one go: one by one they would take twice as long."""
        arrays = self._arrays
        tasks = (arrays[name].setitem(place, values) for name, place, values in parts)
        await asyncio.gather(*tasks)
