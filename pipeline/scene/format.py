"""The format of scene files: each entry with its kind, meaning, default and usual range."""

from __future__ import annotations

import functools
import math
import re
from typing import Annotated as A
from typing import Any, ClassVar, get_type_hints

import tribo
from pipeline.limits import MAX_CASES, MAX_ON_AXIS
from pipeline.scene.declared_tables import (
    ByPath,
    Changes,
    Declared,
    Either,
    Entry,
    List,
    MixedList,
    Range,
    Sorted,
    entries_in,
    kind_of,
    number_in,
    table_of,
)
from pipeline.scene.faults import Faults
from pipeline.scene.kinds import (
    ANY_WEAR_RATE,
    BULK,
    CRITICAL,
    DURATION,
    FRICTION,
    HOLD,
    LOAD,
    SIZE,
    VELOCITY,
    Flag,
    Integer,
    Kind,
    Number,
    OneOf,
    OneQuantity,
    Quantity,
    Scalar,
    Share,
    Spread,
    Text,
    UnitText,
)
from pipeline.sweep.case import OUTCOMES
from tribo.simulation.usual_values import USUAL

SEED = Integer(at_least=0)
LATER = "Acts after the simulation."


def one_or_two(kind: Kind) -> Either:
    """Kind of scene entry: two values along x and y, or one value for both."""
    return Either(kind, List(kind, length=2))


# fmt: off
NAME = Either(Text(), Integer(at_least=0))


class TableFile(Declared):
    form_name = "table of rows"
    file: A[str,
        "Table as CSV or Excel, relative to the folder of the scene. Headings of a record are "
        "`time [s]` and `load [N]`, those of tests their entries."]
    decimal: A[str | None, OneOf((".", ",")), "Decimal mark of the file."] = None
    ignore: A[tuple[str, ...], List(Text(), distinct=True),
        'Headings of columns to skip, such as ["date", "remark"].'] = ()

class EvenStages(Declared):
    first: A[float, LOAD, "Load of the first stage."]
    step: A[float, LOAD, "Difference between one stage and the next."]
    hold: A[float, HOLD, "Time for which each stage is held."]

STAGES = Either(List(MixedList((LOAD, HOLD))), table_of(EvenStages))

class Test(Declared):
    form_name = "entries"
    velocity: A[float, VELOCITY, "Sliding velocity of the test."]
    load: A[float | None, LOAD,
        "Normal load; needed without `mild_up_to` and `severe_at`."] = None
    outcome: A[str | None, OneOf(OUTCOMES),
        'Outcome at the end of the hold, needed with `load`; "transition" if load or velocity was '
        "raised until wear became severe."] = None
    step: A[Any, OneQuantity((Quantity("0.25 m/s"), Quantity("50 N"))),
        "Step of velocity or load of a transition: wear was still mild one step before."] = None
    stages: A[Any, STAGES,
        "Load stages of the specimen, written as in `[loading]`; by default those of `[loading]`, "
        "whose `rate` applies between stages."] = None
    mild_up_to: A[float | None, LOAD,
        "Load of the highest mild stage, instead of load and outcome."] = None
    severe_at: A[float | None, LOAD,
        "Load of the severe stage, if there was one; without `mild_up_to`, the first stage was "
        "severe."] = None
    friction: A[float | None, FRICTION,
        "Measured coefficient of friction; by default the scene's."] = None
    bulk_temperature: A[float | None, BULK,
        "Bulk temperature of both bodies; by default the scene's."] = None
    with_: A[dict[str, Any] | None, Changes(),
        "Other entries of the scene with which the test is simulated, except critical temperature "
        "and area fraction, `[oil]` and `[model]`."] = None
    number: A[str | int | None, NAME,
        "Name of the test in the output; by default the next free number."] = None


USUAL_PRESET = "standard"

class _Preset(OneOf):
    def read(self, value: object, path: str, faults: Faults, allowed: object = None) -> Any:
        return super().read(value, path, faults, f"{self}, or irg run --accuracy 5%")

class FidelityTable(Declared):
    preset: A[str, _Preset(tuple(tribo.PRESETS)),
        'Preset, from "standard", the fastest, to "reference", the most accurate.'] = USUAL_PRESET
    pixels_per_element: A[int | None,
        "Pixels along each side of an element; a maximum if `fewest_elements` is above 0."] = None
    increments: A[int | None, "Steps of the ramp up to its reference load."] = None
    fewest_elements: A[int | None,
        "Least number of elements in contact: elements are small enough for it, and for the "
        "summits of the surface. With 0, elements have the size given, and their mean height."
        ] = None
    contact_tolerance: A[float | None, "Residual of the contact at which its solver stops."] = None

