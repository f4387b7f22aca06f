"""The points of a sweep and of its tests, their tasks, and how a point is computed.

A task is one point. It continues a cached ramp with the same mechanics, velocity and increment,
from the last increment below its load. Whichever ramp a point continues, its results are the same,
bit for bit. The points of tests are those of a sweep of their own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple, Self

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.sweep.case import TEST, Case, Conditions
from pipeline.sweep.case_table import PLACE_UNITS, CaseName, CaseTable, Column
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
from tribo.simulation.pin_ends import end_rise_ratio
from tribo.simulation.verdict import verdict
from tribo.types import Array

StepValues = Mapping[str, float | Array]
"""Values at a step of a point, by variable of the dataset."""

NOT_KNOWN = -1.0
"""Stored at the end of a point instead of NaN, such as for the film of a ball."""
_LOADING_COLUMNS = ("time", "normal_load", "sliding_distance")  # known without a contact
_NO_QUANTILES = np.full(len(QUANTILES), np.nan)
_NO_SAMPLING = {"rise_realization_std": _NO_QUANTILES, "rise_realization_freedom": math.nan}
_NO_FILM: Mapping[str, Any] = {"film_inlet": math.nan, "film_pressure": math.nan}
TEST_POINT = "test_point"
"""Dimension of the points of tests."""


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
    film: Mapping[str, Any]
    #: Quantiles of the rise at the hottest end of the pin over those of the whole pin; NaN if the
    #: pin is not computed with its ends.
    end_rise_ratio: Array

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
        columns = {name: column.copy() for name, column in self.columns.items()}
        for column in columns.values():
            column[-1] = _without_nan(column[-1])
        estimates = self.sampling | {**self.film, "end_rise_ratio": self.end_rise_ratio}
        return PointRecord(
            point=self.point,
            data={
                **columns,
                **{name: _without_nan(value) for name, value in estimates.items()},
                **{
                    name: _without_nan(values).astype(np.float32) for name, values in fields.items()
                },
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
        for velocity in ((float(row["velocity"]),) if "velocity" in row else sweep.velocities)
        for load in sweep.case_table.loads_of(row) or sweep.loads
    )


def _without_nan(values: Any) -> Any:
    """Values with −1 for NaN: in a store NaN at the end of a point means never written."""
    return np.where(np.isnan(values), NOT_KNOWN, values)


class Task(NamedTuple):
    """A point to compute, and the loading ramp that it continues."""

    point: Point
    ramp: tuple[Any, ...]  # number of its mechanics, its velocity and its increment


def tasks(todo: Iterable[Point], sweep: Sweep) -> Iterator[Task]:
    """A task for each of the points `todo`, sorted by ramp, then by ascending load."""
    points_by_case = sorted(todo, key=lambda point: point.case)
    scenes = {
        name: sweep.case(name).scene for name in dict.fromkeys(p.case for p in points_by_case)
    }
    numbers: dict[Scene, int] = {}
    mechanics_numbers = {
        name: numbers.setdefault(mechanics(scene), len(numbers)) for name, scene in scenes.items()
    }
    unsorted = list[Task]()
    for point in points_by_case:
        increment = scenes[point.case].ramp_increment(point.load)
        ramp = mechanics_numbers[point.case], point.velocity, increment
        unsorted.append(Task(point, ramp))
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
    fitted_scene = fit_elements(scene, load)
    heat_steps = stored_steps.heat_steps(scene, load)
    load_steps = stored_steps.select(scene, load)
    field_shape = scene.grid.shape if fields == "steps" else None
    values_at = partial(step_values, fitted_scene, shape=field_shape)
    recorder, solved_indices = None, {step.index for step in load_steps}
    if stored_steps.steps == "course":
        values_of_increment = partial(_increment_values, values_at, fitted_scene, velocity)
        recorder = Recorder((fitted_scene, velocity, fields), values_of_increment)
        solved_indices = {
            step.index
            for step in load_steps
            if step.index in heat_steps or step.normal_load >= load
        }
    results = ramp_cache.memo(contact_key(fitted_scene, load, velocity, heat_steps)).results
    key = fitted_scene, stored_steps, with_film, fields
    if key not in results:  # no point before it had this heat
        states: list[State] = []
        if isinstance(fitted_scene.loading, Stages):
            states += stages_of(scene, load, velocity, ramp_cache)
            solved_indices = set()
        ramp = contacts(scene, load, velocity, ramp_cache, heat_steps, recorder)
        for contact in ramp if solved_indices else ():
            if contact.index in solved_indices:
                is_last = contact.index == load_steps[-1].index
                states.append(_heated(fitted_scene, velocity, contact, is_last))
            progress(Progress(done=contact.index, total=load_steps[-1].index))
        course = recorder.course if recorder else ()  # may include the end
        course = course[: len(load_steps) - len(states)]
        rows = [*course, *map(values_at, states)]
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        film = _film_of(fitted_scene, states[-1]) if with_film else _NO_FILM
        results[key] = columns, states[-1], film
    columns, state, film = results[key]
    return PointResult(
        point=point,
        columns=columns,
        state=state,
        shape=scene.grid.shape,
        least_load=least_load_evaluated(scene, load),
        warnings=tuple(point_warnings(scene, state)),
        wall_time=time.perf_counter() - began,
        film=film,
        end_rise_ratio=end_rise_ratio(scene, state),
    )


def _film_of(scene: Scene, state: State) -> Mapping[str, Any]:
    """Values from which the oil film is computed, by variable; NaN without a solution."""
    try:
        return dict(zip(_NO_FILM, film_inlet(scene, state), strict=True))
    except TriboError:
        return _NO_FILM


def _heated(scene: Scene, velocity: float, contact: State, is_sampled: bool = False) -> State:
    """Copy of a solved contact with its temperature and distance at a sliding velocity [m/s]."""
    contact_heat = contact.heat
    if contact_heat is None and contact.pressure.any():
        contact_heat = heat(scene, contact, velocity, is_sampled)
    return replace(contact, sliding_distance=abs(velocity) * contact.time, heat=contact_heat)


def _increment_values(
    values_at: Callable[[State], StepValues], scene: Scene, velocity: float, contact: State
) -> StepValues:
    """Values to record of a contact after an increment, by variable."""
    try:
        values = values_at(_heated(scene, velocity, contact))
    except TriboError:  # without a temperature, which the end of a point does not need
        values = values_at(replace(contact, sliding_distance=abs(velocity) * contact.time))
    if contact.is_requested or not contact.pressure.any():
        return values
    # Not solved on the grid of the point: only time, load and distance are known.
    return {
        name: value if name in _LOADING_COLUMNS else value * np.nan
        for name, value in values.items()
    }


def step_values(scene: Scene, state: State, shape: tuple[int, int] | None = None) -> StepValues:
    """Values to record at one time of a point's loading, by name of the variable in the dataset.

    With a `shape` they include the fields on as many elements.
    """
    values: dict[str, float | Array] = {
        **measures(scene, state),
        "rise_quantile": state.heat.rise_quantile if state.heat else _NO_QUANTILES,
    }
    if shape:
        fields = _fields_of(state, shape)
        values |= {name: field_values.astype(np.float32) for name, field_values in fields.items()}
    return values


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


@dataclass(frozen=True, slots=True)
class CaseInputs:
    """Common data of the points of a case: the scene, and what to record."""

    scene: Scene
    stored_steps: StoredSteps
    fields: Fields
    with_film: bool

    @classmethod
    def from_sweep(cls, sweep: Sweep, name: CaseName) -> Self:
        """Inputs of the case of a name."""
        case = sweep.case(name)
        return cls(case.scene, choose_stored_steps(sweep), sweep.fields_of(name), case.has_film)

    def simulate(self, point: Point, ramp_cache: RampCache | None = None) -> PointRecord:
        """Simulate a point of the case, and return its record for a store."""
        result = run_point(
            self.scene, self.stored_steps, point, ramp_cache,
            with_film=self.with_film, fields=self.fields,
        )  # fmt: skip
        return result.record(bool(self.fields))


def choose_stored_steps(sweep: Sweep) -> StoredSteps:
    """Steps (times of the loading) to store; those of an existing store do not change."""
    if sweep.stored_steps:
        return sweep.stored_steps
    steps, cases = sweep.steps, sweep.on_first_surface
    scenes = [case.scene for case in cases]
    if not steps:
        # Cases that share contacts would take 2.9 to 4.4 times as long with temperatures at all
        # steps of the course.
        are_ramps = all(
            isinstance(scene.loading, Ramp) and not scene.loading.hold for scene in scenes
        )
        contact_keys = [
            (mechanics(sweep.case(name).scene), row.get("velocity"))
            for name, row in sweep.case_table.by_name.items()
        ]
        wears = any(scene.wears for scene in scenes)
        are_distinct = len({*contact_keys}) == len(contact_keys)
        steps = "course" if are_ramps and wears and are_distinct else "end"
    return StoredSteps(steps, _judges_holds(cases))


def with_sweep_of_tests(sweep: Sweep) -> list[Sweep]:
    """The sweep and, if it has tests or variants, the sweep of their points, a row for each."""
    tests = sweep.tests_and_variants
    if not tests:
        return [sweep]
    columns = (
        Column(TEST_POINT, meaning="number of the point of a test"),
        Column(TEST, "1", TEST_POINT, meaning="number of the test"),
        *(
            Column(k, unit, TEST_POINT, meaning=f"{k} of the test")
            for k, unit in PLACE_UNITS.items()
        ),
    )
    points = [(number, *point) for number, test in enumerate(tests) for point in test.points]
    rows = tuple(
        {TEST_POINT: k, TEST: number, "load": load, "velocity": velocity}
        for k, (number, load, velocity) in enumerate(points)
    )
    cases = [tests[number].case for number, *_ in points]
    sweep_of_tests = replace(
        sweep,
        cases=tuple(replace(case, name=((TEST_POINT, k),)) for k, case in enumerate(cases)),
        case_table=CaseTable(columns, rows),
        loads=tuple(sorted({load for _, load, _ in points})),
        velocities=tuple(sorted({velocity for *_, velocity in points})),
        fields=False,
        tests=(),
        variants=(),
        stored_steps=StoredSteps("end", _judges_holds(cases)),
    )
    return [sweep, sweep_of_tests]


def _judges_holds(cases: Iterable[Case]) -> bool:
    """True if holds are judged at each step: a disc or a track that stores heat warms up then."""
    all_corrections = (case.conditions.corrections for case in cases)
    return any(corrections.keeps_heat for corrections in all_corrections if corrections)
