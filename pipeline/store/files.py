"""The files of a store as Zarr writes them, on a disk or in an object store."""

from __future__ import annotations

import atexit
import functools
import os
import uuid
from collections import deque
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from zarr.core.buffer import default_buffer_prototype
from zarr.storage import FsspecStore, LocalStore

from pipeline.store.folder import Place, sync
from pipeline.store.remote import Remote, as_os_error, asynchronous
from pipeline.store.together import together

__all__ = ["Files", "RemoteFiles", "files_in"]

_THREADS = 8  # that wait for the disk, so that it writes the files of a point in one go


class Files(LocalStore):
    """Files on a disk."""

    def __init__(self, root: Path, *, read_only: bool = False) -> None:
        super().__init__(root, read_only=read_only)
        self._written: deque[Path] = deque()

    async def set(self, key: str, value: Any) -> None:
        """Replace a file; at once, since handing it to a thread takes longer than to write it.

        It is not sure to be on the disk before the next `sync`.
        """
        self._check_writable()
        file = self.root / key
        file.parent.mkdir(parents=True, exist_ok=True)
        os.close(self._replaced(key, value.as_buffer_like()))
        self._written.append(file)

    def content(self, key: str) -> bytes | None:
        """Read a file, if there is one."""
        try:
            return (self.root / key).read_bytes()
        except FileNotFoundError:
            return None

    def remove_all(self, prefix: str) -> None:
        """Remove the files of which the key begins like this."""
        top, beginning = os.path.split(f"{self.root}/{prefix}")
        for folder, _, names in os.walk(top):
            for name in names:
                if name.startswith(beginning):
                    Path(folder, name).unlink()

    def sync(self) -> None:
        """Wait until all that was set is on the disk."""
        written = [self._written.popleft() for _ in range(len(self._written))]
        deque(_disk().map(sync, written), maxlen=0)

    def put_all(self, contents: Iterable[tuple[str, bytes]]) -> None:
        """Replace files in folders that exist, and wait until they are on the disk."""
        written: list[int] = []
        try:
            for key, content in contents:
                written.append(self._replaced(key, content))
            shares = (written[i::_THREADS] for i in range(min(_THREADS, len(written))))
            deque(_disk().map(_sync_all, shares), maxlen=0)
        finally:
            for file in written:
                os.close(file)

    def _replaced(self, key: str, content: Any) -> int:
        """Replace a file; return the number under which it is still open.

        Not to overtake one another, writers use a name of their own until the file is whole.
        """
        # Names and numbers, since objects in their place would take a fifth of the time of a
        # point's commit.
        name = f"{self.root}/{key}"
        partial = f"{name}.{uuid.uuid4().hex}.partial"
        file = os.open(partial, os.O_WRONLY | os.O_CREAT, 0o666)
        try:
            left = memoryview(content).cast("B")
            while left:
                left = left[os.write(file, left) :]
            os.replace(partial, name)  # noqa: PTH105
        except BaseException:
            os.close(file)
            raise
        return file


class RemoteFiles(FsspecStore):
    """Objects, which are safe once they are written; to be used by `together` alone."""

    async def set(self, key: str, value: Any, byte_range: Any = None) -> None:
        """Replace an object."""
        self._check_writable()
        with as_os_error():
            await super().set(key, value, byte_range)

    def put_all(self, contents: Iterable[tuple[str, bytes]]) -> None:
        """Replace objects, at the same time, and wait until they are safe."""
        buffer = default_buffer_prototype().buffer
        together(self.set(key, buffer.from_bytes(content)) for key, content in contents)

    def remove_all(self, prefix: str) -> None:
        """Remove the objects of which the key begins like this."""
        together([self._removed(prefix)])

    async def _removed(self, prefix: str) -> None:
        folder = prefix[: prefix.index("/") + 1]
        found = [key async for key in self.list_prefix(folder) if key.startswith(prefix)]
        for key in found:
            await self.delete(key)

    def sync(self) -> None:
        """Do nothing: what was set is safe."""


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


def _sync_all(files: Iterable[int]) -> None:
    for file in files:
        os.fsync(file)


@functools.cache
def _disk() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(_THREADS, thread_name_prefix="disk")
