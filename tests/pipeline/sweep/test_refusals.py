"""All refusals of sweeps and their cases: what causes each; tests/kept has what it says."""

import importlib
import sys
import types
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import pipeline
import tribo
from pipeline import Conditions
from pipeline.sweep.case import SpecimenTest, known_critical_temperature
from pipeline.sweep.case_table import CaseTable, Column, surface_table
from pipeline.sweep.stored import (
    MissingSurface,
    plain_sweep,
    require_stored_classes,
    sweep_of_plain,
)
from tests.helpers import laws, tiny
from tests.helpers.entries import rows
from tests.helpers.refusals import refusal_tests
from tribo.surface.areal import areal_roughness, remove_form

RANDOM = np.random.default_rng(1)
OIL = {"friction": 0.1, "bulk_temperature": 298.15, "critical_temperature": 418.15}
RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0]), np.array([0.0, 80.0, 750.0]))


def conditions(**changes):
    return lambda: Conditions(**OIL | changes)


def data(**changes):
    """Function that reads the data of a sweep after changes."""
    return lambda: sweep_of_plain(plain_sweep(tiny.sweep())[0] | changes, {})


def other_heights():
    sweep = tiny.sweep(roughness=tribo.MeasuredRoughness(np.zeros((32, 16))))
    plain, arrays = plain_sweep(sweep)
    return sweep_of_plain(plain, {key: array + 1.0 for key, array in arrays.items()})


SMOOTH = tiny.sweep(roughness=None)
MANY = tuple(np.linspace(1.0, 2.0, 4000).tolist())


@dataclass
class Counting:
    """A wear law that changes when it is used."""

    count: int = 0
    pattern: str = "swept"

    def mean_wear(self, begin, end, pressure, velocity):
        self.count += 1
        return tribo.Wear(1e-15)


def law_in(module):
    """A wear law of a class in a module that has no file."""
    return type("Law", (laws.ByPressure,), {"__module__": module})()


@dataclass
class Scattered:
    """A wear law of random numbers."""

    pattern: str = "swept"

    def mean_wear(self, begin, end, pressure, velocity):
        return tribo.Wear(1e-15 * RANDOM.uniform())


def of_function(module):
    """A wear law with a function as its value, which says that it is of `module`."""
    power = types.FunctionType((lambda x: x).__code__, {}, "power")
    power.__module__, power.__qualname__ = module, "power"
    sys.modules[module].power = power
    return laws.ByPressure(rate=2e-24, pattern=Named("swept", power))


class NoPickle(float):
    """A number that cannot be pickled."""

    def __reduce__(self):
        raise TypeError("it has a lock")


class Named(str):
    """A text with an object."""

    def __new__(cls, text, used):
        named = super().__new__(cls, text)
        named.used = used
        return named


def changed_since_import(text):
    """Use a law of a module whose file was written again after its import, or removed."""
    source = Path(laws.__file__).read_text("utf-8")
    Path("laws_of_now.py").write_text(source, "utf-8")
    sys.path.insert(0, str(Path.cwd()))
    sys.modules.pop("laws_of_now", None)
    try:
        law = importlib.import_module("laws_of_now").ByPressure()
    finally:
        sys.path.remove(str(Path.cwd()))
    Path("laws_of_now.py").unlink()
    if text:
        Path("laws_of_now.py").write_text(source.replace(*text), "utf-8")
    return with_law(law)()


def with_law(law, sweep=SMOOTH):
    return lambda: sweep.with_scene(wear=law)


def without_original():
    """Use the law of a sweep that was read from its data."""
    law = sweep_of_plain(*plain_sweep(with_law(laws.Tabled())())).scene.wear
    return law.mean_wear(0.0, 1.0, 1e8, 1.0)


def of_unknown_class():
    scene = replace(SMOOTH.scene, wear=laws.ByPressure())
    return require_stored_classes(replace(SMOOTH, base=replace(SMOOTH.base, scene=scene)))


def varied():
    seeds = surface_table((1, 2))
    return tiny.sweep(case_table=seeds).with_scene(roughness=laws.Grooves())


REFUSALS = {
    # conditions
    "critical": conditions(critical_temperature=298.15),
    "no critical": lambda: known_critical_temperature(conditions(critical_temperature=None)()),
    # the sweep and its cases
    "hold": lambda: tiny.sweep(loading=RECORD).base.with_hold(2.0),
    "field": lambda: tiny.sweep().changed("friktion", 0.1),
    "no path": lambda: tiny.sweep().changed(3, 0.1),
    "plane": lambda: replace(tiny.sweep(), loads=(2.0, 1.0)),
    "take": lambda: tiny.sweep().select_case((("pin", 1),)),
    "columns": lambda: CaseTable((Column("a"),), ({"b": 1},)),
    "surface": lambda: SMOOTH.take_surface(3),
    "labels": lambda: CaseTable((Column("a"),), ({"a": 1},) * 2).by_name,
    "row": lambda: tiny.sweep(case_table=surface_table((1, 2))).case((("realization", 5),)),
    "gap": lambda: (surface_table((1,)) * rows("pin", {"a": {}})).union(
        surface_table((2,)) * rows("pin", {"b": {}})),
    "many points": lambda: replace(SMOOTH, loads=MANY, velocities=MANY).require_few_points(),
    # data of sweeps
    "class": data(warnings=[{"is": "os"}]),
    "field less": data(warnings=[{"is": "SceneWarning"}]),
    "field more": data(warnings=[{"is": "SceneWarning", "path": "", "words": "", "later": 1}]),
    "no data": lambda: sweep_of_plain({}, {}),
    "bias": lambda: replace(tiny.sweep().base, model_bias=1.2),
    "scatter": lambda: replace(tiny.sweep().base, model_scatter=0.0),
    "place of a test": lambda: SpecimenTest(1.0, 1.0, None, velocity_step=2.0),
    "difference": data(cases=[{"no": 1}]),
    "array": other_heights,
    # wear laws and surfaces of users
    "script": with_law(law_in("__main__")),
    "no class of yours": with_law(tribo.Wear(1e-15)),
    "a class": with_law(laws.Tabled),
    "no surface": lambda: pipeline.load_scene("first_try").with_scene(roughness=3),
    "no pickle": with_law(laws.ByPressure(rate=NoPickle(2e-24))),
    "part of a script": lambda: with_law(of_function("__main__"))(),
    "no module": with_law(law_in("nowhere")),
    "no file": lambda: changed_since_import(None),
    "another file": lambda: changed_since_import(("rate * pressure", "rate * pressure**2")),
    "state": with_law(Counting()),
    "random": with_law(Scattered()),
    "no code": without_original,
    "not set": of_unknown_class,
    "varied": varied,
    "replaced": lambda: pipeline.load_scene("first_try").with_scene(
        wear=laws.Tabled()).changed("wear.pattern", "local"),
    # surfaces
    "not beside": lambda: MissingSurface("0", (1, 1)).heights(None),
    "no heights": lambda: remove_form(np.full((3, 3), np.nan), (1.0, 1.0)),
    "level": lambda: areal_roughness(np.indices((20, 30))[1] * 0.1, (1.0, 1.0)),
}  # fmt: skip


refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "sweep", REFUSALS
)
