"""Small chunks as Zarr writes and reads them, without handing each to its event loop.

A point has some twenty of them, of which Zarr's tasks and threads would cost more than a coarse
simulation does. What is written is the same, byte for byte.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numcodecs.vlen import VLenUTF8
from numcodecs.zstd import Zstd
from zarr.codecs import ZstdCodec

__all__ = ["COMPRESSOR", "chunks_of", "values_at"]

COMPRESSOR = ZstdCodec(level=1, checksum=True)  # of every array that this program makes
_compressor, _text = Zstd(COMPRESSOR.level, COMPRESSOR.checksum), VLenUTF8()


def chunks_of(array: Any, index: tuple[int, ...], values: Any) -> Iterator[tuple[str, bytes]]:
    """Cut the values of an array at an index into chunks; yield their keys and contents.

    Parameters
    ----------
    array : zarr.AsyncArray
        Whose chunks hold one place of the leading dimensions each.
    index : tuple of int
        The place.
    values : array_like
        All that is there, along the other dimensions.
    """
    values = np.asarray(values, dtype=object if array.dtype.kind == "T" else array.dtype)
    sizes = array.chunks[len(index) :]
    counts = (range(-(-n // size)) for n, size in zip(values.shape, sizes, strict=True))
    for place in itertools.product(*counts):
        begins = [i * size for i, size in zip(place, sizes, strict=True)]
        window = (slice(i, i + size) for i, size in zip(begins, sizes, strict=True))
        part = values[(*window, ...)]
        if part.shape != sizes:  # the last chunk reaches beyond the array
            whole = np.full(sizes, array.metadata.fill_value, values.dtype)
            whole[tuple(slice(n) for n in part.shape)] = part
            part = whole
        key = f"{array.path}/{array.metadata.encode_chunk_key((*index, *place))}"
        yield key, _compressor.encode(_raw(part))


def values_at(array: Any, index: tuple[int, ...], content: Callable[[str], bytes | None]) -> Any:
    """Read what an array has at an index, or all of it at ``()``.

    Parameters
    ----------
    array : zarr.AsyncArray
        Whose chunks hold one place of the leading dimensions each.
    index : tuple of int
        The place.
    content : callable
        Gives the content of a key, or None if there is none.

    Raises
    ------
    RuntimeError, ValueError
        If a chunk is damaged.
    """
    is_text = array.dtype.kind == "T"
    dtype = np.dtype(object) if is_text else array.dtype.newbyteorder("<")
    sizes, shape = array.chunks[len(index) :], array.shape[len(index) :]
    counts = [-(-n // size) for n, size in zip(shape, sizes, strict=True)]
    extent = [n * size for n, size in zip(counts, sizes, strict=True)]
    values = np.full(extent, array.metadata.fill_value, dtype)
    for place in np.ndindex(*counts):
        found = content(f"{array.path}/{array.metadata.encode_chunk_key((*index, *place))}")
        if found is not None:
            raw = _compressor.decode(found)
            part = _text.decode(raw) if is_text else np.frombuffer(raw, dtype)
            window = tuple(slice(i * n, (i + 1) * n) for i, n in zip(place, sizes, strict=True))
            values[window] = part.reshape(sizes)
    return values[tuple(slice(n) for n in shape)]


def _raw(part: np.ndarray[Any, Any]) -> bytes:
    if part.dtype == object:
        text: bytes = _text.encode(part.ravel())
        return text
    return part.astype(part.dtype.newbyteorder("<"), copy=False).tobytes()
