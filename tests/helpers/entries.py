"""Entries of a scene for objects of the physics, so that tests may give either."""

from dataclasses import fields, is_dataclass, replace
from types import SimpleNamespace

import numpy as np

import tribo
from pipeline.scene.cases_of_tests import attach_case
from pipeline.scene.declare import table_of
from pipeline.scene.fidelity import FidelityTable, complete_fidelity
from pipeline.scene.format import (
    Archard,
    MaterialTable,
    MotionTable,
    OilTable,
    RampTable,
    RandomSurface,
)
from pipeline.scene.format_of_tests import Test, TransitionTable
from pipeline.scene.kinds import Quantity
from pipeline.scene.written import entries_of
from pipeline.sweep.conditions import FIELDS as PATHS_OF
from pipeline.sweep.conditions import UNITS as UNITS_OF
from pipeline.sweep.conditions import plain_values
from pipeline.sweep.tables import replace_value
from pipeline.sweep.variants import PLACE_UNITS, Column, Row, Variants, numbered_rows
from tribo.simulation.pins import sizes_of

_OF_SWEEP = {"name", "variants", "notes", "sources", "stations"}
_TESTS = {"measured": False, "tested": True}  # True if each test has an outcome
_DECLARED = ("title", "caveat", "friction_band", "model_scatter", "model_bias", "uncertainty")
PART_OF = {one.name: "scene" for one in fields(tribo.Scene)}
PART_OF |= dict.fromkeys((*_TESTS, "oil", "preset"), "parts")
PART_OF |= dict.fromkeys(("loads", "velocities", "fields", "steps"), "plane")
FIELDS = {*PART_OF, *_DECLARED, *_OF_SWEEP, "conditions"}


def changed(sweep, **values):
    """Copy of a sweep with other values of fields, written as scene entries where possible."""
    assert values.keys() <= FIELDS, values.keys() - FIELDS
    if any(bool(test.outcome) != _TESTS[k] for k in _TESTS for test in values.get(k, ())):
        tests = (*values.get("measured", ()), *values.get("tested", ()))
        values["measured"] = tuple(test for test in tests if not test.outcome)
        values["tested"] = tuple(test for test in tests if test.outcome)
    own = {name: value for name, value in values.items() if name in _OF_SWEEP}
    variants = own.pop("variants", sweep.variants)
    rest = {k: v for k, v in values.items() if k not in {*own, "variants"}}
    written = sweep.source.written
    for name, value in rest.items():
        for path, entry in _entries(name, value, sweep).items():
            written = replace_value(written, path, entry)
    try:
        made = sweep.source.read_again(sweep, written, variants)
    except tribo.TriboError:
        assert not {*_DECLARED} & rest.keys(), "these are entries alone, and some entry is unfit"
        made = sweep.source.read_again(sweep, sweep.source.written, variants)
    made = replace(made, **own)
    for name, value in (_objects(sweep) | rest).items():
        if not _has(made, name, value):
            made = _with_object(made, name, value)
    return replace(_with_cases(made), entries={**made.entries})


def _with_cases(sweep):
    """Copy of a sweep whose tests have its scene, if they change no entry."""
    tests = (
        test if test.changes else attach_case(test, number, sweep.base)
        for number, test in enumerate(sweep.tests)
    )
    return replace(sweep, tests=tuple(tests))


def _objects(sweep):
    """Objects of a sweep, by field, that its entries do not describe."""
    read = sweep.source.read_again(sweep, sweep.source.written, sweep.variants)
    names = FIELDS - {*_DECLARED, *_OF_SWEEP}
    pairs = ((name, _present(sweep, name), _present(read, name)) for name in names)
    return {name: own for name, own, other in pairs if own is not other and own != other}


def _present(sweep, name):
    if name in _TESTS:
        return tuple(test for test in sweep.tests if bool(test.outcome) == _TESTS[name])
    held = sweep.scene if PART_OF.get(name) == "scene" else sweep
    return getattr(held, {"oil": "lubricant"}.get(name, name))


def _has(sweep, name, value):
    if name in _DECLARED:  # no object holds it, so it is as written
        return True
    present = _present(sweep, name)
    if name == "conditions":
        return present == value.under(sweep.scene.loading)
    if name in _TESTS:  # each test has its own number, or the next one
        return len(present) == len(value) and all(
            test == replace(asked, number=asked.number or test.number)
            for test, asked in zip(present, value, strict=True)
        )
    return present == value


