"""The points of a sweep, the chains in which one continues another, and how a point is computed.

At one velocity every load passes through the same trunk of the ramp, so the points of a velocity
form a chain: each continues the trunk where the next lower load left it. A point computed from
the start, or from any trunk, has the same numbers, bit for bit. Each random surface has chains of
its own.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.sweep.criterion import Conditions, Verdict, verdict
from pipeline.sweep.model import Point, Sweep
from tribo import QUANTILES, PointWarning, Scene, State, measures, simulate, start, warnings
from tribo.simulation.steps import leads_to
from tribo.types import Array

Record = Mapping[str, float | Array]

_NO_QUANTILES = np.full(len(QUANTILES), np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class Trunk:
    """The ramp at one velocity, as far as it has come.

    Attributes
    ----------
    state : State
        State at the last station, without temperature.
    records : tuple of dict
        Values of `PointResult.columns` at each station so far.
    """

    state: State
    records: tuple[Record, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class PointResult:
    """The result of computing one point.

    Attributes
    ----------
    point : Point
        Load, velocity and surface.
    columns : dict of ndarray, shape (n_step,), ``rise_quantile`` (n_step, n_quantile)
        Values at each step since the start of the ramp, by variable of the dataset; NaN where
        the temperature was not asked for.
    state : State
        State at the end, with temperature.
    warnings : tuple of PointWarning
        Reasons for care in relying on the point.
    trunk : Trunk
        Trunk of the ramp, which the next higher load continues.
    wall_time : float
        Duration of the computation, which may have begun on a trunk [s].
    """

    point: Point
    columns: dict[str, Array]
    state: State
    warnings: tuple[PointWarning, ...]
    trunk: Trunk
    wall_time: float

    @property
    def fields(self) -> dict[str, Array]:
        """Pressure [Pa], rise at friction 1 [K] and wear depth [m] at the end, shape (nx, ny)."""
        heat = self.state.heat
        return {
            "pressure": self.state.pressure,
            "rise": heat.rise if heat else np.full_like(self.state.pressure, np.nan),
            "wear_depth": self.state.wear_depth,
        }

    def verdict(self, conditions: Conditions) -> Verdict:
        """Whether wear is severe at the point under these conditions, by its worst moment."""
        return verdict(self.columns, self.point.load, conditions)


def points(sweep: Sweep) -> tuple[Point, ...]:
    """Every point of a sweep, surface by surface, velocity by velocity, loads ascending."""
    if sweep.chosen is not None:
        return tuple(sorted(sweep.chosen, key=_order))
    places = itertools.product(sweep.realizations or (None,), sweep.velocities, sweep.loads)
    return tuple(Point(load, velocity, surface) for surface, velocity, load in places)


def chains(todo: Iterable[Point], independent: bool = False) -> tuple[tuple[Point, ...], ...]:
    """Group points so that each continues the trunk of the one before it.

    Parameters
    ----------
    todo : iterable of Point
        Points to compute.
    independent : bool
        Whether every point begins at the start of the ramp instead.

    Examples
    --------
    >>> for chain in chains([Point(300.0, 1.5), Point(150.0, 1.5), Point(150.0, 1.0)]):
    ...     print(*chain, sep="; ")
    150 N, 1 m/s
    150 N, 1.5 m/s; 300 N, 1.5 m/s
    """
    ordered = sorted(todo, key=_order)
    if independent:
        return tuple((point,) for point in ordered)
    ramps = itertools.groupby(ordered, key=lambda point: (point.realization, point.velocity))
    return tuple(tuple(chain) for _, chain in ramps)


def _order(point: Point) -> tuple[int, float, float]:
    return point.realization or 0, point.velocity, point.load


def step_count(scene: Scene, load: float) -> int:
    """Number of steps of the ramp up to a load."""
    return sum(1 for _ in scene.stations(load))


def run_point(
    sweep: Sweep,
    load: float,
    velocity: float,
    realization: int | None = None,
    trunk: Trunk | None = None,
) -> PointResult:
    """Simulate one point.

    Parameters
    ----------
    sweep : Sweep
        The scene, and the surfaces it has.
    load : float
        Normal load on the whole pin at the end of the ramp [N].
    velocity : float
        Sliding velocity [m/s].
    realization : int, optional
        Seed of the random surface in place of the sweep's own.
    trunk : Trunk, optional
        Trunk of a lower load at the same velocity on the same surface, to continue; the start of
        the ramp if not given. The result is the same.

    Raises
    ------
    TriboError
        What `tribo.simulate` raises.
    """
    began = time.perf_counter()
    sweep = sweep.on_surface(realization)
    trunk = _leading_to(sweep, load, trunk)
    records = list(trunk.records)
    for state in simulate(sweep, load, velocity, trunk.state):
        records.append(_record(sweep, state))
        trunk = _extended(sweep, trunk, state, load, records[-1])
    return PointResult(
        point=Point(load, velocity, realization),
        columns={name: np.array([record[name] for record in records]) for name in records[0]},
        state=state,
        warnings=tuple(warnings(sweep, state)),
        trunk=trunk,
        wall_time=time.perf_counter() - began,
    )


def advance_trunk(
    sweep: Sweep,
    load: float,
    velocity: float,
    realization: int | None = None,
    trunk: Trunk | None = None,
) -> Trunk:
    """Continue a trunk up to the last station below a load, without computing the point there.

    Parameters are those of `run_point`.
    """
    sweep = sweep.on_surface(realization)
    trunk = _leading_to(sweep, load, trunk)
    below = [
        station
        for station in sweep.stations(load, after=trunk.state.normal_load)
        if station.on_trunk and station.normal_load < load
    ]
    if below:
        states = simulate(sweep, load, velocity, trunk.state)
        for state in itertools.islice(states, len(below)):
            trunk = _extended(sweep, trunk, state, load, _record(sweep, state))
    return trunk


def _leading_to(sweep: Sweep, load: float, trunk: Trunk | None) -> Trunk:
    """The trunk if the ramp to a load goes on from it, else the start of the ramp."""
    return trunk if trunk and leads_to(sweep, trunk.state, load) else Trunk(start(sweep))


def _extended(sweep: Sweep, trunk: Trunk, state: State, load: float, record: Record) -> Trunk:
    """Return the trunk with one more state of a point, if higher loads pass through it."""
    if not state.on_trunk:
        return trunk
    onwards = state.history or replace(state, heat=None)
    if not _is_same_for_higher_loads(sweep, state, load):
        record = _record(sweep, onwards)
    return Trunk(onwards, (*trunk.records, record))


def _is_same_for_higher_loads(sweep: Sweep, state: State, load: float) -> bool:
    """Whether a state has its temperature on the finest grid also where it ends no point."""
    if state.normal_load < load or sweep.remembers_heat:
        return True
    (station,) = (at for at in sweep.stations(load) if at.on_trunk and at.normal_load == load)
    interval = sweep.fidelity.temperature_interval
    return interval > 0 and station.index % interval == 0


def _record(sweep: Sweep, state: State) -> Record:
    quantiles = state.heat.rise_quantile if state.heat else _NO_QUANTILES
    return {**measures(sweep, state), "rise_quantile": quantiles}
