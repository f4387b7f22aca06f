"""The points of a sweep, the tasks that they are computed in, and how a point is computed.

A task is one point. It continues a cached ramp with the same mechanics, velocity and increment,
from the last increment below its load. Whichever ramp a point continues, its results are the same,
bit for bit.
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.sweep.case_table import CaseName, CaseRow
from pipeline.sweep.condition_entries import Conditions
from pipeline.sweep.stored_steps import Fields, StoredSteps, least_load_evaluated
from pipeline.sweep.sweep import Point, Sweep
from tribo import QUANTILES, Ramp, Scene, Stages, State, TriboError, Verdict, measures
from tribo.simulation import (
    PointWarning,
    RampCache,
    Recorder,
    contact_key,
    contacts,
    fit_elements,
    heat,
    mechanics,
    point_warnings,
    stages_of,
)
from tribo.simulation.film import film_inlet
from tribo.simulation.verdict import verdict
from tribo.types import Array

Moment = Mapping[str, float | Array]

NOT_KNOWN = -1.0
"""Stored at the end of a point instead of NaN, such as for the film of a ball."""
_LOADING_COLUMNS = ("time", "normal_load", "sliding_distance")  # known without a contact
_NO_QUANTILES = np.full(len(QUANTILES), np.nan)
_NO_SAMPLING = {"rise_realization_std": _NO_QUANTILES, "rise_realization_freedom": math.nan}
_NO_FILM: Mapping[str, Any] = {"film_inlet": math.nan, "film_pressure": math.nan}


@dataclass(frozen=True, slots=True, eq=False)
class PointResult:
    """Temperatures, wear and warnings that were computed at one load and velocity."""

    point: Point  #: Load, velocity and case.
    #: Values at each step, the end last, by variable of the dataset: shape (n_step,), or
    #: (n_step, n_quantile).
    columns: dict[str, Array]
    #: State at the end, with temperature; on smaller elements than the scene's where the surface
    #: needs them, see `tribo.Fidelity.fewest_elements`.
    state: State = field(repr=False)
    shape: tuple[int, int]  #: Elements of the scene along x and y.
    least_load: float  #: Load from which on steps can decide [N].
    warnings: tuple[PointWarning, ...]  #: Reasons for caution about the result.
    wall_time: float  #: Duration of the computation, which may have begun on a cached ramp [s].
    #: Integral of the inlet [1/m] and mean pressure [Pa], by which an oil's film is judged; NaN if
    #: not computed, and under a ball.
    film: Mapping[str, Any] = field(default_factory=lambda: _NO_FILM)

    @property
    def fields(self) -> dict[str, Array]:
        """Fields at the end of the simulation by name, each (nx, ny).

        They are ``pressure`` [Pa], temperature ``rise`` per unit friction coefficient [K] and
        ``wear_depth`` [m]. The rise is NaN without a contact. If the point was computed on smaller
        elements than the scene's, values are means over the scene's elements.
        """
        return _fields_of(self.state, self.shape)

    @property
    def sampling(self) -> dict[str, Any]:
        """How rises differ between surface realizations, by variable of the dataset."""
        return self.state.heat.sampling if self.state.heat else _NO_SAMPLING

    def record(self, with_fields: bool) -> PointRecord:
        """Return the record of the point for a store, with contact fields if `with_fields`."""
        fields = self.fields if with_fields and "pressure" not in self.columns else {}
        columns = {name: v.copy() for name, v in self.columns.items()}
        for values in columns.values():
            values[-1] = _known(values[-1])
        return PointRecord(
            point=self.point,
            data={
                **columns,
                **{name: _known(v) for name, v in (self.sampling | {**self.film}).items()},
                **{name: _known(v).astype(np.float32) for name, v in fields.items()},
            },
            warning_flags=sum({int(warning.kind) for warning in self.warnings}),
            wall_time=self.wall_time,
        )

    def verdict(self, conditions: Conditions) -> Verdict:
        """Mild or severe wear at the worst step of the point's loading, under `conditions`."""
        judged = verdict(self.columns, self.least_load, conditions)
        return replace(judged, warnings=self.warnings)


