"""Boundary mode: a sweep that chooses its velocities itself, to find the boundary and no more."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from pipeline.analysis.boundary import decisive_rise
from pipeline.analysis.dataset import by_surface, open_sweep
from pipeline.run.boundary_search import BoundarySearch
from pipeline.run.sweep import Outcome, Progress, run_sweep
from pipeline.store.folder import ROOT, PathLike, folder_of
from pipeline.store.variables import FAILED
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points
from tribo import InputError

__all__ = ["follow_boundary"]


def follow_boundary(
    sweep: Sweep,
    out: PathLike,
    tolerance: float = 0.01,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[Progress], None] | None = None,
    retry_failed: bool = False,
    tell: Callable[[str], None] | None = None,
) -> Outcome:
    """Find the critical velocity at each load of a sweep, with as few points as that takes.

    Each of several surfaces has a boundary of its own, and is searched for it. The result is a
    store like that of `pipeline.run_sweep`, with velocities of the search's own between the
    sweep's lowest and highest. It resumes like that, begins with what is there, and can be
    completed to the whole sweep later.

    Parameters
    ----------
    sweep : Sweep
    out, workers, scheduler, progress, retry_failed, tell
        See `pipeline.run_sweep`.
    tolerance : float
        Relative, of the critical velocity, besides the error of the scene's fidelity.

    Raises
    ------
    InputError
        If there is no boundary to look for: no friction, or one velocity alone.
    StoreMismatchError, StoreError, ExecutionError
        See `pipeline.run_sweep`.
    """
    limit = rise_limit(sweep.conditions)
    moving = [velocity for velocity in sweep.velocities if velocity > 0]
    if not np.isfinite(limit) or len(moving) < 2:
        raise InputError(
            "there is no boundary to look for without friction, or between fewer than two "
            "velocities above 0"
        )
    search = BoundarySearch(sweep.loads, moving[0], moving[-1], limit, tolerance)

    def searched() -> tuple[set[Point], set[Point]]:
        """The points of the sweep that are known or failed, and those to look at next."""
        there: set[Point] = set()
        wanted: set[Point] = set()
        found = _found(sweep, out) if (folder_of(out) / ROOT).exists() else {}
        for seed in sweep.realizations or (None,):
            known, failed = found.get(seed, ({}, []))
            there |= {at._replace(realization=seed) for at in (*known, *failed)}
            wanted |= {at._replace(realization=seed) for at in search.wanted(known, failed)}
        return there, wanted

    def further() -> Sweep | None:
        there, wanted = searched()
        return _with_points(sweep, there | wanted) if wanted else None

    there, wanted = searched()
    begun = _with_points(sweep, there | wanted)
    return run_sweep(begun, out, workers, scheduler, progress, retry_failed, further, tell)


_Found = tuple[dict[Point, float], list[Point]]


def _found(sweep: Sweep, out: PathLike) -> dict[int | None, _Found]:
    """By surface the decisive rise at the points that are done, and the points that failed."""
    found: dict[int | None, _Found] = {}
    for ds in by_surface(open_sweep(out)):
        rise = decisive_rise(ds, sweep.conditions.failing_share)
        status = ds["status"].transpose("load", "velocity").values
        known, failed = {}, []
        for i, load in enumerate(rise["load"].values.tolist()):
            for j, velocity in enumerate(rise["velocity"].values.tolist()):
                if load in sweep.loads and np.isfinite(rise.values[i, j]):
                    known[Point(load, velocity)] = float(rise.values[i, j])
                elif load in sweep.loads and status[i, j] == FAILED:
                    failed.append(Point(load, velocity))
        found[int(ds["realization"]) if "realization" in ds.coords else None] = known, failed
    return found


def _with_points(sweep: Sweep, chosen: Iterable[Point]) -> Sweep:
    """The sweep at these points alone."""
    asked = replace(sweep, chosen=tuple(chosen))
    velocities = tuple(sorted({point.velocity for point in points(asked)}))
    return replace(asked, velocities=velocities, chosen=points(asked))
