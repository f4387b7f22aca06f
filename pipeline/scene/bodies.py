"""The format of bodies in a scene: materials, pin and disk, and quantities of all its tables."""

from __future__ import annotations

import math

import tribo
from pipeline.scene.kinds import Flag, Number, OneOf, Quantity, Scalar, Text, UnitText, Whole
from pipeline.scene.schema import ByPath, Either, Entry, List, Optional, Table
from tribo.simulation.pins import sizes_of


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
CONDUCTIVITY = Quantity("a conductivity", "45 W/(m K)")
FRICTION = Number(at_least=0)
SEED = Whole(at_least=0)

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
            f"Length of the track {track}, which earlier turns have warmed; without it each turn "
            "meets a cold track. It takes effect after the simulation."),
        "diameter": Optional(length("100 mm"),
            f"Diameter of the track around the {body}, whose circumference is the length of the "
            "track; in place of `track_length`."),
        "width": Optional(length("20 mm"),
            f"Width of the {body} across the track, which is in its middle: heat of earlier turns "
            "does not leave by its sides. By default it is much wider than the contact."),
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
        "Heights of a measured surface, a row for each x: .npy, text, or the file of an instrument "
        "(with the extra `surfaces`); relative to the folder of the scene.",
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
        "First row and column, counted from 0, of the patch to cut out; without it the surface is "
        "to have the window's size."),
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
        "law": Entry(Text(), f"{meaning} It is code, which runs only with `--own-laws`."),
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
# fmt: on
