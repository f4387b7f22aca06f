"""The scene format and ``tribo`` allow the same values.

Each range stands in both: in the format for a message that names the key, in ``tribo`` for those
who build scenes in Python. At each bound, and just beyond, both must say the same. Sizes that no
machine has are faults of the format alone.
"""

import math
from dataclasses import replace

import pytest

import tribo
from pipeline import Conditions, to_si
from pipeline.quantities import DIMENSIONS
from pipeline.scene.faults import Faults
from pipeline.scene.kinds import Quantity, Whole
from pipeline.scene.tables import Either, List
from pipeline.units import si_unit
from tests.helpers.scenes import STEEL, small_scene
from tests.sources.sections import sections

GRID = tribo.Grid((8, 8), (1e-6, 1e-6))
RAMP = tribo.Ramp(rate=150.0, reference_load=750.0)
CONDITIONS = Conditions(0.1, 298.15, None)


def kind_of(entry):
    """Kind of the value of an entry; for a list, of its elements."""
    kind = entry.kind.kinds[0] if isinstance(entry.kind, Either) else entry.kind
    return kind.of if isinstance(kind, List) else kind


KINDS = {
    section.path_of(key).replace("NAME", "steel"): kind_of(entry)
    for section in sections()
    for key, (entry, _) in section.keys().items()
}


def at_bounds(kind):
    """Values at each bound of a kind of entry, and just beyond it."""
    if isinstance(kind, Quantity):
        low, high = (to_si(end, kind.example) for end in DIMENSIONS[si_unit(kind.example)].limits)
        return (-low, 0.0, 1.001 * low, math.sqrt(low * high))
    if isinstance(kind, Whole):
        return (kind.at_least - 1, kind.at_least, kind.at_least + 1)
    named = (getattr(kind, name) for name in ("above", "at_least", "below", "at_most"))
    bounds = [*filter(math.isfinite, named)]
    ends = (-math.inf, math.inf)
    beyond = {
        b: [math.nextafter(b, end) if b else math.copysign(1e-12, end) for end in ends]
        for b in bounds
    }
    return tuple(value for b, others in beyond.items() for value in (b, *others))


def format_allows(path, value):
    kind, faults = KINDS[path], Faults()
    if isinstance(kind, Quantity):
        unit = kind.example.split(" ", 1)[1]
        scale = {"GPa": 1e9, "g/cm^3": 1e3, "um": 1e-6, "mm": 1e-3, "mm^2": 1e-6}
        scale |= {"mm^3/(N m)": 1e-9, "1/GPa": 1e-9}
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
    entries = {"ra": 1e-6, "hurst_exponent": 0.8, "correlation_length": (4e-6, 4e-6)} | changes
    return tribo.SelfAffineRoughness(**entries).heights(GRID)


PLACES = {
    "materials.steel.elastic_modulus": lambda v: replace(STEEL, elastic_modulus=v),
    "materials.steel.poisson_ratio": lambda v: replace(STEEL, poisson_ratio=v),
    "materials.steel.hardness": lambda v: replace(STEEL, hardness=v),
    "materials.steel.thermal_conductivity": lambda v: replace(STEEL, thermal_conductivity=v),
    "pin.radius": lambda v: (tribo.Cylinder(v, 1.0, STEEL), tribo.Ball(v, STEEL)),
    "pin.length": lambda v: tribo.Cylinder(1.0, v, STEEL),
    "disk.track_length": lambda v: tribo.Track.under(tribo.Ball(1.0, STEEL), STEEL, v),
    "pin.width": lambda v: tribo.Disc(diameter=1.0, width=v),
    "pin.diameter": lambda v: tribo.Disc(diameter=v, width=1.0),
    "disk.roughness.ra": lambda v: roughness(ra=v),
    "disk.roughness.hurst_exponent": lambda v: roughness(hurst_exponent=v),
    "disk.roughness.correlation_length": lambda v: roughness(correlation_length=(v, v)),
    "disk.roughness.seed": lambda v: roughness(seed=v),
    "window.pixels": lambda v: tribo.Grid((v, v), (1.0, 1.0)),
    "window.pixel_size": lambda v: tribo.Grid((2, 2), (v, v)),
    "loading.rate": lambda v: replace(RAMP, rate=v),
    "loading.reference_load": lambda v: replace(RAMP, reference_load=v),
    "loading.hold": lambda v: replace(RAMP, hold=v),
    "motion.track_length": lambda v: tribo.Motion(slide_roll_ratio=1.0, track_length=v),
    "wear.specific_wear_rate": tribo.Wear,
    "oil.density": lambda v: tribo.Oil((32e-6, 5e-6), v),
    "oil.pressure_viscosity_coefficient": lambda v: tribo.Oil((32e-6, 5e-6), 866.0, v),
    "friction.coefficient": lambda v: replace(CONDITIONS, friction=v),
    "temperature.critical_area_fraction": lambda v: tribo.Conditions(
        0.1, 300.0, critical_area_fraction=v
    ),
    "sweep.loads": lambda v: list(tribo.simulate(SCENE, v, 1.0)),
}
SCENE = small_scene(roughness=False, wear=False, increments=1)


@pytest.mark.parametrize("path", PLACES)
def test_format_and_tribo_allow_the_same(path):
    values = at_bounds(KINDS[path])
    allowed = [format_allows(path, value) for value in values]
    assert allowed == [tribo_allows(PLACES[path], value) for value in values]
    assert {True, False} <= set(allowed)
