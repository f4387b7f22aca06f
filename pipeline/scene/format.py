"""The format of scene files: each table and key with its kind, meaning, default and example."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any, get_type_hints

import tribo
from pipeline.scene.compounds import (
    ByPath,
    Distribution,
    Either,
    Entry,
    List,
    Optional,
    Range,
    Table,
    Tables,
    fields_of,
)
from pipeline.scene.faults import quoted
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
from pipeline.sweep.limits import MOST_SAMPLES, MOST_SCENES
from tribo.simulation.pins import sizes_of

USUAL_PRESET = "standard"


def length(example: str) -> Quantity:
    """Kind of a length."""
    return Quantity("a length", example)


def one_or_two(kind: Quantity) -> Either:
    """Kind of a quantity: one value along x and one along y, or one for both."""
    return Either(kind, List(kind, length=2))


WEAR_RATE = Quantity("a specific wear rate", "1.2e-6 mm^3/(N m)")
ANY_WEAR_RATE = Quantity("a specific wear rate", "1.2e-6 mm^3/(N m)", zero=True)
LOAD = Quantity("a load", "200 N")
DURATION = Quantity("a duration", "4 s", zero=True)
VELOCITY = Quantity("a velocity", "1.25 m/s", zero=True)
SPEED = Quantity("a velocity", "1.25 m/s")
TEMPERATURE = Quantity("a temperature", "25 degC")
OIL_WORKS = "-53 degC", "627 degC"
"""Bulk temperatures between which an oil may work."""
BULK = Quantity("a temperature", "25 degC", ends=OIL_WORKS)
CRITICAL = Quantity("a temperature", "145 degC")
CONDUCTIVITY = Quantity("a conductivity", "45 W/(m K)")
HEAT_TRANSFER = Quantity("a heat transfer coefficient", "50 W/(m^2 K)")
FRICTION = Number(at_least=0)
SEED = Whole(at_least=0)
NAME = Either(Text(), Whole(at_least=0), when=lambda value: isinstance(value, int))

# fmt: off
MATERIAL = Table({
    "like": Optional(Text(),
        "A material of the library, which gives what is not given here.", example="AISI 52100"),
    "elastic_modulus": Entry(Quantity("a modulus", "210 GPa"), "Young's modulus."),
    "poisson_ratio": Entry(Number(above=-1, at_most=0.5), "Poisson's ratio."),
    "hardness": Optional(Quantity("a pressure", "6.6 GPa"),
        'Highest pressure that it bears, or a hardness such as "62 HRC", "750 HV" or "250 HB"; the '
        "softer body's counts, and a body without one stays elastic.", default=math.inf),
    "thermal_conductivity": Entry(CONDUCTIVITY, "Thermal conductivity."),
    "density": Entry(Quantity("a density", "7800 kg/m^3"), "Density."),
    "specific_heat": Entry(Quantity("a specific heat", "470 J/(kg K)"), "Specific heat capacity."),
})

STEM = Either(
    Table({
        "length": Entry(length("4 mm"), "Length of the rod, of the pin's material."),
        "area": Entry(Quantity("an area", "13.6 mm^2"), "Its cross section."),
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
            f"Length of the track {track}, on a plate, which earlier turns have warmed; without it "
            "each turn meets a cold track. It takes effect after the simulation."),
        "capacity": Optional(
            Either(Quantity("a heat capacity", "650 J/K"), Table({
                "diameter": Entry(length("150 mm")),
                "thickness": Entry(length("10 mm")),
            })),
            f"Heat that warms all of the {body} behind the track by one kelvin, or its size, of "
            "its material; `bulk` is then where it starts. It takes effect after the simulation."),
        "loss": Optional(Quantity("a heat loss per kelvin", "2 W/K"),
            f"Heat that the {body} loses to oil, air and holder for each kelvin above where it "
            "starts; none by default. It takes effect after the simulation."),
        "diameter": Optional(length("100 mm"),
            f"Diameter of the {body} as a disc that its turns heat around the rim, and that warms "
            "as a whole; in place of `track_length`, `capacity` and `loss`. It takes effect after "
            "the simulation."),
        "width": Optional(length("20 mm"), "Width of the disc, which it needs."),
        "bore": Optional(length("30 mm"), "Diameter of the hole of a ring; none by default."),
        "rim_loss": Optional(HEAT_TRANSFER,
            "Heat that the rim of the disc loses to oil and air, for each area and kelvin."),
        "face_loss": Optional(HEAT_TRANSFER, "That of each of its faces."),
        "shaft_loss": Optional(Quantity("a heat loss per kelvin", "5 W/K"),
            "Heat that the disc loses to its shaft for each kelvin, at the bore, or evenly over a "
            "disc without one."),
    }


def _ends_along_y(shape: object) -> bool:
    """True for a known shape of a pin whose contact ends along y, too."""
    return isinstance(shape, str) and shape in tribo.PINS and "length" not in sizes_of(shape)


_ROUND = {
    "shape": Entry(OneOf(tuple(tribo.PINS)), "Shape of the pin."),
    "radius": Entry(length("2 mm"),
        "Radius in the plane of sliding; of two curved bodies the reduced one."),
}
_OF_PIN = {
    "material": Entry(Text(), "Name of its material, here or in the library."),
    "stem": Optional(STEM,
        "Rod between the heated end of the pin and a holder at the bulk temperature, or its "
        "thermal resistance; a half-space without the table. It takes effect after the "
        "simulation."),
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
            "Radius across sliding of a crowned pin, which it needs."),
        **{
            size: Optional(length("100 mm"), f"Size of a {shape} pin, which it needs.")
            for shape in tribo.PINS for size in sizes_of(shape)
            if size not in ("radius", "length", "crown_radius")
        },
        **_OF_PIN,
    }, form="ball or crowned pin"),
    when=lambda pin: isinstance(pin, dict) and _ends_along_y(pin.get("shape")),
)

RANDOM_SURFACE = Table({
    "ra": Entry(length("0.27 um"), "Mean deviation of the heights from their mean plane, Ra."),
    "hurst_exponent": Entry(Number(above=0, at_most=1),
        "Hurst exponent; the nearer to 1, the smoother at short wavelengths."),
    "correlation_length": Entry(one_or_two(length("4 um")),
        "Length beyond which heights no longer depend on each other; two for one along x and one "
        "along y, as on ground surfaces."),
    "seed": Optional(SEED,
        "Seed of the random surface; the same gives the same surface.", default=0),
}, form="random surface")
MEASURED_SURFACE = Table({
    "file": Entry(Text(),
        "Heights of a measured surface, with x along the columns of the file: .npy, text, or the "
        "file of an instrument (with the extra `surfaces`); relative to the folder of the scene.",
        example="surface.npy"),
    "height_unit": Optional(UnitText("a unit of length", "um"),
        "Unit of the heights; needed where the file has none, as in .npy and .csv, and used in "
        "place of a wrong one."),
    "transpose": Optional(Flag(),
        "Exchange of x and y of the file, with the sides of its pixels.", default=False),
    "flip": Optional(OneOf(("no", "x", "y", "heights")),
        "Axis to reverse; or the heights, as of a replica, whose summits were valleys.",
        default="no"),
    "crop": Optional(List(Whole(at_least=0), length=2),
        "First pixel along x and y, counted from 0, of the patch to cut out; without it the "
        "surface is to have the window's size."),
    "level": Optional(Flag(),
        "Least-squares plane (tilt) taken off the heights, or not.", default=False),
    "missing": Optional(OneOf(("refuse", "fill")),
        "Places without a height: the file is refused, or the hole filled smoothly from around it.",
        default="refuse"),
    "repeat": Optional(OneOf(("no", "mirror", "tile")),
        "Filling of a window that is larger than the surface: none, mirrored at each end, or "
        "tiles.", default="no"),
}, form="measured surface")


def own_law(meaning: str, form: str = "") -> Table:
    """Entries of a law that is code, with its meaning."""
    return Table({
        "law": Entry(Text(), f"{meaning} Your own is code, which runs only with `--own-laws`."),
        "parameters": Optional(ByPath(Scalar(), "names"),
            "Names and values that it is made with, in SI units.", default={}),
    }, form=form)


DISK = Table({
    "material": Entry(Text(), "Name of its material, here or in the library."),
    **_kept_heat("disk", "under the pin", "340 mm"),
    "film": Optional(Table({
        "thickness": Entry(length("20 nm"), "Thickness of the film."),
        "thermal_conductivity": Entry(Quantity("a conductivity", "2 W/(m K)"),
            "Its thermal conductivity."),
    }), "An oxide or tribofilm on the disk, a thermal resistance; none without the table. It takes "
        "effect after the simulation."),
    "surface": Optional(own_law('Module and name of the surface, such as "laws:dimples".'),
        "Your own surface instead of a roughness, see [`OWN_LAWS.md`](OWN_LAWS.md)."),
    "roughness": Optional(Either(RANDOM_SURFACE, MEASURED_SURFACE),
        "Its surface: random, or measured; smooth without the table."),
})

WINDOW = Table({
    "pixels": Entry(List(Whole(at_least=1, at_most=100_000), length=2),
        "Number of pixels along x and y."),
    "pixel_size": Entry(List(length("0.95 um"), length=2),
        "Sides of a pixel along x and y; with a measured surface, its pixel size."),
    "periodic_y": Optional(Flag(),
        "Patch repeated along y, or not; by default for a cylinder alone."),
})

_REFERENCE_LOAD = (
    "Load that the ramp reaches in `fidelity.increments` steps; of a record, by default its peak."
)
LOADING = Either(
    Table({
        "rate": Entry(Quantity("a loading rate", "150 N/s"),
            "Rate at which the load grows from 0."),
        "reference_load": Entry(Quantity("a load", "750 N"), _REFERENCE_LOAD),
        "hold": Optional(DURATION,
            "Time for which each load is held once it is reached, in steps that grow.",
            default=0.0),
    }, form="ramp"),
    Table({
        "file": Entry(Text(),
            "Record of the load, .csv with the columns `time [s]` and `load [N]`; relative to the "
            "folder of the scene.", example="load.csv"),
        "reference_load": Optional(Quantity("a load", "750 N"), _REFERENCE_LOAD),
        "fit": Optional(Flag(),
            "A straight line through the record in its place, or not.", default=False),
    }, form="record"),
)

MOTION = Table({
    "slide_roll_ratio": Optional(Number(),
        "Sliding velocity divided by the mean velocity of both surfaces; negative where the pin is "
        "the faster body."),
    "entrainment_velocity": Optional(Quantity("a velocity", "3 m/s", zero=True),
        "Mean velocity of both surfaces, the same at every sliding velocity."),
    "track_length": Optional(length("314 mm"),
        "Length of the pin's track, over which its wear spreads; by default that of `[pin]`, or "
        "the circumference of its radius."),
})

WEAR_PATTERN = kind_of(get_type_hints(tribo.Wear)["pattern"])
_BY_UNIT = {"m^2/N": ANY_WEAR_RATE, "m": length("100 m")}


def _law_form(name: str) -> Table:
    """Entries of a law that ships, by the fields of its class."""
    law: Any = tribo.LAWS[name]
    meanings = {key: entry.meaning for key, entry in fields_of(law).items()}
    entries: dict[str, Entry] = {
        "law": Entry(OneOf((name,)), "Name of a law that ships."),
    }
    for one in fields(law):
        if one.name == "pattern":
            entries[one.name] = Optional(WEAR_PATTERN, meanings[one.name], default=one.default)
        else:
            entries[one.name] = Entry(_BY_UNIT[one.metadata["unit"]], meanings[one.name])
    return Table(entries, form=name)


def _wear_form(table: Any) -> int:
    """Place of the form that a table of wear has."""
    law = table.get("law") if isinstance(table, dict) else None
    return 2 + [*tribo.LAWS].index(law) if law in [*tribo.LAWS] else int(law is not None)


WEAR = Either(
    Table({
        "specific_wear_rate": Entry(ANY_WEAR_RATE, "Worn volume per load and sliding distance."),
        "pattern": Entry(WEAR_PATTERN,
            'Wear of the pin: "swept" by the mean pressure along y, or over positions of the disk '
            'where y is free, since the roughness moves past it; "local" each element by its own '
            "pressure."),
        "by_temperature": Optional(List(Table({
            "temperature": Entry(TEMPERATURE, "Bulk temperature."),
            "specific_wear_rate": Entry(WEAR_RATE, "Specific wear rate there."),
        })), "Wear rates at bulk temperatures, where they are known: an answer at another `bulk` "
             "than that of `specific_wear_rate` says so.", default=()),
    }, form="Archard's wear"),
    own_law(
        f"Name of a law by the distance slid, {', '.join(map(quoted, tribo.LAWS))}; or module and "
        'name of your own, such as "laws:Fading".', form="own law",
    ),
    *map(_law_form, tribo.LAWS),
    when=_wear_form,
)

OIL = Table({
    "like": Optional(Text(), "An oil of the library, which gives what is not given here.",
        example="medicinal white oil"),
    "temperatures": Optional(List(TEMPERATURE, length=2),
        "Two temperatures at which its viscosity is known.",
        default=(313.15, 373.15), example=["40 degC", "100 degC"]),
    "kinematic_viscosity": Optional(List(Quantity("a kinematic viscosity", "32 mm^2/s"), length=2),
        "Kinematic viscosity at both; this or the dynamic one.",
        example=["95 mm^2/s", "10.7 mm^2/s"]),
    "dynamic_viscosity": Optional(List(Quantity("a viscosity", "28 mPa s"), length=2),
        "Dynamic viscosity at both.", example=["83 mPa s", "8.9 mPa s"]),
    "density": Optional(Quantity("a density", "866 kg/m^3"),
        "Density; needed with a kinematic viscosity."),
    "pressure_viscosity_coefficient": Optional(
        one_or_two(Quantity("a pressure coefficient", "20 1/GPa")),
        "Pressure–viscosity coefficient, one, or one at each of both temperatures; without it no "
        "film is predicted."),
})

FRICTION_TABLE = Table({
    "coefficient": Entry(FRICTION, "Coefficient of friction."),
    "band": Optional(List(FRICTION, length=2),
        "Lowest and highest coefficient, drawn as a band in the diagram."),
    "same_rig": Optional(Flag(),
        "Friction that tests have measured is that of the scene, which `irg infer` learns from it; "
        "false where the scene is another machine than the rig.", default=True),
    "by_velocity": Optional(List(Table({
        "velocity": Entry(SPEED, "Sliding velocity."),
        "coefficient": Entry(FRICTION, "Coefficient of friction there."),
    })), "Friction at sliding velocities, smooth in between and constant beyond them; another "
         "coefficient scales it. It takes effect after the simulation.", default=()),
})

TEMPERATURES = Table({
    "bulk": Entry(Either(BULK, Table({
        "pin": Entry(BULK, "Temperature of the pin."),
        "disk": Entry(BULK, "Temperature of the disk."),
    })), "Temperature far from the contact: of both bodies, or of `pin` and `disk`."),
    "critical": Optional(CRITICAL,
        "Contact temperature above which the lubricant fails; needed where wear is judged."),
    "failing_share": Optional(Share(at_least=0, below=1),
        "Share of the contact area above the critical temperature beyond which wear is severe; 0 "
        "for the highest temperature alone.", default=0.1),
    "criterion": Optional(
        Either(OneOf(tuple(tribo.CRITERIA)), Text(), when=lambda word: ":" in str(word)),
        "Temperature that decides: the one that the failing share of the contact area exceeds, the "
        "highest, or the mean of the contact; or a [criterion of your own](OWN_LAWS.md), such as "
        '"laws:hottest_tenth", which runs only with `--own-laws`.', default="share"),
})

MODEL = Table({
    "scatter": Optional(Share(at_least=0, below=1),
        "Relative scatter of the velocity of a run about the model, which four tests count as much "
        "as; 0 for none.", default=0.1),
})

FIDELITY = Table({
    "preset": Optional(OneOf(tuple(tribo.PRESETS)),
        'Preset to begin with: "draft" is the fastest, "reference" the best.',
        default=USUAL_PRESET),
    **fields_of(tribo.Fidelity),
})

SWEEP = Table({
    "loads": Entry(Either(List(LOAD, distinct=True), Range(LOAD)), "Normal loads."),
    "velocities": Entry(Either(List(VELOCITY, distinct=True), Range(VELOCITY)),
        'Sliding velocities; `count` with `spacing = "log"` makes their ratios equal.'),
    "realizations": Optional(
        Either(Whole(at_least=1, at_most=MOST_SCENES), List(SEED, distinct=True)),
        "Random surfaces to compute it all on: a number of them from the seed on, or a list of "
        "seeds."),
    "samples": Optional(Whole(at_least=1, at_most=MOST_SAMPLES),
        "Number of samples drawn of the `unknown` inputs, each at a velocity of its own; fewer are "
        "drawn where more would share their contacts, as `irg check` says."),
    "sample_seed": Optional(SEED, "Seed of the samples.", default=0),
    "over": Optional(ByPath(List(Scalar(), distinct=True), "the paths of others"),
        'Values of entries by their paths, such as `over = { "pin.radius" = ["1 mm", "2 mm"] }`: '
        "all is computed for each value, and for every combination of several entries.",
        default={}),
    "along": Optional(Either(Text(), List(ByPath(Scalar(), "the paths of others"))),
        "Pairs: a CSV file, or a list of tables, such as "
        '`[{ "pin.radius" = "3 mm", load = "400 N", velocity = "2 m/s" }]`. Each row has a place '
        "of its own, and values of entries by their paths, of which `friction`, `bulk temperature` "
        "and `critical temperature` are known by these words, too; `irg margin STORE` gives the "
        "verdict and the margin of each. Other columns are labels."),
    "around": Optional(Whole(at_least=3, at_most=99),
        "Velocities and loads about each row of `along`, from half to twice its own, so that "
        "margins have factors."),
    "fields": Optional(Flag(),
        "Pressure, temperature rise and wear depth over the window stored, or not.",
        default=False),
    "steps": Optional(OneOf(("course", "end")),
        'Steps of a point that are stored. "course": each; increments of the ramp on the grid of '
        'the history. "end": those that can decide, which are the moment when the load is reached, '
        'the ends of a hold, and the hold of each test. By default "course" for what wears on a '
        'ramp without a hold and has contacts of its own, else "end".'),
})

_ALWAYS = {
    "varies": Optional(Flag(), default=False),
    "correlated": Optional(ByPath(Number(above=-1, below=1), "the paths of others"), default={}),
}
UNKNOWN = ByPath(Distribution(
    forms=(
        Table({"mean": Entry(Scalar()), "sd": Entry(Scalar()), **_ALWAYS}, "normal"),
        Table({"median": Entry(Scalar()), "factor": Entry(Number(above=1)), **_ALWAYS},
            "log-normal"),
        Table({"from": Entry(Scalar()), "to": Entry(Scalar()), **_ALWAYS}, "uniform"),
    ),
    listed=List(Scalar(), distinct=True),  # each as likely
), "the paths of entries")

OUTCOMES = ("mild", "severe")
_LOAD = "Normal load on the pin there."
_VELOCITY = "Sliding velocity there."
_TEST = {
    "load": Entry(LOAD, _LOAD),
    "load_scatter": Optional(Quantity("a load", "10 N"),
        "Standard deviation of the load in repeated tests, which `irg infer` of samples counts "
        "with; none by default."),
    "velocity": Entry(VELOCITY, _VELOCITY),
    "velocity_scatter": Optional(Quantity("a velocity", "0.1 m/s"),
        "Standard deviation of the velocity; by default what `--scatter` gives, 5 % of the "
        "velocity."),
    "friction": Optional(FRICTION,
        "Coefficient of friction measured there; by default the scene's."),
    "friction_scatter": Optional(Number(above=0),
        "Standard deviation of the measured friction; none by default."),
    "bulk_temperature": Optional(BULK,
        "Bulk temperature of both bodies there; by default the scene's."),
    "hold": Optional(DURATION, "Duration at the full load; by default that of `[loading]`."),
    "number": Optional(NAME,
        "Number or name of the test, by which answers call it; by default its place in the file, "
        "or its row in a log."),
    "oil": Optional(NAME,
        "Oil that ran, where those of one rig are compared; by default the scene's."),
}
TRANSITION = Table(_TEST, form="entries")
_RUN = {
    "run": Optional(NAME,
        "Run of the test. Tests of one run are of one specimen, as the stages of a load-stage test "
        "are, and count as one; by default each is a run."),
}
TEST = Table({
    **_TEST, **_RUN,
    "outcome": Entry(OneOf(OUTCOMES), "Outcome of the test, at the end of its hold."),
}, form="entries")
STAGES = Table({
    **_TEST, **_RUN,
    "load": Optional(LOAD, _LOAD),
    "velocity": Optional(VELOCITY, _VELOCITY),
    "mild_up_to": Optional(Scalar(),
        "Highest stage of a run that stayed mild, in place of the outcome: a load beside a "
        "velocity, or a velocity beside a load; alone where the last stage was mild, too.",
        example="400 N"),
    "severe_at": Optional(Scalar(),
        "Stage that turned severe; alone if it was the first.", example="450 N"),
}, form="run by stages")
LOG = Table({
    "file": Entry(Text(),
        "Log as CSV or Excel in place of the entries: a row for each test, and columns such as "
        "`load [N]`; beside the scene. `irg tests LOG` prints these lines."),
    "columns": Optional(ByPath(Text(), "entries of a test"),
        "Heading of the column for an entry, where it is not found by its own words.",
        example={"load": "Kraft / N"}),
    "words": Optional(ByPath(OneOf(OUTCOMES), "words of the log"),
        "What a word of the log means as an outcome.", example={"Fresser": "severe"}),
    "where": Optional(ByPath(Scalar(), "headings of the log"),
        "Rows to take: those with this value below a heading, such as the name of one oil.",
        example={"oil": "FVA 3"}),
    "sheet": Optional(Text(), "Sheet of a workbook; its first one by default."),
    "decimal": Optional(OneOf((".", ",")),
        "Mark of decimals; by default a comma in a file with semicolons or tabs that has any."),
}, form="log")

FORMAT = Table({
    "extends": Optional(Text(),
        "Another scene file whose entries hold where this one gives none; relative to the folder "
        "of this one.", example="other.toml"),
    "without": Optional(List(Text(), distinct=True),
        'Key paths of entries of the other scene to leave out, such as ["wear", "friction.band"].',
        example=["wear", "friction.band"]),
    "title": Optional(Text(), "Title of figures and summaries; by default the name of the file."),
    "materials": Optional(Tables(MATERIAL),
        "A material, under a name of your choice by which `[pin]` and `[disk]` call it. Not needed "
        "for those of the [library](../pipeline/scene/library.toml)."),
    "pin": Entry(PIN,
        "The body that is loaded and that wears: a cylinder across the sliding direction, a ball, "
        "or a roller with a crown."),
    "disk": Entry(DISK, "The body that slides under the pin."),
    "window": Entry(WINDOW,
        "The patch of the contact that is simulated: x along sliding, y along the cylinder's "
        "axis."),
    "loading": Entry(LOADING, "Growth of the load: a ramp, or a recorded load."),
    "motion": Optional(MOTION,
        "Motion of both bodies; without it the pin is at rest. Give one of `slide_roll_ratio` and "
        "`entrainment_velocity`."),
    "wear": Optional(WEAR,
        "Archard's wear of the pin, a law by the distance slid, or [one of your own](OWN_LAWS.md); "
        "no wear without the table."),
    "oil": Optional(OIL,
        "The lubricant, which says only which crossings lie in boundary lubrication. In place of "
        'the table `oil = "NAME"` takes one of the [library](../pipeline/scene/library.toml).'),
    "friction": Entry(FRICTION_TABLE,
        "Friction, by which the temperature rises. It takes effect after the simulation: `irg "
        "boundary --friction` changes it at no cost."),
    "temperature": Entry(TEMPERATURES,
        "Temperatures that decide about wear. They take effect after the simulation, as friction "
        "does."),
    "model": Optional(MODEL,
        "What is known of the model's own error."),
    "fidelity": Optional(FIDELITY,
        "Numerical choices: a preset, and single choices in place of its own; the preset "
        '"standard" without the table.'),
    "sweep": Entry(SWEEP, "The points of the load–velocity plane to compute."),
    "unknown": Optional(UNKNOWN,
        "Inputs that are not known exactly, by the paths of their entries: normal by mean and "
        "standard deviation, log-normal by median and the factor within which two thirds lie, "
        "uniform between two values, or a list of values that are as likely. An entry that "
        "`--set` gives, or a scene that extends this one, is fixed at that value. `correlated` in "
        "a table gives others by their paths, each with its correlation: that of the normal "
        "scores, which are the values of a normal input and the logarithms of a log-normal one. "
        "`varies = true` says that it differs from part to part, so that no test narrows it, as "
        "none does the seed of a surface.",
        example={"temperature.critical": {"mean": "145 degC", "sd": "8 K"}}),
    "measured": Optional(List(Either(TRANSITION, LOG)),
        "Transitions that were measured, each a table `[[measured]]`: drawn in the diagram, and "
        "what `irg infer` goes by.", default=()),
    "tested": Optional(List(Either(TEST, LOG, STAGES)),
        "Tests that stayed mild or turned severe, each a table `[[tested]]`, a run by its stages, "
        "or rows of a log in CSV; what `irg infer` of samples goes by, too.", default=()),
})
SCENE = Entry(FORMAT, "The file itself, above its first table.")
# fmt: on
