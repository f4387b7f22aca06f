"""How far each uncertain input moves y, for one standard deviation of it, at places and tests.

A simulated input has a point one standard uncertainty away; ln(rise) there minus ln(rise) of the
scene is its effect. Between its places of the plane it is linear in ln(load) and ln(velocity), and
beyond them constant. Conditions follow from the limit of the rise in closed form.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.analysis.results import Results
from pipeline.sweep.conditions import FIELDS, Conditions
from pipeline.sweep.inputs import CRITICAL, Input, InputPoints
from pipeline.sweep.measurement import Measurement
from tribo.types import Array

_STATED = {
    "friction.coefficient": ("friction", "friction"),
    "temperature.bulk": ("bulk_temperature", "temperature"),
}
"""Conditions that a test may state: its own entry, and the table of its changes."""


@dataclass(frozen=True, eq=False)
class Effects:
    """Effects of the uncertain inputs of a scene on y.

    `conditions` are those before the tests, whose critical temperature has its uncertainty there.
    """

    inputs: tuple[Input, ...]
    data: Results
    conditions: Conditions

    @property
    def critical(self) -> int | None:
        """Index of the critical temperature among the inputs; None if it is certain."""
        paths = [one.path for one in self.inputs]
        return paths.index(CRITICAL) if CRITICAL in paths else None

    @property
    def scale(self) -> float:
        """Standard deviation of λ = ln(critical − bulk temperature of the scene), 1 if unknown."""
        spread = None if self.critical is None else self.inputs[self.critical].spread
        return 1.0 if spread is None else spread / (self._prior - self.bulk)

    @property
    def _prior(self) -> float:
        return self.conditions.critical_temperature or math.nan

    @property
    def bulk(self) -> float:
        """Coldest bulk temperature of the scene [K], from which λ counts."""
        return self.data.stored.conditions.coldest_bulk_temperature

    @property
    def waiting(self) -> tuple[str, ...]:
        """Paths of simulated inputs without the points that they need."""
        lacking = (one.path for one in self.inputs if one.is_simulated and self._lacks(one))
        return tuple(lacking)

    def _lacks(self, one: Input) -> bool:
        at_tests = [self.at_tests.get((one.path, number), 0.0) for number in one.tests]
        return bool(np.isnan([*self._nodes[one.path], *at_tests]).any())

    def at(self, conditions: Conditions, loads: Array, velocities: Array) -> Array:
        """Change of y at k places under `conditions`, for each of n inputs (k, n)."""
        columns = [
            self.interpolate(np.nan_to_num(self._nodes[one.path]), loads, velocities)
            if one.is_simulated
            else np.full(len(loads), self._by_condition(one, conditions))
            for one in self.inputs
        ]
        return np.reshape(columns, (len(self.inputs), len(loads))).T

    def middle(self, conditions: Conditions) -> tuple[float, ...]:
        """Change of y for each input, the mean over the plane."""
        return tuple(
            float(np.mean(np.nan_to_num(self._nodes[one.path])))
            if one.is_simulated
            else self._by_condition(one, conditions)
            for one in self.inputs
        )

    def of_test(self, number: int, test: Measurement, own: Conditions) -> tuple[float, ...]:
        """Change of y at a test for each input; 0 for what the test states itself."""
        found = []
        for one in self.inputs:
            if one.is_simulated:
                value = self.at_tests.get((one.path, number), 0.0)
                found.append(0.0 if math.isnan(value) else value)
            else:
                found.append(0.0 if _states(test, one.path) else self._by_condition(one, own))
        return tuple(found)

    def _by_condition(self, one: Input, conditions: Conditions) -> float:
        critical = conditions.critical_temperature
        above = (critical or math.nan) - conditions.coldest_bulk_temperature
        if one.path == CRITICAL:
            return -self.scale * ((critical or math.nan) - self.bulk) / above
        return (one.spread or 0.0) / (above if one.is_kelvin else 1.0)

    @functools.cached_property
    def _rises(self) -> dict[tuple[str, int | None], tuple[Array, Array, Array]]:
        """Loads, velocities and ln(rise) of the points of each input, by path and test."""
        data, found = self.data, {}
        for number, one in enumerate(data.stored._own_points):
            if isinstance(one, InputPoints):
                points = np.flatnonzero(data.tests.numbers == number)
                under = replace(self.conditions, corrections=one.simulated.conditions.corrections)
                rises = [data.tests.rise(point, under) for point in points.tolist()]
                places = np.array(one.places).T
                found[one.path, one.test] = (*places, np.log(np.maximum(rises, 1e-9)))
        return found

    @functools.cached_property
    def _nodes(self) -> dict[str, Array]:
        """Effect of each simulated input at its places of the plane, by path."""
        own = self._rises
        if not own:
            return {}
        *_, base = own["", None]
        return {
            path: rises[-1] - base for (path, test), rises in own.items() if path and test is None
        }

    @functools.cached_property
    def at_tests(self) -> dict[tuple[str, int], float]:
        """Effect of each simulated input at each test, by path and number of the test."""
        found, data = {}, self.data
        for (path, test), (*_, rises) in self._rises.items():
            if test is not None and data.takes_tests:
                points = np.flatnonzero(data.tests.numbers == test).tolist()
                corrections = data.stored.tests[test].simulated.conditions.corrections
                under = replace(self.conditions, corrections=corrections)
                base = np.log([max(data.tests.rise(point, under), 1e-9) for point in points])
                is_known = bool(np.isfinite(base).all())  # else the test says nothing yet
                found[path, test] = float(np.mean(rises - base)) if is_known else 0.0
        return found

    @property
    def nodes(self) -> tuple[Array, Array] | None:
        """Loads and velocities of the plane at which inputs are simulated, or None."""
        if not any(one.is_simulated for one in self.inputs):
            return None
        loads, velocities, _ = self._rises["", None]
        return loads, velocities

    def interpolate(self, values: Array, loads: Array, velocities: Array) -> Array:
        """Interpolate values at `nodes` to k places."""
        assert self.nodes is not None
        y, x = map(np.unique, self.nodes)
        plane = values.reshape(len(y), len(x))
        moving = np.maximum(velocities, x[0])
        rows = np.array([np.interp(np.log(moving), np.log(x), row) for row in plane])
        part = np.interp(np.log(loads), np.log(y), np.arange(len(y)))
        low = np.minimum(part.astype(int), max(len(y) - 2, 0))
        each, high = np.arange(len(loads)), np.minimum(low + 1, len(y) - 1)
        return np.asarray(rows[low, each] + (part - low) * (rows[high, each] - rows[low, each]))


def _states(test: Measurement, path: str) -> bool:
    """True if a test states a condition itself."""
    if path not in _STATED:
        return False
    name, table = _STATED[path]
    return getattr(test, name) is not None or any(one.startswith(table) for one in test.changes)


def effects_of(
    data: Results, conditions: Conditions, given: Iterable[str] = (), infers: bool = False
) -> Effects:
    """Effects of the uncertain inputs of a scene, under `conditions`.

    `given` has the names of conditions that were given for a place. They keep their uncertainty,
    unless they are to be exact; a critical temperature that is to come from tests alone is then
    certain. With `infers` it is uncertain in any case.
    """
    names = {FIELDS[name] for name in given} | data.judged.keys()
    inputs: Sequence[Input] = [
        one
        for one in data.stored.inputs
        if not (one.path in names and (data.is_exact or one.spread is None))
        and (one.spread is not None or data.takes_tests)
    ]
    if infers and CRITICAL not in [one.path for one in inputs]:
        start = conditions.critical_temperature or math.nan
        inputs = [*inputs, Input(CRITICAL, "from tests", start, "degC", None, is_kelvin=True)]
    return Effects(tuple(inputs), data, conditions)
