"""Boundary mode: a sweep that chooses its own velocities, to find the boundary and no more."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

from pipeline.run.batch import Batch
from pipeline.run.boundary_search import BoundarySearch, searched, tolerance_under
from pipeline.run.replay import Replay, Variant
from pipeline.run.sweep import Outcome, run_sweep
from pipeline.run.tally import Progress
from pipeline.scene.scenefile import sweep_of
from pipeline.store.place import PathLike, place_of
from pipeline.store.root import read_root
from pipeline.store.write import Store
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.model import Point, Sweep
from tribo import InputError

_FIRST = 16  # samples that are searched without knowing where others found their boundary
_GROWTH = 2  # of the number of samples that are searched at a time
_MOST = 1024  # samples that are searched at a time, since what is known of them is kept


def follow_boundary(
    sweep: Sweep | PathLike,
    out: PathLike,
    tolerance: float = 0.01,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[Progress], None] | None = None,
    retry_failed: bool = False,
    tell: Callable[[str], None] | None = None,
    cluster: Batch | None = None,
) -> Outcome:
    """Find the critical velocity at each load of a sweep, with as few points as that takes.

    Where there are several surfaces, the boundary of each is searched for. So is that of each
    sample of unknown inputs: of a few first, of the others about where these let it be expected;
    samples that differ in friction and temperatures alone share their points. The result is a store
    like that of `pipeline.run_sweep`, with velocities that the search chose between the sweep's
    lowest and highest. It is resumed in the same way, begins with what is there, and can be
    completed to the whole sweep later.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path.
    out, workers, scheduler, progress, retry_failed, tell, cluster
        See `pipeline.run_sweep`.
    tolerance : float
        Relative error of the critical velocity, besides that of the scene's fidelity.

    Raises
    ------
    InputError
        If there is no boundary to look for: no friction, or one velocity alone.
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
    sweep = sweep_of(sweep)
    if sweep.wear_rates:
        raise InputError(
            "sweep.wear_rates: the search looks for the boundary at the scene's own wear rate "
            "alone; leave them out (--set without='[\"sweep.wear_rates\"]'), or compute the whole "
            "sweep"
        )
    variants = _variants(sweep)
    limits = [rise_limit(each) for variant in variants for each in variant.conditions]
    moving = searched(sweep, limits)
    tolerance = tolerance_under(sweep.conditions, tolerance)
    within = BoundarySearch(sweep.loads, moving[0], moving[-1], limits[0], tolerance)
    search = Replay(within, variants, retry_failed)
    batches = deque(_batches(variants) if sweep.samples else [variants])

    def further(store: Store | None) -> Sweep | None:
        """The sweep at the points that are known or failed, and at those to look at next."""
        search.look(store)
        while batches:
            if wanted := search.wanted(batches[0]):
                return _with_points(sweep, itertools.chain(search.there(), wanted))
            search.leave(batches.popleft())
        return None

    place = place_of(out)
    store = Store(place, read_root(place)) if place.exists() else None
    begun = further(store) or _with_points(sweep, search.there())
    return run_sweep(
        begun, out, workers, scheduler, progress, retry_failed, further, tell, cluster=cluster
    )


def _variants(sweep: Sweep) -> list[Variant]:
    if sweep.samples is None:
        seeds = sweep.realizations or (None,)
        return [Variant((seed, None), (sweep.conditions,)) for seed in seeds]
    samples = sweep.samples
    conditions = [sweep.variant(sample=number).conditions for number in range(len(samples))]
    if not samples.are_simulated:
        return [Variant((None, None), tuple(conditions))]
    alike: dict[int, list[int]] = {}
    for number, first in enumerate(samples.simulations):
        alike.setdefault(first, []).append(number)
    return [
        Variant(
            (None, first),
            tuple(conditions[number] for number in each),
            tuple(samples.scaled(number) for number in each),
        )
        for first, each in alike.items()
    ]


def _batches(variants: Sequence[Variant]) -> Iterator[Sequence[Variant]]:
    """Samples to search at a time: few at first, from which the others learn."""
    begin, size = 0, _FIRST
    while begin < len(variants):
        yield variants[begin : begin + size]
        begin, size = begin + size, min(_GROWTH * size, _MOST)


def _with_points(sweep: Sweep, chosen: Iterable[Point]) -> Sweep:
    """The same sweep at these points alone."""
    return replace(sweep, chosen=frozenset(chosen))
