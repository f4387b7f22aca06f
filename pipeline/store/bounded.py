"""zstd that unpacks no chunk that states another size than it must have.

Some kilobytes can unpack to gigabytes, and the sizes in a store may be a stranger's.
"""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING

import numpy as np
from numcodecs.zstd import Zstd
from zarr.codecs import ZstdCodec

from pipeline.store.place import DamagedError

if TYPE_CHECKING:
    from zarr.abc.buffer import Buffer
    from zarr.core.array_spec import ArraySpec

_ADVICE = "copy the dataset again from its store"
_MOST_OF_TEXT = 2**16  # bytes of a text: messages have 2000 characters, and labels fewer


class BoundedZstd(ZstdCodec):
    """Zarr's codec of this name, with a `DamagedError` for a chunk that is not of its array."""

    async def _decode_single(self, chunk_bytes: Buffer, chunk_spec: ArraySpec) -> Buffer:
        return await asyncio.to_thread(self._decode_sync, chunk_bytes, chunk_spec)

    def _decode_sync(self, chunk_bytes: Buffer, chunk_spec: ArraySpec) -> Buffer:
        packed, count = chunk_bytes.to_bytes(), math.prod(chunk_spec.shape)
        dtype = chunk_spec.dtype.to_native_dtype()
        is_text = dtype.kind in "TO"
        size, most = stated_size(packed), count * (_MOST_OF_TEXT if is_text else dtype.itemsize)
        if size > most or (size < most and not is_text):
            raise DamagedError(
                f"a chunk is damaged: it states {size} bytes, and its array has {most}; {_ADVICE}"
            )
        content = np.empty(size, np.uint8)  # another frame behind the first one finds no room
        try:
            Zstd().decode(packed, content)
        except RuntimeError as error:
            raise DamagedError(f"a chunk is damaged; {_ADVICE}") from error
        if is_text and int.from_bytes(content[:4].tobytes(), "little") != count:  # room is made for
            raise DamagedError(f"a chunk has another number of texts than {count}; {_ADVICE}")
        return chunk_spec.prototype.buffer.from_array_like(content)


def stated_size(packed: bytes) -> int:
    """Size that a zstd frame states for its content (RFC 8878, 3.1.1.1); raise if it states none.

    Examples
    --------
    >>> stated_size(Zstd().encode(bytes(100_000)))
    100000
    """
    descriptor = int.from_bytes(packed[4:5], "little")  # 0 if there is none
    is_single = descriptor >> 5 & 1
    width = (is_single, 2, 4, 8)[descriptor >> 6]
    if not width:
        raise DamagedError(f"a chunk does not state its size; {_ADVICE}")
    start = 6 - is_single + (0, 1, 2, 4)[descriptor & 3]
    size = int.from_bytes(packed[start : start + width], "little")
    return size + 256 if width == 2 else size
