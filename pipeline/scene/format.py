"""The format of scene files: each entry with its kind, meaning, default and usual range."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import replace
from typing import Any, get_args, get_type_hints

import tribo
from pipeline.condition_kinds import BULK, CONDITIONS, CRITICAL, FRICTION
from pipeline.kinds import (
    LOAD,
    VELOCITY,
    Flag,
    Integer,
    Kind,
    Level,
    LoadOrVelocity,
    Number,
    OneOf,
    Quantity,
    Scalar,
    Share,
    Text,
    UnitOfLength,
)
from pipeline.limits import MAX_CASES, MAX_ON_AXIS
from pipeline.scene.table_kinds import (
    ByPath,
    Declared,
    Either,
    Entry,
    List,
    MixedList,
    Range,
    Sorted,
    TableKind,
    Tables,
    entries_in,
    entry,
    number_in,
)
from pipeline.sweep.case import OUTCOME_WORDS, OUTCOMES
from pipeline.sweep.stored_steps import Fields, Steps
from tribo.loading.ramp import MOST_STEPS
from tribo.simulation.usual_values import USUAL

HOLD = Quantity("60 s")
SEED = Integer(at_least=0)
LOAD_FACTORS = Sorted(List(Number(above=0), distinct=True, max_length=MAX_ON_AXIS))
STEPS = Integer(at_most=MOST_STEPS)
USUAL_PRESET = "standard"
LATER = "Acts after the simulation."


def one_or_two(kind: Kind) -> Either:
    """Kind of scene entry: two values along x and y, or one value for both."""
    return Either(kind, List(kind, length=2))


# fmt: off
class TableFile(Declared):
    form, mark = "table of rows", "file"
    file: str = entry(Text(),
        "Table as CSV, relative to the folder of the scene. Headings of a record are "
        "`time [s]` and `load [N]`, those of tests their entries.")
    decimal: str | None = entry(OneOf((".", ",")), "Decimal mark of the file.", None)
    ignore: tuple[str, ...] = entry(List(Text(), distinct=True),
        'Headings of columns to skip, such as ["date", "remark"].', ())

class EvenStages(Declared):
    first: float = entry(LOAD, "Load of the first stage.")
    step: float = entry(LOAD, "Difference between one stage and the next.")
    hold: float = entry(HOLD, "Time for which each stage is held.")

STAGES = Either(List(MixedList((LOAD, HOLD))), TableKind(EvenStages))

class Test(Declared):
    form = "entries"
    velocity: float = entry(VELOCITY, "Sliding velocity of the test.")
    load: float | None = entry(LOAD,
        "Normal load; needed without `mild_up_to` and `severe_at`.", None)
    outcome: str | None = entry(OneOf(OUTCOMES, OUTCOME_WORDS),
        'Outcome at the end of the hold, needed with `load`; "transition" if load or velocity was '
        "raised until wear became severe.", None)
    step: Level | None = entry(LoadOrVelocity(Quantity("50 N"), Quantity("0.25 m/s")),
        "Step of velocity or load of a transition: wear was still mild one step before.", None)
    stages: Any = entry(STAGES,
        "Load stages of the specimen, written as in `[loading]`; by default those of `[loading]`, "
        "whose `rate` applies between stages.", None)
    mild_up_to: float | None = entry(LOAD,
        "Load of the highest mild stage, instead of load and outcome.", None)
    severe_at: float | None = entry(LOAD,
        "Load of the severe stage, if there was one; without `mild_up_to`, the first stage was "
        "severe.", None)
    friction: float | None = entry(FRICTION,
        "Measured coefficient of friction; by default the scene's.", None)
    bulk_temperature: float | None = entry(BULK,
        "Bulk temperature of both bodies; by default the scene's.", None)
    with_: dict[str, Any] | None = entry(ByPath(),
        "Other entries of the scene with which the test is simulated, except critical temperature "
        "and area fraction, `[oil]` and `[model]`.", None)
    inputs: str | None = entry(OneOf(("own",)),
        'With "own", the uncertain inputs of this test err independently of the scene\'s, such as '
        "those of another batch or thermometer; it then does not narrow them.", None)
    number: str | int | None = entry(Either(Text(), Integer(at_least=0)),
        "Name of the test in the output; by default the next free number.", None)


class FidelityTable(Declared):
    preset: str = entry(OneOf(tuple(tribo.PRESETS)),
        'Preset, from "standard", the fastest, to "reference", the most accurate.', USUAL_PRESET)
    pixels_per_element: int | None = entry(STEPS,
        "Pixels along each side of an element; a maximum if `fewest_elements` is above 0.", None)
    increments: int | None = entry(STEPS, "Steps of the ramp up to its reference load.", None)
    fewest_elements: int | None = entry(STEPS,
        "Least number of elements in contact: elements are small enough for it, and for the "
        "summits of the surface. With 0, elements have the size given, and their mean height.",
        None)
    contact_tolerance: float | None = entry(Number(),
        "Residual of the contact at which its solver stops.", None)

class MaterialTable(Declared):
    like: str | None = entry(Text(), "Material of the library that supplies missing values.", None)
    elastic_modulus: float = entry(Quantity("210 GPa", usual=USUAL["elastic_modulus"].ends),
        "Young's modulus.")
    poisson_ratio: float = entry(Number(above=-1, at_most=0.5), "Poisson's ratio.")
    hardness: float = entry(Quantity("6.6 GPa", usual=USUAL["hardness"].ends),
        'Hardness, also as "62 HRC", "750 HV" or "250 HB". That of the softer body is the highest '
        "contact pressure; without any, the contact is elastic.", math.inf)
    thermal_conductivity: float = entry(
        Quantity("45 W/(m K)", usual=USUAL["thermal_conductivity"].ends), "Thermal conductivity.")
    density: float = entry(Quantity("7800 kg/m^3", usual=USUAL["density"].ends), "Density.")
    specific_heat: float = entry(Quantity("470 J/(kg K)", usual=USUAL["specific_heat"].ends),
        "Specific heat capacity.")


class Body(Declared):
    material: str = entry(Text(), "Name of the material, in this file or in the library.")
    track_length: float | None = entry(Quantity("314 mm", usual=(20, 1e4)),
        "Length of the track, on a plate or around a rolling pin, that earlier revolutions have "
        f"warmed; without it, the track is cold. {LATER}", None)
    diameter: float | None = entry(Quantity("100 mm", usual=(6, 3000)),
        "Diameter of a disc that is heated around its rim and warms up as a whole, instead of "
        f"`track_length`. {LATER}", None)
    width: float | None = entry(Quantity("20 mm"),
        "Width of the disc; needed with `diameter`.", None)

class ReliefTable(Declared):
    depth: float = entry(Quantity("2 um"), "Drop of the surface at the end of the pin.")
    length: float = entry(Quantity("0.3 mm"), "Part of the pin that is relieved, at each end.")

class _Shape(Declared):
    shape: str = entry(OneOf(tuple(tribo.PINS)), "Shape of the pin.")
    radius: float = entry(Quantity("2 mm", usual=USUAL["radius"].ends),
        "Radius in the plane of sliding; the reduced radius of two curved bodies.")
    length: float | None = entry(Quantity("3.4 mm", usual=USUAL["length"].ends),
        "Length of the line contact, along y; needed for a cylinder.", None)
    crown_radius: float | None = entry(Quantity("100 mm", usual=USUAL["crown_radius"].ends),
        "Radius across sliding; needed for a crowned pin.", None)

class PinTable(Body, _Shape):
    ends: str | None = entry(OneOf(("free",)),
        'With "free", the window is as long as a cylinder, with as many pixels along y as this '
        "needs, and the pin has two ends. Without it, the window repeats along y, without ends.",
        None)
    relief: ReliefTable | None = entry(TableKind(ReliefTable),
        'Relief of both free ends, a parabola; sharp without the table.', None)

class RandomSurface(Declared):
    ra: float = entry(Quantity("0.27 um", usual=USUAL["ra"].ends),
        "Mean deviation of the heights from their mean plane.")
    hurst_exponent: float = entry(Number(above=0, at_most=1),
        "A larger one is smoother at short wavelengths.")
    correlation_length: Any = entry(one_or_two(Quantity("4 um")),
        "Distance over which heights are correlated; for a ground surface two, along x and y. "
        "Needed without `rsm`.", None)
    rsm: Any = entry(one_or_two(Quantity("30 um")),
        "Mean width RSm of the elements of a profile, which a profilometer prints next to Ra, "
        "instead of `correlation_length`; along x and y for a ground surface. The correlation "
        "length that follows depends on the pixels.", None)
    seed: int = entry(SEED, "Seed of the random surface.", 0)

class MeasuredSurfaceTable(Declared):
    mark = "file"
    file: str = entry(Text(),
        "File of heights, relative to the scene's folder, with x from column to column: .npy or "
        "text. Its pixels are those of the window.")
    height_unit: float = entry(UnitOfLength(), "Unit of the heights.")
    level: bool = entry(Flag(),
        "True to remove tilt, and a curvature that is higher than Rq.", False)
    missing: float = entry(Share(at_least=0, below=1),
        "Largest share of missing heights, which are filled smoothly from around.", 0.1)
    mirror: bool = entry(Flag(),
        "True to mirror a scan that is smaller than the window at its edges.", False)

class Disk(Body):
    roughness: Any = entry(Either(TableKind(RandomSurface), TableKind(MeasuredSurfaceTable)),
        "Surface of the disk, random or measured; smooth without the table.", None)

class Window(Declared):
    pixels: tuple[int, int] = entry(List(Integer(at_least=1, at_most=100_000), length=2),
        "Number of pixels along x and y.")
    pixel_size: tuple[float, float] = entry(List(Quantity("0.95 um"), length=2),
        "Sides of a pixel along x and y, also of a measured surface.")

_REFERENCE_LOAD = (
    "Load that is reached in `fidelity.increments` steps; that of a record is by default its peak."
)

class RampTable(Declared):
    rate: float = entry(Quantity("150 N/s"),
        "Rate at which the load grows; also needed for stages.")
    reference_load: float = entry(Quantity("750 N"), _REFERENCE_LOAD)
    hold: float = entry(Quantity("4 s", zero=True),
        "Time for which each load is held after the ramp.", 0.0)

class StagesTable(Declared):
    form, mark = "stages", "stages"
    stages: Any = entry(STAGES,
        "Load stages of one specimen: equal steps up to the highest load of the sweep, or a list "
        'such as `[["100 N", "60 s"], ["250 N", "300 s"]]`. The loads of the sweep are stages. The '
        "window is widened to 1.25 times the worn pin.")
    rate: float = entry(Quantity("150 N/s"), "Rate at which the load grows to each stage.")
    reference_load: float | None = entry(Quantity("750 N"), "Not used with stages.", None)

class Record(TableFile):
    form = "record"
    reference_load: float | None = entry(Quantity("750 N"), _REFERENCE_LOAD, None)

class MotionTable(Declared):
    slide_roll_ratio: float = entry(Share(usual=USUAL["slide_roll_ratio"].ends),
        "Sliding velocity over the mean of both velocities; negative if the pin is faster.")
    pin_track_length: float | None = entry(Quantity("314 mm"),
        "Length of the track around the pin, over which its wear spreads; by default that of "
        "`[pin]`, or 2π times its radius.", None)
    disk_track_length: float | None = entry(Quantity("314 mm"),
        "Length of the track around the disk; by default that of `[disk]`. With either length, "
        "answers state the effect of heat from earlier revolutions, without including it.", None)

class Archard(Declared):
    form = "Archard"
    specific_wear_rate: float = entry(
        Quantity("1.2e-6 mm^3/(N m)", zero=True, usual=USUAL["specific_wear_rate"].ends),
        "Worn volume per load and sliding distance.")
    pattern: str = entry(OneOf(get_args(get_type_hints(tribo.Wear)["pattern"])),
        'Pressure by which the pin wears: "swept", averaged over positions of the moving disk, and '
        'along a periodic y; "local", that of each element.')


class OilTable(Declared):
    kinematic_viscosity: tuple[float, float] = entry(
        List(Quantity("32 mm^2/s", usual=(0.5, 1e5)), length=2),
        "Kinematic viscosity at 40 and at 100 °C.")
    density: float = entry(Quantity("866 kg/m^3", usual=(500, 2000)), "Density.")
    pressure_viscosity_coefficient: float | None = entry(
        Quantity("20 1/GPa", name="a pressure coefficient"),
        "Pressure–viscosity coefficient. Without it, no film thickness is predicted.", None)

class FrictionTable(Declared):
    coefficient: float = entry(FRICTION, "Coefficient of friction.")
    band: tuple[float, float] | None = entry(List(FRICTION, length=2),
        "Lowest and highest coefficient; the diagram draws both boundaries as thin lines.", None)

class Temperature(Declared):
    bulk: float = entry(BULK, "Temperature of both bodies far from the contact.")
    critical: float | None = entry(replace(CRITICAL, from_tests=True),
        "Contact temperature above which the lubricant fails; needed for verdicts. "
        '"from tests": each answer computes it from the tests of the scene.', None)
    critical_area_fraction: float = entry(CONDITIONS["critical_area_fraction"].kind,
        "Wear is severe if a larger fraction of the contact is above the critical temperature; "
        "with 0 the highest temperature governs.", 0.1)
    includes_earlier_revolutions: bool = entry(Flag(),
        "True if `bulk` was measured on the running bodies, so that it contains the heat of their "
        "earlier revolutions.", False)

class Model(Declared):
    bias: float = entry(Share(at_least=0, below=1),
        "Bias common to all specimens: scale of Student's t with 4 degrees of freedom. With "
        "`[uncertainty]`, a bias that is stated is that without the uncertain inputs.",
        default=0.15)
    scatter: float = entry(Share(at_least=1e-3, below=1),
        "Scatter between specimens; the default counts as much as four tests of yours.",
        default=0.055)
    rise: float = entry(CONDITIONS["added_rise_fraction"].kind,
        "Known heating outside the model, such as of a pin holder, a surface film or a "
        'reciprocating contact: "+6 %" multiplies the rise by 1.06.', default=0.0)

class SweepTable(Declared):
    loads: tuple[float, ...] = entry(
        Sorted(List(LOAD, distinct=True, max_length=MAX_ON_AXIS), Range(LOAD)), "Normal loads.")
    velocities: tuple[float, ...] = entry(
        Sorted(List(VELOCITY, distinct=True, max_length=MAX_ON_AXIS), Range(VELOCITY)),
        "Sliding velocities.")
    realizations: int | tuple[int, ...] | None = entry(
        Either(Integer(at_least=1, at_most=MAX_CASES), List(SEED, distinct=True)),
        "Surface realizations, their number or a list: seeds of random surfaces, from `seed` on, "
        "or areas of a scan, from 0 on.", None)
    over: dict[str, Any] | None = entry(ByPath(List(Scalar(), distinct=True)),
        'Entries with several values, such as `{ "pin.radius" = ["1 mm", "2 mm"] }`; each '
        "combination has a sweep.", None)
    along: Any = entry(
        Either(Text(), TableKind(TableFile), List(ByPath(Scalar()), max_length=MAX_ON_AXIS)),
        "Cases, each with its own load and velocity: a table as CSV, or a list such as "
        '`[{ "pin.radius" = "3 mm", load = "400 N", velocity = "2 m/s" }]`. Columns are entries by '
        "their paths, conditions such as `friction`, or words.", None)
    load_factors: tuple[float, ...] | None = entry(
        LOAD_FACTORS,
        "Shares of the load of each row of `along` at which it is simulated, at its own velocity, "
        "such as [0.5, 0.75, 1, 1.25]; 1 must be among them. Answers state the largest at which "
        "the row is mild.", None)
    fields: Fields = entry(Either(Flag(), OneOf(("steps",))),
        "True to store pressure, temperature rise and wear depth over the window at the end of "
        'each point; "steps" to store them at each stored step.', False)
    steps: Steps | None = entry(OneOf(("course", "end")),
        'Steps to store: "course" for all, "end" for those that can govern the verdict; '
        "[the default](DATASET.md#steps) depends on the scene.", None)

class SceneFile(Declared):
    extends: str | None = entry(Text(),
        "Shipped scene, or path of another file, that supplies missing entries.", None)
    without: tuple[str, ...] | None = entry(List(Text(), distinct=True, max_length=1000),
        'Entries of the extended scene to leave out, such as ["wear", "friction.band"].', None)
    title: str | None = entry(Text(),
        "Title of figures; by default the name of the file.", None)
    note: str | None = entry(Text(), "A line that every verdict on this scene repeats.", None)
    materials: dict[str, MaterialTable] | None = entry(Tables(TableKind(MaterialTable)),
        "A material, whose NAME `[pin]` and `[disk]` use. Those of the "
        "[library](../pipeline/scene/library.toml) need no table.", None)
    pin: PinTable = entry(TableKind(PinTable),
        "The loaded body, which wears: a cylinder across sliding, a ball, or a crowned roller.")
    disk: Disk = entry(TableKind(Disk), "The body that slides under the pin.")
    window: Window = entry(TableKind(Window),
        "The simulated part of the contact: x along sliding, y across.")
    loading: RampTable | StagesTable | Record = entry(
        Either(TableKind(RampTable), TableKind(StagesTable), TableKind(Record)),
        "Growth of the load: a ramp, stages of one specimen, or a recorded load.")
    motion: MotionTable | None = entry(TableKind(MotionTable),
        "Motion of both bodies. Without the table the pin is at rest.", None)
    wear: Archard | None = entry(TableKind(Archard),
        "Wear of the pin by Archard's law. Without the table there is no wear.", None)
    oil: OilTable | None = entry(TableKind(OilTable),
        "The lubricant, for the lubrication regime and the load on its film. "
        '`oil = "NAME"` uses an oil of the [library](../pipeline/scene/library.toml).', None)
    friction: FrictionTable = entry(TableKind(FrictionTable),
        f"Friction, to which the temperature rise is proportional. {LATER}")
    temperature: Temperature = entry(TableKind(Temperature),
        "Temperatures that decide whether wear is severe. They act after the simulation.")
    model: Model | None = entry(TableKind(Model),
        "Model error and effects outside the model, as fractions of the temperature rise. They act "
        "after the simulation.", None)
    uncertainty: dict[str, Any] | None = entry(ByPath(Scalar()),
        "Standard deviations of [inputs](YOUR_SYSTEM.md#your-own-system) by their paths, a share "
        "or a quantity, such as "
        '`{ "materials.steel.thermal_conductivity" = "15 %" }`; paths separated by commas have '
        "one deviation in common. They act after the simulation.", None)
    fidelity: FidelityTable | None = entry(TableKind(FidelityTable),
        "Numerical settings: a preset, and entries that replace its own.", None)
    sweep: SweepTable = entry(TableKind(SweepTable),
        "The points of the load–velocity plane to compute.")
    tests: tuple[Any, ...] = entry(List(Either(TableKind(Test), TableKind(TableFile))),
        "Tests of specimens: a table for each, or a file with many.", ())
# fmt: on


Levels = tuple[tuple[float, ...], tuple[float, ...]]
"""Loads of stages [N], and their holds [s]."""


def stages_of(stages: Any, highest: float) -> Levels:
    """Loads and holds of the stages in an entry; even stages end at the `highest` load [N]."""
    if not isinstance(stages, EvenStages):
        return tuple(load for load, _ in stages), tuple(hold for _, hold in stages)
    first, step = stages.first, stages.step
    step_count = max(0.0, (highest - first) / step)
    if step_count > MOST_STEPS:
        raise tribo.InputError(f"{step_count:.3g} load stages exceed the limit of {MOST_STEPS}")
    count = 1 + math.floor(step_count * (1 + 1e-9))  # in spite of rounding
    return tuple(first + k * step for k in range(count)), (stages.hold,) * count


@functools.cache
def scene_entries() -> dict[str, Entry]:
    """Declarations of all entries of a scene, by path; the first of several forms counts."""
    return dict(reversed([*entries_in(TableKind(SceneFile))]))


def number_at(path: str) -> Quantity | Number:
    """Kind of the number that an entry of a scene holds; without one, a `Number` without bounds."""
    entry = scene_entries().get(re.sub(r"^materials\.[^.]+", "materials.NAME", path))
    return (entry and number_in(entry.kind)) or Number()
