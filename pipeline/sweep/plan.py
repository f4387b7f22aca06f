"""The points of a sweep, the chains in which one continues another, and how a point is computed.

At one velocity every load passes through the same trunk of the ramp, so the points of a velocity
form a chain: each continues the trunk where the next lower load left it. A point computed from
the start, or from any trunk, has the same numbers, bit for bit. Each random surface has chains of
its own. So have samples of unknown inputs, of which some share each contact (`contacts`): a
chain has the points of all of them, load by load.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import Verdict, verdict
from pipeline.sweep.description import as_html, as_lines, on_point
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.variants import Variant
from tribo import BULK_RATIOS, QUANTILES, Scene, State, Wear, measures, warnings
from tribo.simulation import PointWarning, contacts, heat, heated, leads_to, start
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
    records : mapping of tuple of dict
        Values of `PointResult.columns` at each station so far, for each variant on it.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> lower = pipeline.run_point(scene, "400 N", "2.8 m/s")
    >>> higher = pipeline.run_point(scene, "600 N", "2.8 m/s", trunk=lower.trunk)
    >>> alone = pipeline.run_point(scene, "600 N", "2.8 m/s")
    >>> bool((higher.fields["rise"] == alone.fields["rise"]).all())
    True
    """

    state: State
    records: Mapping[Variant, tuple[Record, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class PointResult:
    """The result of computing one point.

    Attributes
    ----------
    point : Point
        Load, velocity and variant.
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

    Examples
    --------
    >>> import pipeline
    >>> result = pipeline.run_point("workflows/first_try.toml", "400 N", "2.8 m/s")
    >>> print(result)
    400 N, 2.8 m/s
      after    2.667 s and 7.467 m
      contact  264.4 µm wide, 3.67 GPa on average, 6.6 GPa at most
      wear     3.29 µm deep, 0.00179 mm³
      rise     1600 K at most, at friction 1
    >>> sorted(result.fields), result.fields["pressure"].shape == result.shape
    (['pressure', 'rise', 'wear_depth'], True)
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
        """Return the stored record of the point: fields at its end only if asked for."""
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
    """Stored result of a point: variables of the dataset, or None of one that failed.

    Fields of a packed record are bytes, and it has a checksum; see `pipeline.store.packing`.
    """

    point: Point
    data: Mapping[str, Array | bytes] | None
    message: str = ""  # its warnings, or the reason of its failure
    warning_flags: int = 0
    wall_time: float = math.nan  # [s]
    finished_at: float = math.nan  # since 1970-01-01 UTC [s]
    checksum: np.uint64 | None = field(default=None, kw_only=True)


def points(sweep: Sweep) -> tuple[Point, ...]:
    """Every point of a sweep, variant by variant, velocity by velocity, loads ascending."""
    if sweep.plane.chosen is not None:
        return tuple(sorted(sweep.plane.chosen, key=lambda point: (point.variant, *point[1::-1])))
    return tuple(
        Point(load, velocity, name)
        for name in sweep.variants.names
        for velocity, load in _places_of(sweep, name)
    )


def _places_of(sweep: Sweep, name: Variant) -> Iterable[tuple[float, float]]:
    """Velocities and loads of a row of the table, loads ascending."""
    loads, velocities = sweep.variants.plane_of(name, sweep.plane.loads, sweep.plane.velocities)
    return itertools.product(velocities, loads)


def chains(todo: Iterable[Point], sweep: Sweep) -> tuple[tuple[Point, ...], ...]:
    """Group points of a sweep so that each continues the trunk of the one before it.

    Points of independent ones are alone, but for variants that share a contact.
    """

    def ramp(point: Point) -> tuple[Any, ...]:
        velocity, variant = sweep.contact_of(point)
        return variant, velocity, point.load if sweep.plane.independent else 0.0

    ordered = sorted(todo, key=lambda point: (ramp(point), point.load, point.variant))
    return tuple(tuple(chain) for _, chain in itertools.groupby(ordered, key=ramp))


def step_count(scene: Scene, load: float) -> int:
    """Number of steps of the ramp up to a load."""
    return sum(1 for _ in scene.stations(load))


def run_point(
    sweep: Sweep,
    load: float,
    velocity: float,
    variant: Variant = (),
    trunk: Trunk | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> PointResult:
    """Simulate one point; see `pipeline.run_point`, which takes text, too."""
    return run_points(sweep, (Point(load, velocity, variant),), trunk, progress)[0]


def run_points(
    sweep: Sweep,
    points: Sequence[Point],
    trunk: Trunk | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[PointResult, ...]:
    """Simulate points of one contact: one point, or variants that share it, at one load.

    The trunk is that of the contact, with the records of these variants; `progress` is called with
    the steps done and their number.
    """
    began = time.perf_counter()
    load, names = points[0].load, [point.variant for point in points]
    variants = [sweep.variant(name) for name in names]
    first, name_of_lead = sweep.contact_of(points[0])
    lead = variants[0] if name_of_lead == names[0] else sweep.variant(name_of_lead)
    trunk = _leading_to(lead, load, trunk, names)
    records = {name: list(trunk.records.get(name, ())) for name in names}
    places = [(one.scene, point.velocity) for one, point in zip(variants, points, strict=True)]
    steps = step_count(lead.scene, load) if progress else 0
    states: list[State] = []
    at_load = [dict[int, State]() for _ in points]
    for number_of_step, contact in enumerate(contacts(lead.scene, load, first, trunk.state), 1):
        heated_at = {place: _with_heat(*place, contact, first) for place in dict.fromkeys(places)}
        states = [heated_at[place] for place in places]
        rows = list(zip(variants, states, strict=True))
        for name, row, hot in zip(names, rows, at_load, strict=True):
            if row[1].heat and row[1].normal_load >= load:
                hot[len(records[name])] = row[1]
            records[name].append(_record(*row))
        trunk = _extended(trunk, contact, rows, load, records)
        if progress:
            progress(number_of_step, steps)
    duration = (time.perf_counter() - began) / len(points)
    return tuple(
        PointResult(
            point=point,
            columns=_stacked(records[point.variant])
            | _at_wear_rates(variant, point.velocity, hot, len(records[point.variant])),
            state=state,
            shape=variant.scene.grid.shape,
            warnings=tuple(warnings(variant.scene, state)),
            trunk=trunk,
            at_load=tuple(hot.values()),
            wall_time=duration,
        )
        for point, variant, state, hot in zip(points, variants, states, at_load, strict=True)
    )


def _with_heat(scene: Scene, velocity: float, contact: State, first: float) -> State:
    """A contact with its temperature, at the velocity that leads it or at that of another row."""
    if velocity != first:
        return heated(scene, contact, velocity)
    if contact.is_asked and contact.heat is None:
        return replace(contact, heat=heat(scene, contact, velocity))
    return contact


def _at_wear_rates(
    sweep: Sweep, velocity: float, at_load: Mapping[int, State], steps: int
) -> dict[str, Array]:
    """Heat on the contacts of a point at the velocities at which other wear rates have them.

    The states, by their places among the steps, are those from when the load is reached on.
    """
    wear = sweep.scene.wear
    if not isinstance(wear, Wear) or not sweep.rates:
        return {}
    usual, rates = wear.specific_wear_rate, sweep.rates
    shapes = {"rise_quantile": (len(QUANTILES),), "mean_rise": (), "pin_heat_share": ()}
    columns = {name: np.full((steps, len(rates), *shape), np.nan) for name, shape in shapes.items()}
    for step, state in at_load.items():
        for place, rate in enumerate(rates):
            temperature = heat(sweep.scene, state, velocity * usual / rate)
            for name, values in columns.items():
                values[step, place] = getattr(temperature, name)
    return {f"{name}_at_wear_rate": values for name, values in columns.items()}


def stacked_columns(sweep: Sweep, states: Iterable[State]) -> dict[str, Array]:
    """Columns of a point at some of its states, as in `PointResult.columns`."""
    return _stacked([_record(sweep, state) for state in states])


def _stacked(records: Sequence[Record]) -> dict[str, Array]:
    return {name: np.array([record[name] for record in records]) for name in records[0]}


def _leading_to(
    sweep: Sweep, load: float, trunk: Trunk | None, variants: Sequence[Variant]
) -> Trunk:
    """The trunk if the ramp of these variants to a load goes on from it, else the start."""
    if trunk and leads_to(sweep.scene, trunk.state, load) and set(variants) <= set(trunk.records):
        return trunk
    return Trunk(start(sweep.scene))


def _extended(
    trunk: Trunk,
    contact: State,
    rows: Sequence[tuple[Sweep, State]],
    load: float,
    records: Mapping[Variant, list[Record]],
) -> Trunk:
    """Return the trunk with one more contact and its rows, if higher loads pass through it."""
    if not contact.on_trunk:
        return trunk
    onwards = replace(contact.history or contact, heat=None)
    longer: dict[Variant, tuple[Record, ...]] = {}
    for (name, rows_of_it), (sweep, state) in zip(records.items(), rows, strict=True):
        record = rows_of_it[-1]
        if not _is_same_for_higher_loads(sweep, state, load):
            passed = replace(state.history or state, sliding_distance=state.sliding_distance)
            at_every_step = sweep.scene.remembers_heat and not sweep.scene.fidelity.fewest_elements
            record = _record(sweep, passed if at_every_step else replace(passed, heat=None))
        longer[name] = (*trunk.records.get(name, ()), record)
    return Trunk(onwards, longer)


def _is_same_for_higher_loads(sweep: Sweep, state: State, load: float) -> bool:
    """True if a ramp to a higher load reports the same temperature at this state."""
    if state.normal_load < load:
        return True
    stations = [one for one in sweep.scene.stations(load) if one.on_trunk]
    (station,) = (one for one in stations if one.normal_load == load)
    interval = sweep.scene.fidelity.temperature_interval
    return interval > 0 and station.index % interval == 0


def _record(sweep: Sweep, state: State) -> Record:
    quantiles = state.heat.rise_quantile if state.heat else _NO_QUANTILES
    record: dict[str, float | Array] = {**measures(sweep.scene, state), "rise_quantile": quantiles}
    if sweep.scene.unequal_bulks:
        of_bulk = state.heat.bulk_rise_quantile if state.heat else None
        record["bulk_rise_quantile"] = _NO_BULK_QUANTILES if of_bulk is None else of_bulk
    return record