def _with_object(sweep, name, value):
    """Copy of a sweep with an object that no entry describes."""
    if name in _TESTS:
        others = (one for one in sweep.tests if bool(one.outcome) != _TESTS[name])
        return replace(sweep, tests=tuple(sorted((*others, *value), key=lambda t: bool(t.outcome))))
    if PART_OF.get(name) == "plane":
        return replace(sweep, **{name: value})
    if name == "preset":  # stored with the choices, whichever these are
        sweep = replace(sweep, entries=replace_value(sweep.entries, "fidelity.preset", value))

    def of(case):
        if PART_OF.get(name) == "scene":
            return replace(case, scene=replace(case.scene, **{name: value}))
        if name == "conditions":
            return replace(case, conditions=value.under(case.scene.loading))
        return replace(case, **{"lubricant" if name == "oil" else name: value})

    return replace(sweep, base=of(sweep.base), cases=tuple(map(of, sweep.cases)))


def _quantities(values, example):
    return [entries_of(Quantity(example, zero=True), float(value)) for value in values]


def _table(kind, made):
    return entries_of(table_of(kind), made)


def _entries(name, value, sweep):
    match name, value:
        case "loads", _:
            return {"sweep.loads": _quantities(value, "200 N")}
        case "velocities", _:
            return {"sweep.velocities": _quantities(value, "1 m/s")}
        case "fields" | "steps", _:
            return {f"sweep.{name}": value}
        case "title" | "caveat" | "uncertainty", _:
            return {name: value}
        case "fidelity", _:
            return {"fidelity": entries_of(table_of(FidelityTable), complete_fidelity(None, value))}
        case "pin", _:
            return _pin(value)
        case "disk", _:
            return {"materials.of_disk": _material(value), "disk.material": "of_disk"}
        case (("roughness" | "wear" | "motion" | "oil"), None):
            return {"disk.roughness" if name == "roughness" else name: None}
        case "roughness", tribo.SelfAffineRoughness():
            return {"disk.roughness": _table(RandomSurface, value)}
        case "roughness", tribo.MeasuredRoughness():
            sweep.source.reader.contents.arrays[value.digest] = value.array
            return {"disk.roughness": {"file": "surface.npy", "content": value.digest}}
        case "loading", tribo.Ramp():
            return {"loading": _table(RampTable, value)}
        case "loading", tribo.MeasuredLoad():
            digest = sweep.source.reader.contents.keep(np.array([value.times, value.loads]))
            record = {"file": "load.csv", "content": digest}
            if value.reference_load is not None:
                record["reference_load"] = f"{value.reference_load!r} N"
            return {"loading": record}
        case "wear", tribo.Wear():
            return {"wear": _table(Archard, value)}
        case "motion", tribo.Motion():
            return {"motion": _table(MotionTable, value)}
        case "pixels", _:
            sides = [f"{float(side)!r} m" for side in value.spacing]
            return {"window": {"pixels": [*map(int, value.shape)], "pixel_size": sides}}
        case "conditions", _:
            return _conditions(value)
        case "friction_band", _:
            return {"friction.band": value and [*value]}
        case "model_scatter" | "model_bias", _:
            return {f"model.{name.removeprefix('model_')}": value}
        case "measured" | "tested", _:
            return {name: [_test(name, test) for test in value] or None}
        case "oil", _:
            return {"oil": _oil(value)}
    return {}


def _material(material):
    return _table(MaterialTable, SimpleNamespace(like=None, **_fields(material)))


def _fields(made):
    return {
        one.name: float(value) if isinstance(value, np.floating) else value
        for one in fields(made)
        if one.init
        for value in [getattr(made, one.name)]
    }


def _pin(pin):
    shape = next((name for name, kind in tribo.PINS.items() if kind is type(pin)), None)
    if shape is None or not is_dataclass(pin):
        return {}
    sizes = {name: _quantities([getattr(pin, name)], "2 mm")[0] for name in sizes_of(shape)}
    every = {f"pin.{name}": None for other in tribo.PINS for name in sizes_of(other)}
    own = {f"pin.{name}": size for name, size in sizes.items()}
    own |= {"pin.shape": shape, "pin.material": "of_pin"}
    return {"materials.of_pin": _material(pin.material), **every, **own}


def _condition_entries(changes):
    """Scene entries by path for fields of `Conditions`, given by name."""
    texts = {
        name: value if UNITS_OF.get(name, "1") == "1" else f"{value!r} {UNITS_OF[name]}"
        for name, value in changes.items()
        if value is not None
    }
    if disk := texts.pop("disk_temperature", None):
        texts["bulk_temperature"] = {"pin": texts["bulk_temperature"], "disk": disk}
    return {PATHS_OF[name]: text for name, text in texts.items()}


