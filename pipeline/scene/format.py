"""The format of scene files: every table and key, with its kind, range and default."""

from __future__ import annotations

import math
from typing import Any, Literal, get_args, get_origin, get_type_hints

import tribo
from pipeline.scene.kinds import Choice, Flag, Kind, Number, Quantity, Text, Unit, Whole
from pipeline.scene.schema import (
    ByPath,
    Distributions,
    Either,
    List,
    Optional,
    Range,
    Scalar,
    Table,
    Tables,
)
from pipeline.sweep.unknown import MOST_SAMPLES


def _kind(hint: Any) -> Kind:
    """Translate the type of an entry whose range `tribo` checks itself."""
    if get_origin(hint) is Literal:
        return Choice(get_args(hint))
    return {int: Whole(), float: Number(), bool: Flag(), str: Text()}[hint]


def _is_curved(pin: Any) -> bool:
    return isinstance(pin, dict) and pin.get("shape") in ("ball", "crowned")


def _has_file(table: Any) -> bool:
    return isinstance(table, dict) and "file" in table


def _has_law(table: Any) -> bool:
    return isinstance(table, dict) and "law" in table


def _is_reference(value: Any) -> bool:
    return isinstance(value, str) and ":" in value


def _is_list(value: Any) -> bool:
    return isinstance(value, list)


def _is_table(value: Any) -> bool:
    return isinstance(value, dict)


SIZE = Quantity("a length", "2 mm")
LENGTH = Quantity("a length", "0.95 um")
WEAR_RATE = Quantity("a specific wear rate", "1.2e-6 mm^3/(N m)")
LOAD = Quantity("a load", "200 N")
DURATION = Quantity("a duration", "4 s", zero=True)
VELOCITY = Quantity("a velocity", "1.25 m/s", zero=True)
SPEED = Quantity("a velocity", "1.25 m/s")
TEMPERATURE = Quantity("a temperature", "25 degC")
PER_PRESSURE = Quantity("a pressure coefficient", "20 1/GPa")
VELOCITY_SCATTER = Quantity("a velocity", "0.1 m/s")
LOAD_SCATTER = Quantity("a load", "10 N")
FRICTION = Number(at_least=0)
FRICTION_SCATTER = Number(above=0)
CONDUCTIVITY = Quantity("a conductivity", "45 W/(m K)")
SEED = Whole(at_least=0)
SURFACES = Whole(at_least=1, at_most=100_000)
SHAPE = Choice(("cylinder", "ball", "crowned"))
PRESET = Choice(tuple(tribo.PRESETS))
USUAL_PRESET = "standard"
FIDELITY = {name: Optional(_kind(hint)) for name, hint in get_type_hints(tribo.Fidelity).items()}

SAMPLES = Whole(at_least=1, at_most=MOST_SAMPLES)
CORRELATED = {"correlated": Optional(ByPath(Number(above=-1, below=1)), default={})}
UNKNOWN = Distributions(
    (
        Table({"mean": Scalar(), "sd": Scalar(), **CORRELATED}),  # normal
        Table({"median": Scalar(), "factor": Number(above=1), **CORRELATED}),  # log-normal
        Table({"from": Scalar(), "to": Scalar(), **CORRELATED}),  # uniform
    ),
    listed=List(Scalar(), distinct=True),  # each as likely
)

STEM = Either(
    Table({"length": SIZE, "area": Quantity("an area", "12 mm^2")}),
    Table({"resistance": Quantity("a thermal resistance", "8 K/W")}),
    when=lambda stem: isinstance(stem, dict) and "resistance" in stem,
)

_PLACE: dict[str, Kind | Optional] = {  # of a test
    "load": LOAD,
    "load_scatter": Optional(LOAD_SCATTER),
    "velocity": VELOCITY,
    "velocity_scatter": Optional(VELOCITY_SCATTER),
    "friction": Optional(FRICTION),
    "friction_scatter": Optional(FRICTION_SCATTER),
    "bulk_temperature": Optional(TEMPERATURE),
    "hold": Optional(DURATION),
}
TRANSITION = Table(_PLACE)
TEST = Table({**_PLACE, "outcome": Choice(("mild", "severe"))})
LOG = Table({"file": Text()})  # rows of a CSV file, replaced before the scene is read
OWN = Table({"law": Text(), "parameters": Optional(ByPath(Scalar()), {})})

EXTENDS = Text()
WITHOUT = List(Text(), distinct=True)

