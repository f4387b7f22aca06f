"""Paths of stores, which are folders of a disk, and their errors.

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
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pipeline.paths import require_path, user_path
from tribo import TriboError

PathLike = str | os.PathLike[str]
ROOT = "zarr.json"
"""Key of the metadata of a group; for an array, below its name."""
NEW, OLD, LOCK = ".irg-new", ".irg-old", ".irg-lock"
"""Endings of paths next to a store: its successor, its predecessor, and its lock."""
REMEDY = "irg run repairs it with the same scene"
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


MEMORY = Path(os.devnull) / "memory"
"""Path of stores in the memory of this process, where single points are computed."""
_SUFFIXES_OF_FILES = {
    ".nc", ".nc4", ".cdf", ".h5", ".hdf5", ".he5", ".csv", ".txt", ".json", ".xlsx", ".parquet",
    ".zip", ".toml", ".npy", ".npz", ".mat", ".png", ".pdf", ".svg", ".html", ".md",
}  # fmt: skip


def location_of(path: PathLike | None) -> Path:
    """Folder of a store from its path; ``file://PATH`` is a path, too. None is `MEMORY`.

    Raises a `StoreError` for another address and for the root of a file system.
    """
    if path is None:
        return MEMORY
    require_path(path)
    address = os.fspath(path).removeprefix("file://")
    if "://" in address:
        raise StoreError(f"{address} is not a folder; copy the store to a disk, and give its path")
    folder = Path(os.path.realpath(user_path(address).absolute()))
    if not folder.name:
        raise StoreError(f"{folder} cannot be a store; choose a folder below it")
    if folder.suffix.lower() in _SUFFIXES_OF_FILES and not folder.exists():
        raise StoreError(
            f"{folder} cannot be a store, which is a Zarr folder; give a name such as "
            f"{folder.stem}.zarr"
        )
    return folder


def sibling(location: Path, ending: str) -> Path:
    """Path next to a store with an `ending`: `NEW`, `OLD` or `LOCK`."""
    return location.with_name(location.name + ending)


@contextmanager
def io_errors(location: Path, verb: str = "read") -> Iterator[None]:
    """Context manager: turn an error of the disk into a `StoreError`.

    Its message says that the file or `location` cannot be read, or "written" if that is `verb`.
    """
    try:
        yield
    except OSError as error:
        if is_lack_of_memory(error):
            raise
        file, reason = error.filename, error.strerror or error
        raise StoreError(
            f"{file or location} cannot be {verb}: {reason}; finished points are saved. Check free "
            "space, permissions and the disk, then repeat the command"
        ) from error


@contextmanager
def read_errors(location: Path, name: str) -> Iterator[None]:
    """Context manager: turn errors of reading the variable `name` from a store into store errors.

    Bad data raise a `DamagedError`, errors of the disk a `StoreError`.
    """
    with io_errors(location):
        try:
            yield
        except (RuntimeError, ValueError, DamagedError) as error:
            if is_lack_of_memory(error):  # not damage
                raise
            raise damaged(location, name) from error


def damaged(location: Path, name: str, problem: str = "cannot be read") -> DamagedError:
    """Error that the data `name` of a store are damaged."""
    return DamagedError(f"{location}: {name} {problem}; irg verify names what is damaged; {REMEDY}")


def is_lack_of_memory(error: BaseException) -> bool:
    """True if an error means that memory has run out."""
    if isinstance(error, OSError):
        return error.errno in (errno.ENOMEM, errno.EAGAIN)
    phrases = ("start new thread", "failed to map segment", "annot allocate memory")
    return isinstance(error, MemoryError) or any(words in str(error) for words in phrases)