class MaterialTable(Declared):
    like: A[str | None,
        "Material of the library that supplies missing values."] = None
    elastic_modulus: A[float, Quantity("210 GPa", usual=USUAL["elastic_modulus"].ends),
        "Young's modulus."]
    poisson_ratio: A[float, Number(above=-1, at_most=0.5), "Poisson's ratio."]
    hardness: A[float, Quantity("6.6 GPa", usual=USUAL["hardness"].ends),
        'Hardness, also as "62 HRC", "750 HV" or "250 HB". That of the softer body is the highest '
        "contact pressure; without any, the contact is elastic."] = math.inf
    thermal_conductivity: A[float, Quantity("45 W/(m K)", usual=USUAL["thermal_conductivity"].ends),
        "Thermal conductivity."]
    density: A[float, Quantity("7800 kg/m^3", usual=USUAL["density"].ends), "Density."]
    specific_heat: A[float, Quantity("470 J/(kg K)", usual=USUAL["specific_heat"].ends),
        "Specific heat capacity."]


class Body(Declared):
    material: A[str, "Name of the material, in this file or in the library."]
    track_length: A[float | None, Quantity("314 mm", usual=(20, 1e4)),
        "Length of the track, on a plate or around a rolling pin, that earlier revolutions have "
        f"warmed; without it, the track is cold. {LATER}"] = None
    diameter: A[float | None, Quantity("100 mm", usual=(6, 3000)),
        "Diameter of a disc that is heated around its rim and warms up as a whole, instead of "
        f"`track_length`. {LATER}"] = None
    width: A[float | None, Quantity("20 mm"), "Width of the disc; needed with `diameter`."] = None

class _Shape(Declared):
    shape: A[str, OneOf(tuple(tribo.PINS)), "Shape of the pin."]
    radius: A[float, Quantity("2 mm", usual=USUAL["radius"].ends),
        "Radius in the plane of sliding; the reduced radius of two curved bodies."]
    length: A[float | None, Quantity("3.4 mm", usual=USUAL["length"].ends),
        "Length of the line contact, along y; needed for a cylinder."] = None
    crown_radius: A[float | None, SIZE, "Radius across sliding; needed for a crowned pin."] = None

class PinTable(Body, _Shape):
    pass

class RandomSurface(Declared):
    ra: A[float, Quantity("0.27 um", usual=USUAL["ra"].ends),
        "Mean deviation of the heights from their mean plane."]
    hurst_exponent: A[float, Number(above=0, at_most=1),
        "A larger one is smoother at short wavelengths."]
    correlation_length: A[Any, one_or_two(Quantity("4 um")),
        "Length beyond which heights are independent; along x and y for a ground surface."]
    seed: A[int, SEED, "Seed of the random surface."] = 0

class MeasuredSurfaceTable(Declared):
    file: A[str,
        "File of heights, relative to the scene's folder, with x from column to column: .npy, "
        "text, or the format of an instrument (extra `surfaces`)."]
    height_unit: A[float | None, UnitText("a unit of length", "um"),
        "Unit of the heights, if the file has none or a wrong one."] = None
    pixel_size: A[tuple[float, float] | None, List(Quantity("0.8 um"), length=2),
        "Pixel sides along x and y, if the file has none or wrong ones."] = None
    level: A[bool,
        "True to remove tilt, and a curvature that is higher than Rq."] = False
    missing: A[float, Share(at_least=0, below=1),
        "Largest share of missing heights, which are filled smoothly from around."] = 0.1
    mirror: A[bool,
        "True to mirror a scan that is smaller than the window at its edges."] = False

class Disk(Body):
    roughness: A[RandomSurface | MeasuredSurfaceTable | None,
        "Surface of the disk, random or measured; smooth without the table."] = None

class Window(Declared):
    pixels: A[tuple[int, int], List(Integer(at_least=1, at_most=100_000), length=2),
        "Number of pixels along x and y."]
    pixel_size: A[tuple[float, float], List(Quantity("0.95 um"), length=2),
        "Sides of a pixel along x and y; those of a measured surface."]

