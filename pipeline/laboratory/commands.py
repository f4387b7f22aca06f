"""The commands ``irg surface`` and ``irg tests``, and their options."""

from __future__ import annotations

import math

from pipeline.cli import options as o
from pipeline.cli import values
from pipeline.cli.options import Command, Option
from pipeline.paths import user_path


def _sides(text: str) -> tuple[float, float]:
    """Read the sides of a pixel [m] from ``DX,DY``, or from one length for a square pixel."""
    read = values.quantity("0.8 um")
    first, comma, second = text.partition(",")
    return read(first), read(second if comma else first)


def _cutoff(text: str) -> float:
    """Read a cutoff [m]; infinite for "none"."""
    return math.inf if text == "none" else values.quantity("0.8 mm")(text)


_SCAN = (
    Option(
        "scan", metavar="SCAN", type=user_path, nargs="?",
        help="map or profiles of heights: .npy, text, or the file of an instrument",
    ),
    Option(
        "--height-unit", metavar="UNIT",
        help='unit of the heights, such as "um", where the file gives none or a wrong one',
    ),
    Option(
        "--pixel-size", metavar="DX[,DY]", type=_sides,
        help='sides of a pixel, where the file gives none, like "0.8 um" or "0.8 um,0.9 um"',
    ),
    o.flag("--transpose", "exchange x and y of the file"),
    Option(
        "--length-unit", metavar="UNIT",
        help='unit of the places of a profile, such as "mm", where the file gives none',
    ),
    Option(
        "--cutoff", metavar="LENGTH", type=_cutoff,
        help='nesting index of a profile, like "0.8 mm"; default: by ISO 21920-3 from its Ra; none '
        "leaves it unfiltered",
    ),
    o.quantity(
        "--lay", "LENGTH", "40 um",
        "correlation length along the lay of random surfaces, across which a profile was measured; "
        "default: isotropic",
    ),
    o.quantity("--ra", "RA", "0.2 um", "Ra of a data sheet, with --rsm and without a file"),
    o.quantity("--rsm", "RSM", "60 um", "RSm of a data sheet"),
)  # fmt: skip
COMMANDS = (
    Command(
        "surface", "pipeline.laboratory.answer:surface",
        "describe a scan or profiles: roughness, lay, correlation lengths; print a table for "
        "random surfaces like it",
        'scan.npy --height-unit um --pixel-size "0.8 um"', _SCAN,
    ),
)  # fmt: skip
