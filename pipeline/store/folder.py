"""Where stores lie, in folders or in an object store, and how their files are read and replaced.

::

    TriboError
    └── StoreError               no store, not readable, not writable or in use
        └── StoreMismatchError   the store of another scene
"""

from __future__ import annotations

import json
import os
import uuid
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pipeline.store import parts
from pipeline.store.lock import HeldError, hold, holder
from pipeline.store.remote import SCHEME, Remote
from tribo import TriboError

PathLike = str | os.PathLike[str] | Remote
Place = Path | Remote
ROOT = "zarr.json"
"""Name of the file with the metadata of a group or an array."""
PARTIAL = ".partial"
"""Ending of the names of files that are being written."""

UNREADABLE = (RuntimeError, ValueError, OSError)
"""What Zarr and its codecs raise on damaged chunks."""
DAMAGED = "{}: {} cannot be read; irg verify names what is damaged, and repairs it with --repair"


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


def folder_of(path: PathLike) -> Place:
    """The folder of a store, the same for processes that run elsewhere."""
    if isinstance(path, Remote):
        return path
    address = os.fspath(path)
    if address.startswith(SCHEME):
        if find_spec("s3fs") is None:
            raise StoreError(f"{address}: this needs pip install 'irg-transition[s3]'")
        return Remote(address.rstrip("/"))
    if "://" in address:
        raise StoreError(f"{address}: a store is a local folder or an {SCHEME} address")
    try:
        return Path(address).absolute()
    except FileNotFoundError:
        raise StoreError(
            f"{address}: the folder that this process works in was deleted; go to another"
        ) from None


@contextmanager
def locked(path: PathLike) -> Iterator[None]:
    """Be the only one to run a sweep into a store.

    Raises
    ------
    StoreError
        If another process is doing so, or the place cannot be written to.
    """
    folder = folder_of(path)
    with ExitStack() as stack:
        try:
            stack.enter_context(hold(_lock_of(folder)))
        except HeldError as error:
            raise StoreError(
                f"{folder} is in use by {error}; wait for it, or write to another store"
            ) from None
        except OSError as error:
            above = folder.parents if isinstance(folder, Path) else ()
            in_the_way = (f"{each} is a file, not a folder" for each in above if each.is_file())
            reason = next(in_the_way, error)
            raise StoreError(f"{folder} cannot be written: {reason}") from error
        yield
        if isinstance(folder, Path):
            parts.remove_unused(_lock_of_parts(folder))


@contextmanager
def part_held(folder: Place, part: tuple[int, ...] | None = None) -> Iterator[None]:
    """Be the only one to write to the chunks of some points, or of all.

    Raises
    ------
    StoreError
        If another process does so without an end, or there are no such locks.
    OSError
        If the place cannot be written to.
    """
    if isinstance(folder, Remote):
        raise StoreError(
            f"{folder} has chunks that several points share, which cannot be written safely in an "
            "object store; irg run gives each point chunks of its own first"
        )
    with ExitStack() as stack:
        try:
            stack.enter_context(parts.hold_part(_lock_of_parts(folder), part))
        except parts.StuckError as error:
            raise StoreError(
                f"{folder} cannot be written: {error} has been writing the same chunks for "
                f"{parts.PATIENCE:g} s; continue or end it if it is stopped, and run again: what "
                "is finished is safe"
            ) from None
        yield


def has_parts(folder: Place) -> bool:
    """Whether the parts of a store at this place can be held."""
    return isinstance(folder, Path) and parts.has_locks(_lock_of_parts(folder))


def user(path: PathLike) -> str | None:
    """Tell which process runs a sweep into a store, if one does."""
    return holder(_lock_of(folder_of(path)))


def _lock_of(folder: Place) -> Place:
    """The lock of a store, the same by whatever path it is reached."""
    if isinstance(folder, Path):
        folder = Path(os.path.realpath(folder))
        if not folder.name:
            raise StoreError(f"{folder} cannot be a store; give a folder below it")
    return folder.with_name(folder.name + ".lock")


def _lock_of_parts(folder: Path) -> Path:
    real = Path(os.path.realpath(folder))
    return real.with_name(f"{real.name}.lock.parts")


def read_json(file: Place) -> dict[str, Any]:
    """Read a JSON object; raise an `OSError` or a `ValueError` if there is none."""
    if isinstance(file, Path) and file.exists() and not file.is_file():
        raise OSError(f"{file} is not a file")
    document = json.loads(file.read_bytes())
    if not isinstance(document, dict):
        raise ValueError(f"{file} does not hold an object")
    return document


def as_json(document: Mapping[str, Any]) -> bytes:
    """Write a JSON object, on one line: Python takes ten times as long to indent it."""
    return json.dumps(document, allow_nan=False).encode()


def write_json(file: Place, document: Mapping[str, Any]) -> None:
    """Replace a file at one stroke, and wait until it is on the disk."""
    content = as_json(document)
    if isinstance(file, Remote):
        file.write_bytes(content)
        return
    partial = file.with_name(f"{file.name}.{uuid.uuid4().hex}{PARTIAL}")
    try:
        partial.write_bytes(content)
        sync(partial)
        rename(partial, file)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    sync(file.parent)


def rename(partial: Path | str, file: Path | str) -> None:
    """Give a file its name, in place of an empty folder as well."""
    try:
        os.replace(partial, file)  # noqa: PTH105
    except IsADirectoryError:
        os.rmdir(file)  # noqa: PTH106
        os.replace(partial, file)  # noqa: PTH105


def sync(file: Path | str) -> None:
    """Wait until a file or folder is on the disk."""
    descriptor = os.open(file, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
