"""What users ask of a store, its progress, and its damage."""

from __future__ import annotations

from pipeline.store.place import PathLike, place_of
from pipeline.store.progress import Summary, summary_of
from pipeline.store.root_file import read_root
from pipeline.store.verify import Verification, verified
from pipeline.store.write import Store, opened
from pipeline.sweep.model import Sweep
from pipeline.sweep.stages import Report, silent


def summary(path: PathLike) -> Summary:
    """Count the points of a store by state, and those with warnings, without reading results.

    Parameters
    ----------
    path : str or path
        Folder or address of the store.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> summary = pipeline.summary("results/first_try.zarr")
    >>> summary.done, summary.pending, summary.failed
    (24, 0, ())
    """
    return states(path)[0]


def states(path: PathLike) -> tuple[Summary, Sweep]:
    """Progress of a store, and its sweep."""
    store = opened(path)
    return summary_of(store), store.sweep


def verify_store(path: PathLike, progress: Report | None = None) -> Verification:
    """Check a whole store for damage; nothing is written.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use.
    progress : callable, optional
        Called now and then with a `Progress` that counts chunks of points.

    Raises
    ------
    StoreError
        If there is no readable store, or one of its files cannot be read now.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.damaged, verification.is_clean
    (24, (), True)
    """
    place = place_of(path)
    store = Store(place, read_root(place), is_damaged=True)
    return verified(store, progress or silent)