FORMAT = Table({
    "extends": Optional(EXTENDS),  # another scene file, relative to this one's folder
    "without": Optional(WITHOUT),  # key paths of the other's entries to leave out
    "title": Optional(Text()),
    "materials": Optional(Tables(Table({
        "like": Optional(Text()),  # a material of the library, for what is not given here
        "elastic_modulus": Quantity("a modulus", "210 GPa"),
        "poisson_ratio": Number(above=-1, at_most=0.5),
        "hardness": Optional(Quantity("a pressure", "6.6 GPa"), math.inf),  # or "62 HRC"
        "thermal_conductivity": CONDUCTIVITY,
        "density": Quantity("a density", "7800 kg/m^3"),
        "specific_heat": Quantity("a specific heat", "470 J/(kg K)"),
    }))),
    "pin": Either(
        Table({
            "shape": SHAPE, "radius": SIZE, "length": SIZE, "material": Text(),
            "stem": Optional(STEM),
        }),
        Table({
            "shape": SHAPE, "radius": SIZE, "crown_radius": Optional(SIZE), "material": Text(),
            "stem": Optional(STEM),
        }),
        when=_is_curved,
    ),
    "disk": Table({
        "material": Text(),
        "track_length": Optional(SIZE),  # of the ring that earlier passes have heated
        "film": Optional(Table({  # an oxide or tribofilm
            "thickness": LENGTH,
            "thermal_conductivity": CONDUCTIVITY,
        })),
        "surface": Optional(OWN),  # in place of a roughness
        "roughness": Optional(Either(
            Table({
                "ra": LENGTH,
                "hurst_exponent": Number(above=0, at_most=1),
                "correlation_length": Either(LENGTH, List(LENGTH, length=2), when=_is_list),
                "seed": Optional(SEED, 0),
            }),
            Table({
                "file": Text(),
                "height_unit": Optional(Unit("a unit of length", "um")),  # in place of the file's
                "transpose": Optional(Flag(), False),
                "flip": Optional(Choice(("no", "x", "y", "heights")), "no"),
                "crop": Optional(List(Whole(at_least=0), length=2)),  # its first row and column
                "level": Optional(Flag(), False),
                "missing": Optional(Choice(("refuse", "fill")), "refuse"),
                "repeat": Optional(Choice(("no", "mirror", "tile")), "no"),  # to fill the window
            }),
            when=_has_file,
        )),
    }),
    "window": Table({
        "pixels": List(Whole(at_least=1, at_most=100_000), length=2),
        "pixel_size": List(LENGTH, length=2),
        "periodic_y": Optional(Flag()),  # by default as the pin's shape has it
    }),
    "loading": Either(
        Table({
            "rate": Quantity("a loading rate", "150 N/s"),
            "reference_load": LOAD,
            "hold": Optional(DURATION, 0.0),
            "hold_steps": Optional(Whole(at_least=1)),
        }),
        Table({
            "file": Text(),
            "reference_load": Optional(LOAD),  # by default the record's peak
            "fit": Optional(Flag(), False),  # a straight line in place of the record itself
        }),
        when=_has_file,
    ),
    "motion": Optional(Table({  # of both bodies; without it the pin is at rest
        "slide_roll_ratio": Optional(Number()),  # one of this
        "entrainment_velocity": Optional(VELOCITY),  # and this
        "track_length": Optional(SIZE),  # by default the pin's circumference
    })),
    "wear": Optional(Either(
        Table({
            "specific_wear_rate": Quantity("a specific wear rate", "1.2e-6 mm^3/(N m)", zero=True),
            "pattern": _kind(get_type_hints(tribo.Wear)["pattern"]),
        }),
        OWN,
        when=_has_law,
    )),
    "oil": Optional(Table({  # says only which film it would build
        "like": Optional(Text()),  # an oil of the library, for what is not given here
        "temperatures": Optional(List(TEMPERATURE, length=2), (313.15, 373.15)),
        "kinematic_viscosity": Optional(
            List(Quantity("a kinematic viscosity", "32 mm^2/s"), length=2)
        ),
        "dynamic_viscosity": Optional(List(Quantity("a viscosity", "28 mPa s"), length=2)),
        "density": Optional(Quantity("a density", "866 kg/m^3")),  # with a kinematic viscosity
        "pressure_viscosity_coefficient": Optional(
            Either(PER_PRESSURE, List(PER_PRESSURE, length=2), when=_is_list)
        ),
    })),
    "friction": Table({
        "coefficient": FRICTION,
        "band": Optional(List(FRICTION, length=2)),
        "by_velocity": Optional(
            List(Table({"velocity": SPEED, "coefficient": FRICTION})), ()
        ),
    }),
    "temperature": Table({
        "bulk": Either(  # of both bodies, or of each
            TEMPERATURE, Table({"pin": TEMPERATURE, "disk": TEMPERATURE}), when=_is_table
        ),
        "critical": Optional(TEMPERATURE),  # needed where wear is judged
        "failing_share": Optional(Number(at_least=0, below=1), 0.1),
        "criterion": Optional(
            Either(Choice(("share", "highest", "mean")), Text(), when=_is_reference), "share"
        ),
    }),
    "fidelity": Optional(Table({"preset": Optional(PRESET, USUAL_PRESET), **FIDELITY})),
    "sweep": Table({
        "loads": Either(List(LOAD, distinct=True), Range(LOAD), when=_is_table),
        "velocities": Either(List(VELOCITY, distinct=True), Range(VELOCITY), when=_is_table),
        "realizations": Optional(Either(SURFACES, List(SEED, distinct=True), when=_is_list)),
        "samples": Optional(SAMPLES),  # of what is unknown
        "sample_seed": Optional(SEED, 0),
        "wear_rates": Optional(Table({"from": WEAR_RATE, "to": WEAR_RATE})),
        "fields": Optional(Flag(), False),
        "independent": Optional(Flag(), False),
    }),
    "unknown": Optional(UNKNOWN),  # by the paths of entries
    "measured": Optional(List(Either(TRANSITION, LOG, when=_has_file)), ()),
    "tested": Optional(List(Either(TEST, LOG, when=_has_file)), ()),
})  # fmt: skip
