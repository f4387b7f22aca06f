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

__all__ = ["COMPRESSOR", "chunks_of", "numbers_in"]

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


def numbers_in(array: Any, content: Callable[[str], bytes | None]) -> np.ndarray[Any, Any]:
    """Read an array that has a chunk for each number.

    Parameters
    ----------
    array : zarr.AsyncArray
    content : callable
        Gives the content of a key, or None if there is none.
    """
    dtype = array.dtype.newbyteorder("<")
    fill = np.asarray(array.metadata.fill_value, dtype).tobytes()
    keys = map(array.metadata.encode_chunk_key, np.ndindex(array.shape))
    found = (content(f"{array.path}/{key}") for key in keys)
    numbers = b"".join(fill if each is None else _compressor.decode(each) for each in found)
    return np.frombuffer(numbers, dtype).reshape(array.shape)


def _raw(part: np.ndarray[Any, Any]) -> bytes:
    if part.dtype == object:
        text: bytes = _text.encode(part.ravel())
        return text
    return part.astype(part.dtype.newbyteorder("<"), copy=False).tobytes()
