"""Meaning of each entry of a scene file, in a sentence: for the reference and the template.

The entries of ``[fidelity]`` are described where they are defined, in `tribo.Fidelity`.
"""

from __future__ import annotations

import inspect
import re

import tribo

TABLES = {
    "": "The file itself, above its first table.",
    "materials.NAME": "A material, under a name of your choice by which `[pin]` and `[disk]` call "
    "it. Not needed for those of the [library](../pipeline/scene/library.toml).",
    "pin": "The body that is loaded and that wears: a cylinder across the sliding direction, a "
    "ball, or a roller with a crown.",
    "pin.stem": "Rod between the heated end of the pin and a holder at the bulk temperature, or "
    "its thermal resistance; a half-space without the table. It takes effect after the simulation.",
    "disk": "The body that slides under the pin.",
    "disk.roughness": "Its surface: random, or measured; smooth without the table.",
    "disk.film": "An oxide or tribofilm on the disk, a thermal resistance; none without the table. "
    "It takes effect after the simulation.",
    "disk.surface": "A surface of one's own in place of a roughness, see "
    "[`OWN_LAWS.md`](OWN_LAWS.md).",
    "window": "The patch of the contact that is simulated: x along sliding, y along the cylinder's "
    "axis.",
    "loading": "Growth of the load: a ramp, or a recorded load.",
    "motion": "Motion of both bodies; without it the pin is at rest. Give one of "
    "`slide_roll_ratio` and `entrainment_velocity`.",
    "wear": "Archard's wear of the pin, or [a law of one's own](OWN_LAWS.md); no wear "
    "without the table.",
    "oil": "The lubricant, which says only which crossings lie in boundary lubrication. In place "
    'of the table `oil = "NAME"` takes one of the [library](../pipeline/scene/library.toml).',
    "friction": "Friction, by which the temperature rises. It takes effect after the simulation: "
    "`irg boundary --friction` changes it at no cost.",
    "friction.by_velocity": "Friction at sliding velocities, smooth in between and constant beyond "
    "them; another coefficient scales it. It takes effect after the simulation.",
    "temperature": "Temperatures that decide about wear. They take effect after the simulation, as "
    "friction does.",
    "fidelity": "Numerical choices: a preset, and single choices in place of its own; the preset "
    '"standard" without the table.',
    "sweep": "The points of the load–velocity plane to compute.",
    "sweep.wear_rates": "Specific wear rates for which the diagram answers, too, with the scene's "
    "own between them: `irg boundary --wear-rate`. Velocities are added so far beyond the scene's "
    "that each rate has those of the scene.",
    "measured": "Transitions that were measured, each a table `[[measured]]`: drawn in the "
    "diagram, and what `irg infer` goes by.",
    "tested": "Tests that stayed mild or turned severe, each a table `[[tested]]`, or rows of a "
    "log in CSV; what `irg infer` of samples goes by, too.",
}
"""Sentence on each table, by its path."""

VARIANTS = {
    "pin": ("cylinder", "ball or crowned pin"),
    "pin.stem": ("rod", "resistance"),
    "disk.roughness": ("random surface", "measured surface"),
    "loading": ("ramp", "record"),
    "measured": ("entries", "log"),
    "tested": ("entries", "log"),
    "wear": ("Archard's wear", "own law"),
}
"""Forms of a table that has two, with keys of their own, the usual one first."""

