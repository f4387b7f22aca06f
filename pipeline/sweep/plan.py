"""The points of a sweep, the chains in which one continues another, and how a point is computed.

At one velocity every load passes through the same trunk of the ramp, so the points of a velocity
form a chain: each continues the trunk where the next lower load left it. A point computed from
the start, or from any trunk, has the same numbers, bit for bit. Each random surface, and each
sample of unknown inputs, has chains of its own.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import Verdict, verdict
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.shown import as_html, as_lines, on_point
from tribo import (
    BULK_RATIOS,
    QUANTILES,
    PointWarning,
    Scene,
    State,
    heat,
    measures,
    simulate,
    start,
    warnings,
)
from tribo.simulation import leads_to
from tribo.types import Array

Record = Mapping[str, float | Array]

_NO_QUANTILES = np.full(len(QUANTILES), np.nan)
_NO_BULK_QUANTILES = np.full((len(BULK_RATIOS), len(QUANTILES)), np.nan)


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
        State at the end, with temperature; where few elements touch, on smaller ones than the
        scene's, see `tribo.Fidelity.fewest_elements`.
    shape : tuple of int
        Numbers of elements of the scene along x and y.
    warnings : tuple of PointWarning
        Reasons for care in relying on the point.
    trunk : Trunk
        Trunk of the ramp, which the next higher load continues.
    at_load : tuple of State
        States with temperature from when the load is reached on, which decide.
    wall_time : float
        Duration of the computation, which may have begun on a trunk [s].
    finished_at : float
        Time of its end, since 1970-01-01 UTC [s].
    """

    point: Point
    columns: dict[str, Array]
    state: State
    shape: tuple[int, int]
    warnings: tuple[PointWarning, ...]
    trunk: Trunk
    at_load: tuple[State, ...]
    wall_time: float
    finished_at: float = field(default_factory=time.time)

    def __repr__(self) -> str:
        return as_lines(str(self.point), list(on_point(self.columns, self.warnings)))

    def _repr_html_(self) -> str:
        """Show the result as a table in a notebook."""
        return as_html(str(self.point), list(on_point(self.columns, self.warnings)))

    @property
    def fields(self) -> dict[str, Array]:
        """Pressure [Pa], rise at friction 1 [K] and wear depth [m] at the end, shape (nx, ny).

        With unequal bulk temperatures the response to their difference, too. Means over the
        scene's elements, where the state has smaller ones.
        """
        heat, pressure = self.state.heat, self.state.pressure
        unknown = np.full_like(pressure, np.nan)
        fields = {
            "pressure": pressure,
            "rise": heat.rise if heat else unknown,
            "wear_depth": self.state.wear_depth,
        }
        if "bulk_rise_quantile" in self.columns:
            response = heat.bulk_response if heat else None
            fields["bulk_response"] = unknown if response is None else response
        if pressure.shape == self.shape:
            return fields
        blocks = (self.shape[0], -1, self.shape[1], pressure.shape[1] // self.shape[1])
        return {name: field.reshape(blocks).mean((1, 3)) for name, field in fields.items()}

    def record(self, with_fields: bool) -> PointRecord:
        """Return what is stored of the point: fields at its end only if asked for."""
        fields = self.fields if with_fields else {}
        return PointRecord(
            point=self.point,
            data={**self.columns, **{k: v.astype(np.float32) for k, v in fields.items()}},
            message="; ".join(map(str, self.warnings)),
            warning_flags=sum({int(warning.kind) for warning in self.warnings}),
            wall_time=self.wall_time,
            finished_at=self.finished_at,
        )

    def verdict(self, conditions: Conditions) -> Verdict:
        """Verdict on the wear at the point under these conditions, by its worst moment."""
        return verdict(self.columns, self.point.load, conditions)


@dataclass(frozen=True, slots=True, eq=False)
class PointRecord:
    """Stored result of a point.

    Attributes
    ----------
    point : Point
    data : dict of ndarray or None
        Variables of the dataset, at the point's own steps and at its end; None if it failed.
        Fields of a packed record are bytes, see `pipeline.store.packing`.
    message : str
        Its warnings, or the reason why it failed.
    warning_flags : int
        Kinds of its warnings.
    wall_time : float
        Duration of its computation [s].
    finished_at : float
        End of its computation, since 1970-01-01 UTC [s].
    checksum : int or None
        Checksum of the data, if they are packed.
    """

    point: Point
    data: Mapping[str, Array | bytes] | None
    message: str = ""
    warning_flags: int = 0
    wall_time: float = math.nan
    finished_at: float = math.nan
    checksum: np.uint64 | None = field(default=None, kw_only=True)


def points(sweep: Sweep) -> tuple[Point, ...]:
    """Every point of a sweep, variant by variant, velocity by velocity, loads ascending."""
    if sweep.chosen is not None:
        return tuple(sorted(sweep.chosen, key=_order))
    name = sweep.axis[0] if sweep.axis else "realization"
    places = itertools.product(sweep.simulated, sweep.velocities, sweep.loads)
    return tuple(Point(load, velocity, **{name: each}) for each, velocity, load in places)


def chains(todo: Iterable[Point], independent: bool = False) -> tuple[tuple[Point, ...], ...]:
    """Group points so that each continues the trunk of the one before it.

    Parameters
    ----------
    todo : iterable of Point
        Points to compute.
    independent : bool
        True if every point begins at the start of the ramp.

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
    ramps = itertools.groupby(ordered, key=lambda point: point[1:])
    return tuple(tuple(chain) for _, chain in ramps)


def _order(point: Point) -> tuple[int, int, float, float]:
    return point.sample or 0, point.realization or 0, point.velocity, point.load


def step_count(scene: Scene, load: float) -> int:
    """Number of steps of the ramp up to a load."""
    return sum(1 for _ in scene.stations(load))


def run_point(
    sweep: Sweep,
    load: float,
    velocity: float,
    realization: int | None = None,
    sample: int | None = None,
    trunk: Trunk | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> PointResult:
    """Simulate one point; see `pipeline.run_point`, which takes text, too."""
    began = time.perf_counter()
    sweep = sweep.variant(realization, sample)
    trunk = _leading_to(sweep, load, trunk)
    records, at_load = list(trunk.records), dict[int, State]()
    steps = step_count(sweep, load) if progress else 0
    for state in simulate(sweep, load, velocity, trunk.state):
        records.append(_record(sweep, state))
        trunk = _extended(sweep, trunk, state, load, records[-1])
        if state.heat and state.normal_load >= load:
            at_load[len(records) - 1] = state
        if progress:
            progress(len(records), steps)
    return PointResult(
        point=Point(load, velocity, realization, sample),
        columns=_columns(records) | _at_wear_rates(sweep, velocity, at_load, len(records)),
        state=state,
        shape=sweep.grid.shape,
        warnings=tuple(warnings(sweep, state)),
        trunk=trunk,
        at_load=tuple(at_load.values()),
        wall_time=time.perf_counter() - began,
    )


def _at_wear_rates(
    sweep: Sweep, velocity: float, at_load: Mapping[int, State], steps: int
) -> dict[str, Array]:
    """Heat on the contacts of a point at the velocities at which other wear rates have them.

    Parameters
    ----------
    sweep : Sweep
    velocity : float
        Velocity at which the scene's own wear rate has them [m/s].
    at_load : mapping
        States from when the load is reached on, by their places among the steps.
    steps : int
        Number of steps.
    """
    if sweep.wear is None or not sweep.rates:
        return {}
    own, rates = sweep.wear.specific_wear_rate, sweep.rates
    found = {
        "rise_quantile": np.full((steps, len(rates), len(QUANTILES)), np.nan),
        "mean_rise": np.full((steps, len(rates)), np.nan),
        "pin_heat_share": np.full((steps, len(rates)), np.nan),
    }
    for step, state in at_load.items():
        for place, rate in enumerate(rates):
            temperature = heat(sweep, state, velocity * own / rate)
            for name, values in found.items():
                values[step, place] = getattr(temperature, name)
    return {f"{name}_at_wear_rate": values for name, values in found.items()}


def columns_of(sweep: Sweep, states: Iterable[State]) -> dict[str, Array]:
    """Columns of a point at some of its states, as in `PointResult.columns`."""
    return _columns([_record(sweep, state) for state in states])


def _columns(records: Sequence[Record]) -> dict[str, Array]:
    return {name: np.array([record[name] for record in records]) for name in records[0]}


def advance_trunk(
    sweep: Sweep,
    load: float,
    velocity: float,
    realization: int | None = None,
    sample: int | None = None,
    trunk: Trunk | None = None,
) -> Trunk:
    """Continue a trunk up to the last station below a load, without computing the point there.

    Parameters are those of `run_point`.
    """
    sweep = sweep.variant(realization, sample)
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
    passed = state.history or state
    onwards = replace(passed, heat=None)
    if not _is_same_for_higher_loads(sweep, state, load):
        at_every_step = sweep.remembers_heat and not sweep.fidelity.fewest_elements
        record = _record(sweep, passed if at_every_step else onwards)
    return Trunk(onwards, (*trunk.records, record))


def _is_same_for_higher_loads(sweep: Sweep, state: State, load: float) -> bool:
    """True if a ramp to a higher load reports the same temperature at this state."""
    if state.normal_load < load:
        return True
    (station,) = (at for at in sweep.stations(load) if at.on_trunk and at.normal_load == load)
    interval = sweep.fidelity.temperature_interval
    return interval > 0 and station.index % interval == 0


def _record(sweep: Sweep, state: State) -> Record:
    quantiles = state.heat.rise_quantile if state.heat else _NO_QUANTILES
    record: dict[str, float | Array] = {**measures(sweep, state), "rise_quantile": quantiles}
    if sweep.unequal_bulks:
        found = state.heat.bulk_rise_quantile if state.heat else None
        record["bulk_rise_quantile"] = _NO_BULK_QUANTILES if found is None else found
    return record
