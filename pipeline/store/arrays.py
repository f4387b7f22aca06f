"""Arrays of a store as Zarr has them: their metadata, which follow from the schema, and their keys.

Nothing of the metadata on the disk is read, which only other programs need.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import zarr
from zarr.abc.store import Store
from zarr.codecs import ZstdCodec
from zarr.storage import MemoryStore, StorePath

from pipeline.store.bounded import BoundedZstd
from pipeline.store.place import ROOT
from pipeline.store.schema import (
    COMPRESSION,
    Variable,
    attributes_of,
    is_of_points,
    path_of,
)
from pipeline.sweep.limits import MOST_POINTS

Document = dict[str, Any]
"""What a file of JSON says."""

_GROWING = 4096  # entries in a chunk of a coordinate that grows
_LARGEST = 2**27  # values of a chunk: a field of 11585 × 11585 elements
_CODECS = ["bytes", "zstd"], ["vlen-utf8", "zstd"]
_TYPES = {"bool", "int8", "int32", "int64", "float32", "float64", "string"}


def array_documents(
    wanted: Mapping[str, Variable], sizes: Mapping[str, int], block: Mapping[str, int]
) -> dict[str, Document]:
    """Metadata of arrays by name, from the sizes along dimensions and the points in a chunk."""
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


def open_arrays(store: Store, documents: Mapping[str, Document]) -> dict[str, Any]:
    """Open the arrays of a store by their metadata."""
    # A chunk of nothing but fill values that is not written looks like one that was lost. Zarr's
    # own setting of this belongs to all threads, and one that ends would change it for another.
    return {
        name: zarr.Array(
            zarr.AsyncArray(array, StorePath(store, path_of(name)), {"write_empty_chunks": True})
        )
        for name, array in bounded(documents).items()
    }


class Encoder:
    """Chunks by key, from names of arrays, places of whole chunks there, and values."""

    def __init__(self, documents: Mapping[str, Document]) -> None:
        self._memory: dict[str, Any] = {}
        self._arrays = open_arrays(MemoryStore(self._memory), documents)

    def __call__(self, parts: Iterable[tuple[str, Any, Any]]) -> dict[str, bytes]:
        """Chunks of some parts."""
        self._memory.clear()
        for name, place, values in parts:
            self._arrays[name][place] = values
        return {key: chunk.to_bytes() for key, chunk in self._memory.items()}


def bounded(documents: Mapping[str, Document]) -> dict[str, Any]:
    """Metadata of arrays that unpack no chunk of another size than they say."""
    codec = BoundedZstd(**COMPRESSION)
    return {
        name: {**array, "codecs": [array["codecs"][0], codec]} for name, array in documents.items()
    }


def are_plain(documents: Mapping[str, Document]) -> bool:
    """True for metadata of arrays that may be read, though they be a stranger's.

    Arrays are made as large as they say. Codecs of Zarr 2 may unpickle chunks, and those of Zarr 3
    are looked up among all that is installed.
    """
    return all(
        array["zarr_format"] == 3
        and [codec["name"] for codec in array["codecs"]] in _CODECS
        and array["data_type"] in _TYPES
        and all(size <= MOST_POINTS for size in array["shape"])
        and 0 < math.prod(array["chunk_grid"]["configuration"]["chunk_shape"]) <= _LARGEST
        for array in documents.values()
    )


def chunk_key(name: str, numbers: Sequence[int], count: int) -> str:
    """Key of a chunk of an array of so many dimensions, such as ``time/c.0.2.0``.

    It is given by its numbers along the dimensions of points, and whole along the others.
    """
    within = [0] * (count - len(numbers))
    return f"{path_of(name)}/" + ".".join(map(str, ("c", *numbers, *within)))