_ENTRIES = {
    "extends": "Another scene file whose entries hold where this one gives none; relative to the "
    "folder of this one.",
    "unknown": "Inputs that are not known exactly, by the paths of their entries: normal by mean "
    "and standard deviation, log-normal by median and the factor within which two thirds lie, "
    "uniform between two values, or a list of values that are as likely. `correlated` in a "
    "table gives others by their paths, each with its correlation: that of the normal scores, "
    "which are the values of a normal input and the logarithms of a log-normal one.",
    "without": "Key paths of entries of the other scene to leave out, such as "
    '["wear", "friction.band"].',
    "title": "Title of figures and summaries; by default the name of the file.",
    "materials.NAME.like": "A material of the library, which gives what is not given here.",
    "materials.NAME.elastic_modulus": "Young's modulus.",
    "materials.NAME.poisson_ratio": "Poisson's ratio.",
    "materials.NAME.hardness": "Highest pressure that it bears, or a hardness such as "
    '"62 HRC", "750 HV" or "250 HB"; the softer body\'s counts, and a body without one stays '
    "elastic.",
    "materials.NAME.thermal_conductivity": "Thermal conductivity.",
    "materials.NAME.density": "Density.",
    "materials.NAME.specific_heat": "Specific heat capacity.",
    "pin.shape": "Shape of the pin.",
    "pin.radius": "Radius in the plane of sliding; of two curved bodies the reduced one.",
    "pin.crown_radius": "Radius across sliding of a crowned pin, which it needs.",
    "pin.length": "Length of the cylinder's line contact, along y.",
    "pin.material": "Name of its material, here or in the library.",
    "pin.stem.length": "Length of the rod, of the pin's material.",
    "pin.stem.area": "Its cross section.",
    "pin.stem.resistance": "Thermal resistance to the holder.",
    "disk.track_length": "Length of the track under the pin, which earlier passes have warmed; "
    "without it each pass meets a cold disk. It takes effect after the simulation.",
    "disk.film.thickness": "Thickness of the film.",
    "disk.film.thermal_conductivity": "Its thermal conductivity.",
    "disk.material": "Name of its material, here or in the library.",
    "disk.surface.law": 'Module and name of the surface, such as "laws:dimples".',
    "disk.surface.parameters": "Names and values that it is made with, in SI units.",
    "disk.roughness.ra": "Mean deviation of the heights from their mean plane, Ra.",
    "disk.roughness.hurst_exponent": "Hurst exponent; the nearer to 1, the smoother at short "
    "wavelengths.",
    "disk.roughness.correlation_length": "Length beyond which heights no longer depend on each "
    "other; two for one along x and one along y, as on ground surfaces.",
    "disk.roughness.seed": "Seed of the random surface; the same gives the same surface.",
    "disk.roughness.file": "Heights of a measured surface, a row for each x: .npy, .csv, or the "
    "file of an instrument (with the extra `surfaces`); relative to the folder of the scene.",
    "disk.roughness.height_unit": "Unit of the heights; needed where the file has none, as in .npy "
    "and .csv, and used in place of a wrong one.",
    "disk.roughness.transpose": "Exchange of x and y of the file, with the sides of its pixels.",
    "disk.roughness.flip": "Axis to reverse; or the heights, as of a replica, whose summits were "
    "valleys.",
    "disk.roughness.crop": "First row and column, counted from 0, of the patch to cut out; without "
    "it the surface is to have the window's size.",
    "disk.roughness.level": "Least-squares plane (tilt) taken off the heights, or not.",
    "disk.roughness.missing": "Places without a height: the file is refused, or the hole filled "
    "smoothly from around it.",
    "disk.roughness.repeat": "Filling of a window that is larger than the surface: none, mirrored "
    "at each end, or tiles.",
    "window.pixels": "Number of pixels along x and y.",
    "window.pixel_size": "Sides of a pixel along x and y; those of the measured surface.",
    "window.periodic_y": "Patch repeated along y, or not; by default for a cylinder alone.",
    "loading.rate": "Rate at which the load grows from 0.",
    "loading.reference_load": "Load that the ramp reaches in `fidelity.increments` steps; of a "
    "record, by default its peak.",
    "loading.hold": "Time for which each load is held once it is reached.",
    "loading.hold_steps": "Number of steps of the hold; by default as few as are no longer than "
    "those of the ramp.",
    "loading.file": "Record of the load, .csv with the columns `time [s]` and `load [N]`; relative "
    "to the folder of the scene.",
    "loading.fit": "A straight line through the record in its place, or not.",
    "motion.slide_roll_ratio": "Sliding velocity divided by the mean velocity of both surfaces; "
    "negative where the pin is the faster body.",
    "motion.entrainment_velocity": "Mean velocity of both surfaces, the same at every sliding "
    "velocity.",
    "motion.track_length": "Length of the pin's track, over which its wear spreads; by default its "
    "circumference.",
    "wear.specific_wear_rate": "Worn volume per load and sliding distance.",
    "wear.pattern": 'Wear of the pin: "swept" by the mean pressure along y, or over positions of '
    'the disk where y is free, since the roughness moves past it; "local" each element by its own '
    "pressure.",
    "wear.law": 'Module and name of the law, such as "laws:RunningIn".',
    "wear.parameters": "Names and values that it is made with, in SI units.",
    "oil.like": "An oil of the library, which gives what is not given here.",
    "oil.temperatures": "Two temperatures at which its viscosity is known.",
    "oil.kinematic_viscosity": "Kinematic viscosity at both; this or the dynamic one.",
    "oil.dynamic_viscosity": "Dynamic viscosity at both.",
    "oil.density": "Density; needed with a kinematic viscosity.",
    "oil.pressure_viscosity_coefficient": "Pressure–viscosity coefficient, one, or one at each of "
    "both temperatures; without it no film is foretold.",
    "friction.coefficient": "Coefficient of friction.",
    "friction.by_velocity.velocity": "Sliding velocity.",
    "friction.by_velocity.coefficient": "Coefficient of friction there.",
    "friction.band": "Lowest and highest coefficient, drawn as a band in the diagram.",
    "temperature.bulk": "Temperature far from the contact: of both bodies, or of `pin` and `disk`.",
    "temperature.critical": "Contact temperature above which the lubricant fails; needed where "
    "wear is judged.",
    "temperature.failing_share": "Share of the contact area above the critical temperature beyond "
    "which wear is severe; 0 for the highest temperature alone.",
    "temperature.criterion": "Temperature that decides: the one that the failing share of the "
    "contact area exceeds, the highest, or the mean of the contact; or a "
    '[criterion of one\'s own](OWN_LAWS.md), such as "laws:hottest_tenth".',
    "fidelity.preset": 'Preset to begin with: "draft" is the fastest, "reference" the best.',
    "sweep.loads": "Normal loads.",
    "sweep.velocities": "Sliding velocities.",
    "sweep.realizations": "Random surfaces to compute it all on: a number of them from the seed "
    "on, or a list of seeds.",
    "sweep.samples": "Number of samples drawn of the `unknown` inputs, each at a velocity of its "
    "own.",
    "sweep.sample_seed": "Seed of the samples.",
    "sweep.wear_rates.from": "Lowest of them.",
    "sweep.wear_rates.to": "Highest of them.",
    "sweep.fields": "Pressure, temperature rise and wear depth over the window stored, or not.",
    "sweep.independent": "Each point simulated from the start, not on from the next lower load; "
    "takes longer.",
    **{
        f"{table}.{key}": text
        for table in ("measured", "tested")
        for key, text in {
            "load": "Normal load on the pin there.",
            "load_scatter": "Standard deviation of the load in repeated tests, which `irg infer` "
            "of samples counts with; none by default.",
            "velocity": "Sliding velocity there.",
            "velocity_scatter": "Standard deviation of the velocity; by default what `--scatter` "
            "gives, 5 % of the velocity.",
            "friction": "Coefficient of friction measured there; by default the scene's.",
            "friction_scatter": "Standard deviation of the measured friction; none by default.",
            "bulk_temperature": "Bulk temperature of both bodies there; by default the scene's.",
            "hold": "Duration at the full load; by default that of `[loading]`.",
            "file": "Log in CSV in place of the entries: a row for each test, and columns by the "
            "names of the entries, such as `load [N]`; beside the scene.",
        }.items()
    },
    "tested.outcome": "Outcome of the test, at the end of its hold.",
}


def _of_fidelity() -> dict[str, str]:
    """First sentence on each parameter in the docstring of `tribo.Fidelity`."""
    text = inspect.cleandoc(tribo.Fidelity.__doc__ or "")
    section = text.partition("Parameters\n----------\n")[2].partition("\n\nRaises")[0]
    sentences = {}
    for name, about in re.findall(r"^(\w+) : .*\n((?:    .*\n?)+)", section, flags=re.MULTILINE):
        sentence = re.split(r"(?<=[.\w])[.;] ", " ".join(about.split()))[0].rstrip(".") + "."
        sentences[f"fidelity.{name}"] = sentence.replace('``"', '"').replace('"``', '"')
    return sentences


MEANINGS = _ENTRIES | _of_fidelity()
"""Sentence on each entry, by its path; NAME stands for a name of the user's choice."""
