"""Sweeps with other objects of the physics: they are data, and a test replaces what it wants."""

from dataclasses import fields, replace

import tribo
from pipeline.sweep.case import SpecimenTest
from pipeline.sweep.case_table import PLACE_UNITS, CaseTable, Column, numbered_cases

_SCENE = {one.name for one in fields(tribo.Scene)}
_CASE = {
    "conditions",
    "friction_band",
    "model_bias",
    "model_scatter",
    "oil",
    "preset",
    "critical_from_tests",
}
_SWEEP = {
    "name", "title", "note", "notes", "sources", "stored_steps", "loads", "velocities", "fields",
    "steps", "case_table",
}  # fmt: skip
FIELDS = {*_SCENE, *_CASE, *_SWEEP, "tests"}


def bare_test(load, velocity, friction=None, case=None, **more):
    """A test of a case of its own, or without one, which `changed` gives it."""
    return SpecimenTest(load, velocity, case, friction, **more)


class Rows(CaseTable):
    """A table of cases, and the objects that each of its rows replaces, by path."""

    def __init__(self, table, changes):
        super().__init__(table.columns, table.rows)
        object.__setattr__(self, "changes", [*changes])

    def __rmul__(self, other):
        return Rows(CaseTable.__mul__(other, self), [*self.changes] * len(other))


def changed(sweep, **values):
    """Copy of a sweep with other values of fields, of its cases and of the scenes of these."""
    assert values.keys() <= FIELDS, values.keys() - FIELDS
    own = {name: value for name, value in values.items() if name in _SWEEP}
    objects = {name: value for name, value in values.items() if name in {*_SCENE, *_CASE}}
    base, *cases = (_case(one, objects) for one in (sweep.base, *sweep.cases))
    if rows := own.pop("case_table", None):
        table = CaseTable(rows.columns, rows.rows)
        changes = getattr(rows, "changes", [{} for _ in rows.rows])
        pairs = zip(table.names, changes, strict=True)
        cases = [replace(_case(base, _seeded(name) | one), name=name) for name, one in pairs]
        own["case_table"] = table
    made = replace(sweep, base=base, cases=tuple(cases), source=None, **own)
    tests = values.get("tests", made.tests)
    numbered = (_with_case(test, k, made.base) for k, test in enumerate(tests))
    return replace(made, tests=tuple(numbered))


def _seeded(name):
    seeds = [label for dim, label in name if dim == "realization"]
    return {"roughness.seed": seeds[0]} if seeds else {}


def _with_case(test, number, base):
    from pipeline.scene.tests import test_case

    of = test.case if test.case and not test.case.name else base
    return replace(test, case=test_case(of, number, test), number=test.number or str(number + 1))


def _case(case, changes):
    whole = {path: value for path, value in changes.items() if path in _SCENE}
    case = replace(case, scene=replace(case.scene, **whole))  # in one step: pin and pixels fit
    case = replace(case, conditions=case.conditions.under(case.scene.loading))
    for path, value in changes.items():
        first = path.partition(".")[0]
        if path in whole:
            continue
        if first in _SCENE:
            case = replace(case, scene=_replaced(case.scene, path, value))
        elif path == "conditions":
            case = replace(case, conditions=value.under(case.scene.loading))
        else:
            case = _replaced(case, "lubricant" if path == "oil" else path, value)
    return case


def _replaced(made, path, value):
    first, _, rest = path.partition(".")
    return replace(made, **{first: _replaced(getattr(made, first), rest, value) if rest else value})


def rows(name, changes, velocities=None, loads=None):
    """Cases of a sweep; `changes` has for each label the changed fields [SI] or objects."""
    places = {"load": loads, "velocity": velocities}
    return labelled_rows(name, changes, **{k: v for k, v in places.items() if v is not None})


def placed_rows(*places):
    """Numbered cases, each (load, velocity), or with further labels."""
    held = [
        {**labels, "load": load, "velocity": velocity}
        for load, velocity, labels in ((*one, {})[:3] for one in places)
    ]
    columns = (
        Column(name, PLACE_UNITS.get(name, "1"), meaning=f"{name} of the row") for name in held[0]
    )
    return numbered_cases(columns, held)


def two_pins():
    """Two cases of a sweep, with pin radii of 1 and 2 mm."""
    column = Column("pin_radius", "m", entry="pin.radius", shown="mm")
    radii = (1e-3, 2e-3)
    table = CaseTable((column,), tuple({"pin_radius": one} for one in radii))
    return Rows(table, [{"pin.radius": one} for one in radii])


def labelled_rows(name, changes, **places):
    """Table of cases along one dimension, called `name`: a row for each label in `changes`.

    For each label, `changes` has the objects that the case replaces. `places` may give each
    case its own ``load`` [N] or ``velocity`` [m/s].
    """
    is_text = isinstance(next(iter(changes)), str)
    key = Column(name, None if is_text else "1", meaning=f"{name} of the scene")
    own = (Column(one, PLACE_UNITS[one], name, meaning=f"{one} of each {name}") for one in places)
    labels = (
        {name: label} | {one: float(values[k]) for one, values in places.items()}
        for k, label in enumerate(changes)
    )
    return Rows(CaseTable((key, *own), tuple(labels)), [*changes.values()])
