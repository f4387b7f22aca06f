"""The files of a store, on a disk or in an object store, read and replaced by their keys."""

from __future__ import annotations

import atexit
import errno
import functools
import itertools
import os
import stat
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from pipeline.store.folder import PARTIAL, Place, rename, sync
from pipeline.store.remote import Remote, as_os_error, asynchronous
from pipeline.store.together import together

_T = TypeVar("_T")
Contents = Iterable[tuple[str, bytes]]
_Written = tuple[int, str]  # the number of an open file, and the name that it is to have

_AS_IT_IS = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
"""Flags for files that are bytes, not lines, and that do not wait for somebody to write."""

_THREADS = 8  # that wait for the disk, so that it writes the files of a point in one go
_AT_ONCE = 256  # files that are written, or objects that are under way


class Files:
    """Files on a disk, by their path below a folder."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def content(self, key: str) -> bytes | None:
        """Read a file, if there is one.

        Raises
        ------
        OSError
            If it cannot be read, or is something without an end.
        """
        try:
            file = os.open(f"{self.root}/{key}", os.O_RDONLY | _AS_IT_IS)
        except FileNotFoundError:
            return None
        try:
            found = os.fstat(file)
            if not stat.S_ISREG(found.st_mode):
                raise OSError(f"{self.root}/{key} is not a file")
            return os.read(file, found.st_size)
        finally:
            os.close(file)

    def contents(self, keys: Iterable[str]) -> Iterator[bytes | None]:
        """Read files one by one, as they are asked for; empty where the disk cannot read."""
        for key in keys:
            try:
                yield self.content(key)
            except OSError as error:
                if error.errno not in (None, errno.EIO):
                    raise
                yield b""

    def listed(self, folder: str) -> list[str] | None:
        """Names of all files in a folder."""
        try:
            with os.scandir(f"{self.root}/{folder}") as there:
                return [each.name for each in there]
        except FileNotFoundError:
            return []

    def exist(self, keys: Iterable[str]) -> list[bool]:
        """Tell which of these there are."""
        return [os.path.lexists(f"{self.root}/{key}") for key in keys]

    def make_folders(self, names: Iterable[str]) -> None:
        """Make folders, and wait until their names are on the disk."""
        folders = [self.root / name for name in names]
        for folder in folders:
            folder.mkdir(parents=True, exist_ok=True)
        parents = (parent for folder in folders for parent in folder.parents)
        for parent in {each for each in parents if each.is_relative_to(self.root)}:
            sync(parent)

    def put_all(self, contents: Contents, then: Contents = ()) -> None:
        """Replace files in existing folders, `then` others, once the former are safe on the disk.

        Each is written beside the one it replaces, synced, and only then given its name; then its
        folder is synced. So what has its name is whole, and what is to come last is not there
        before the rest, whenever the power fails.
        """
        # Names and numbers, since objects in their place would take a fifth of the time of a
        # point's commit.
        mark = f".{uuid.uuid4().hex}{PARTIAL}"  # not to meet other writers
        first: list[_Written] = []
        last: list[_Written] = []
        try:
            self._write(contents, mark, first)
            self._write(then, mark, last)
            _together(os.fsync, [file for file, _ in (*first, *last)])
            for written in (first, last):
                for _, name in written:
                    rename(name + mark, name)
                _together(sync, sorted({name[: name.rindex("/")] for _, name in written}))
        except BaseException:
            for _, name in (*first, *last):
                with suppress(OSError):
                    os.unlink(name + mark)  # noqa: PTH108
            raise
        finally:
            for file, _ in (*first, *last):
                os.close(file)

    def _write(self, contents: Contents, mark: str, written: list[_Written]) -> None:
        """Write files beside those that they are to replace, and note each."""
        for key, content in contents:
            name = f"{self.root}/{key}"
            file = os.open(name + mark, os.O_WRONLY | os.O_CREAT | _AS_IT_IS, 0o666)
            written.append((file, name))
            rest = memoryview(content)
            while rest:
                rest = rest[os.write(file, rest) :]

    def put_many(self, contents: Contents) -> None:
        """Replace any number of files."""
        for batch in _batches(contents):
            self.put_all(batch)

    def remove(self, keys: Iterable[str]) -> None:
        """Remove files, as far as they are there, and empty folders in the place of one."""
        for key in keys:
            file = Path(self.root, key)
            try:
                file.unlink(missing_ok=True)
            except IsADirectoryError:
                file.rmdir()

    def remove_all(self, prefix: str) -> None:
        """Remove the files whose keys begin with a prefix."""
        top, beginning = os.path.split(f"{self.root}/{prefix}")
        for folder, _, names in os.walk(top):
            for name in names:
                if name.startswith(beginning):
                    Path(folder, name).unlink()


class RemoteFiles:
    """Objects below an address, by their path there, which are safe once they are written."""

    def __init__(self, fs: Any, path: str) -> None:
        self.fs, self.path = fs, path

    def content(self, key: str) -> bytes | None:
        """Read an object, if there is one."""
        (content,) = self.contents([key])
        return content

    def contents(self, keys: Iterable[str]) -> Iterator[bytes | None]:
        """Read objects, many at the same time."""
        for batch in _batches(keys):
            yield from together(map(self._content, batch))

    def listed(self, _: str) -> list[str] | None:
        """None: a list may be older than the objects."""
        return None

    def exist(self, keys: Iterable[str]) -> list[bool]:
        """Tell which of these there are."""
        return together(self.fs._exists(self._path(key)) for key in keys)

    def make_folders(self, names: Iterable[str]) -> None:
        """Do nothing: an object needs no folder."""

    def put_all(self, contents: Contents, then: Contents = ()) -> None:
        """Replace objects, all at the same time, `then` others, once the former are safe."""
        for group in (contents, then):
            together(self._put(key, content) for key, content in group)

    def put_many(self, contents: Contents) -> None:
        """Replace any number of objects."""
        for batch in _batches(contents):
            self.put_all(batch)

    def remove(self, keys: Iterable[str]) -> None:
        """Remove objects, as far as they are there."""
        together(self._removed(key) for key in keys)

    def remove_all(self, prefix: str) -> None:
        """Remove the objects whose keys begin with a prefix."""
        (found,) = together([self.fs._find(self._path(prefix.rpartition("/")[0]))])
        beginning = self._path(prefix)
        for batch in _batches(key for key in found if key.startswith(beginning)):
            together(self.fs._rm_file(key) for key in batch)

    def _path(self, key: str) -> str:
        return f"{self.path}/{key}"

    async def _content(self, key: str) -> bytes | None:
        with as_os_error():
            try:
                content: bytes = await self.fs._cat_file(self._path(key))
            except FileNotFoundError:
                return None
        return content

    async def _put(self, key: str, content: bytes) -> None:
        with as_os_error():
            await self.fs._pipe_file(self._path(key), content)

    async def _removed(self, key: str) -> None:
        with as_os_error(), suppress(FileNotFoundError):
            await self.fs._rm_file(self._path(key))


def files_in(folder: Place) -> Files | RemoteFiles:
    """The files below a folder."""
    return RemoteFiles(_objects(), folder.key) if isinstance(folder, Remote) else Files(folder)


@functools.cache
def _objects() -> Any:
    objects = asynchronous()

    async def close() -> None:
        session = await objects.set_session()
        await session.close()

    atexit.register(lambda: together([close()]))  # or it complains on stderr
    return objects


def _batches(items: Iterable[_T]) -> Iterator[list[_T]]:
    items = iter(items)
    while batch := list(itertools.islice(items, _AT_ONCE)):
        yield batch


def _together(act: Callable[[Any], None], items: Sequence[Any]) -> None:
    """Do something with each item, several at the same time.

    A file system writes in one go what waits at the same time; one after the other, each item would
    take a go of its own.
    """
    shares = [items[i::_THREADS] for i in range(min(_THREADS, len(items)))]
    under_way = []
    with suppress(RuntimeError):  # where no further thread can be started
        while len(shares) > 1:
            under_way.append(_disk().submit(_each, act, shares[-1]))
            shares.pop()
    for share in shares:
        _each(act, share)
    for each in wait(under_way).done:
        each.result()


def _each(act: Callable[[Any], None], items: Iterable[Any]) -> None:
    for item in items:
        act(item)


@functools.cache
def _disk() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(_THREADS, thread_name_prefix="disk")


if hasattr(os, "register_at_fork"):  # a forked process has none of the threads
    os.register_at_fork(after_in_child=_disk.cache_clear)
