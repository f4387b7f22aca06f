"""The files of a store as Zarr writes them, on a disk or in an object store."""

from __future__ import annotations

import asyncio
import atexit
import functools
import uuid
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from zarr.core.buffer import default_buffer_prototype
from zarr.storage import FsspecStore, LocalStore

from pipeline.folder import Place, sync
from pipeline.remote import Remote, as_os_error, asynchronous
from pipeline.together import together

__all__ = ["Files", "RemoteFiles", "files_in"]


class Files(LocalStore):
    """Files on a disk, which are seen to it when asked to."""

    def __init__(self, root: Path, *, read_only: bool = False) -> None:
        super().__init__(root, read_only=read_only)
        self._written: deque[Path] = deque()

    async def set(self, key: str, value: Any) -> None:
        """Replace a file; at once, since handing it to a thread takes longer than to write it."""
        (self.root / key).parent.mkdir(parents=True, exist_ok=True)
        self.put(key, value.as_buffer_like())

    def put(self, key: str, content: Any) -> None:
        """Replace a file in a folder that exists.

        Not to overtake one another, writers use a name of their own until the file is whole.
        """
        file = self.root / key
        partial = file.with_name(f"{file.name}.{uuid.uuid4().hex}.partial")
        partial.write_bytes(content)
        partial.replace(file)
        self._written.append(file)

    def put_all(self, contents: Iterable[tuple[str, bytes]]) -> None:
        """Replace files in folders that exist."""
        for key, content in contents:
            self.put(key, content)

    def sync(self) -> None:
        """Wait until all that was written is on the disk."""
        written = [self._written.popleft() for _ in range(len(self._written))]
        together(asyncio.to_thread(sync, file) for file in written)


class RemoteFiles(FsspecStore):
    """Objects, which are safe once they are written; to be used by `together` alone."""

    async def set(self, key: str, value: Any, byte_range: Any = None) -> None:
        """Replace an object."""
        with as_os_error():
            await super().set(key, value, byte_range)

    def put_all(self, contents: Iterable[tuple[str, bytes]]) -> None:
        """Replace objects, at the same time."""
        buffer = default_buffer_prototype().buffer
        together(self.set(key, buffer.from_bytes(content)) for key, content in contents)

    def sync(self) -> None:
        """Do nothing."""


def files_in(folder: Place) -> Files | RemoteFiles:
    """The files below a folder."""
    if isinstance(folder, Remote):
        return RemoteFiles(_objects(), path=folder.key)
    return Files(folder)


@functools.cache
def _objects() -> Any:
    objects = asynchronous()

    async def close() -> None:
        session = await objects.set_session()
        await session.close()

    atexit.register(lambda: together([close()]))  # or it complains on stderr
    return objects
