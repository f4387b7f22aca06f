"""Zarr's view of a store in a folder, where a file may be something else, or far too large."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from pathlib import Path

from zarr.abc.store import ByteRequest
from zarr.core.buffer import Buffer, BufferPrototype, default_buffer_prototype
from zarr.storage import LocalStore

from pipeline.paths import read_file


class FolderStore(LocalStore):
    """Read-only Zarr store of a folder, which reads regular files alone.

    `most` has the most bytes of a chunk of each array, by the path of the array.
    """

    def __init__(self, root: Path) -> None:
        super().__init__(root, read_only=True)
        self.most: dict[str, int] = {}

    async def get(
        self,
        key: str,
        prototype: BufferPrototype | None = None,
        byte_range: ByteRequest | None = None,
    ) -> Buffer | None:
        """Content of the file `key`; None if there is none."""
        if byte_range is not None:  # as for shards, which only copies may have
            return await super().get(key, prototype, byte_range)
        make = (prototype or default_buffer_prototype()).buffer.from_bytes
        with suppress(FileNotFoundError, NotADirectoryError, IsADirectoryError):
            most = self.most.get(key.rpartition("/")[0])
            return make(await asyncio.to_thread(read_file, self.root / key, most))
        return None
