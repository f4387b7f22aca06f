"""Zarr's view of the files of a folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from zarr.storage import LocalStore

from pipeline.store.files import require_no_device

if TYPE_CHECKING:
    from zarr.abc.buffer import Buffer


class Files(LocalStore):
    """A `zarr.storage.LocalStore` that no pipe in the place of a file keeps waiting."""

    async def get(self, key: str, *arguments: Any, **options: Any) -> Buffer | None:
        """Content of a key; None if there is none."""
        require_no_device(self.root / key)
        return await super().get(key, *arguments, **options)

    def get_sync(self, key: str, **options: Any) -> Buffer | None:
        """Content of a key as `get` gives it."""
        require_no_device(self.root / key)
        return super().get_sync(key, **options)