def _conditions(made):
    values = plain_values(made)
    beside = "unmodelled_rise", "corrections"
    entries = {"temperature.critical": None}
    entries |= _condition_entries({k: v for k, v in values.items() if k not in beside})
    entries |= _beside(made.corrections)
    curves = made.corrections and made.corrections.friction
    entries["friction.by_velocity"] = [
        {"velocity": f"{float(node)!r} m/s", "coefficient": factor * made.friction}
        for node, factor in (curves.by_velocity if curves else ())
    ] or None
    return entries


def _beside(corrections):
    """Scene entries for `Corrections`, such as films and tracks, except friction curves."""
    entries = {f"{body}.track_length": None for body in ("pin", "disk")}
    if corrections is None:
        return entries
    for body, track in (("pin", corrections.pin_track), ("disk", corrections.track)):
        if track and track.disc is None:
            entries[f"{body}.track_length"] = f"{track.length!r} m"
    return entries


def _test(name, test):
    kind = TransitionTable if name == "measured" else Test
    values = _fields(test)
    values["load"] = values.pop("normal_load")
    steps = {"N": values.pop("load_step"), "m/s": values.pop("velocity_step")}
    step = next((f"{value!r} {unit}" for unit, value in steps.items() if value), None)
    values["with_"] = values.pop("changes") or None
    del values["own"]
    return _table(kind, SimpleNamespace(oil=None, step=step, **values))


def _oil(oil):
    values = {
        "temperatures": oil.temperatures, "kinematic_viscosity": oil.viscosities,
        "density": oil.density, "pressure_viscosity_coefficient": oil.pressure_coefficients,
    }  # fmt: skip
    values = {
        key: tuple(map(float, one)) if isinstance(one, tuple) else one
        for key, one in values.items()
    }
    rest = {one.name: None for one in fields(OilTable) if one.name not in values}
    return _table(OilTable, SimpleNamespace(**values, **rest))


def rows(name, changes, velocities=None, loads=None):
    """Variants of a sweep; `changes` has for each label the changed fields [SI] or objects."""
    places = {"load": loads, "velocity": velocities}
    return labelled_rows(
        name,
        {label: _row(change) for label, change in changes.items()},
        **{axis: values for axis, values in places.items() if values is not None},
    )


def placed_rows(*places):
    """Numbered variants, each (load, velocity), or with further labels."""
    held = [
        Row({**labels, "load": load, "velocity": velocity}, {})
        for load, velocity, labels in ((*one, {})[:3] for one in places)
    ]
    units = {"load": "N", "velocity": "m/s"}
    columns = (
        Column(name, units.get(name, "1"), meaning=f"{name} of the row") for name in held[0].labels
    )
    return numbered_rows(columns, held)


def two_pins():
    """Two variants of a sweep, with pin radii of 1 and 2 mm."""
    held = (Row({"pin_radius": n * 1e-3}, {"pin.radius": f"{n} mm"}) for n in (1, 2))
    return Variants((Column("pin_radius", "m", entry="pin.radius"),), tuple(held))


_KEYS = {"wear": ("specific_wear_rate", "pattern")}
_UNITS = {"pin.radius": "m", "pin.length": "m", "wear.specific_wear_rate": "m^2/N"}


def _row(change):
    row = {}
    for path, value in change.items():
        table, _, key = path.partition(".")
        if path in _UNITS:
            row[path] = f"{value!r} {_UNITS[path]}"
        elif table == "disk" and key:
            row[f"materials.of_disk.{key}"] = entries_of(
                table_of(MaterialTable).keys[key].kind, value
            )
        else:
            for entry, one in _entries(path, value, None).items():
                whole = one if isinstance(one, dict) else dict.fromkeys(_KEYS.get(entry, ()))
                inner = {f"{entry}.{key}": part for key, part in whole.items()}
                row |= inner or {entry: one}
    return row


def labelled_rows(name, changes, **places):
    """Table of variants along one dimension, called `name`: a row for each label in `changes`.

    For each label, `changes` has the entries that the variant replaces. `places` may give each
    variant its own ``load`` [N] or ``velocity`` [m/s].
    """
    is_text = isinstance(next(iter(changes)), str)
    key = Column(name, None if is_text else "1", meaning=f"{name} of the scene")
    own = (Column(one, PLACE_UNITS[one], name, meaning=f"{one} of each {name}") for one in places)
    rows = (
        Row({name: label} | {one: float(values[k]) for one, values in places.items()}, change)
        for k, (label, change) in enumerate(changes.items())
    )
    return Variants((key, *own), tuple(rows))
