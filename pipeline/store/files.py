"""Files that are on the disk, names included, once they are written; a Zarr store of such files."""

from __future__ import annotations

import asyncio
import errno
import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from zarr.storage import LocalStore

from pipeline.store import files

if TYPE_CHECKING:
    from zarr.abc.buffer import Buffer

PARTIAL = ".partial"
"""Ending of the names of files that are being written."""
THREADS = 8
"""Threads that wait for the disk, which then writes several files in one go."""

_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def replace_file(file: Path, content: bytes) -> None:
    """Replace the content of a file at one stroke; return once that is on the disk.

    Only one process and thread may replace a file at a time.
    """
    make_folder(file.parent)
    if file.parent.is_symlink():  # of a stranger's store; it may lead anywhere
        raise OSError(f"{file.parent} is a link to another folder; copy that in its place")
    partial = file.with_name(file.name + PARTIAL)
    try:
        partial.unlink(missing_ok=True)  # left by a killed process, or a link to a file of others
        with partial.open("xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(file)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    sync(file.parent)


def replace_files(root: Path, contents: Mapping[str, bytes]) -> None:
    """Replace several files below a folder, side by side."""
    with ThreadPoolExecutor(THREADS) as threads:
        files = [(root / key, content) for key, content in contents.items()]
        list(threads.map(lambda file: replace_file(*file), files))


def make_folder(folder: Path) -> None:
    """Make a folder and those above it; return once their names are on the disk."""
    if not folder.is_dir():
        make_folder(folder.parent)
        folder.mkdir(exist_ok=True)
        sync(folder.parent)


def sync(folder: Path) -> None:
    """Wait until the names in a folder are on the disk, as far as its file system can tell."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)


class Durable(LocalStore):
    """A `zarr.storage.LocalStore` that survives a power cut.

    A file is written beside its place, synced and renamed, and its folder synced. So after a cut
    each key has its old content or its new one, and the new one if `set` had returned.

    Examples
    --------
    >>> import tempfile, zarr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     array = zarr.create_array(Durable(folder), shape=3, dtype="f8")
    ...     array[:] = 1.5
    ...     zarr.open_array(folder, mode="r")[:].tolist()
    [1.5, 1.5, 1.5]
    """

    async def set(self, key: str, value: Buffer) -> None:
        """Replace the content of a key."""
        await asyncio.to_thread(self.set_sync, key, value)

    async def set_if_not_exists(self, key: str, value: Buffer) -> None:
        """Set the content of a key that has none."""
        if not await self.exists(key):
            await self.set(key, value)

    async def delete(self, key: str) -> None:
        """Remove a key."""
        await super().delete(key)
        await asyncio.to_thread(files.sync, (self.root / key).parent)

    def set_sync(self, key: str, value: Buffer) -> None:
        """Replace the content of a key."""
        self._check_writable()
        files.replace_file(self.root / key, value.to_bytes())

    def delete_sync(self, key: str) -> None:
        """Remove a key."""
        super().delete_sync(key)
        files.sync((self.root / key).parent)
