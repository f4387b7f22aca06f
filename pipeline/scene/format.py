"""The format of scene files: each table and key with its kind, meaning, default and example."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any, get_type_hints

import tribo
from pipeline import extras
from pipeline.scene.compounds import (
    ByPath,
    Either,
    Entry,
    List,
    Optional,
    Range,
    Table,
    Tables,
    fields_of,
)
from pipeline.scene.faults import did_you_mean
from pipeline.scene.kinds import (
    Flag,
    Number,
    OneOf,
    Quantity,
    Scalar,
    Share,
    Text,
    UnitText,
    Whole,
    kind_of,
)
from pipeline.sweep.about import OUTCOMES
from pipeline.sweep.limits import MOST_SCENES
from tribo.simulation.pins import sizes_of

USUAL_PRESET = "standard"


def length(example: str) -> Quantity:
    """Kind of a length."""
    return Quantity("a length", example)


def one_or_two(kind: Quantity) -> Either:
    """Kind of a quantity: one value along x and one along y, or one for both."""
    return Either(kind, List(kind, length=2))


ANY_WEAR_RATE = Quantity("a specific wear rate", "1.2e-6 mm^3/(N m)", zero=True)
LOAD = Quantity("a load", "200 N")
DURATION = Quantity("a duration", "4 s", zero=True)
VELOCITY = Quantity("a velocity", "1.25 m/s", zero=True)
SPEED = Quantity("a velocity", "1.25 m/s")
TEMPERATURE = Quantity("a temperature", "25 degC")
KINEMATIC = Quantity("a kinematic viscosity", "32 mm^2/s")
OIL_WORKS = "-53 degC", "627 degC"
"""Bulk temperatures between which an oil may work."""
BULK = Quantity("a temperature", "25 degC", ends=OIL_WORKS)
CRITICAL = Quantity("a temperature", "145 degC")
CRITICAL_SD = Quantity("a difference", "8 K", ends=("0.001 K", "200 K"))
CONDUCTIVITY = Quantity("a conductivity", "45 W/(m K)")
HEAT_TRANSFER = Quantity("a heat transfer coefficient", "50 W/(m^2 K)")
FRICTION = Number(at_least=0)
SEED = Whole(at_least=0)
NAME = Either(Text(), Whole(at_least=0), when=lambda value: isinstance(value, int))
LATER = "Acts after the simulation."


def _brought_entries(table: str) -> dict[str, Entry]:
    """Entries of a table that extras bring, each as ``ENTRIES`` of its module ``format``."""
    paths = (item for brought in extras.modules("format") for item in brought.ENTRIES.items())
    parts = ((*path.rpartition("."), entry) for path, entry in paths)
    return {key: entry for above, _, key, entry in parts if above == table}


def _brought_forms(key: str) -> list[Table]:
    """Further forms of a test that extras bring, each as ``FORMS`` of its module ``format``."""
    return [brought.FORMS[key] for brought in extras.modules("format") if key in brought.FORMS]


# fmt: off
MATERIAL = Table({
    "like": Optional(Text(),
        "A material of the library, whose values hold where none is given here.",
        example="AISI 52100"),
    "elastic_modulus": Entry(Quantity("a modulus", "210 GPa"), "Young's modulus."),
    "poisson_ratio": Entry(Number(above=-1, at_most=0.5), "Poisson's ratio."),
    "hardness": Optional(Quantity("a pressure", "6.6 GPa"),
        'Highest contact pressure, also as "62 HRC", "750 HV" or "250 HB"; the softer body '
        "decides, and a body without a hardness stays elastic.", default=math.inf),
    "thermal_conductivity": Entry(CONDUCTIVITY, "Thermal conductivity."),
    "density": Entry(Quantity("a density", "7800 kg/m^3"), "Density."),
    "specific_heat": Entry(Quantity("a specific heat", "470 J/(kg K)"), "Specific heat capacity."),
})

STEM = Either(
    Table({
        "length": Entry(length("4 mm"), "Length of the rod, of the pin's material."),
        "area": Entry(Quantity("an area", "13.6 mm^2"), "Cross section of the rod."),
    }, form="rod"),
    Table({
        "resistance": Entry(Quantity("a thermal resistance", "8 K/W"),
            "Thermal resistance to the holder."),
    }, form="resistance"),
)

def _kept_heat(body: str, track: str, example: str) -> dict[str, Optional]:
    """Entries of a body on the heat that stays in it."""
    return {
        "track_length": Optional(length(example),
            f"Length of the track {track}, on a plate; earlier turns have warmed it. Without it "
            f"each turn meets a cold track. {LATER}"),
        "capacity": Optional(
            Either(Quantity("a heat capacity", "650 J/K"), Table({
                "diameter": Entry(length("150 mm")),
                "thickness": Entry(length("10 mm")),
            })),
            f"Heat capacity of the {body} behind the track, or its size; the temperature of the "
            f"{body} then starts at `bulk`. {LATER}"),
        "loss": Optional(Quantity("a heat loss per kelvin", "2 W/K"),
            f"Heat loss of the {body} to oil, air and holder, for each kelvin above its start; "
            f"none by default. {LATER}"),
        "diameter": Optional(length("100 mm"),
            f"Diameter, if the {body} is a disc that conducts as a whole and is heated around its "
            f"rim; it excludes `track_length`, `capacity` and `loss`. {LATER}"),
        "width": Optional(length("20 mm"), "Width of the disc; needed with `diameter`."),
        "bore": Optional(length("30 mm"), "Diameter of its hole, if the disc is a ring."),
        "rim_loss": Optional(HEAT_TRANSFER,
            "Heat loss of the rim to oil and air, for each area and kelvin; none by default."),
        "face_loss": Optional(HEAT_TRANSFER, "The same for each face; none by default."),
        "shaft_loss": Optional(Quantity("a heat loss per kelvin", "5 W/K"),
            "Heat loss to the shaft for each kelvin, at the bore, or evenly over a disc without a "
            "bore; none by default."),
    }


def _ends_along_y(shape: object) -> bool:
    """True for a known shape of a pin whose contact ends along y, too."""
    return isinstance(shape, str) and shape in tribo.PINS and "length" not in sizes_of(shape)


_ROUND = {
    "shape": Entry(OneOf(tuple(tribo.PINS)), "Shape of the pin."),
    "radius": Entry(length("2 mm"),
        "Radius in the plane of sliding; for two curved bodies the reduced radius."),
}
_OF_PIN = {
    "material": Entry(Text(), "Name of the material, in this file or in the library."),
    "stem": Optional(STEM,
        "Rod between the heated end of the pin and a holder at the bulk temperature, or its "
        f"thermal resistance. Without the table the pin is a half-space. {LATER}"),
    **_kept_heat("pin", "around a pin that rolls", "314 mm"),
}
PIN = Either(
    Table({
        **_ROUND,
        "length": Entry(length("3.4 mm"), "Length of the cylinder's line contact, along y."),
        **_OF_PIN,
    }, form="cylinder"),
    Table({
        **_ROUND,
        "crown_radius": Optional(length("100 mm"),
            "Radius across sliding; needed for a crowned pin."),
        **{
            size: Optional(length("100 mm"), f"Size of a {shape} pin; needed.")
            for shape in tribo.PINS for size in sizes_of(shape)
            if size not in ("radius", "length", "crown_radius")
        },
        **_OF_PIN,
    }, form="ball or crowned pin"),
    when=lambda pin: isinstance(pin, dict) and _ends_along_y(pin.get("shape")),
)

RANDOM_SURFACE = Table({
    "ra": Entry(length("0.27 um"), "Ra, the mean deviation of the heights from their mean plane."),
    "hurst_exponent": Entry(Number(above=0, at_most=1),
        "Hurst exponent; a larger one is smoother at short wavelengths."),
    "correlation_length": Entry(one_or_two(length("4 um")),
        "Length beyond which heights are independent; two values, along x and y, for a ground "
        "surface."),
    "seed": Optional(SEED,
        "Seed of the random surface.", default=0),
}, form="random surface")
MEASURED_SURFACE = Table({
    "file": Entry(Text(),
        "File with the heights of a measured surface, x along its columns: .npy, text, or the "
        "format of an instrument (extra `surfaces`); relative to the folder of the scene.",
        example="surface.npy"),
    "height_unit": Optional(UnitText("a unit of length", "um"),
        "Unit of the heights, or its length in m; needed if the file has none, as .npy, and "
        "overrides a wrong one."),
    "pixel_size": Optional(List(length("0.8 um"), length=2),
        "Sides of a pixel of the file along x and y, after any exchange, if it gives none or wrong "
        "ones; the ratio of its places stays."),
    "transpose": Optional(Flag(),
        "True to exchange x and y of the file, with the sides of its pixels.", default=False),
    "flip": Optional(OneOf(("no", "x", "y", "heights")),
        "Axis to reverse; or the heights, for a replica.",
        default="no"),
    "crop": Optional(List(Whole(at_least=0), length=2),
        "First pixel of the patch to cut out, along x and y from 0. Without it the surface must "
        "have the size of the window."),
    "level": Optional(Flag(),
        "True to subtract the form: the least-squares plane (tilt), and a curvature that stands "
        "out, which the pin's radius has already.", default=False),
    "missing": Optional(OneOf(("refuse", "fill")),
        "Pixels without a height: refuse the file, or fill them smoothly from around.",
        default="refuse"),
    "repeat": Optional(OneOf(("no", "mirror", "tile")),
        "How a surface smaller than the window is continued: not, mirrored at each end, or as "
        "tiles.", default="no"),
}, form="measured surface")


DISK = Table({
    "material": Entry(Text(), "Name of the material, in this file or in the library."),
    **_kept_heat("disk", "under the pin", "340 mm"),
    "film": Optional(Table({
        "thickness": Entry(length("20 nm"), "Thickness of the film."),
        "thermal_conductivity": Entry(Quantity("a conductivity", "2 W/(m K)"),
            "Thermal conductivity of the film."),
    }), f"Oxide or tribofilm on the disk, a thermal resistance. {LATER}"),
    "roughness": Optional(Either(RANDOM_SURFACE, MEASURED_SURFACE),
        "Surface of the disk, random or measured; smooth without the table. In Python also [your "
        "own](OWN_LAWS.md)."),
})

WINDOW = Table({
    "pixels": Entry(List(Whole(at_least=1, at_most=100_000), length=2),
        "Number of pixels along x and y."),
    "pixel_size": Entry(List(length("0.95 um"), length=2),
        "Sides of a pixel along x and y; for a measured surface, those of its pixels."),
    "periodic_y": Optional(Flag(),
        "True if the patch repeats along y; by default only for a cylinder."),
})

_REFERENCE_LOAD = (
    "Load that is reached in `fidelity.increments` steps; by default the peak of a record."
)
LOADING = Either(
    Table({
        "rate": Entry(Quantity("a loading rate", "150 N/s"),
            "Rate at which the load grows from 0."),
        "reference_load": Entry(Quantity("a load", "750 N"), _REFERENCE_LOAD),
        "hold": Optional(DURATION,
            "Time for which each load is held after the ramp, in growing steps.",
            default=0.0),
    }, form="ramp"),
    Table({
        "file": Entry(Text(),
            "Recorded load, a CSV file with the columns `time [s]` and `load [N]`; relative to the "
            "folder of the scene.", example="load.csv"),
        "reference_load": Optional(Quantity("a load", "750 N"), _REFERENCE_LOAD),
        "fit": Optional(Flag(),
            "True to replace the record by a straight line through it.", default=False),
    }, form="record"),
)

MOTION = Table({
    "slide_roll_ratio": Optional(Number(),
        "Sliding velocity over the mean velocity of both surfaces; negative if the pin is the "
        "faster body."),
    "entrainment_velocity": Optional(Quantity("a velocity", "3 m/s", zero=True),
        "Mean velocity of both surfaces, at all sliding velocities."),
    "track_length": Optional(length("314 mm"),
        "Length over which the wear of the pin spreads; by default the pin's `track_length`, or "
        "the circumference of its radius."),
})

WEAR_PATTERN = kind_of(get_type_hints(tribo.Wear)["pattern"])
_BY_UNIT = {"m^2/N": ANY_WEAR_RATE, "m": length("100 m")}


def _law_form(name: str) -> Table:
    """Entries of a law that ships, by the fields of its class."""
    law: Any = tribo.LAWS[name]
    meanings = {key: entry.meaning for key, entry in fields_of(law).items()}
    entries: dict[str, Entry] = {
        "law": Entry(OneOf(tuple(tribo.LAWS)), "Name of a law that ships."),
    }
    for one in fields(law):
        if one.name == "pattern":
            entries[one.name] = Optional(WEAR_PATTERN, meanings[one.name], default=one.default)
        else:
            entries[one.name] = Entry(_BY_UNIT[one.metadata["unit"]], meanings[one.name])
    return Table(entries, form=name)


def _wear_form(table: Any) -> int:
    """Place of the form that a table of wear has."""
    law, laws = (table.get("law") if isinstance(table, dict) else None), [*tribo.LAWS]
    if law is None:
        return 0
    near = [one for one in laws if one == law or did_you_mean(str(law), [one])]
    return 1 + laws.index(near[0] if near else laws[0])


WEAR = Either(
    Table({
        "specific_wear_rate": Entry(ANY_WEAR_RATE, "Worn volume per load and sliding distance."),
        "pattern": Entry(WEAR_PATTERN,
            'How the pin wears. "swept": by the pressure averaged along y, as the roughness moves '
            'past; over positions of the disk if y is not periodic. "local": each element by its '
            "own pressure."),
    }, form="Archard"),
    *map(_law_form, tribo.LAWS),
    when=_wear_form,
)

OIL = Table({
    "like": Optional(Text(),
        "An oil of the library, whose values hold where none is given here.",
        example="medicinal white oil"),
    "temperatures": Optional(List(TEMPERATURE),
        "Two temperatures or more at which the viscosity is known, rising.",
        default=(313.15, 373.15), example=["40 degC", "100 degC"]),
    "kinematic_viscosity": Optional(Either(KINEMATIC, List(KINEMATIC)),
        "Kinematic viscosity at each of these temperatures; give this or the dynamic one. A line "
        "of ASTM D341 is fitted to more than two.",
        example=["95 mm^2/s", "10.7 mm^2/s"]),
    "dynamic_viscosity": Optional(List(Quantity("a viscosity", "28 mPa s")),
        "Dynamic viscosity at each of these temperatures.", example=["83 mPa s", "8.9 mPa s"]),
    "viscosity_index": Optional(Number(),
        "Viscosity index (ASTM D2270): with it, `kinematic_viscosity` is one value, that at 40 °C, "
        "or that of a grade of the library (`like`).", example=95),
    "density": Optional(Quantity("a density", "866 kg/m^3"),
        "Density; needed with a kinematic viscosity."),
    "pressure_viscosity_coefficient": Optional(
        one_or_two(Quantity("a pressure coefficient", "20 1/GPa")),
        "Pressure–viscosity coefficient, one, or one at the first temperature and one at the last. "
        "Without it no "
        "film is predicted."),
})

FRICTION_TABLE = Table({
    "coefficient": Entry(FRICTION,
        "Coefficient of friction. Another one given afterwards (`--at`, `--friction`) scales what "
        "`by_velocity` and `by_temperature` tell; one in the scene (`--set`) leaves their values."),
    "band": Optional(List(FRICTION, length=2),
        "Lowest and highest coefficient, drawn as a band in the diagram."),
    "same_rig": Optional(Flag(),
        "True if tests and scene have the same friction, so that `irg infer` learns from the "
        "tests; false if the scene is another machine than the rig.", default=True),
    "by_velocity": Optional(List(Table({
        "velocity": Entry(SPEED, "Sliding velocity."),
        "coefficient": Entry(FRICTION, "Coefficient of friction."),
    })), "Friction by sliding velocity, smooth between the given values and constant beyond them. "
         f"A coefficient given afterwards scales it. {LATER}", default=()),
    "by_temperature": Optional(List(Table({
        "temperature": Entry(TEMPERATURE, "Temperature of the contact."),
        "coefficient": Entry(Number(above=0), "Coefficient of friction."),
    })), "Friction by the temperature of the contact, in each of its parts; linear between the "
         "given values and constant beyond them. Its factor on the coefficient multiplies that of "
         f"the velocity. {LATER}", default=()),
})

TEMPERATURES = Table({
    "bulk": Entry(Either(BULK, Table({
        "pin": Entry(BULK, "Temperature of the pin."),
        "disk": Entry(BULK, "Temperature of the disk."),
    })), "Temperature far from the contact, of both bodies, or of `pin` and `disk`."),
    "critical": Optional(CRITICAL,
        "Contact temperature above which the lubricant fails; needed to judge wear."),
    "critical_sd": Optional(CRITICAL_SD,
        "Standard deviation of `critical`, which counts in each verdict. With `sweep.samples` give "
        "`critical` as one of their `unknown` inputs instead."),
    "failing_share": Optional(Share(at_least=0, below=1),
        "Wear is severe if a larger share of the contact area is above the critical temperature; "
        "0 if the highest temperature decides.", default=0.1),
    "criterion": Optional(
        OneOf(tuple(tribo.CRITERIA)),
        "Deciding temperature: the one exceeded on the failing share of the contact, the highest, "
        "or the mean; in Python also [your own criterion](OWN_LAWS.md).", default="share"),
})

MODEL = Table({
    "scatter": Optional(Share(at_least=0, below=1),
        "Relative scatter of measured velocities about the model. It weighs as much as four tests; "
        f"0 for none. {LATER}", default=0.1),
})

_OF_PAPER = ("kernel", "contact_criterion", "wear_scheme", "heat_kernel")
"""Choices that the results of the paper compare, in Python; a scene has those of its preset."""
FIDELITY = Table({
    "preset": Optional(OneOf(tuple(tribo.PRESETS)),
        'Preset, from "draft", the fastest, to "reference", the most accurate.',
        default=USUAL_PRESET),
    **{name: entry for name, entry in fields_of(tribo.Fidelity).items() if name not in _OF_PAPER},
})

SWEEP = Table({
    "loads": Entry(Either(List(LOAD, distinct=True), Range(LOAD)), "Normal loads."),
    "velocities": Entry(Either(List(VELOCITY, distinct=True), Range(VELOCITY)),
        'Sliding velocities; `count` with `spacing = "log"` gives equal ratios.'),
    "realizations": Optional(
        Either(Whole(at_least=1, at_most=MOST_SCENES), List(SEED, distinct=True)),
        "Random surfaces: their number, counted from the seed on, or a list of seeds."),
    **_brought_entries("sweep"),
    "over": Optional(ByPath(List(Scalar(), distinct=True), "paths of other entries"),
        'Entries with several values, such as `over = { "pin.radius" = ["1 mm", "2 mm"] }`. The '
        "plane is computed for each combination of values.",
        default={}),
    "along": Optional(Either(Text(), List(ByPath(Scalar(), "paths of other entries"))),
        "Rows, each with its own load and velocity: a CSV file, or a list of tables, such as "
        '`[{ "pin.radius" = "3 mm", load = "400 N", velocity = "2 m/s" }]`. A column is an entry, '
        "by its path or as `friction`, `bulk temperature` or `critical temperature`; other columns "
        "are labels. `irg margin STORE` gives the verdict on each row."),
    "fields": Optional(Flag(),
        "True to store pressure, temperature rise and wear depth over the window.",
        default=False),
    "steps": Optional(OneOf(("course", "end")),
        'Steps to store. "course": all; increments of the ramp are on the grid of the history. '
        '"end": those that can decide, which are the end of the ramp, the end of a hold, and the '
        'hold of each test. By default "course" for a ramp with wear, without a hold and with '
        'contacts of its own, else "end".'),
})

_LOAD = "Normal load on the pin."
_VELOCITY = "Sliding velocity."
_TEST = {
    "load": Entry(LOAD, _LOAD),
    "load_scatter": Optional(Quantity("a load", "10 N"),
        "Standard deviation of the load in repeated tests, for `irg infer` with samples; none by "
        "default."),
    "velocity": Entry(VELOCITY, _VELOCITY),
    "velocity_scatter": Optional(Quantity("a velocity", "0.1 m/s"),
        "Standard deviation of the velocity; by default `--scatter`, 5 % of the velocity."),
    "friction": Optional(FRICTION,
        "Measured coefficient of friction; by default the scene's."),
    "friction_scatter": Optional(Number(above=0),
        "Standard deviation of the measured friction; none by default."),
    "bulk_temperature": Optional(BULK,
        "Bulk temperature of both bodies; by default the scene's."),
    "hold": Optional(DURATION, "Time at the full load; by default that of `[loading]`."),
    "number": Optional(NAME,
        "Number or name of the test in answers; by default its place in the file, or its row in a "
        "log."),
    "oil": Optional(NAME,
        "Oil of the test, where those of one rig are compared; by default the scene's."),
}
TRANSITION = Table(_TEST, form="entries")
_RUN = {
    "run": Optional(NAME,
        "Run of the test. Tests of one run have one specimen, such as the stages of a load-stage "
        "test, and count as one; by default each test is a run."),
}
TEST = Table({
    **_TEST, **_RUN,
    "outcome": Entry(OneOf(OUTCOMES), "Outcome at the end of the hold."),
}, form="entries")
STAGES = Table({
    **_TEST, **_RUN,
    "load": Optional(LOAD, _LOAD),
    "velocity": Optional(VELOCITY, _VELOCITY),
    "mild_up_to": Optional(Scalar(),
        "Highest mild stage of a run, instead of the outcome: a load if `velocity` is given, a "
        "velocity if `load` is; give it alone if no stage was severe.",
        example="400 N"),
    "severe_at": Optional(Scalar(),
        "Severe stage of a run; give it alone if it was the first stage.", example="450 N"),
}, form="run by stages")
FORMAT = Table({
    "extends": Optional(Text(),
        "Another scene, whose entries hold where this file gives none: a shipped name, or a path "
        "relative to this file.", example="other.toml"),
    "without": Optional(List(Text(), distinct=True),
        'Paths of entries not to take from the other scene, such as ["wear", "friction.band"].',
        example=["wear", "friction.band"]),
    "title": Optional(Text(), "Title of figures and summaries; by default the name of the file."),
    "caveat": Optional(Text(), "What a reader of each verdict must know of this scene, in a line."),
    "materials": Optional(Tables(MATERIAL),
        "A material, whose NAME `[pin]` and `[disk]` use. Materials of the "
        "[library](../pipeline/scene/library.toml) need no table."),
    "pin": Entry(PIN,
        "The loaded body, which wears: a cylinder across the sliding direction, a ball, or a "
        "crowned roller."),
    "disk": Entry(DISK, "The body that slides under the pin."),
    "window": Entry(WINDOW,
        "The simulated patch of the contact, x along sliding and y across."),
    "loading": Entry(LOADING, "Growth of the load: a ramp, or a recorded load."),
    "motion": Optional(MOTION,
        "Motion of both bodies: give `slide_roll_ratio` or `entrainment_velocity`. Without the "
        "table the pin is at rest."),
    "wear": Optional(WEAR,
        "Wear of the pin: Archard's law, or a rate by sliding distance; in Python also [your own "
        "law](OWN_LAWS.md). Without the table there is no wear."),
    "oil": Optional(OIL,
        "The lubricant, used only to say which transitions lie in boundary lubrication. "
        '`oil = "NAME"` takes an oil of the [library](../pipeline/scene/library.toml).'),
    "friction": Entry(FRICTION_TABLE,
        f"Friction, to which the temperature rise is proportional. {LATER} `--friction` changes "
        "it."),
    "temperature": Entry(TEMPERATURES,
        "Temperatures that decide whether wear is severe. They act after the simulation."),
    "model": Optional(MODEL,
        "Error of the model itself."),
    "fidelity": Optional(FIDELITY,
        'Numerical choices: a preset, and choices that replace its own. Without the table the '
        'preset is "standard".'),
    "sweep": Entry(SWEEP, "The points of the load–velocity plane to compute."),
    **_brought_entries(""),
    "measured": Optional(List(Either(TRANSITION, *_brought_forms("measured"))),
        "Measured transitions, a table for each: for the diagram, for `irg infer`, and for the "
        "model's own error.", default=()),
    "tested": Optional(List(Either(TEST, *_brought_forms("tested"), STAGES)),
        "Tests that stayed mild or turned severe: a table for each, a run by its stages, or a log; "
        "for `irg infer` with samples, and for the model's own error.", default=()),
})
SCENE = Entry(FORMAT, "The file itself, above its first table.")
# fmt: on
