"""Creates the store of a sweep, or opens it and makes room for what the sweep adds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pipeline.store.folder import (
    PathLike,
    StoreError,
    StoreMismatchError,
    folder_of,
    has_parts,
)
from pipeline.store.identity import describe, differences, stored_scene
from pipeline.store.layout import block_of
from pipeline.store.points import Store
from pipeline.store.root import begin, read_metadata, renew_copy
from pipeline.store.shape import commit_shape
from pipeline.store.variables import (
    POINTS_PER_CHUNK,
    grown,
    lasting_attributes,
)
from pipeline.sweep.model import Sweep
from tribo import QUANTILES


def prepare(path: PathLike, sweep: Sweep, shares: bool = True) -> Store:
    """Create the store of a sweep, or open it and make room for what the sweep adds.

    Call it while the store is `locked`. What is in the store stays, whether or not the sweep still
    asks for it, and what can be healed is healed.

    Parameters
    ----------
    path : str or path
        Path of the store.
    sweep : Sweep
    shares : bool
        Whether points of a new store may share chunks: whether all who write see the locks of each
        other.

    Raises
    ------
    StoreMismatchError
        If the store belongs to another scene; the message says how the two differ.
    StoreError
        If there is something else in its place, or it cannot be written.
    """
    folder = folder_of(path)
    try:
        if begin(folder):
            attributes, axes = lasting_attributes(sweep), grown({}, sweep)
            if shares and has_parts(folder):
                attributes[POINTS_PER_CHUNK] = block_of(len(sweep.loads), 3 if sweep.axis else 2)
            commit_shape(folder, attributes, {}, axes, sweep)
            return Store(folder)
        store = Store(folder)
        axes = store.axes
        name, _ = sweep.axis or (None, ())
        if fault := next(_other_axes(axes, name), None):
            raise StoreMismatchError(f"{folder} {fault}")
        if different := [
            *differences(stored_scene(store.attributes), describe(sweep)),
            *differences(axes["quantile"], list(QUANTILES), "quantile"),
        ]:
            reason = f"{folder} belongs to another scene; write to another store"
            raise StoreMismatchError("\n  ".join([reason, *different]))
        if other := next(_drawn_otherwise(axes, sweep), None):
            raise StoreMismatchError(
                f"{folder} has samples with other values of {other}: what is drawn of it follows "
                "from its place in [unknown] too; give its entries in the order that they had, new "
                "ones last, or write to another store"
            )
        renew_copy(folder)
        store.heal()
        commit_shape(folder, *read_metadata(folder), grown(axes, sweep), sweep)
        return Store(folder)
    except OSError as error:
        raise StoreError(f"{folder} cannot be written: {error}") from error


def _drawn_otherwise(axes: Mapping[str, Any], sweep: Sweep) -> Iterator[str]:
    """Inputs of which the samples of a store have other values than those of a sweep.

    Rounding differs from machine to machine.
    """
    if sweep.samples:
        columns = sweep.samples.columns
        for path in sweep.samples.simulated:
            known, wanted = zip(*zip(axes[path], columns[path], strict=False), strict=True)
            if not np.allclose(known, wanted, rtol=1e-9, atol=0.0):
                yield path


def _other_axes(axes: Mapping[str, Any], leading: str | None) -> Iterator[str]:
    """Say how what leads the dimensions of a store is not what the scene asks for."""
    for name, what in (("realization", "the seeds"), ("sample", "the number")):
        if name in axes and name != leading:
            yield (
                f"has an axis for sweep.{name}s, which the scene does not give; give {what} that "
                "are wanted, or write to another store"
            )
        if name not in axes and name == leading:
            yield (
                f"has no axis for sweep.{name}s, and the dimensions of a store stay what they were "
                "at its creation; write to another store"
            )
