"""The critical temperature of a scene's lubricant, computed from measured transitions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.run.boundary_search import RiseReader
from pipeline.run.cluster import Client
from pipeline.run.sweep import run_sweep
from pipeline.run.work import ExecutionError
from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.source import Source
from pipeline.store.place import PathLike
from pipeline.store.write import opened, store_path
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Report
from pipeline.sweep.tables import CURVE, replace_values
from pipeline.sweep.variants import Label, Variants, labelled_rows, surfaces
from tribo import Criterion, InputError
from tribo.errors import require_positive


class Transition(NamedTuple):
    """A measured transition from mild to severe wear: load [N], velocity [m/s], friction.

    Examples
    --------
    >>> Transition(normal_load=600.0, velocity=1.5, friction=0.1).velocity
    1.5
    """

    normal_load: float
    velocity: float
    friction: float


@shown
@dataclass(frozen=True, slots=True)
class CriticalTemperatures:
    """Critical temperatures [K] for each measured transition and random surface."""

    transitions: tuple[Transition, ...]  #: Measured transitions, each with its friction.
    #: Seeds of the surfaces; None for a surface that is not random.
    surfaces: tuple[int | None, ...]
    #: Critical temperatures [K], a row for each transition, a value for each surface.
    temperatures: tuple[tuple[float, ...], ...]
    criterion: Criterion  #: Criterion of severe wear that defines the temperature.

    @property
    def means(self) -> tuple[float, ...]:
        """Mean critical temperature over surfaces [K] of each transition."""
        return tuple(float(np.mean(row)) for row in self.temperatures)

    @property
    def spreads(self) -> tuple[float | None, ...]:
        """Standard deviation [K] over surfaces, by transition; None for a single surface."""
        return tuple(_spread(row) for row in self.temperatures)

    @property
    def mean(self) -> float:
        """Mean critical temperature over all transitions [K]."""
        return float(np.mean(self.means))

    @property
    def spread(self) -> float | None:
        """Standard deviation of critical temperatures between transitions [K]; None if only one."""
        return _spread(self.means)

    def as_dict(self) -> dict[str, Any]:
        """Return the criterion, surfaces, transitions and temperatures [K] as plain data."""
        rows = zip(self.transitions, self.temperatures, self.means, self.spreads, strict=True)
        return {
            "criterion": self.criterion.name,
            "share": self.criterion.share,
            "surfaces": list(self.surfaces),
            "transitions": [
                transition._asdict() | {"temperatures": list(row), "mean": mean, "spread": spread}
                for transition, row, mean, spread in rows
            ],
            "mean": self.mean,
            "spread": self.spread,
        }


@np.errstate(under="ignore")
def critical_temperatures(
    sweep: SceneLike,
    out: PathLike | None = None,
    workers: int | None = None,
    client: Client | None = None,
    progress: Report | None = None,
) -> CriticalTemperatures:
    """Find the critical temperature of a lubricant from measured transitions.

    It is the contact temperature that the scene's criterion judges, at a transition: by default
    that which the failing share of the contact area exceeds. A good model gives the same
    temperature at all transitions (Bosman & de Rooij, Table 6). A rig cannot measure this
    temperature.

    Parameters
    ----------
    sweep : Sweep, str or path
        Scene with measured transitions, or its path or name. Each of its random surfaces is
        simulated. A transition without friction, bulk temperature or time at full load takes the
        scene's value.
    out : path, optional
        Store of the simulated points, resumed if it exists. By default it is temporary.
    workers, client, progress : optional
        Number of processes, Dask client, and callback for progress, as in `pipeline.run_sweep`. In
        a script, call this under ``if __name__ == "__main__":``.

    Raises
    ------
    InputError
        If no transition was measured, or the friction at a transition is not above 0.
    ExecutionError
        If a point cannot be computed.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> with_one_test = scene.changed("measured", scene.entries["measured"][:1])
    >>> inferred = pipeline.critical_temperatures(with_one_test)
    >>> f"{inferred.mean - 273.15:.0f} °C"
    '149 °C'
    """
    sweep = sweep_of(sweep)
    if not sweep.measured:
        raise InputError(
            f"the scene {sweep.name} has no measured transition; give it a [[measured]] with "
            "load and velocity"
        )
    transitions = tuple(
        Transition(
            entry.normal_load,
            entry.velocity,
            entry.simulated.conditions.friction_at(entry.velocity),
        )
        for entry in sweep.measured
    )
    seeds = tuple(map(int, sweep.variants.axes.get("realization", ())))
    on: tuple[int | None, ...] = seeds or (getattr(sweep.scene.roughness, "seed", None),)
    for crossing in transitions:
        require_positive(friction=crossing.friction)
    asked = _transition_rows(sweep, surfaces(seeds))
    with store_path(out) as path:
        run_sweep(asked, path, workers, client, progress, retry_failed=True)
        reader, todo = RiseReader(opened(path)), points(asked)
    if failed := reader.failed(todo):
        raise ExecutionError(
            f"{min(failed)} could not be computed; see irg check of the scene, or give another "
            "fidelity"
        )
    by_row: dict[Label, list[float]] = {number: [] for number in range(len(transitions))}
    for point in sorted(todo, key=lambda point: point.variant):
        conditions = asked.case(point.variant).conditions
        (rise,) = reader.rises([point], conditions).tolist()
        by_row[point.variant[0][1]].append(conditions.contact_temperature(rise))
    temperatures = tuple(tuple(values) for values in by_row.values())
    return CriticalTemperatures(transitions, on, temperatures, sweep.conditions.criterion)


def as_transitions(sweep: Sweep) -> Sweep:
    """Return the sweep with its tests of known outcome as measured transitions."""
    tests = sweep.entries.get("tested", ())
    entries = [{k: v for k, v in one.items() if k not in ("outcome", "run")} for one in tests]
    return sweep.changed("measured", entries or None)


def _transition_rows(sweep: Sweep, seeds: Variants) -> Sweep:
    """Sweep with a variant for each transition, at its load, velocity and conditions.

    `seeds` are the variants with the random surfaces; each is combined with each transition.
    """
    changes: dict[Label, dict[str, Any]] = {}
    for number, test in enumerate(sweep.measured):
        row: dict[str, Any] = {"temperature.critical": None, **test.changes}
        if test.friction is not None:  # a measured value replaces friction curves
            row |= {CURVE: None, "friction.coefficient": test.friction}
        if test.bulk_temperature is not None:
            row["temperature.bulk"] = f"{test.bulk_temperature!r} K"
        if test.hold is not None:
            _ = sweep.with_hold(test.hold)  # raises if the load is recorded
            row["loading.hold"] = f"{test.hold!r} s"
        changes[number] = row
    loads = [test.normal_load for test in sweep.measured]
    velocities = [test.velocity for test in sweep.measured]
    table = labelled_rows("test", changes, load=loads, velocity=velocities) * seeds
    entries: dict[str, Any] = {"sweep.fields": False}
    for name, values, unit in (("loads", loads, "N"), ("velocities", velocities, "m/s")):
        entries[f"sweep.{name}"] = [f"{value!r} {unit}" for value in sorted({*values})]
    source: Source = sweep.source
    made = source.read_again(sweep, replace_values(source.written, entries), table)
    return replace(made, tests=())  # their rows stand for them


def _spread(values: tuple[float, ...]) -> float | None:
    return float(np.std(values, ddof=1)) if len(values) > 1 else None
