"""Boundary mode: a sweep that chooses its own velocities, to find the boundary and no more."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from distributed import Client

from pipeline.run.boundary_search import BoundarySearch
from pipeline.run.source import PATIENCE
from pipeline.run.sweep import Outcome, run_sweep
from pipeline.run.tally import Progress
from pipeline.scene.scenefile import sweep_of
from pipeline.store.place import PathLike, place_of
from pipeline.store.restore import restore_root
from pipeline.store.root import find_root
from pipeline.store.schema import DONE, FAILED, STEPPED
from pipeline.store.write import Store
from pipeline.sweep.criterion import worst_rises
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.variants import Variant
from tribo import Scene


def follow_boundary(
    sweep: Sweep | PathLike,
    out: PathLike,
    tolerance: float = 0.01,
    workers: int | None = None,
    client: Client | None = None,
    progress: Callable[[Progress], None] | None = None,
    retry_failed: bool = False,
    tell: Callable[[str], None] | None = None,
    patience: float = PATIENCE,
    dashboard: bool = False,
    own_laws: bool = False,
) -> Outcome:
    """Find the critical velocity at each load of a sweep, with as few points as that takes.

    Where there are several surfaces, the boundary of each is searched for. The result is a store
    like that of `pipeline.run_sweep`, with velocities that the search chose between the sweep's
    lowest and highest. It is resumed in the same way, begins with what is there, and can be
    completed to the whole sweep later.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path.
    out, workers, client, progress, retry_failed, tell, patience, dashboard, own_laws
        See `pipeline.run_sweep`.
    tolerance : float
        Relative error of the critical velocity, besides that of the scene's fidelity.

    Raises
    ------
    InputError
        If there is no boundary to look for: no friction, one velocity alone, or samples.
    StoreMismatchError, StoreError, ExecutionError
        See `pipeline.run_sweep`.

    Examples
    --------
    >>> import pipeline
    >>> scene = "workflows/first_try.toml"
    >>> outcome = pipeline.follow_boundary(scene, "results/edge.zarr")  # doctest: +SKIP
    >>> outcome.done  # doctest: +SKIP
    11
    """
    sweep = sweep_of(sweep, own_laws)
    sweep.require_search()
    searches = {
        variant: BoundarySearch.of(sweep.variant(variant), tolerance, sweep.leads[variant].ratio)
        for variant in sweep.variants.names
    }
    alike: dict[Scene, list[Variant]] = {}  # whose points have the same numbers
    for variant in searches:
        alike.setdefault(sweep.variant(variant).scene, []).append(variant)

    def further(store: Store | None, retry_failed: bool = False) -> Sweep | None:
        """Sweep of the points done or failed and those to compute next; None if there are none."""
        rises, failed = results_of(store, sweep) if store else ({}, set())
        wanted: set[Point] = set()
        for variant, search in searches.items():
            rises_here = {
                Point(*point[:2]): rise for point, rise in rises.items() if point.variant == variant
            }
            hopeless = {Point(*point[:2]) for point in failed if point.variant == variant}
            asked = search.wanted(rises_here, () if retry_failed else hopeless)
            same = alike[sweep.variant(variant).scene]
            wanted |= {Point(*point[:2], other) for point in asked for other in same}
        return sweep.changed(chosen=frozenset({*rises, *failed, *wanted})) if wanted else None

    place = place_of(out)
    restore_root(out, sweep)
    root = find_root(place)
    store = Store(place, root) if root else None
    begun = further(store, retry_failed)
    if begun is None and store:
        begun = sweep.changed(chosen=frozenset(itertools.chain(*results_of(store, sweep))))
    return run_sweep(
        begun or sweep, out, workers, client, progress, retry_failed, further, tell, patience,
        dashboard,
    )  # fmt: skip


def results_of(store: Store, sweep: Sweep) -> tuple[dict[Point, float], set[Point]]:
    """Decisive rise of each point of a store that is done [K], and points that failed."""
    names = [name for name in STEPPED if name in store.arrays]
    columns = {name: store.read(name, ...) for name in names}
    inner = len(store.dims) - store.dims.index(
        store.along("load")
    )  # further dimensions, with the step
    loads = np.array(store.axes["load"]).reshape(-1, *[1] * inner)
    variants = {variant: sweep.variant(variant).conditions for variant in sweep.variants.names}
    rises = {
        conditions: worst_rises(columns, loads, conditions) for conditions in set(variants.values())
    }

    def of_sweep(flag: int) -> Iterator[tuple[Point, tuple[Any, ...]]]:
        for point in store.points_at(np.nonzero(store.flags == flag)):
            if point.load in sweep.plane.loads and point.variant in variants:
                yield point, store.index(point)

    done = {point: float(rises[variants[point.variant]][index]) for point, index in of_sweep(DONE)}
    return done, {point for point, _ in of_sweep(FAILED)}
