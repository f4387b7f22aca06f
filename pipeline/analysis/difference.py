"""Differences between two stores: in their scenes, their boundaries and their points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.boundary import boundary, middle_of
from pipeline.analysis.dataset import (
    asked,
    attributes_of,
    dataset_of,
    end_of_point,
    require_one_scene,
    variant_of,
)
from pipeline.analysis.entries import entries_of
from pipeline.analysis.tables import as_dict, frame_of
from pipeline.analysis.transition import outcomes
from pipeline.store.place import PathLike
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.own_laws import OwnLawError
from tribo import InputError

_STATES = {DONE: "done", FAILED: "failed"}


@dataclass(frozen=True, slots=True)
class Difference:
    """Differences between two stores, A and B.

    Attributes
    ----------
    entries : DataFrame
        Entries of the scenes that differ: ``entry``, ``a``, ``b``.
    boundary : DataFrame
        Critical velocities at the loads that both have, medians over several surfaces, each under
        the conditions of its own scene: ``load [N]``, ``a [m/s]``, ``b [m/s]``, ``change [%]``,
        ``outcome a`` and ``outcome b``.
    points : DataFrame
        Points that are done in one store alone, or whose highest rises differ: ``load [N]``,
        ``velocity [m/s]``, ``variant``, ``state a``, ``state b``, ``rise a [K]``, ``rise b [K]``
        and ``change [%]``.
    alike : int
        Number of points that are done in both, with equal rises.

    Examples
    --------
    >>> import pipeline
    >>> difference = pipeline.diff("results/first_try.zarr", "results/first_try.zarr")
    >>> len(difference.entries), difference.alike
    (0, 24)
    """

    entries: pd.DataFrame
    boundary: pd.DataFrame
    points: pd.DataFrame
    alike: int

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        return {
            "entries": as_dict(self.entries),
            "boundary": as_dict(self.boundary),
            "points": as_dict(self.points),
            "points_alike": self.alike,
        }


def diff(
    a: xr.Dataset | PathLike,
    b: xr.Dataset | PathLike,
    criterion: str | None = None,
    own_laws: bool = False,
) -> Difference:
    """Find the differences between two stores.

    Parameters
    ----------
    a, b : Dataset, str or path
        Datasets of `pipeline.open_sweep`, or paths of stores.
    criterion, own_laws : optional
        Criterion of both in place of their own; see `pipeline.boundary`.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> store = "results/first_try.zarr"
    >>> pipeline.diff(store, store).boundary["change [%]"].to_list()
    [0.0, 0.0, 0.0, 0.0]
    """
    first, second = dataset_of(a), dataset_of(b)
    for ds in (first, second):
        require_one_scene(ds)
    points, alike = _points(first, second)
    crossings = _boundary(first, second, criterion=criterion, own_laws=own_laws)
    return Difference(_entries(first, second), crossings, points, alike)


def _entries(a: xr.Dataset, b: xr.Dataset) -> pd.DataFrame:
    """Entries that differ, in the order of the scene."""
    values = [entries_of(attributes_of(ds)) for ds in (a, b)]
    paths = dict.fromkeys([*values[0], *values[1]])
    rows = ((path, *(entries.get(path) for entries in values)) for path in paths)
    return frame_of(("entry", "a", "b"), (row for row in rows if row[1] != row[2]))


def _boundary(a: xr.Dataset, b: xr.Dataset, **criterion: Any) -> pd.DataFrame:
    """Critical velocities at the loads of both; none where wear is not judged."""
    heads = "load [N]", "a [m/s]", "b [m/s]", "change [%]", "outcome a", "outcome b"
    try:
        crossings = [_crossings(ds, **criterion) for ds in (a, b)]
    except OwnLawError:
        raise
    except InputError:  # no critical temperature, or samples, whose boundary is a probability
        return frame_of(heads, ())
    loads = sorted(crossings[0].keys() & crossings[1].keys())
    rows = []
    for load in loads:
        (first, of_a), (second, of_b) = (crossing[load] for crossing in crossings)
        rows.append((load, first, second, second / first - 1, of_a, of_b))
    return frame_of(heads, rows)


def _crossings(ds: xr.Dataset, **criterion: Any) -> dict[float, tuple[float, str]]:
    """Critical velocity and outcome at each load; over several surfaces the median."""
    boundaries = boundary(ds, **criterion)
    meanings, outcome = outcomes("velocity"), boundaries["outcome_at_load"]
    words = [
        ", ".join(meanings[code] for code in np.unique(codes))
        for codes in outcome.transpose("load", ...).values
    ]
    values = zip(middle_of(boundaries, "critical_velocity").values.tolist(), words, strict=True)
    return dict(zip(boundaries["load"].values.tolist(), values, strict=True))


def _points(a: xr.Dataset, b: xr.Dataset) -> tuple[pd.DataFrame, int]:
    """Points that are done in one alone or differ, and the number of those that are alike."""
    heads = (
        "load [N]", "velocity [m/s]", "variant", "state a", "state b", "rise a [K]", "rise b [K]",
        "change [%]",
    )  # fmt: skip
    has_seeds = any("realization" in ds.dims for ds in (a, b))
    states = [dict(_states(ds, has_seeds)) for ds in (a, b)]
    rows, alike = [], 0
    for place in sorted(
        {**states[0], **states[1]},
        key=lambda place: (*place[:2], -1 if place[2] is None else place[2]),
    ):
        (of_a, rise_a), (of_b, rise_b) = (state.get(place, ("absent", np.nan)) for state in states)
        if of_a == of_b == "done" and rise_a == rise_b:
            alike += 1
        elif "done" in (of_a, of_b):
            change = rise_b / rise_a - 1 if rise_a else np.nan
            rows.append((*place, of_a, of_b, rise_a, rise_b, change))
    return frame_of(heads, rows), alike


def _states(
    ds: xr.Dataset, has_seeds: bool
) -> Iterator[tuple[tuple[float, float, int | None], tuple[str, float]]]:
    """Place of each point that is done, failed or asked for; its state and highest rise [K]."""
    axis = variant_of(ds)
    roughness = attributes_of(ds)["scene"].get("roughness") or {}
    seed = roughness.get("seed") if has_seeds else None
    rise = end_of_point(ds[["time", "max_rise"]])["max_rise"]
    points = xr.Dataset({"status": ds["status"], "asked": asked(ds), "rise": rise})
    for point in points.to_dataframe().reset_index().to_dict("records"):
        if point["status"] or point["asked"]:
            place = point["load"], point["velocity"], point[axis] if axis else seed
            yield place, (_STATES.get(point["status"], "pending"), point["rise"])
