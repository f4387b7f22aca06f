"""Zarr's view of the files of a folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from zarr.storage import LocalStore

from pipeline.store.files import require_file

if TYPE_CHECKING:
    from zarr.abc.buffer import Buffer


class Files(LocalStore):
    """A `zarr.storage.LocalStore` that refuses what is there and is no file."""

    async def get(self, key: str, *arguments: Any, **options: Any) -> Buffer | None:
        """Content of a key; None if there is none."""
        require_file(self.root / key)
        return await super().get(key, *arguments, **options)

    def get_sync(self, key: str, **options: Any) -> Buffer | None:
        """Content of a key as `get` gives it."""
        require_file(self.root / key)
        return super().get_sync(key, **options)
