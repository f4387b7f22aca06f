"""Where stores lie, so far in local folders, and how their files are read and replaced.

::

    TriboError
    └── StoreError               no store, not readable, not writable or in use
        └── StoreMismatchError   the store of another scene
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from pipeline.layout import FORMAT, VARIABLES
from pipeline.lock import HeldError, hold, holder
from tribo import TriboError

__all__ = [
    "DAMAGED",
    "ROOT",
    "UNREADABLE",
    "PathLike",
    "StoreError",
    "StoreMismatchError",
    "begin",
    "commit_metadata",
    "folder_of",
    "locked",
    "read_json",
    "read_metadata",
    "sync",
    "user",
    "write_json",
]

PathLike = str | os.PathLike[str]
_METADATA = "consolidated_metadata"
ROOT = "zarr.json"
"""Name of the file with the metadata of a group or an array."""

UNREADABLE = (RuntimeError, ValueError, OSError)
"""What Zarr and its codecs raise on damaged chunks."""
DAMAGED = "{}: {} cannot be read; irg verify names what is damaged, and repairs it with --repair"


class StoreError(TriboError):
    """A store that is missing, not readable, not writable or in use."""


class StoreMismatchError(StoreError):
    """A store that belongs to another scene."""


def folder_of(path: PathLike) -> Path:
    """The folder of a store, the same for processes that run elsewhere."""
    if "://" in os.fspath(path):
        raise StoreError(f"{path}: so far a store is a local folder, not a URL")
    return Path(path).absolute()


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
            folder.parent.mkdir(parents=True, exist_ok=True)
            stack.enter_context(hold(folder.with_name(folder.name + ".lock")))
        except HeldError as error:
            raise StoreError(
                f"{folder} is in use by {error}; wait for it, or write to another store"
            ) from None
        except OSError as error:
            raise StoreError(f"{folder} cannot be written: {error}") from error
        yield


def user(path: PathLike) -> str | None:
    """Tell which process runs a sweep into a store, if one does."""
    folder = folder_of(path)
    return holder(folder.with_name(folder.name + ".lock"))


def begin(folder: Path) -> bool:
    """Make a folder for a new store, unless there is a store; say whether it is new.

    A store is new until it has a root, so a creation that was cut short begins again. A folder
    with anything else in it is left alone.
    """
    if folder.exists():
        if not folder.is_dir():
            raise StoreError(f"{folder} is a file, not a store")
        if not _is_begun(folder):
            _read_root(folder)
            for left in folder.rglob("*.partial"):  # by a process that was killed
                left.unlink(missing_ok=True)
            return False
    folder.mkdir(exist_ok=True)
    return True


def _is_begun(folder: Path) -> bool:
    """Whether a folder holds what comes before the root of a store, and nothing else."""
    return all(
        entry.suffix == ".partial" or (entry.is_dir() and entry.name in VARIABLES)
        for entry in folder.iterdir()
    )


def _read_root(folder: Path) -> dict[str, Any]:
    """Read the ``zarr.json`` of a store, if it is one of a format known here.

    Raises
    ------
    StoreError
        If it is not, or cannot be read.
    """
    try:
        root = read_json(folder / ROOT)
        version = int(root["attributes"]["format"])
    except (FileNotFoundError, NotADirectoryError):
        if folder.is_dir() and any(folder.iterdir()) and _is_begun(folder):
            raise StoreError(f"{folder} was not created completely; run the sweep again") from None
        raise StoreError(f"{folder} is not a store: there is no {ROOT}") from None
    except OSError as error:
        raise StoreError(f"{folder} cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError):
        raise StoreError(
            f"{folder} is not the store of a sweep, or its {ROOT} is damaged"
        ) from None
    if version > FORMAT:
        raise StoreError(
            f"{folder} has format {version}, of a newer version of this program; this one reads "
            f"formats up to {FORMAT}"
        )
    return root


def read_metadata(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Attributes of a store, and the metadata of each array, as of the last commit.

    Raises
    ------
    StoreError
        If there is no store, or it is not complete.
    """
    root = _read_root(folder)
    try:
        return root["attributes"], root[_METADATA]["metadata"]
    except (KeyError, TypeError):
        raise StoreError(
            f"{folder} is not the store of a sweep, or its {ROOT} is damaged"
        ) from None


def commit_metadata(folder: Path, attributes: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
    """Replace attributes and the metadata of all arrays at one stroke."""
    consolidated = {"kind": "inline", "must_understand": False, "metadata": arrays}
    write_json(
        folder / ROOT,
        {
            "zarr_format": 3,
            "node_type": "group",
            "attributes": attributes,
            _METADATA: consolidated,
        },
    )


def read_json(file: Path) -> dict[str, Any]:
    """Read a JSON object."""
    document: dict[str, Any] = json.loads(file.read_bytes())
    return document


def write_json(file: Path, document: Mapping[str, Any]) -> None:
    """Replace a file at one stroke, and see it on the disk."""
    partial = file.with_name(file.name + ".partial")
    partial.write_text(json.dumps(document, indent=1, allow_nan=False))
    sync(partial)
    partial.replace(file)
    sync(file.parent)


def sync(file: Path) -> None:
    """Wait until a file or folder is on the disk."""
    descriptor = os.open(file, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