@dataclass(frozen=True, slots=True, eq=False)
class PointRecord:
    """Stored result of a point; `data` are variables of the dataset, None if the point failed."""

    point: Point
    data: Mapping[str, Array | bytes] | None
    message: str = ""  # the reason for its failure
    warning_flags: int = 0  # sum of `WarningKind` codes
    wall_time: float = math.nan  # of the simulation [s]


def points(sweep: Sweep) -> tuple[Point, ...]:
    """All points of a sweep, by case, then by velocity, then by load."""
    return tuple(
        Point(load, velocity, name)
        for name, row in sweep.case_table.by_name.items()
        for velocity in _axis_values(row, "velocity", sweep.velocities)
        for load in _axis_values(row, "load", sweep.loads)
    )


def _axis_values(row: CaseRow, axis: str, usual: Sequence[float]) -> Sequence[Any]:
    """Loads or velocities (`axis`) of a case: the single value of its row, else `usual`."""
    return (row[axis],) if axis in row else usual


def _known(values: Any) -> Any:
    """Values with −1 for NaN: in a store NaN at the end of a point means never written."""
    return np.where(np.isnan(values), NOT_KNOWN, values)


class Task(NamedTuple):
    """A point to compute, and the loading ramp that it continues."""

    point: Point
    ramp: tuple[Any, ...]  # number of its mechanics, its velocity and its increment


def tasks(todo: Iterable[Point], sweep: Sweep) -> Iterator[Task]:
    """A task for each of the points `todo`, sorted by ramp, then by ascending load."""
    numbers: dict[Scene, int] = {}

    @functools.cache
    def ramp(name: CaseName, velocity: float, load: float) -> tuple[Any, ...]:
        scene = sweep.case(name).scene
        number = numbers.setdefault(mechanics(scene), len(numbers))
        return number, velocity, scene.ramp_increment(load)

    order = sorted(todo, key=lambda point: point.case)
    unsorted = [Task(point, ramp(point.case, point.velocity, point.load)) for point in order]
    yield from sorted(unsorted, key=lambda task: (task.ramp, task.point.load, task.point.case))


def run_point(
    scene: Scene,
    stored_steps: StoredSteps,
    point: Point,
    ramp_cache: RampCache | None = None,
    progress: Report = silent,
    with_film: bool = False,
    fields: Fields = False,
) -> PointResult:
    """Simulate a scene at a point, and record the results at its `stored_steps`.

    `ramp_cache` is a cache of load steps that were simulated for other points. This point continues
    from the cached steps, and its own steps are added to the cache. With None nothing is cached.
    `progress` is called after each step. `with_film` is True to also record the inlet of the worn
    contact, by which the film of an oil is judged. With `fields` "steps" the columns include them.
    """
    began = time.perf_counter()
    load, velocity, _ = point
    ramp_cache = ramp_cache or RampCache()
    fitted = fit_elements(scene, load)
    heat_steps = stored_steps.heat_steps(scene, load)
    stored = stored_steps.select(scene, load)
    record = partial(record_at, fitted, shape=scene.grid.shape if fields == "steps" else None)
    recorder, indices = None, {step.index for step in stored}
    if stored_steps.steps == "course":
        name = fitted, velocity, fields
        recorder = Recorder(name, lambda state: _increment_values(record, fitted, velocity, state))
        indices = {
            step.index for step in stored if step.index in heat_steps or step.normal_load >= load
        }
    memo = ramp_cache.memo(contact_key(fitted, load, velocity, heat_steps))
    results = memo.get(memo_key := (fitted, stored_steps, with_film, fields))
    if results is None:  # no point before it had this heat
        states: list[State] = []
        if isinstance(fitted.loading, Stages):
            states += stages_of(scene, load, velocity, ramp_cache)
            indices = set()
        for contact in (
            contacts(scene, load, velocity, ramp_cache, heat_steps, recorder) if indices else ()
        ):
            if contact.index in indices:
                is_last = contact.index == stored[-1].index
                states.append(_heated(fitted, velocity, contact, is_last))
            progress(Progress(done=contact.index, total=stored[-1].index))
        course = states[-1].course[: len(stored) - len(states)]  # the end may be one of its steps
        records = [*course, *map(record, states)]
        columns = {key: np.array([record[key] for record in records]) for key in records[0]}
        film = _film_of(fitted, states[-1]) if with_film else _NO_FILM
        results = memo[memo_key] = columns, states[-1], film
    columns, state, film = results
    return PointResult(
        point=point,
        columns=columns,
        state=state,
        shape=scene.grid.shape,
        least_load=least_load_evaluated(scene, load),
        warnings=tuple(point_warnings(scene, state)),
        wall_time=time.perf_counter() - began,
        film=film,
    )


