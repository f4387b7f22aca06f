"""A Zarr store of files that are on the disk once they are written."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from zarr.storage import LocalStore

from pipeline.store import files

if TYPE_CHECKING:
    from zarr.abc.buffer import Buffer


class Durable(LocalStore):
    """A `zarr.storage.LocalStore` that survives a power cut.

    A file is written beside its place, synced and renamed, and its folder synced. So after a cut
    each key has its old content or its new one, and the new one if `set` had returned. What is
    there and cannot be read is an `OSError`, and never taken for what is not there.
    """

    async def get(self, key: str, *arguments: Any, **options: Any) -> Buffer | None:
        """Content of a key; None if there is none."""
        if not files.is_there(self.root, key):
            return None
        return await super().get(key, *arguments, **options)

    def get_sync(self, key: str, **options: Any) -> Buffer | None:
        """Content of a key as `get` gives it."""
        return super().get_sync(key, **options) if files.is_there(self.root, key) else None

    async def set(self, key: str, value: Buffer) -> None:
        """Replace the content of a key."""
        await asyncio.to_thread(self.set_sync, key, value)

    def set_sync(self, key: str, value: Buffer) -> None:
        """Replace the content of a key."""
        self._check_writable()
        files.replace_file(self.root, key, value.to_bytes())
