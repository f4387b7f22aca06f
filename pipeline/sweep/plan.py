"""The points of a sweep, the chains in which one continues another, and how a point is computed.

At one velocity each load continues the trunk of the next lower one; a point has the same numbers
from any trunk, bit for bit. Variants that share a contact are in one chain.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.sweep.about import as_lines, on_point
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.severity import Verdict, verdict
from pipeline.sweep.station_choice import choose_stations
from pipeline.sweep.stations import Stations
from pipeline.sweep.variants import Variant
from tribo import BULK_RATIOS, QUANTILES, Ramp, Scene, State, measures, warnings
from tribo.simulation import PointWarning, contacts, heat, heated, leads_to, start
from tribo.types import Array

Moment = Mapping[str, float | Array]

_NO_QUANTILES = np.full(len(QUANTILES), np.nan)
_NO_BULK_QUANTILES = np.full((len(BULK_RATIOS), len(QUANTILES)), np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class Trunk:
    """The ramp at one velocity, as far as it has come."""

    state: State  # at the last step, without temperature
    # `PointResult.columns` of each variant on reaching each load so far; None where that failed.
    ends: Mapping[Variant, Mapping[float, Moment | None]] = field(default_factory=dict)

    def without(self, failed: Iterable[Point]) -> Trunk:
        """The trunk, with these points noted as failed."""
        ends = {
            point.variant: {**self.ends.get(point.variant, {}), point.load: None}
            for point in failed
        }
        return replace(self, ends={**self.ends, **ends})


@dataclass(frozen=True, slots=True, eq=False)
class PointResult:
    """The result of computing one point."""

    point: Point  #: Load, velocity and variant.
    #: Values at each station, the end last, by variable of the dataset: shape (n_step,), or
    #: (n_step, n_quantile).
    columns: dict[str, Array]
    #: State at the end, with temperature; where few elements touch, on smaller ones than the
    #: scene's, see `tribo.Fidelity.fewest_elements`.
    state: State
    shape: tuple[int, int]  #: Elements of the scene along x and y.
    warnings: tuple[PointWarning, ...]  #: Reasons for care in relying on the point.
    trunk: Trunk  #: Trunk of the ramp, which the next higher load continues.
    at_load: tuple[State, ...]  #: States that decide, from when the load is reached on.
    wall_time: float  #: Duration of the computation, which may have begun on a trunk [s].

    def __repr__(self) -> str:
        return as_lines(str(self.point), list(on_point(self.columns, self.warnings)))

    @property
    def fields(self) -> dict[str, Array]:
        """Pressure [Pa], rise at friction 1 [K] and wear depth [m] at the end, shape (nx, ny).

        With unequal bulk temperatures the response to their difference, too; means over elements.
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
        )

    def verdict(self, conditions: Conditions) -> Verdict:
        """Verdict on the wear at the point under these conditions, by its worst moment."""
        return verdict(self.columns, self.point.load, conditions)


@dataclass(frozen=True, slots=True, eq=False)
class PointRecord:
    """Stored result of a point: variables of the dataset, or None of one that failed."""

    point: Point
    data: Mapping[str, Array | bytes] | None
    message: str = ""  # its warnings, or the reason of its failure
    warning_flags: int = 0
    wall_time: float = math.nan  # [s]
    checksum: str | None = field(default=None, kw_only=True)


def points(sweep: Sweep) -> tuple[Point, ...]:
    """Every point of a sweep, variant by variant, velocity by velocity, loads ascending."""
    if sweep.plane.chosen is not None:
        return tuple(sorted(sweep.plane.chosen, key=lambda point: (point.variant, *point[1::-1])))
    return tuple(
        Point(load, velocity, name)
        for name in sweep.variants.names
        for loads, velocities in [
            sweep.variants.plane_of(name, sweep.plane.loads, sweep.plane.velocities)
        ]
        for velocity, load in itertools.product(velocities, loads)
    )


def chains(todo: Iterable[Point], sweep: Sweep) -> tuple[tuple[Point, ...], ...]:
    """Group points so that each continues the trunk of the one before, unless independent."""

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
    failed: Collection[Point] = (),
) -> tuple[PointResult, ...]:
    """Simulate points of one contact: one point, or variants that share it, at one load.

    The trunk is that of the contact. Ends of lower loads that are stations of the points come from
    it; those that it lacks are computed on the way, but for points that are known to have failed.
    `progress` is called with the steps done and their number.
    """
    began = time.perf_counter()
    load, stations = points[0].load, choose_stations(sweep)
    trunk = trunk or Trunk(start(sweep.variant(sweep.contact_of(points[0])[1]).scene))
    for below in stations.below(load):
        trunk = _passed(sweep, [point._replace(load=below) for point in points], trunk, failed)
    runs, trunk = _simulated(sweep, points, trunk, stations, progress)
    duration = (time.perf_counter() - began) / len(points)
    results = []
    for point, run in zip(points, runs, strict=True):
        ends = trunk.ends.get(point.variant, {})
        passed = [end for below in stations.below(load) if (end := ends[below]) is not None]
        results.append(
            PointResult(
                point=point,
                columns=_stacked([*passed, *run.records]),
                state=run.states[-1],
                shape=run.scene.grid.shape,
                warnings=tuple(warnings(run.scene, run.states[-1])),
                trunk=trunk,
                at_load=tuple(state for state in run.states if state.normal_load >= load),
                wall_time=duration,
            )
        )
    return tuple(results)