def _film_of(scene: Scene, state: State) -> Mapping[str, Any]:
    """Values from which the oil film is computed, by variable; NaN without a solution."""
    try:
        return dict(zip(_NO_FILM, film_inlet(scene, state), strict=True))
    except TriboError:
        return _NO_FILM


def _heated(scene: Scene, velocity: float, contact: State, is_sampled: bool = False) -> State:
    """Copy of a solved contact with its temperature and distance at a sliding velocity [m/s]."""
    warm = contact.heat
    if warm is None and contact.pressure.any():
        warm = heat(scene, contact, velocity, is_sampled)
    return replace(contact, sliding_distance=abs(velocity) * contact.time, heat=warm)


def _increment_values(
    record: Callable[[State], Moment], scene: Scene, velocity: float, contact: State
) -> Moment:
    """Values to record of a contact after an increment, by variable."""
    try:
        values = record(_heated(scene, velocity, contact))
    except TriboError:  # without a temperature, which the end of a point does not need
        values = record(replace(contact, sliding_distance=abs(velocity) * contact.time))
    if contact.is_requested or not contact.pressure.any():
        return values
    # Not solved on the grid of the point: only time, load and distance are known.
    return {
        name: value if name in _LOADING_COLUMNS else value * np.nan
        for name, value in values.items()
    }


def record_at(scene: Scene, state: State, shape: tuple[int, int] | None = None) -> Moment:
    """Values to record at one time of a point's loading, by name of the variable in the dataset.

    With a `shape` they include the fields on as many elements.
    """
    record: dict[str, float | Array] = {
        **measures(scene, state),
        "rise_quantile": state.heat.rise_quantile if state.heat else _NO_QUANTILES,
    }
    if shape:
        record |= {k: values.astype(np.float32) for k, values in _fields_of(state, shape).items()}
    return record


def _fields_of(state: State, shape: tuple[int, int]) -> dict[str, Array]:
    """Fields of a state by name, as means over the elements of a grid of a `shape`."""
    pressure = state.pressure
    fields = {
        "pressure": pressure,
        "rise": state.heat.rise if state.heat else np.full_like(pressure, np.nan),
        "wear_depth": state.wear_depth,
    }
    if pressure.shape == shape:
        return fields
    blocks = (shape[0], -1, shape[1], pressure.shape[1] // shape[1])
    return {name: field.reshape(blocks).mean((1, 3)) for name, field in fields.items()}


def choose_stored_steps(sweep: Sweep) -> StoredSteps:
    """Steps (times of the loading) to store; those of an existing store do not change."""
    if sweep.stored_steps:
        return sweep.stored_steps
    steps, cases = sweep.steps, sweep._on_first_surface
    scenes = [case.scene for case in cases]
    if not steps:
        # Cases that share contacts would take 2.9 to 4.4 times as long with temperatures at all
        # steps of the course.
        are_ramps = all(
            isinstance(scene.loading, Ramp) and not scene.loading.hold for scene in scenes
        )
        contacts = [
            (mechanics(sweep.case(name).scene), row.get("velocity"))
            for name, row in sweep.case_table.by_name.items()
        ]
        wears = any(scene.wears for scene in scenes)
        are_distinct = len({*contacts}) == len(contacts)
        steps = "course" if are_ramps and wears and are_distinct else "end"
    # A disc or a track that stores heat warms up during the hold.
    loading, case_corrections = sweep.scene.loading, [case.conditions.corrections for case in cases]
    has_hold = isinstance(loading, Ramp) and bool(loading.hold)
    warms = has_hold and any(
        corrections.keeps_heat for corrections in case_corrections if corrections
    )
    return StoredSteps(steps, warms)
