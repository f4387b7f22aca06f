"""Chunks: how an array lies in files, and their content, byte for byte as Zarr writes it.

Zarr reads a chunk that is missing as fill values, and so a lost file as if it had never been
written; here the caller is told. Besides, a point has some twenty small chunks, on which Zarr's
tasks and threads would spend more time than a coarse simulation takes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numcodecs.vlen import VLenUTF8
from numcodecs.zstd import Zstd

from pipeline.store.layout import LEVEL, separator_of, sizes_of

_compressor, _text = Zstd(LEVEL, checksum=True), VLenUTF8()
_LONGEST_TEXT = 2**24  # bytes, of a chunk

Place = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ChunkedArray:
    """An array in chunks, as its metadata describe it.

    Attributes
    ----------
    name : str
        Path of the array in its store.
    shape, chunks : tuple of int
        Size of the array, and of each of its chunks.
    dtype : dtype
        Type of the values in memory; object for text.
    fill : object
        Value where no chunk was written.
    separator : str
        Separator of the numbers in the name of a chunk.
    """

    name: str
    shape: tuple[int, ...]
    chunks: tuple[int, ...]
    dtype: np.dtype[Any]
    fill: Any
    separator: str

    @classmethod
    def of(cls, name: str, metadata: Mapping[str, Any]) -> ChunkedArray:
        """The array with this ``zarr.json``."""
        is_text = metadata["data_type"] == "string"
        dtype = np.dtype(object) if is_text else np.dtype(metadata["data_type"]).newbyteorder("<")
        fill = metadata["fill_value"]
        return cls(
            name=name,
            shape=tuple(metadata["shape"]),
            chunks=tuple(sizes_of(metadata)),
            dtype=dtype,
            fill=fill if is_text else dtype.type(fill),
            separator=separator_of(metadata),
        )

    def key(self, place: Place) -> str:
        """Name of the file with the chunk at a place."""
        return self.separator.join((f"{self.name}/c", *map(str, place)))

    def is_shared(self, axes: int) -> bool:
        """Whether a chunk holds several points, which the first so many dimensions tell apart."""
        return math.prod(self.chunks[:axes]) > 1

    def counts(self, first: int = 0) -> Place:
        """Number of chunks along each dimension from the `first` on."""
        sizes = zip(self.shape[first:], self.chunks[first:], strict=True)
        return tuple(-(-length // size) for length, size in sizes)

    def encoded(self, part: np.ndarray[Any, Any]) -> bytes:
        """Content of the file with a chunk."""
        if self.dtype == object:
            return bytes(_compressor.encode(_text.encode(part.ravel())))
        return bytes(_compressor.encode(np.ascontiguousarray(part, self.dtype)))

    def decoded(self, content: bytes) -> np.ndarray[Any, Any]:
        """Read a chunk from the content of its file.

        Raises
        ------
        RuntimeError, ValueError
            If the content is damaged, or not that of such a chunk.
        """
        size, number = _content_size(content), math.prod(self.chunks)
        if self.dtype == object:
            if size > _LONGEST_TEXT:
                raise ValueError(f"a chunk holds {size} bytes of text")
            raw = _compressor.decode(content)
            if int.from_bytes(raw[:4], "little") != number:
                raise ValueError(f"a chunk does not hold {number} texts")
            texts: np.ndarray[Any, Any] = _text.decode(raw).reshape(self.chunks)
            return texts
        if size != number * self.dtype.itemsize:
            raise ValueError(f"a chunk holds {size} bytes instead of {number} numbers")
        return np.frombuffer(_compressor.decode(content), self.dtype).reshape(self.chunks)


def chunks_of(array: ChunkedArray, place: Place, values: Any) -> Iterator[tuple[str, bytes]]:
    """Cut the values of an array at a place into chunks; yield their keys and contents.

    Parameters
    ----------
    array : ChunkedArray
        Array that the chunks belong to.
    place : tuple of int
        Numbers of the chunk along the leading dimensions.
    values : array_like
        What the chunks there hold: along the leading dimensions as much as one chunk has or less,
        or a single entry without these dimensions; along the others all there is.
    """
    values = np.asarray(values, array.dtype)
    if values.ndim < len(array.shape):
        values = values[(None,) * len(place)]
    for further in np.ndindex(*array.counts(len(place))):
        sizes = zip(further, array.chunks[len(place) :], strict=True)
        part = values[(..., *(slice(i * size, (i + 1) * size) for i, size in sizes))]
        if part.shape != array.chunks:  # the last chunk reaches beyond the array
            whole = np.full(array.chunks, array.fill, array.dtype)
            whole[tuple(map(slice, part.shape))] = part
            part = whole
        yield array.key((*place, *further)), array.encoded(part)


def chunks_with(
    array: ChunkedArray,
    place: Place,
    entries: Mapping[Place, Any],
    there: Callable[[str, Place], np.ndarray[Any, Any] | None] = lambda key, place: None,
) -> Iterator[tuple[str, bytes]]:
    """Put entries into the chunks at a place; yield the keys and contents that these have then.

    Parameters
    ----------
    array : ChunkedArray
        Array to write to.
    place : tuple of int
        Numbers of the chunk along the leading dimensions.
    entries : mapping
        What to put at each of some indices along these dimensions: all there is along the others.
    there : callable, optional
        Called with the key and the place of each chunk; returns what it holds now, None if nothing.
    """
    lead = len(place)
    values = {index: np.asarray(each, array.dtype) for index, each in entries.items()}
    for further in np.ndindex(*array.counts(lead)):
        sizes = zip(further, array.chunks[lead:], strict=True)
        window = tuple(slice(i * size, (i + 1) * size) for i, size in sizes)
        key = array.key((*place, *further))
        before = there(key, (*place, *further))
        part = np.full(array.chunks, array.fill, array.dtype) if before is None else before.copy()
        for index, value in values.items():
            own = value[window] if window else value
            at = (i % size for i, size in zip(index, array.chunks, strict=False))
            along = (*(slice(i, i + 1) for i in at), *map(slice, own.shape))
            part[along] = own[(None,) * lead]
        yield key, array.encoded(part)


def keys_at(array: ChunkedArray, index: Place) -> list[str]:
    """Keys of the chunks at an index along the leading dimensions."""
    places = itertools.product(*map(range, array.counts(len(index))))
    return [array.key((*index, *place)) for place in places]


def values_at(
    array: ChunkedArray,
    index: Place,
    content: Callable[[str], bytes | None],
    lacks: Callable[[str, Place], None] = lambda key, place: None,
) -> np.ndarray[Any, Any]:
    """Read what an array has at an index; all of it at ``()``.

    Parameters
    ----------
    array : ChunkedArray
        Array to read.
    index : tuple of int
        Index along the leading dimensions, where chunks have one entry each.
    content : callable
        Called with a key; returns the content of its file, or None if there is no such file.
    lacks : callable, optional
        Called with the key and the place of each chunk that is missing.

    Raises
    ------
    RuntimeError, ValueError
        If a chunk is damaged.
    """
    lead = len(index)
    shape, counts = array.shape[lead:], array.counts(lead)
    if math.prod(counts) == 1:  # as nearly always; `picked` takes three times as long
        place = index + (0,) * len(counts)
        found = content(key := array.key(place))
        if found is not None:
            own = array.decoded(found).reshape(array.chunks[lead:])
            return own if own.shape == shape else own[tuple(map(slice, shape))]
        lacks(key, place)
        return np.full(shape, array.fill, array.dtype)
    picks = (*([i] for i in index), *map(np.arange, shape))
    values = picked(array, picks, lambda keys: map(content, keys), lambda _: True, lacks)
    return values.reshape(shape)


def picked(
    array: ChunkedArray,
    picks: Sequence[Any],
    contents: Callable[[list[str]], Iterable[bytes | None]],
    is_wanted: Callable[[tuple[Any, ...]], Any],
    lacks: Callable[[str, Place], None],
) -> np.ndarray[Any, Any]:
    """Read a part of an array.

    Parameters
    ----------
    array : ChunkedArray
        Array to read.
    picks : sequence of array_like of int
        Indices of the entries along each dimension.
    contents : callable
        Called with keys; returns the contents of their files, None for those without a file.
    is_wanted : callable
        Called with the entries of the result that a chunk holds; returns whether to read the chunk.
        The result has fill values where it is not read.
    lacks : callable
        Called with the key and the place of each chunk that is missing.

    Raises
    ------
    RuntimeError, ValueError
        If a chunk is damaged.
    """
    values = np.full([len(pick) for pick in picks], array.fill, array.dtype)
    along = [
        _by_chunk(np.asarray(pick), size) for pick, size in zip(picks, array.chunks, strict=True)
    ]
    parts = [each for each in map(_Part.of, itertools.product(*along)) if is_wanted(each.into)]
    keys = [array.key(part.place) for part in parts]
    for part, key, content in zip(parts, keys, contents(keys), strict=True):
        if content is None:
            lacks(key, part.place)
        else:
            values[part.into] = array.decoded(content)[part.taken]
    return values


class _Part(NamedTuple):
    """What a chunk gives to a result: which chunk, where it goes, and what of it is taken."""

    place: Place
    into: tuple[Any, ...]
    taken: tuple[Any, ...]

    @classmethod
    def of(cls, along: Iterable[_Part]) -> _Part:
        """The part with these shares along the dimensions."""
        place, into, taken = zip(*along, strict=True) if (along := list(along)) else ((), (), ())
        places = tuple(itertools.chain.from_iterable(place))
        return cls(places, _indices(into), _indices(taken))


def _indices(along: Iterable[tuple[Any]]) -> tuple[Any, ...]:
    """An index of slices, or where one of them is an array, of arrays, taken orthogonally."""
    found = tuple(each for (each,) in along)
    if all(isinstance(each, slice) for each in found):
        return found
    return np.ix_(*(np.r_[each] for each in found))


def _by_chunk(pick: Any, size: int) -> list[_Part]:
    """The shares of chunks in what is picked along a dimension."""
    numbers = pick // size
    shares = []
    for number in sorted(set(numbers.tolist())):  # np.unique would load numpy.ma, for 20 ms
        (into,) = np.nonzero(numbers == number)
        shares.append(_Part((number,), (_slice(into),), (_slice(pick[into] - number * size),)))
    return shares


def _slice(index: Any) -> Any:
    """The slice with the same entries, if there is one."""
    if (np.diff(index) == 1).all():
        return slice(int(index[0]), int(index[-1]) + 1)
    return index


def _content_size(frame: bytes) -> int:
    """Size of what a Zstandard frame unpacks to, by its header (RFC 8878, 3.1.1.1).

    Raises
    ------
    ValueError
        If this is not such a frame, or it does not say.
    """
    if len(frame) < 6 or frame[:4] != b"\x28\xb5\x2f\xfd":
        raise ValueError("a chunk is not compressed with Zstandard")
    descriptor = frame[4]
    flag, is_single = descriptor >> 6, bool(descriptor & 0x20)
    if not flag and not is_single:
        raise ValueError("a chunk does not say how large it is")
    at = 5 + (not is_single) + (0, 1, 2, 4)[descriptor & 3]
    size = int.from_bytes(frame[at : at + (1, 2, 4, 8)[flag]], "little")
    return size + 256 if flag == 1 else size
