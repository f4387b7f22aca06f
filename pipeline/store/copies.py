"""Recover a store from the copies that a killed run left, or without its root."""

from __future__ import annotations

import shutil
from contextlib import suppress
from dataclasses import replace

from pipeline.progress import Progress, Report, silent
from pipeline.store.files import PARTIAL, sync
from pipeline.store.location import (
    NEW,
    OLD,
    ROOT,
    DamagedError,
    Folder,
    Location,
    PathLike,
    io_errors,
    location_of,
)
from pipeline.store.resume import join
from pipeline.store.root import FACTS, Root, find_root, has_results, restored_root
from pipeline.store.schema import INPUTS
from pipeline.store.status import Verification, verified
from pipeline.store.store import Store
from pipeline.sweep.sweep import Sweep


def find_sweep(path: PathLike) -> Sweep | None:
    """Read the sweep that a run continues; None if there is none, `StoreError` for other content.

    A store that a run has to restore has none yet. If a growth was cut short between its renames,
    the sweep is that of a copy.
    """
    location = location_of(path)
    with suppress(DamagedError):
        if root := find_root(location):
            return root.sweep
    copies = map(location.sibling, (NEW, OLD)) if isinstance(location, Folder) else ()
    for copy in copies:
        with suppress(DamagedError):
            if root := _root_of_copy(copy):
                return root.sweep
    return None


def keep_best_copy(location: Folder, sweep: Sweep, progress: Report) -> None:
    """Of the copies that a killed run left, keep the one with most sound points at `location`.

    A copy is deleted only if it was read, or if another one that has no damage stays.
    """
    new, old = location.sibling(NEW), location.sibling(OLD)
    verifications, fault = dict[Folder, Verification](), None
    for copy in (location, new, old) if new.path.exists() or old.path.exists() else ():
        try:
            if root := _root_of_copy(copy, sweep):
                verifications[copy] = verified(Store(copy, root, may_be_damaged=True))
        except DamagedError as error:
            fault = error
    # The first of equal copies, which is `location` if it is among them.
    best = max(verifications, key=lambda copy: _count(verifications[copy]), default=location)
    if fault and not (best in verifications and verifications[best].is_clean):
        raise fault
    with io_errors(location, "written"):
        if best != location:
            spare = new if best == old else old
            remove_folder(spare)
            if location.path.exists():
                location.path.rename(spare.path)
            best.path.rename(location.path)
            sync(location.path.parent)
            progress(Progress(f"{location} was restored from {best}, left by an interrupted run"))
        for copy in (new, old):
            remove_folder(copy)
        for file in [*location.path.rglob(f"*{PARTIAL}")]:
            file.unlink()


def _root_of_copy(copy: Folder, sweep: Sweep | None = None) -> Root | None:
    """Root of a store or a copy of it; None without its root's documents or any results.

    Raises a `DamagedError` if it cannot be read, not even with the scene of its points.
    """
    with io_errors(copy):
        keys = copy.keys()
    if not {FACTS, ROOT} & keys or not has_results(keys):
        return None
    return root_or_restored(copy, sweep, silent) if sweep else find_root(copy)


def _count(verification: Verification) -> int:
    """Number of points of plane and tests that are done and intact."""
    return verification.done + (_count(verification.tests) if verification.tests else 0)


def root_or_restored(location: Location, sweep: Sweep, progress: Report) -> Root | None:
    """Root of a store; if both of its documents are lost, that of a scene with the same points.

    Raises the `DamagedError` of the root if the scene disagrees with any array or done point.
    """
    try:
        return find_root(location)
    except DamagedError:
        root = restored_root(location, join(None, sweep))
        if root is None:
            raise
        verification = verified(Store(location, root, may_be_damaged=True))
        # Input arrays can be written again, because the scene has them.
        sound_inputs = replace(verification, shared=tuple({*verification.shared} - {INPUTS}))
        if not sound_inputs.is_clean:
            raise
        progress(Progress(f"the root of {location} is lost; it is restored from the scene"))
        return root


def remove_folder(copy: Folder) -> None:
    """Delete a folder, its root first: after a kill, what is left of it is no store."""
    if copy.path.exists():
        for key in (FACTS, ROOT):
            (copy.path / key).unlink(missing_ok=True)
        shutil.rmtree(copy.path)
