"""The scene format and ``tribo`` allow the same values.

Each range stands in both: in the format for a message that names the key, in ``tribo`` for those
who build scenes in Python. At each bound, and just beyond, both must say the same.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import tribo
from pipeline.scene.faults import Faults
from pipeline.scene.format import FORMAT
from pipeline.scene.kinds import Quantity
from pipeline.scene.schema import Either, Entry, List, Table, Tables
from pipeline.sweep.conditions import Conditions
from tests.helpers.scenes import STEEL, small_scene

GRID = tribo.Grid((8, 8), (1e-6, 1e-6))
RAMP = tribo.Ramp(rate=150.0, reference_load=750.0)
CONDITIONS = Conditions(0.1, 298.15, None)


def kind_at(path):
    """The kind of the entry at a key path; the usual one where there are two."""
    kind = FORMAT
    for key in path.split("."):
        kind = kind.usual if isinstance(kind, Either) else kind
        if isinstance(kind, Tables):
            kind = kind.of
            continue
        assert isinstance(kind, Table)
        kind = kind.keys[key].kind
    kind = kind.usual if isinstance(kind, Either) else kind
    return kind.of if isinstance(kind, List) else kind


def format_allows(path, value):
    kind, faults = kind_at(path), Faults()
    if isinstance(kind, Quantity):
        unit = kind.example.split(" ", 1)[1]
        scale = {"GPa": 1e9, "g/cm^3": 1e3, "um": 1e-6, "mm": 1e-3, "mm^2": 1e-6}
        scale |= {"mm^3/(N m)": 1e-9}
        value = f"{value / scale.get(unit, 1.0):.17g} {'K' if unit == 'degC' else unit}"
    kind.read(value, path, faults)
    return not faults


def tribo_allows(build, value):
    try:
        build(value)
    except tribo.InputError:
        return False
    return True


def roughness(**changes):
    given = {"ra": 1e-6, "hurst_exponent": 0.8, "correlation_length": (4e-6, 4e-6)} | changes
    return tribo.SelfAffineRoughness(**given).heights(GRID)


ABOVE_0, AT_LEAST_0 = (-1e-300, 0.0, 1e-30, 1.0), (-1e-30, 0.0, 1e-30, 1.0)
FROM_1 = (-1, 0, 1, 2)
PLACES = {
    "materials.steel.elastic_modulus": (ABOVE_0, lambda v: replace(STEEL, elastic_modulus=v)),
    "materials.steel.poisson_ratio": (
        (-1.0, math.nextafter(-1, 0), 0.5, math.nextafter(0.5, 1)),
        lambda v: replace(STEEL, poisson_ratio=v),
    ),
    "materials.steel.hardness": (ABOVE_0, lambda v: replace(STEEL, hardness=v)),
    "materials.steel.thermal_conductivity": (
        ABOVE_0,
        lambda v: replace(STEEL, thermal_conductivity=v),
    ),
    "materials.steel.density": (ABOVE_0, lambda v: replace(STEEL, density=v)),
    "materials.steel.specific_heat": (ABOVE_0, lambda v: replace(STEEL, specific_heat=v)),
    "pin.radius": (ABOVE_0, lambda v: (tribo.Cylinder(v, 1.0, STEEL), tribo.Ball(v, STEEL))),
    "pin.length": (ABOVE_0, lambda v: tribo.Cylinder(1.0, v, STEEL)),
    "pin.stem.length": (ABOVE_0, lambda v: tribo.Stem.rod(v, 1.0, 1.0, 1.0)),
    "pin.stem.area": (ABOVE_0, lambda v: tribo.Stem.rod(1.0, v, 1.0, 1.0)),
    "disk.track_length": (
        ABOVE_0,
        lambda v: tribo.Track.under(tribo.Ball(1.0, STEEL), STEEL, v),
    ),
    "disk.roughness.ra": (ABOVE_0, lambda v: roughness(ra=v)),
    "disk.roughness.hurst_exponent": (
        (0.0, 5e-324, 1.0, math.nextafter(1, 2)),
        lambda v: roughness(hurst_exponent=v),
    ),
    "disk.roughness.correlation_length": (
        (-1e-6, 0.0, 1e-6),
        lambda v: roughness(correlation_length=(v, v)),
    ),
    "disk.roughness.seed": ((-1, 0, 1), lambda v: roughness(seed=v)),
    "window.pixels": (FROM_1, lambda v: tribo.Grid((v, v), (1.0, 1.0))),
    "window.pixel_size": (ABOVE_0, lambda v: tribo.Grid((2, 2), (v, v))),
    "loading.rate": (ABOVE_0, lambda v: replace(RAMP, rate=v)),
    "loading.reference_load": (ABOVE_0, lambda v: replace(RAMP, reference_load=v)),
    "loading.hold": (AT_LEAST_0, lambda v: replace(RAMP, hold=v)),
    "loading.hold_steps": (FROM_1, lambda v: replace(RAMP, hold_steps=v)),
    "motion.track_length": (
        ABOVE_0,
        lambda v: tribo.Motion(slide_roll_ratio=1.0, track_length=v),
    ),
    "wear.specific_wear_rate": (AT_LEAST_0, tribo.Wear),
    "oil.temperatures": (ABOVE_0, lambda v: tribo.Oil((v, 400.0), (32e-6, 5e-6), 866.0)),
    "oil.kinematic_viscosity": (
        (-1.0, 0.0, 1.0),
        lambda v: tribo.Oil((313.0, 373.0), (v, v / 2), 866.0),
    ),
    "oil.density": (ABOVE_0, lambda v: tribo.Oil((313.0, 373.0), (32e-6, 5e-6), v)),
    "oil.pressure_viscosity_coefficient": (
        ABOVE_0,
        lambda v: tribo.Oil((313.0, 373.0), (32e-6, 5e-6), 866.0, (v, v)),
    ),
    "friction.coefficient": (AT_LEAST_0, lambda v: replace(CONDITIONS, friction=v)),
    "temperature.bulk": (
        (-1.0, 0.0, 1e-30, 300.0),
        lambda v: replace(CONDITIONS, bulk_temperature=v),
    ),
    "temperature.failing_share": (
        (-5e-324, 0.0, math.nextafter(1, 0), 1.0),
        lambda v: replace(CONDITIONS, failing_share=v),
    ),
    "sweep.loads": ((-1.0, 0.0, 100.0), lambda v: list(tribo.simulate(SCENE, v, 1.0))),
}
SCENE = small_scene(roughness=False, wear=False, increments=1)


@pytest.mark.parametrize("path", PLACES)
def test_format_and_tribo_allow_the_same(path):
    values, build = PLACES[path]
    allowed = [format_allows(path, value) for value in values]
    assert allowed == [tribo_allows(build, value) for value in values]
    assert True in allowed
    assert False in allowed


@pytest.mark.parametrize("path", PLACES)
def test_neither_takes_a_number_that_is_not_finite(path):
    _, build = PLACES[path]
    for value in (math.nan, math.inf, -math.inf):
        infinite_hardness = path.endswith("hardness") and value == math.inf
        assert not format_allows(path, value)
        with np.errstate(all="ignore"):
            assert tribo_allows(build, value) == infinite_hardness


def test_every_range_of_the_format_is_held_against_tribo():
    """A quantity or a number with a range that is added must be added here, too."""
    elsewhere = {
        "loading.file",
        "fidelity",  # `tribo.Fidelity` alone checks these
        "sweep.velocities",  # `tribo` lets the disk move backwards, too
        "motion.slide_roll_ratio",  # any but 0
        "motion.entrainment_velocity",  # likewise
        "sweep.realizations",  # how many, or seeds as above
        "oil.dynamic_viscosity",  # as the kinematic one
        "sweep.samples",  # how many
        "sweep.sample_seed",  # as a seed above
        "sweep.wear_rates",  # about the rate above, and above 0
        "disk.film",  # a quotient of both
        "friction.band",  # as the coefficient
        "temperature.critical",  # above the bulk temperature
        "measured",
        "disk.roughness.crop",
        "disk.roughness.height_unit",
    }

    def ranged(kind, path):
        kind = kind.kind if isinstance(kind, Entry) else kind
        kind = kind.usual if isinstance(kind, Either) else kind
        if isinstance(kind, Tables):
            yield from ranged(kind.of, f"{path}.steel")
        elif isinstance(kind, Table):
            for key, entry in kind.keys.items():
                yield from ranged(entry, f"{path}.{key}".strip("."))
        else:
            of = kind.of if isinstance(kind, List) else kind
            if isinstance(of, Quantity) or (hasattr(of, "at_least") and "from" not in path):
                yield path

    found = set(ranged(FORMAT, ""))
    assert {path for path in found if not path.startswith(tuple(elsewhere))} == set(PLACES)