_REFERENCE_LOAD = (
    "Load that is reached in `fidelity.increments` steps; that of a record is by default its peak."
)

class RampTable(Declared):
    rate: A[float, Quantity("150 N/s"),
        "Rate at which the load grows; also needed for stages."]
    reference_load: A[float, Quantity("750 N"), _REFERENCE_LOAD]
    hold: A[float, DURATION,
        "Time for which each load is held after the ramp."] = 0.0

class StagesTable(Declared):
    form_name = "stages"
    refused: ClassVar[dict[str, str]] = {
        "hold": "each of the stages has its own; leave this one out",
        "file": "a recorded load has no stages; give one of the two",
    }
    stages: A[Any, STAGES,
        "Load stages of one specimen: equal steps up to the highest load of the sweep, or a list "
        'such as `[["100 N", "60 s"], ["250 N", "300 s"]]`. The loads of the sweep are stages. The '
        "window is widened to 1.25 times the worn pin."]
    rate: A[float, Quantity("150 N/s"), "Rate at which the load grows to each stage."]
    reference_load: A[float | None, Quantity("750 N"), "Not used with stages."] = None

class Record(TableFile):
    form_name = "record"
    reference_load: A[float | None, Quantity("750 N"), _REFERENCE_LOAD] = None
    fit: A[bool, "True to replace the record by a straight line through it."] = False

class MotionTable(Declared):
    slide_roll_ratio: A[float, Share(usual=USUAL["slide_roll_ratio"].ends),
        "Sliding velocity over the mean of both velocities; negative if the pin is faster."]
    pin_track_length: A[float | None, Quantity("314 mm"),
        "Length of the track around the pin, over which its wear spreads; by default that of "
        "`[pin]`, or 2π times its radius."] = None
    disk_track_length: A[float | None, Quantity("314 mm"),
        "Length of the track around the disk; by default that of `[disk]`. With either length, "
        "answers state the effect of heat from earlier revolutions, without including it."] = None

WEAR_PATTERN = kind_of(get_type_hints(tribo.Wear)["pattern"])

class Archard(Declared):
    form_name = "Archard"
    specific_wear_rate: A[float, ANY_WEAR_RATE, "Worn volume per load and sliding distance."]
    pattern: A[str, WEAR_PATTERN,
        'Pressure by which the pin wears: "swept", averaged over positions of the moving disk, and '
        'along a periodic y; "local", that of each element.']


class OilTable(Declared):
    kinematic_viscosity: A[tuple[float, float],
        List(Quantity("32 mm^2/s", usual=(0.5, 1e5)), length=2),
        "Kinematic viscosity at 40 and at 100 °C."]
    density: A[float, Quantity("866 kg/m^3", usual=(500, 2000)), "Density."]
    pressure_viscosity_coefficient: A[float | None,
        Quantity("20 1/GPa", name="a pressure coefficient"),
        "Pressure–viscosity coefficient. Without it, no film thickness is predicted."] = None

class FrictionTable(Declared):
    coefficient: A[float, FRICTION,
        "Coefficient of friction."]
    band: A[tuple[float, float] | None, List(FRICTION, length=2),
        "Lowest and highest coefficient; the diagram draws both boundaries as thin lines."] = None

class Temperature(Declared):
    bulk: A[float, BULK, "Temperature of both bodies far from the contact."]
    critical: A[float | None, CRITICAL,
        "Contact temperature above which the lubricant fails; needed for verdicts. "
        '"from tests": each answer computes it from the tests of the scene.'] = None
    critical_area_fraction: A[float, Share(at_least=0, below=1),
        "Wear is severe if a larger fraction of the contact is above the critical temperature; "
        "with 0 the highest temperature governs."] = 0.1

class Model(Declared):
    bias: A[float, Spread(at_least=0, below=1),
        "Bias common to all specimens: scale of Student's t with 4 degrees of freedom."] = 0.15
    scatter: A[float, Spread(at_least=1e-3, below=1),
        "Scatter between specimens; this prior weighs as much as four tests."] = 0.055
    rise: A[float, Share(above=-1, usual=(0, 0.5)),
        "Known heating outside the model, such as of a pin holder, a surface film or a "
        'reciprocating contact: "+6 %" multiplies the rise by 1.06.'] = 0.0

