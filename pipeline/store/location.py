"""Locations of stores: folders of a disk, and addresses of an object store.

A write to a folder returns once the files and their names are on the disk. The path of the folder
may contain links. Below the folder, only regular files are read, written or locked, and links are
not followed.

::

    TriboError
    └── StoreError               no store, not readable, not writable or in use
        ├── StoreMismatchError   the store of another scene
        └── DamagedError         data that were read and are wrong

Data that cannot be read now may be sound, and raise a plain `StoreError`. Only data that are known
to be wrong are replaced.
"""

from __future__ import annotations

import errno
import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.paths import require_path, user_path
from pipeline.store.files import sync
from tribo import TriboError

if TYPE_CHECKING:
    from zarr.abc.store import Store

    from pipeline.store.folder_store import FolderStore

PathLike = str | os.PathLike[str]
ROOT = "zarr.json"
"""Key of the metadata of a group; for an array, below its name."""
NEW, OLD, LOCK = ".irg-new", ".irg-old", ".irg-lock"
"""Endings of paths next to a store: its successor, its predecessor, and its lock."""
REMEDY = "irg run repairs it with the same scene; on an object store, write to another store"
"""How to repair a damaged store."""


class StoreError(TriboError):
    """A store is missing, not readable, not writable or in use.

    Examples
    --------
    >>> import pipeline
    >>> try:
    ...     pipeline.open_sweep("results/none.zarr")
    ... except pipeline.StoreError:
    ...     print("run the scene first")
    run the scene first
    """


class StoreMismatchError(StoreError):
    """A store belongs to another scene.

    Examples
    --------
    >>> import pipeline
    >>> other = pipeline.load_scene("workflows/first_try.toml", overrides={"wear.pattern": "local"})
    >>> try:
    ...     pipeline.run_sweep(other, "results/first_try.zarr")
    ... except pipeline.StoreMismatchError:
    ...     print("another scene: give another folder")
    another scene: give another folder
    """


class DamagedError(StoreError):
    """Data of a store differ from what was written; for example, a chunk cannot be decoded."""


@dataclass(frozen=True)
class Folder:
    """Location of a store: a folder of a disk, by its absolute path."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    @cached_property
    def zarr(self) -> FolderStore:
        """Zarr store of the folder."""
        from pipeline.store.folder_store import FolderStore

        return FolderStore(self.path)

    def sibling(self, ending: str) -> Folder:
        """Path next to this folder with an `ending`: `NEW`, `OLD` or `LOCK`."""
        return Folder(self.path.with_name(self.path.name + ending))

    def stamp(self) -> tuple[int, int] | None:
        """A value that changes if the folder is replaced, but not if files in it are written."""
        with suppress(FileNotFoundError, NotADirectoryError):
            status = (self.path / "status" / ROOT).stat()
            return status.st_ino, status.st_mtime_ns
        return None

    def keys(self) -> set[str]:
        """Names of all files and links below the folder; links are not followed."""
        start, keys = len(str(self.path)) + 1, set[str]()
        for folder, folders, files in os.walk(self.path):
            links = [name for name in folders if Path(folder, name).is_symlink()]
            keys |= {f"{folder}/{name}"[start:] for name in (*files, *links)}
        return keys

    def sync(self) -> None:
        """Wait until the names of the files that were written are on the disk."""
        while self.zarr.touched:
            sync(self.zarr.touched.pop())


# Errors of fsspec for a missing object; older versions raise the last one for a zip file.
_MISSING_OBJECT_ERRORS = (FileNotFoundError, IsADirectoryError, NotADirectoryError, KeyError)


@dataclass(frozen=True)
class Bucket:
    """Location of a store: an address, such as ``s3://bucket/sweep.zarr``."""

    address: str
    is_writable: bool
    """True if stores can be written there; at other kinds of addresses they are only read."""

    def __str__(self) -> str:
        return self.address

    @cached_property
    def zarr(self) -> Store:
        """Zarr store of the objects."""
        from zarr.storage import FsspecStore

        # With more concurrent requests, each read of an object would first ask for its size.
        only_s3 = {"max_concurrency": 1} if self.address.startswith("s3://") else {}
        return FsspecStore.from_url(
            self.address,
            read_only=not self.is_writable,
            allowed_exceptions=_MISSING_OBJECT_ERRORS,
            storage_options={"use_listings_cache": False, **only_s3},
        )

    def stamp(self) -> None:
        """None: a store at an address is not replaced."""

    def keys(self) -> set[str]:
        """Names of all objects of the store."""
        from zarr.core.sync import sync as run

        async def list_names() -> set[str]:
            return {name async for name in self.zarr.list()}

        names = run(list_names())
        if not names and run(self.zarr.exists(ROOT)):  # most web servers
            raise StoreError(
                f"the files in {self} cannot be listed; copy the store to a local folder"
            )
        return names

    def sync(self) -> None:
        """Nothing to do: objects are stored once they are sent."""


