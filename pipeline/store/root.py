"""The root of a store: what its last commit says, kept safe by a hash and a copy.

``zarr.json`` has the attributes, and the metadata of every array, and is replaced at one stroke.
A hash over all of that tells whether it is whole; a copy lies beside the statuses, from which a
root that was lost or damaged is restored.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from pipeline.store.begun import is_begun
from pipeline.store.folder import ROOT, Place, StoreError, read_json, sync, write_json
from pipeline.store.layout import faults_of
from pipeline.store.variables import FORMAT, HASHED

_PAUSES = (0.1, 0.3, 1.0)  # [s] after which to look again for a copy that is being renewed
COPY = "root.json"
"""Name of the copy of the root, in the folder of the statuses."""

_CONSOLIDATED = "consolidated_metadata"
_HASH = "root_hash"


class DamagedRootError(StoreError):
    """A store whose root is lost or damaged, but may be restored."""


def begin(folder: Place) -> bool:
    """Make a folder for a new store, unless there is a store; say whether it is new.

    Raises
    ------
    StoreError
        If there is something else, or a store that cannot be read.
    """
    if not folder.exists():
        if isinstance(folder, Path):
            real = Path(os.path.realpath(folder))  # behind a link that leads nowhere yet
            real.mkdir()
            sync(real.parent)
        return True
    if not folder.is_dir():
        raise StoreError(f"{folder} is a file, not a store; give a folder that is not there yet")
    if is_begun(folder):
        return True
    read_metadata(folder)
    return False


def read_metadata(folder: Place) -> tuple[dict[str, Any], dict[str, Any]]:
    """Attributes of a store, and the metadata of each array, as of the last commit.

    Raises
    ------
    StoreError
        If there is no store, or it cannot be read.
    DamagedRootError
        If its root is lost or damaged.
    """
    try:
        root = read_json(folder / ROOT)
    except (FileNotFoundError, NotADirectoryError):
        if copy_of(folder) is not None:
            raise DamagedRootError(f"{folder} has lost its {ROOT}; {_REMEDY}") from None
        if folder.is_dir() and any(folder.iterdir()):
            if is_begun(folder):
                raise StoreError(
                    f"{folder} was not created completely; run the sweep again"
                ) from None
            if (folder / "status").is_dir():
                raise StoreError(
                    f"{folder} has lost its {ROOT}, and there is no copy to restore it from; take "
                    "it from a backup, or write to another store"
                ) from None
        if not folder.exists():
            raise StoreError(f"{folder} does not exist; give a store that irg run made") from None
        if isinstance(folder, Path) and folder.is_file():
            raise StoreError(
                f"{folder} is a file, not a store; give a folder that irg run made"
            ) from None
        raise StoreError(
            f"{folder} is not a store: there is no {ROOT}; give a folder that irg run made, or to "
            "run a scene into, one that is not there yet"
        ) from None
    except OSError as error:
        file = folder / ROOT
        if isinstance(file, Path) and file.exists() and not file.is_file() and copy_of(folder):
            raise DamagedRootError(f"{folder}: {ROOT} is not a file; {_REMEDY}") from None
        raise StoreError(f"{folder} cannot be read: {error.strerror or error}") from error
    except (ValueError, RecursionError):
        root = {}
    if (version := _version(root)) > FORMAT:
        raise StoreError(
            f"{folder} has format {version}, of a newer version of this program; this one reads "
            f"formats up to {FORMAT}: update it"
        )
    if (fault := _fault(root)) is None:
        return root["attributes"], root[_CONSOLIDATED]["metadata"]
    if copy_of(folder) is not None:
        raise DamagedRootError(f"{folder}: {ROOT} is damaged: {fault}; {_REMEDY}")
    raise StoreError(
        f"{folder} is not the store of a sweep, or its {ROOT} is damaged: {fault}; there is no "
        "copy of it to restore it from"
    )


_REMEDY = "irg verify --repair restores it"


def commit_metadata(folder: Place, attributes: dict[str, Any], arrays: Mapping[str, Any]) -> None:
    """Replace attributes and the metadata of all arrays at one stroke."""
    attributes["revision"] = attributes.get("revision", 0) + 1
    if attributes["format"] >= HASHED:
        attributes[_HASH] = hash_of(attributes, arrays)
    root = {
        "zarr_format": 3,
        "node_type": "group",
        "attributes": attributes,
        _CONSOLIDATED: {"kind": "inline", "must_understand": False, "metadata": arrays},
    }
    write_json(folder / ROOT, root)
    renew_copy(folder)


def renew_copy(folder: Place) -> None:
    """Bring the copy of the root up to date."""
    root = read_json(folder / ROOT)
    if _HASH in root["attributes"] and root != copy_of(folder):
        write_json(folder / "status" / COPY, root)


def has_copy(folder: Place) -> bool:
    """Whether there is a copy of the root, and it is up to date, or soon after.

    Whoever commits a root renews the copy next.
    """
    for pause in _PAUSES:
        if copy_of(folder) == read_json(folder / ROOT):
            return True
        time.sleep(pause)
    return copy_of(folder) == read_json(folder / ROOT)


def restore_root(folder: Place) -> None:
    """Restore the root from its copy.

    Raises
    ------
    StoreError
        If there is no intact copy.
    """
    if (copy := copy_of(folder)) is None:
        raise StoreError(f"{folder}: there is no copy of {ROOT} to restore it from")
    write_json(folder / ROOT, copy)


def copy_of(folder: Place) -> dict[str, Any] | None:
    """The copy of the root, if there is an intact one."""
    with suppress(OSError, ValueError, RecursionError):
        copy = read_json(folder / "status" / COPY)
        if _fault(copy) is None and _HASH in copy["attributes"]:
            return copy
    return None


def _version(root: Any) -> int:
    """Format of a store, as far as its root tells."""
    try:
        return int(root["attributes"]["format"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return 0


def _fault(root: Any) -> str | None:
    """What is wrong with a root, if anything is."""
    try:
        attributes, arrays = root["attributes"], root[_CONSOLIDATED]["metadata"]
        if (attributes["format"] >= HASHED or _HASH in attributes) and (
            attributes.get(_HASH) != hash_of(attributes, arrays)
        ):
            return "it is not what was committed"
        return next(faults_of(attributes, arrays), None)
    except (KeyError, TypeError, AttributeError, ValueError, RecursionError):
        return "it is not what a sweep writes"


def hash_of(attributes: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
    """SHA-256 of what a root says, without the hash itself."""
    hashed = {name: value for name, value in attributes.items() if name != _HASH}
    return hashlib.sha256(json.dumps([hashed, arrays], sort_keys=True).encode()).hexdigest()
