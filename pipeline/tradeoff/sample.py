"""Times a few real steps of a sweep, from which the duration of the whole is foretold."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pipeline.sweep.model import Sweep
from tribo import State, advance, simulate, start

_BUDGET = 2.0  # [s] after which no further load is sampled
_STEPS = 5  # that lead to a sampled load; the first two are not yet extrapolated from earlier ones


@dataclass(frozen=True, slots=True)
class Sample:
    """Durations of steps of a sweep at some of its loads, and the contact at the highest.

    Attributes
    ----------
    loads : tuple of float
        Where steps were timed, ascending [N].
    step_seconds, end_seconds : tuple of float
        Duration of a step at each of these loads without a temperature, and with one [s].
    begin_seconds : float
        Duration of what a worker does once: the surface, the kernels [s].
    contact_nodes : int
        Elements in contact at the highest load.
    contact_rows : int
        Rows of elements from the first to the last in contact at the highest load.
    """

    loads: tuple[float, ...]
    step_seconds: tuple[float, ...]
    end_seconds: tuple[float, ...]
    begin_seconds: float
    contact_nodes: int
    contact_rows: int

    def step(self, load: float) -> float:
        """Duration of a step at a load without a temperature [s]."""
        return float(np.interp(load, self.loads, self.step_seconds))

    def end(self, load: float) -> float:
        """Duration of a step at a load with a temperature [s]."""
        return float(np.interp(load, self.loads, self.end_seconds))


def sampled(sweep: Sweep) -> Sample:
    """Time steps of a sweep at its median velocity: at the highest load, the lowest, between.

    The ramp is not followed up to these loads; one long step leads near to each, and the sweep's
    own steps from there. As many loads are sampled as fit into two seconds, and at least one.

    Raises
    ------
    TriboError
        What `tribo.simulate` raises.
    """
    if sweep.fidelity.partition == "direct":  # its duration is known without running it
        sweep = replace(sweep, fidelity=replace(sweep.fidelity, partition="local"))
    moving = sorted((velocity for velocity in sweep.velocities if velocity), key=abs)
    velocity = moving[len(moving) // 2] if moving else 0.0
    began = time.perf_counter()
    first = _timed(sweep, max(sweep.loads), velocity)
    cold = time.perf_counter() - began
    found, begin = {max(sweep.loads): first}, 0.0
    for load in _spread(sweep.loads):
        if time.perf_counter() - began > _BUDGET:
            break
        again = time.perf_counter()
        found[load] = _timed(sweep, load, velocity)
        if load == max(sweep.loads):
            begin = max(0.0, cold - (time.perf_counter() - again))
    rows = np.flatnonzero(first.state.pressure.any(axis=1))
    loads = sorted(found)
    return Sample(
        loads=tuple(loads),
        step_seconds=tuple(found[load].step for load in loads),
        end_seconds=tuple(found[load].end for load in loads),
        begin_seconds=begin,
        contact_nodes=int(np.count_nonzero(first.state.pressure)),
        contact_rows=int(np.ptp(rows)) + 1 if rows.size else 0,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Timed:
    """Duration of a step without a temperature and with one [s], and the last state."""

    step: float
    end: float
    state: State


def _timed(sweep: Sweep, load: float, velocity: float) -> _Timed:
    steps, ends = [], []
    before = _shortly_before(sweep, load, velocity)
    began = time.perf_counter()
    for number, state in enumerate(simulate(sweep, load, velocity, before), start=1):
        seconds = time.perf_counter() - began
        if state.heat is not None:
            ends.append(seconds)
        elif number > 2:
            steps.append(seconds)
        began = time.perf_counter()
    end = float(np.median(ends))
    return _Timed(float(np.median(steps)) if steps else end, end, state)


def _shortly_before(sweep: Sweep, load: float, velocity: float) -> State | None:
    """The state a few steps below a load, reached in one; None where the ramp has no more."""
    trunk = [station for station in sweep.stations(load) if station.on_trunk]
    if len(trunk) <= _STEPS:
        return None
    scene = next(sweep.levels())
    if scene.fidelity.wear_scheme == "explicit":  # unstable in so long a step
        scene = replace(scene, fidelity=replace(scene.fidelity, wear_scheme="implicit"))
    return advance(scene, start(scene), trunk[-_STEPS], velocity)


def _spread(loads: tuple[float, ...]) -> Iterator[float]:
    """Each load once: the highest, the lowest, and ever closer between them.

    Examples
    --------
    >>> list(_spread((1.0, 2.0, 3.0, 4.0, 5.0)))
    [5.0, 1.0, 3.0, 2.0, 4.0]
    """
    last = len(loads) - 1
    yield loads[last]
    seen = {last}
    for parts in (2**k for k in range(last.bit_length() + 1)):
        for place in range(parts):
            index = round(last * place / parts)
            if index not in seen:
                seen.add(index)
                yield loads[index]
