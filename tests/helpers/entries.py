"""Sweeps with other objects of the physics: they are data, and a test replaces what it wants."""

from dataclasses import dataclass, fields, replace

import tribo
from pipeline.sweep.case import SpecimenTest
from pipeline.sweep.case_table import PLACE_UNITS, CaseTable, Column, numbered_cases
from pipeline.sweep.sweep import Sweep

_SCENE = {field.name for field in fields(tribo.Scene)}
_SWEEP = {field.name for field in fields(Sweep)} - {"base", "cases", "tests"}


@dataclass(frozen=True)
class BareTest(SpecimenTest):
    """A test whose case lacks its friction and bulk temperature, or that has no case."""

    friction: float | None = None
    bulk_temperature: float | None = None


def bare_test(load, velocity, friction=None, case=None, **more):
    """A test for `changed`, which builds its case; from `case`, or from that of the sweep."""
    return BareTest(load, velocity, case, friction=friction, **more)


class Rows(CaseTable):
    """A table of cases, and the objects that each of its rows replaces, by path."""

    def __init__(self, table, changes):
        super().__init__(table.columns, table.rows, table.load_factors)
        object.__setattr__(self, "changes", [*changes])

    def __rmul__(self, other):
        return Rows(CaseTable.__mul__(other, self), [*self.changes] * len(other))


def changed(sweep, **values):
    """Copy of a sweep with new values of fields of the sweep, its cases and their scenes."""
    sweep_values = {name: value for name, value in values.items() if name in _SWEEP}
    objects = {name: value for name, value in values.items() if name not in {*_SWEEP, "tests"}}
    base, *cases = (_case(case, objects) for case in (sweep.base, *sweep.cases))
    if rows := sweep_values.pop("case_table", None):
        table = CaseTable(rows.columns, rows.rows, rows.load_factors)
        changes = getattr(rows, "changes", [{} for _ in rows.rows])
        pairs = zip(table.names, changes, strict=True)
        cases = [replace(_case(base, _seeded(name) | change), name=name) for name, change in pairs]
        sweep_values["case_table"] = table
    copy = replace(sweep, base=base, cases=tuple(cases), source=None, **sweep_values)
    tests = values.get("tests", copy.tests)
    numbered = (_with_case(test, k, copy.base, sweep.base) for k, test in enumerate(tests))
    return replace(copy, tests=tuple(numbered))


def _seeded(name):
    seeds = [label for dim, label in name if dim == "realization"]
    return {"roughness.seed": seeds[0]} if seeds else {}


def _with_case(test, number, base, unchanged_base):
    """A test with a case of `base`; it keeps friction and bulk temperature of its own."""
    from pipeline.scene.tests import test_case

    values = {field.name: getattr(test, field.name) for field in fields(SpecimenTest)}
    if isinstance(test, BareTest):
        own, base = (test.friction, test.bulk_temperature), test.case or base
    else:
        of_test, of_sweep = test.case.conditions, unchanged_base.conditions
        pairs = (
            (of_test.friction, of_sweep.friction),
            (of_test.bulk_temperature, of_sweep.bulk_temperature),
        )
        own = (None if value == of_base else value for value, of_base in pairs)
    case = test_case(base, number, *own)
    return SpecimenTest(**values | {"case": case, "number": test.number or str(number + 1)})


def _case(case, changes):
    scene_fields = {path: value for path, value in changes.items() if path in _SCENE}
    # In one step, because pin and pixels must fit.
    case = replace(case, scene=replace(case.scene, **scene_fields))
    case = replace(case, conditions=case.conditions.with_loading(case.scene.loading))
    for path, value in changes.items():
        first = path.partition(".")[0]
        if path in scene_fields:
            continue
        if first in _SCENE:
            case = replace(case, scene=_replaced(case.scene, path, value))
        elif path == "conditions":
            case = replace(case, conditions=value.with_loading(case.scene.loading))
        else:
            case = _replaced(case, "lubricant" if path == "oil" else path, value)
    return case


def _replaced(instance, path, value):
    first, _, rest = path.partition(".")
    return replace(
        instance, **{first: _replaced(getattr(instance, first), rest, value) if rest else value}
    )


def placed_rows(*positions, load_factors=()):
    """Numbered cases, each (load, velocity), or with further labels, at shares of their loads."""
    case_rows = [
        {**labels, "load": load, "velocity": velocity}
        for load, velocity, labels in ((*position, {})[:3] for position in positions)
    ]
    columns = (
        Column(name, PLACE_UNITS.get(name, "1"), meaning=f"{name} of the row")
        for name in case_rows[0]
    )
    return numbered_cases(columns, case_rows, load_factors)


def two_pins():
    """Two cases of a sweep, with pin radii of 1 and 2 mm."""
    column = Column("pin_radius", "m", entry="pin.radius", display_unit="mm")
    radii = (1e-3, 2e-3)
    table = CaseTable((column,), tuple({"pin_radius": radius} for radius in radii))
    return Rows(table, [{"pin.radius": radius} for radius in radii])


def rows(name, changes, **positions):
    """Table of cases along one dimension, called `name`: a row for each label in `changes`.

    `changes` maps each label to the objects that its case replaces. `positions` may give each
    case its own ``load`` [N] or ``velocity`` [m/s].
    """
    is_text = isinstance(next(iter(changes)), str)
    key = Column(name, None if is_text else "1", meaning=f"{name} of the scene")
    columns = (
        Column(axis, PLACE_UNITS[axis], name, meaning=f"{axis} of each {name}")
        for axis in positions
    )
    labels = (
        {name: label} | {axis: float(values[k]) for axis, values in positions.items()}
        for k, label in enumerate(changes)
    )
    return Rows(CaseTable((key, *columns), tuple(labels)), [*changes.values()])
