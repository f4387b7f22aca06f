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
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.paths import user_path
from pipeline.store.files import is_there, make_folder, replace_files
from tribo import TriboError

if TYPE_CHECKING:
    from zarr.abc.store import Store

PathLike = str | os.PathLike[str]
ROOT = "zarr.json"
"""Key of the metadata of a group; that of an array lies below its name."""
LOCK = "status/lock"
"""Key of the lock of a store: within it, where no other path misses it."""
KEPT = "status/kept-"
"""Beginning of the keys of what commands keep beside the lock, which is no data."""


class StoreError(TriboError):
    """A store that is missing, not readable, not writable or in use.

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
    """A store that belongs to another scene.

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
    """Data of a store that were read, and are not what was written."""


@dataclass(frozen=True)
class Folder:
    """A folder of a disk, by its absolute path."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    def zarr(self, read_only: bool) -> Store:
        """Zarr's view of the folder, whose files are on the disk once they are set."""
        from pipeline.store.durable import Durable  # with zarr, which workers do not need

        return Durable(self.path, read_only=read_only)

    def read(self, key: str) -> bytes | None:
        """Content of a file; None if there is none."""
        with suppress(FileNotFoundError, NotADirectoryError):  # by now
            if is_there(self.path, key):
                return (self.path / key).read_bytes()
        return None

    def put(self, contents: Mapping[str, bytes]) -> None:
        """Replace files; return once they are on the disk."""
        replace_files(self.path, contents)

    def keys(self) -> set[str]:
        """Names of all files and links below the folder; no link is followed."""
        above = len(f"{self.path}/")
        walked = os.walk(self.path, onerror=_require_missing)
        return {f"{folder}/{name}"[above:] for folder, _, files in walked for name in files}


def _require_missing(error: OSError) -> None:
    """Raise an error of a folder that is there, and cannot be read."""
    if not isinstance(error, FileNotFoundError | NotADirectoryError):
        raise error


@dataclass(frozen=True)
class Bucket:
    """An address of fsspec, such as ``s3://bucket/sweep.zarr``; what is put is safe."""

    address: str

    def __str__(self) -> str:
        return self.address

    def zarr(self, read_only: bool) -> Store:
        """Zarr's view of the objects."""
        from zarr.storage import FsspecStore

        return FsspecStore.from_url(self.address, read_only=read_only, storage_options=_OPTIONS)

    def read(self, key: str) -> bytes | None:
        """Content of an object; None if there is none."""
        try:
            content: bytes = self._call("cat_file", self._key(key))
        except FileNotFoundError:
            return None
        return content

    def put(self, contents: Mapping[str, bytes]) -> None:
        """Replace objects, side by side."""
        self._call("pipe", {self._key(key): content for key, content in contents.items()})

    def keys(self) -> set[str]:
        """Names of all objects."""
        return {name.removeprefix(self._key("")) for name in self._call("find", self._key(""))}

    def _key(self, key: str) -> str:
        return f"{self._call('_strip_protocol', self.address)}/{key}"

    def _call(self, name: str, *arguments: Any) -> Any:
        """Call a method of the file system; what goes wrong is an `OSError`."""
        import fsspec  # which stores in folders do without

        try:
            scheme = self.address.partition("://")[0]
            return getattr(fsspec.filesystem(scheme, **_OPTIONS), name)(*arguments)
        except OSError:
            raise
        except Exception as error:
            raise OSError(f"{self.address}: {error}") from error


# With more, each read of an object would begin with a request for its size.
_OPTIONS = {"use_listings_cache": False, "max_concurrency": 1}


StorePlace = Folder | Bucket
"""Files of a store by their keys; what goes wrong is an `OSError`."""


def place_of(path: PathLike) -> StorePlace:
    """Place of a store; raises a `StoreError` for a path that cannot be one."""
    address = os.fspath(path)
    if "://" in address:
        return Bucket(address.rstrip("/"))
    no_path = StoreError(
        f"{address}: a store is a local folder, or an address such as s3://a/b.zarr"
    )
    if "\0" in address:
        raise no_path
    try:
        folder = Path(os.path.realpath(user_path(address).absolute()))
    except UnicodeEncodeError:
        raise no_path from None
    except FileNotFoundError:
        raise StoreError(
            f"{address}: the folder that this process works in was deleted; go to another"
        ) from None
    if not folder.name:
        raise StoreError(f"{folder} cannot be a store; give a folder below it")
    return Folder(folder)


def require_writable(path: PathLike) -> None:
    """Refuse a place where no store can be made, before long work for it."""
    place = place_of(path)
    if isinstance(place, Bucket):
        return
    with writes(place):
        make_folder(place.path.parent)
        if not os.access(place.path.parent, os.W_OK):
            raise PermissionError("no permission to write to its folder")


@contextmanager
def writes(place: StorePlace, advice: str = "") -> Iterator[None]:
    """Turn an `OSError` into a `StoreError` that says why a place cannot be written."""
    try:
        yield
    except OSError as error:
        above = place.path.parents if isinstance(place, Folder) else ()
        in_the_way = (f"{folder} is a file, not a folder" for folder in above if folder.is_file())
        reason = next(in_the_way, error.strerror or error)
        is_within = str(error.filename).startswith(f"{place}/")
        file = error.filename if is_within else place
        raise StoreError(f"{file} cannot be written: {reason}{advice}") from error


@contextmanager
def reaches(place: StorePlace) -> Iterator[None]:
    """Turn an `OSError` into a `StoreError` that says which file cannot be read, and why."""
    try:
        yield
    except OSError as error:
        if is_lack_of_memory(error):
            raise
        file = error.filename if isinstance(error.filename, str) else place
        raise StoreError(
            f"{file} cannot be read: {error.strerror or error}; see to its permissions or its "
            "disk, then repeat the command"
        ) from error


@contextmanager
def decodes(place: StorePlace, name: str) -> Iterator[None]:
    """Turn an error of Zarr or its codecs into a `DamagedError` that names what they read."""
    try:
        yield
    except (RuntimeError, ValueError, DamagedError) as error:
        if is_lack_of_memory(error):  # nothing is damaged
            raise
        raise DamagedError(damaged(place, name)) from error


@contextmanager
def reads(place: StorePlace, name: str) -> Iterator[None]:
    """Turn errors of data into a `DamagedError`, or a `StoreError` if nobody can read them now."""
    with reaches(place), decodes(place, name):
        yield


def damaged(place: StorePlace, name: str) -> str:
    """Message that data of a store cannot be read."""
    return f"{place}: {name} cannot be read; irg verify names what is damaged; {remedy(place)}"


def remedy(place: StorePlace) -> str:
    """What to do about a store that is damaged."""
    if isinstance(place, Bucket):  # whose points no run reads again
        return "write to another store"
    return "irg run with its scene makes it sound again"


def is_lack_of_memory(error: BaseException) -> bool:
    """True for an error by which Python reports that memory has run out."""
    if isinstance(error, OSError):
        return error.errno in (errno.ENOMEM, errno.EAGAIN)
    said = ("start new thread", "failed to map segment", "annot allocate memory")
    return isinstance(error, MemoryError) or any(words in str(error) for words in said)
