"""Points of several systems, whose contacts are computed once at each load and wear number.

Systems that differ in wear rate and thermal constants alone have the same contacts where the
product of wear rate and velocity is the same; see `tribo.contacts`. The heat on these contacts is
computed for each system.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import chains, columns_of, run_point
from tribo import PointWarning, Scene, State, heated, inseparable, mechanics, warnings, wear_number
from tribo.types import Array

_DIGITS = 12  # of a wear number: two that ought to be the same differ by rounding

_Contact = tuple[Scene, float, float]
"""System, wear number and load of a contact."""


class SharedPoint(NamedTuple):
    """Columns of a point by step, and its warnings; some columns begin when the load is reached."""

    columns: dict[str, Array]
    warnings: tuple[PointWarning, ...]


class SharedContacts:
    """Contacts that were computed, for reuse by points of other systems, and their number."""

    def __init__(self) -> None:
        self._states: dict[_Contact, tuple[State, ...]] = {}
        self.computed = 0

    def points(self, sweep: Sweep, wanted: Iterable[Point]) -> dict[Point, SharedPoint]:
        """Compute points of a system, on contacts of others where these are the same."""
        results = {}
        is_shared = inseparable(sweep.scene, sweep.plane.velocities) is None
        for chain in chains(wanted, sweep):
            variant = sweep.variant(chain[0].variant)
            system, trunk = mechanics(variant.scene), None
            for point in chain:
                number = float(f"{wear_number(variant.scene, point.velocity):.{_DIGITS}g}")
                contact = system, number, point.load
                if contact in self._states:
                    results[point] = _heated(variant, point, self._states[contact])
                    continue
                result = run_point(sweep, *point, trunk=trunk)
                trunk = result.trunk
                self.computed += 1
                results[point] = SharedPoint(result.columns, result.warnings)
                if is_shared:
                    self._states[contact] = tuple(map(_lighter, result.at_load))
        return results


def _heated(sweep: Sweep, point: Point, contacts: Iterable[State]) -> SharedPoint:
    """A point on contacts of another one."""
    states = [heated(sweep.scene, contact, point.velocity) for contact in contacts]
    return SharedPoint(columns_of(sweep, states), tuple(warnings(sweep.scene, states[-1])))


def _lighter(state: State) -> State:
    """The state, stripped to the parts that its temperature and record need."""
    return replace(
        state,
        heat=None,
        history=None,
        previous_pressure=state.pressure,
        displacement=None,
        previous_displacement=None,
    )