Location = Folder | Bucket
"""Location of the files of a store."""


_SUFFIXES_OF_FILES = {
    ".nc", ".nc4", ".cdf", ".h5", ".hdf5", ".he5", ".csv", ".txt", ".json", ".xlsx", ".parquet",
    ".zip", ".toml", ".npy", ".npz", ".mat", ".png", ".pdf", ".svg", ".html", ".md",
}  # fmt: skip


def location_of(path: PathLike | None) -> Location:
    """`Folder` or `Bucket` of a store from its path or address.

    An address ``file://PATH`` is a folder. None is the memory of this process, where the answer to
    a single point is computed.

    Raises a `StoreError` for the root of a file system.
    """
    if path is None:
        return Bucket(f"memory://{uuid.uuid4()}/sweep.zarr", is_writable=True)
    require_path(path)
    address = os.fspath(path).removeprefix("file://")
    if "://" in address:
        return Bucket(address.rstrip("/"), is_writable=address.startswith("s3://"))
    folder = Path(os.path.realpath(user_path(address).absolute()))
    if not folder.name:
        raise StoreError(f"{folder} cannot be a store; choose a folder below it")
    if folder.suffix.lower() in _SUFFIXES_OF_FILES and not folder.exists():
        raise StoreError(
            f"{folder} cannot be a store, which is a Zarr folder; give a name such as "
            f"{folder.stem}.zarr"
        )
    return Folder(folder)


@contextmanager
def io_errors(location: Location, verb: str = "read") -> Iterator[None]:
    """Context manager: turn an error of disk or network into a `StoreError`.

    Its message says that the file or `location` cannot be read, or "written" if that is `verb`.
    """
    try:
        yield
    except Exception as error:
        # The library of a bucket may raise any error.
        is_expected = isinstance(error, OSError) or isinstance(location, Bucket)
        if not is_expected or isinstance(error, TriboError) or is_lack_of_memory(error):
            raise
        file, reason = getattr(error, "filename", None), getattr(error, "strerror", None) or error
        raise StoreError(
            f"{file or location} cannot be {verb}: {reason}; finished points are saved. Check free "
            "space, permissions and the disk, then repeat the command"
        ) from error


@contextmanager
def read_errors(location: Location, name: str) -> Iterator[None]:
    """Context manager: turn errors of reading the variable `name` from a store into store errors.

    Bad data raise a `DamagedError`, errors of disk or network a `StoreError`.
    """
    with io_errors(location):
        try:
            yield
        except (RuntimeError, ValueError, DamagedError) as error:
            if is_lack_of_memory(error):  # not damage
                raise
            raise damaged(location, name) from error


def damaged(location: Location, name: str, problem: str = "cannot be read") -> DamagedError:
    """Error that the data `name` of a store are damaged."""
    return DamagedError(f"{location}: {name} {problem}; irg verify names what is damaged; {REMEDY}")


def is_lack_of_memory(error: BaseException) -> bool:
    """True if an error means that memory has run out."""
    if isinstance(error, OSError):
        return error.errno in (errno.ENOMEM, errno.EAGAIN)
    phrases = ("start new thread", "failed to map segment", "annot allocate memory")
    return isinstance(error, MemoryError) or any(words in str(error) for words in phrases)
