"""Differences between two stores."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.boundary import boundary
from pipeline.analysis.dataset import Layout, require_kind, require_one_scene
from pipeline.analysis.outcomes import outcomes
from pipeline.analysis.reading import results
from pipeline.analysis.results import Results
from pipeline.analysis.tables import frame_of
from pipeline.scene.written import differing_entries
from pipeline.store.place import PathLike
from pipeline.store.schema import DONE, FAILED, PENDING, PLANE
from pipeline.sweep.laws import LawError
from pipeline.sweep.shown import shown
from tribo import InputError

_STATES = {DONE: "done", FAILED: "failed"}


@shown
@dataclass(frozen=True, slots=True)
class Difference:
    """Differences between two stores A and B, as data frames: entries, boundary and points."""

    entries: pd.DataFrame  #: Entries of the scenes that differ: ``entry``, ``a``, ``b``.
    #: Critical velocities at loads of both stores, each store under its own conditions: ``load
    #: [N]``, ``a [m/s]``, ``b [m/s]``, ``change [%]``, ``outcome a`` and ``outcome b``. With
    #: several surfaces they are medians. The frame is empty if no boundary is found.
    boundary: pd.DataFrame
    #: Points that are done in only one store or have different rises: ``load [N]``, ``velocity
    #: [m/s]``, ``variant``, ``state a``, ``state b``, ``rise a [K]``, ``rise b [K]``, ``change
    #: [%]``. A rise is the highest in the contact at the end of the point's simulation,
    #: per unit friction coefficient.
    points: pd.DataFrame
    alike: int  #: Number of points that are done in both stores with equal rises.


@np.errstate(under="ignore")
def diff(a: xr.Dataset | PathLike, b: xr.Dataset | PathLike) -> Difference:
    """Find the differences between two stores.

    Parameters
    ----------
    a, b : Dataset, str or path
        Datasets of `pipeline.open_sweep` or `pipeline.at`, or paths of stores.

    Returns
    -------
    Difference
        Data frames of entries that differ, critical velocities at common loads, and points that
        differ.

    Raises
    ------
    StoreError
        If there is no readable store.
    InputError
        If a store has several scenes, or lists pairs of load and velocity.

    Examples
    --------
    >>> import pipeline
    >>> store = "results/first_try.zarr"
    >>> pipeline.diff(store, store).boundary["change [%]"].to_list()
    [0.0, 0.0, 0.0, 0.0]
    """
    first, second = results(a), results(b)
    for data in (first, second):
        require_kind(data.kind, Layout.PLANE)
        require_one_scene(data.entry_dims)
        data.require_lists(*PLANE)
    points, alike = _differing_points(first, second)
    rows = differing_entries(first.sweep, second.sweep)  # in the order of the scene
    entries = frame_of(("entry", "a", "b"), ((path, x or None, y or None) for path, x, y in rows))
    return Difference(entries, _boundary(first, second), points, alike)


def _boundary(a: Results, b: Results) -> pd.DataFrame:
    """Frame of critical velocities at common loads; empty if there is no boundary."""
    heads = "load [N]", "a [m/s]", "b [m/s]", "change [%]", "outcome a", "outcome b"
    try:
        first, second = (_critical_velocities(data) for data in (a, b))
    except LawError:
        raise
    except InputError:  # no critical temperature
        return frame_of(heads, ())
    both = pd.merge(first, second, on="load", suffixes=(" a", " b"))
    change = both["velocity b"] / both["velocity a"] - 1
    columns = both["load"], both["velocity a"], both["velocity b"], change
    return frame_of(heads, zip(*columns, both["outcome a"], both["outcome b"], strict=True))


def _critical_velocities(data: Results) -> pd.DataFrame:
    """Frame of critical velocity [m/s], NaN where there is none, and outcome, by load."""
    found, meanings = boundary(data), outcomes("velocity")
    outcome = [meanings[code] for code in found["outcome_at_load"].values.tolist()]
    velocities, loads = found["critical_velocity"].values, found["load"].values
    return pd.DataFrame({"load": loads, "velocity": velocities, "outcome": outcome})


def _differing_points(a: Results, b: Results) -> tuple[pd.DataFrame, int]:
    """Frame of points that differ or are done in one store only, and the number of equal points."""
    heads = (
        "load [N]", "velocity [m/s]", "variant", "state a", "state b", "rise a [K]", "rise b [K]",
        "change [%]",
    )  # fmt: skip
    has_seeds = any("realization" in data.front for data in (a, b))
    place = ["load", "velocity", "variant"]
    states = (_point_states(data, has_seeds) for data in (a, b))
    both = pd.merge(*states, on=place, how="outer", suffixes=(" a", " b"))
    both = both.fillna({"state a": "absent", "state b": "absent"})
    is_done = both[["state a", "state b"]] == "done"
    is_alike = is_done.all(axis=1) & (both["rise a"] == both["rise b"])
    both["change"] = (both["rise b"] / both["rise a"] - 1).where(both["rise a"] != 0)
    names = [*place, "state a", "state b", "rise a", "rise b", "change"]
    rows = both.loc[is_done.any(axis=1) & ~is_alike, names]
    return frame_of(heads, rows.itertuples(index=False, name=None)), int(is_alike.sum())


def _point_states(data: Results, has_seeds: bool) -> pd.DataFrame:
    """Frame of points that are done or asked for: place, seed as text, state, highest rise [K]."""
    data.require("max_rise")
    values = {
        "status": data.columns["status"],
        "asked": data.asked,
        "rise": data.columns["max_rise"][..., -1],
    }
    axes = {"load": data.loads, "velocity": data.velocities}
    own = {name: axis for name, axis in axes.items() if name not in data.rows.coords}
    shape = *(data.rows.sizes[name] for name in data.front), *map(len, own.values())
    dims, in_front = [*data.front, *own], [*data.front]
    points = xr.Dataset(
        {name: (dims, np.reshape(one, shape)) for name, one in values.items()},
        {**data.rows.coords, **own},
    )
    frame = points.to_dataframe().reset_index()
    if in_front:
        frame["variant"] = frame[in_front].astype(str).agg(", ".join, axis="columns")
    else:
        seed = str(getattr(data.sweep.scene.roughness, "seed", None))
        frame["variant"] = seed if has_seeds else None
    frame["state"] = frame["status"].map(_STATES).fillna("pending")
    here = (frame["status"] != PENDING) | frame["asked"]
    return frame.loc[here, ["load", "velocity", "variant", "state", "rise"]]
