"""Reads that are whole, however much a store is written to meanwhile."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from pipeline.store.folder import PathLike, StoreError
from pipeline.store.snapshot import Snapshot

_T = TypeVar("_T")
_S = TypeVar("_S", bound=Snapshot)
_ATTEMPTS = 20
_LOOKS = 3  # at what cannot be read, since a point may just be written anew
A_COMMIT = 0.1
"""Time in which a point is mostly committed [s]."""


def read_whole(
    path: PathLike, read: Callable[[_S], _T], opened: Callable[[PathLike], _S]
) -> tuple[_S, _T]:
    """Read from a snapshot of a store; again if the store or one of its points was being written.

    Returns
    -------
    Snapshot
        Snapshot that was current throughout.
    object
        Result of `read` on that snapshot.

    Raises
    ------
    StoreError
        If there is no readable store, or it changes all the time.
    """
    for attempt in range(_ATTEMPTS):
        snapshot = opened(path)
        try:
            found = read(snapshot)
        except StoreError:
            if snapshot.is_current():
                if attempt >= _LOOKS:
                    raise
                time.sleep(A_COMMIT)
            continue
        if snapshot.is_current():
            return snapshot, found
    raise StoreError(f"{path} is being rewritten all the time; try again when that has ended")
