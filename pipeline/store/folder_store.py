"""Zarr store of a folder."""

from __future__ import annotations

import asyncio
from pathlib import Path

from zarr.abc.store import ByteRequest
from zarr.core.buffer import Buffer, BufferPrototype, default_buffer_prototype
from zarr.storage import LocalStore

from pipeline.limits import MAX_BYTES_OF_ROOT
from pipeline.paths import read_file
from pipeline.store.files import store_file, wrong_kind


class FolderStore(LocalStore):
    """Zarr store of a folder: it reads only regular files, and waits until files are on the disk.

    `max_bytes` has the largest size [bytes] of a chunk of each array, by the path of the array;
    `touched` has the folders that got files, whose names are on the disk after `Folder.sync`.
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
        max_bytes = self.max_bytes.get(key.rpartition("/")[0], MAX_BYTES_OF_ROOT)
        try:
            return make(await asyncio.to_thread(read_file, self.root / key, max_bytes))
        except FileNotFoundError:
            return None
        except (IsADirectoryError, NotADirectoryError) as error:
            raise wrong_kind(self.root, key) from error

    async def set(self, key: str, value: Buffer) -> None:
        """Create or replace the file `key`."""
        make = asyncio.to_thread(store_file, self.root, key, value.to_bytes())
        self.touched.add(await make)