class SweepTable(Declared):
    loads: A[tuple[float, ...],
        Sorted(List(LOAD, distinct=True, max_length=MAX_ON_AXIS), Range(LOAD)), "Normal loads."]
    velocities: A[tuple[float, ...],
        Sorted(List(VELOCITY, distinct=True, max_length=MAX_ON_AXIS), Range(VELOCITY)),
        "Sliding velocities."]
    realizations: A[int | tuple[int, ...] | None,
        Either(Integer(at_least=1, at_most=MAX_CASES), List(SEED, distinct=True)),
        "Surface realizations, their number or a list: seeds of random surfaces, from `seed` on, "
        "or areas of a scan, from 0 on."] = None
    over: A[dict[str, Any] | None, ByPath(List(Scalar(), distinct=True), "paths of other entries"),
        'Entries with several values, such as `{ "pin.radius" = ["1 mm", "2 mm"] }`; each '
        "combination has a sweep."] = None
    along: A[Any, Either(
            Text(), table_of(TableFile),
            List(ByPath(Scalar(), "paths of other entries"), max_length=MAX_ON_AXIS)),
        "Cases, each with its own load and velocity: a table as CSV or Excel, or a list such as "
        '`[{ "pin.radius" = "3 mm", load = "400 N", velocity = "2 m/s" }]`. Columns are entries by '
        "their paths, conditions such as `friction`, or words."] = None
    fields: A[bool | str, Either(Flag(), OneOf(("steps",))),
        "True to store pressure, temperature rise and wear depth over the window at the end of "
        'each point; "steps" to store them at each stored step.'] = False
    steps: A[str | None, OneOf(("course", "end")),
        'Steps to store: "course" for all, "end" for those that can govern the verdict; '
        "[the default](DATASET.md#steps) depends on the scene."] = None

class SceneFile(Declared):
    extends: A[str | None,
        "Shipped scene, or path of another file, that supplies missing entries."] = None
    without: A[tuple[str, ...] | None, List(Text(), distinct=True, max_length=1000),
        'Paths of entries that it does not supply, such as ["wear", "friction.band"].'] = None
    title: A[str | None, "Title of figures; by default the name of the file."] = None
    note: A[str | None,
        "A line that every verdict on this scene repeats."] = None
    materials: A[dict[str, MaterialTable] | None,
        "A material, whose NAME `[pin]` and `[disk]` use. Those of the "
        "[library](../pipeline/scene/library.toml) need no table."] = None
    pin: A[Any, table_of(PinTable),
        "The loaded body, which wears: a cylinder across sliding, a ball, or a crowned roller."]
    disk: A[Disk, "The body that slides under the pin."]
    window: A[Window, "The simulated part of the contact: x along sliding, y across."]
    loading: A[RampTable | StagesTable | Record,
        "Growth of the load: a ramp, stages of one specimen, or a recorded load."]
    motion: A[MotionTable | None,
        "Motion of both bodies. Without the table the pin is at rest."] = None
    wear: A[Any, table_of(Archard),
        "Wear of the pin by Archard's law. Without the table there is no wear."] = None
    oil: A[OilTable | None,
        "The lubricant, for the lubrication regime and the load on its film. "
        '`oil = "NAME"` uses an oil of the [library](../pipeline/scene/library.toml).'] = None
    friction: A[FrictionTable,
        f"Friction, to which the temperature rise is proportional. {LATER}"]
    temperature: A[Temperature,
        "Temperatures that decide whether wear is severe. They act after the simulation."]
    model: A[Model | None,
        "Model error and effects outside the model, as fractions of the temperature rise. They act "
        "after the simulation."] = None
    fidelity: A[Any, table_of(FidelityTable),
        "Numerical settings: a preset, and entries that replace its own."] = None
    sweep: A[Any, table_of(SweepTable), "The points of the load–velocity plane to compute."]
    tests: A[tuple[Any, ...], List(Either(table_of(Test), table_of(TableFile))),
        "Tests of specimens: a table for each, or a file with many."] = ()
# fmt: on


@functools.cache
def scene_entries() -> dict[str, Entry]:
    """Declarations of all entries of a scene, by path; the first of several forms counts."""
    return dict(reversed([*entries_in(table_of(SceneFile))]))


def number_at(path: str) -> Quantity | Number:
    """Kind of the number that an entry of a scene holds; without one, a `Number` without bounds."""
    entry = scene_entries().get(re.sub(r"^materials\.[^.]+", "materials.NAME", path))
    return (entry and number_in(entry.kind)) or Number()
