"""Places of stores: folders of a disk, and addresses of an object store.

::

    TriboError
    └── StoreError               no store, not readable, not writable or in use
        ├── StoreMismatchError   the store of another scene
        └── DamagedError         data that were read, and are proved wrong

Data that cannot be read now may be sound, and raise a plain `StoreError`. Only what is proved wrong
is ever replaced.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.paths import read_file, user_path
from pipeline.store import files
from tribo import TriboError

if TYPE_CHECKING:
    from zarr.abc.store import Store

PathLike = str | os.PathLike[str]
ROOT = "zarr.json"
"""Key of the metadata of a group; that of an array lies below its name."""
LOCK = "status/lock"
"""Key of the lock of a store: within it, so that every path to the store finds it."""
_MOST_OF_DOCUMENT = 2**28  # bytes of a JSON document, which has the scene's text
REMEDY = "irg run with its scene mends it; on an object store, write to another store"
"""What to do about a store that is damaged."""


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
    """Place of a store: a folder of a disk, by its absolute path."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    def zarr(self) -> Store:
        """Read-only Zarr store of the folder."""
        from pipeline.store.folder import FolderStore  # Zarr, which workers do not need

        return FolderStore(self.path)

    def read(self, key: str) -> bytes | None:
        """Content of the document `key`; None if there is no such file."""
        with suppress(FileNotFoundError, NotADirectoryError):
            return read_file(self.path / key, _MOST_OF_DOCUMENT)
        return None

    def has(self, key: str) -> bool:
        """True if there is something named `key`, readable or not."""
        with suppress(FileNotFoundError, NotADirectoryError):
            return bool((self.path / key).stat())
        return False

    def put(self, contents: Mapping[str, bytes]) -> None:
        """Create or replace files (`contents` by key); return once they are on the disk."""
        files.replace_files(self.path, contents)

    def keys(self) -> set[str]:
        """Names of all files below the folder; links to folders are not followed."""
        start = len(str(self.path)) + 1
        paths = (f"{folder}/{name}" for folder, _, names in os.walk(self.path) for name in names)
        return {path[start:].replace(os.sep, "/") for path in paths}


# Errors of fsspec for a missing object; older versions of it raise the last for a zip file.
_MISSING = (FileNotFoundError, IsADirectoryError, NotADirectoryError, KeyError)


@dataclass(frozen=True)
class Bucket:
    """Place of a store: an address of an object store, such as ``s3://bucket/sweep.zarr``."""

    address: str

    def __str__(self) -> str:
        return self.address

    def zarr(self) -> Store:
        """Read-only Zarr store of the objects."""
        from zarr.storage import FsspecStore

        return FsspecStore.from_url(
            self.address,
            read_only=True,
            allowed_exceptions=_MISSING,
            storage_options=self._options,
        )

    @property
    def is_written(self) -> bool:
        """True if stores are written there; at addresses of other kinds they are only read."""
        return self.address.startswith("s3://")

    @property
    def _options(self) -> dict[str, Any]:
        # With more requests at a time, each read of an object would begin with one for its size.
        only_s3 = {"max_concurrency": 1} if self.is_written else {}
        return {"use_listings_cache": False, **only_s3}

    def _opened(self) -> tuple[Any, str]:
        """File system of fsspec, and the prefix of the names of the store's objects."""
        import fsspec  # which stores in folders do without

        system, path = fsspec.core.url_to_fs(self.address, **self._options)
        return system, f"{path}/"

    def read(self, key: str) -> bytes | None:
        """Content of the object `key`; None if there is no such object."""
        system, above = self._opened()
        with suppress(*_MISSING):
            return bytes(system.cat_file(above + key))
        return None

    def has(self, key: str) -> bool:
        """True if there is an object `key`."""
        return self.read(key) is not None

    def put(self, contents: Mapping[str, bytes]) -> None:
        """Create or replace objects (`contents` by key); several are sent at the same time."""
        system, above = self._opened()
        system.pipe({above + key: content for key, content in contents.items()})

    def keys(self) -> set[str]:
        """Names of all objects of the store."""
        system, above = self._opened()
        names = {name.removeprefix(above) for name in system.find(above)}
        if not names and self.has(ROOT):  # by the web servers of most sites
            raise StoreError(f"{self} does not list its files; copy the store to a folder here")
        return names