def _passed(
    sweep: Sweep, points: Sequence[Point], trunk: Trunk, failed: Collection[Point]
) -> Trunk:
    """The trunk with the ends of points at a load that it passes."""
    new = [p for p in points if p.load not in trunk.ends.get(p.variant, {})]
    trunk = trunk.without(point for point in new if point in failed)
    missing = [point for point in new if point not in failed]
    try:
        return _simulated(sweep, missing, trunk)[1] if missing else trunk
    except Exception:  # such a point is recorded as failed, and is no station
        if len(missing) == 1:
            return trunk.without(missing)
        for point in missing:
            trunk = _passed(sweep, [point], trunk, failed)
        return trunk


class _Run(NamedTuple):
    """A simulation of one variant: its states that are kept, and their records."""

    scene: Scene
    states: list[State]
    records: list[Moment]

    def reached(self, load: float) -> Moment | None:
        """Record on reaching a load."""
        moments = zip(self.states, self.records, strict=True)
        return next((record for state, record in moments if state.normal_load >= load), None)


def _simulated(
    sweep: Sweep,
    points: Sequence[Point],
    trunk: Trunk,
    stations: Stations | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[list[_Run], Trunk]:
    """Simulate points of one contact, and lengthen its trunk; not held without stations."""
    load, names = points[0].load, [point.variant for point in points]
    variants = [sweep.variant(name) for name in names]
    first, name_of_lead = sweep.contact_of(points[0])
    lead = variants[0].scene if name_of_lead == names[0] else sweep.variant(name_of_lead).scene
    if stations is None and isinstance(lead.loading, Ramp) and lead.loading.hold:
        lead = replace(lead, loading=replace(lead.loading, hold=0.0))
    asked = stations.asked(lead, load) if stations else frozenset[int]()
    goes_on = leads_to(lead, trunk.state, load)
    state = trunk.state if goes_on else start(lead)
    steps = sum(1 for _ in lead.stations(load, state.normal_load, asked)) if progress else 0
    runs = [_Run(variant.scene, [], []) for variant in variants]
    ways = contacts(lead, load, first, state, asked)
    for number_of_step, contact in enumerate(ways, 1):
        if contact.on_trunk:
            state = replace(contact.history or contact, heat=None)
        if contact.index in asked or contact.normal_load >= load or contact.is_asked:
            places = [(run.scene, at.velocity) for run, at in zip(runs, points, strict=True)]
            heats = {place: _with_heat(*place, contact, first) for place in dict.fromkeys(places)}
            for variant, run, place in zip(variants, runs, places, strict=True):
                hot = heats[place]
                if hot.heat is not None:
                    run.states.append(hot)
                    run.records.append(record_at(variant, hot))
        if progress:
            progress(number_of_step, steps)
    if not goes_on and trunk.state.normal_load >= load:
        state = trunk.state  # the trunk had come beyond this load
    ends = {
        point.variant: {**trunk.ends.get(point.variant, {}), load: run.reached(load)}
        for point, run in zip(points, runs, strict=True)
    }
    return runs, Trunk(state, {**trunk.ends, **ends})


def _with_heat(scene: Scene, velocity: float, contact: State, first: float) -> State:
    """A contact with its temperature, at the velocity that leads it or at that of another row."""
    if velocity != first:
        return heated(scene, contact, velocity)
    if contact.is_asked and contact.heat is None:
        return replace(contact, heat=heat(scene, contact, velocity))
    return contact


def _stacked(records: Sequence[Moment]) -> dict[str, Array]:
    return {name: np.array([record[name] for record in records]) for name in records[0]}


def record_at(sweep: Sweep, state: State) -> Moment:
    """Values at one moment of a point, by variable of the dataset."""
    quantiles = state.heat.rise_quantile if state.heat else _NO_QUANTILES
    record: dict[str, float | Array] = {**measures(sweep.scene, state), "rise_quantile": quantiles}
    if sweep.scene.unequal_bulks:
        of_bulk = state.heat.bulk_rise_quantile if state.heat else None
        record["bulk_rise_quantile"] = _NO_BULK_QUANTILES if of_bulk is None else of_bulk
    return record
