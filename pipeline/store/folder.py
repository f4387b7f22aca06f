"""Where stores lie, in folders or in an object store, and how their files are read and replaced.

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
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pipeline.store.lock import HeldError, hold, holder
from pipeline.store.remote import SCHEME, Remote
from pipeline.store.variables import FORMAT, VARIABLES
from tribo import TriboError

__all__ = [
    "DAMAGED",
    "ROOT",
    "UNREADABLE",
    "PathLike",
    "Place",
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

PathLike = str | os.PathLike[str] | Remote
Place = Path | Remote
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
    return Path(address).absolute()


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


def begin(folder: Place) -> bool:
    """Make a folder for a new store, unless there is a store; say whether it is new.

    A store is new until it has a root, so a creation that was cut short begins again. A folder
    with anything else in it is left alone.
    """
    if folder.exists():
        if not folder.is_dir():
            raise StoreError(f"{folder} is a file, not a store")
        if not _is_begun(folder):
            _read_root(folder)
            if isinstance(folder, Path):
                for left in folder.rglob("*.partial"):  # by a process that was killed
                    left.unlink(missing_ok=True)
            return False
    if isinstance(folder, Path):
        folder.mkdir(exist_ok=True)
    return True


def _is_begun(folder: Place) -> bool:
    """Whether a folder holds what comes before the root of a store, and nothing else."""
    return all(
        entry.suffix == ".partial" or (entry.is_dir() and entry.name in VARIABLES)
        for entry in folder.iterdir()
    )


def _read_root(folder: Place) -> dict[str, Any]:
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
        raise StoreError(f"{folder} cannot be read: {error.strerror or error}") from error
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


def read_metadata(folder: Place) -> tuple[dict[str, Any], dict[str, Any]]:
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


def commit_metadata(
    folder: Place, attributes: Mapping[str, Any], arrays: Mapping[str, Any]
) -> None:
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


def read_json(file: Place) -> dict[str, Any]:
    """Read a JSON object."""
    document: dict[str, Any] = json.loads(file.read_bytes())
    return document


def write_json(file: Place, document: Mapping[str, Any]) -> None:
    """Replace a file at one stroke, and see it on the disk."""
    content = json.dumps(document, indent=1, allow_nan=False).encode()
    if isinstance(file, Remote):
        file.write_bytes(content)
        return
    partial = file.with_name(file.name + ".partial")
    partial.write_bytes(content)
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