@dataclass(frozen=True)
class Memory:
    """Place of a store that nobody keeps: the memory of this process."""

    contents: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    def __str__(self) -> str:
        return "the memory of this process"

    def zarr(self) -> Store:
        """Read-only Zarr store of the contents."""
        from zarr.storage import MemoryStore

        return MemoryStore(self.contents, read_only=True)

    def read(self, key: str) -> bytes | None:
        """Content by its `key`; None if there is none."""
        return self.contents[key].to_bytes() if key in self.contents else None

    def put(self, contents: Mapping[str, bytes]) -> None:
        """Keep or replace `contents` by key."""
        from zarr.core.buffer import default_buffer_prototype

        make = default_buffer_prototype().buffer.from_bytes
        self.contents.update({key: make(content) for key, content in contents.items()})

    def has(self, key: str) -> bool:
        """True if there is content of this `key`."""
        return key in self.contents

    def keys(self) -> set[str]:
        """Keys of all contents."""
        return {*self.contents}


StorePlace = Folder | Bucket | Memory
"""Where the files of a store are: a folder, an object store, or memory."""


def place_of(path: PathLike | None) -> StorePlace:
    """`Folder` or `Bucket` of a store, from its path or address; `Memory` without one.

    An address ``file://PATH`` is a folder.

    Raises a `StoreError` for the root of a file system.
    """
    if path is None:
        return Memory()
    address = os.fspath(path).removeprefix("file://")
    if "://" in address:
        return Bucket(address.rstrip("/"))
    folder = Path(os.path.realpath(user_path(address).absolute()))
    if not folder.name:
        raise StoreError(f"{folder} cannot be a store; give a folder below it")
    return Folder(folder)


@contextmanager
def io_errors(place: StorePlace, verb: str = "read") -> Iterator[None]:
    """Context manager: turn an error of disk or network into a `StoreError`.

    Its message says that the file or `place` cannot be read, or "written" if this is the `verb`.
    """
    try:
        yield
    except Exception as error:
        # A bucket's library may raise errors of any class.
        is_expected = isinstance(error, OSError) or isinstance(place, Bucket)
        if not is_expected or isinstance(error, TriboError) or is_lack_of_memory(error):
            raise
        file, reason = getattr(error, "filename", None), getattr(error, "strerror", None) or error
        raise StoreError(
            f"{file or place} cannot be {verb}: {reason}; finished points are safe: check free "
            "space, permissions and the disk, then repeat the command"
        ) from error


@contextmanager
def read_errors(place: StorePlace, name: str) -> Iterator[None]:
    """Context manager: turn errors of reading the variable `name` from a store into store errors.

    Bad data raise a `DamagedError`, errors of disk or network a `StoreError`.
    """
    with io_errors(place):
        try:
            yield
        except (RuntimeError, ValueError, DamagedError) as error:
            if is_lack_of_memory(error):  # which is no damage
                raise
            raise DamagedError(damaged(place, name)) from error


def damaged(place: StorePlace, name: str) -> str:
    """Error message that the data `name` of a store are damaged."""
    return f"{place}: {name} cannot be read; irg verify names what is damaged; {REMEDY}"


def is_lack_of_memory(error: BaseException) -> bool:
    """True if an error means that memory has run out."""
    if isinstance(error, OSError):
        return error.errno in (errno.ENOMEM, errno.EAGAIN)
    said = ("start new thread", "failed to map segment", "annot allocate memory")
    return isinstance(error, MemoryError) or any(words in str(error) for words in said)
