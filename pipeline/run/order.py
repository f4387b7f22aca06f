"""The order in which the chains of a sweep are computed."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from pipeline.sweep.model import Point

_SHARE = 10  # velocities, of which the coarse pass takes one
_FEWEST = 3  # velocities of the coarse pass
# In a large plane, each point of the coarse pass rewrites a chunk of its own: 50 ms of CPU time.
_MOST = 200


def coarse_first(
    chains: Sequence[tuple[Point, ...]], velocities: Collection[float]
) -> tuple[tuple[Point, ...], ...]:
    """Put chains of a tenth of the velocities first, 200 at most: the ends, then the middles.

    So a diagram of a running sweep soon shows the whole boundary, and the time to go is known from
    cheap and dear points alike. The others follow in order, in which points that share chunks of
    the store are neighbours. Chains and velocities are ascending.

    Examples
    --------
    >>> chains = [(Point(200.0, velocity),) for velocity in (0.5, 1.0, 1.5, 2.0, 2.5)]
    >>> [chain[0].velocity for chain in coarse_first(chains, (0.5, 1.0, 1.5, 2.0, 2.5))]
    [0.5, 2.5, 1.5, 1.0, 2.0]
    >>> chains = [(Point(200.0, float(velocity)),) for velocity in range(1, 10_001)]
    >>> in_order = [chain[0].velocity for chain in coarse_first(chains, range(1, 10_001))]
    >>> in_order[:3], in_order[200:203]
    ([1.0, 10000.0, 5026.0], [2.0, 3.0, 4.0])
    """
    axis = list(velocities)
    count = min(max(_FEWEST, -(-len(axis) // _SHARE)), _MOST, len(axis))
    last = len(axis) - 1
    coarse = [axis[round(last * i / max(count - 1, 1))] for i in _ends_first(count)]
    ranks = {velocity: rank for rank, velocity in enumerate(coarse)}
    first = [chain for chain in chains if chain[0].velocity in ranks]
    others = (chain for chain in chains if chain[0].velocity not in ranks)
    return (*sorted(first, key=lambda chain: ranks[chain[0].velocity]), *others)


def _ends_first(count: int) -> list[int]:
    """Numbers below a count: the ends, then the middles of the gaps, again and again.

    Examples
    --------
    >>> _ends_first(9)
    [0, 8, 5, 3, 6, 2, 4, 1, 7]
    """
    numbers = dict.fromkeys((0, count - 1))
    step = count
    while step > 1:
        step = -(-step // 2)
        numbers |= dict.fromkeys(range(0, count, step))
    return list(numbers)
