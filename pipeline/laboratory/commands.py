"""The commands ``irg surface`` and ``irg tests``, and their options."""

from __future__ import annotations

import math
from argparse import ArgumentTypeError

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


def _word_meaning(text: str) -> tuple[str, str]:
    """Read ``WORD=OUTCOME``: what a word in a log means; an empty word stands for empty cells."""
    name, _, outcome = map(str.strip, text.partition("="))
    if outcome not in ("mild", "severe"):
        raise ArgumentTypeError(f'"{outcome}" is no outcome; give {name}=mild or {name}=severe')
    return name, outcome


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
_TESTS = (
    Option(
        "log", metavar="LOG", type=user_path,
        help="log of tests, or a trace of friction over time: .csv, .txt or .xlsx",
    ),
    Option(
        "--word", metavar="WORD=OUTCOME", type=_word_meaning, action="append", default=[],
        help='what a word of the log means, like Fresser=severe, or an empty cell, "=mild"; may be '
        "repeated",
    ),
    Option(
        "--form", metavar="NAME",
        help="export of a machine, where it was not recognised: compend, mtm, rtec, srv, "
        "t11, trb3 or umt",
    ),
    *o.OF_TABLE_FILE,
    Option("--outcome", choices=("mild",), help="print the lines of a trace that stayed mild"),
    Option(
        "--scuffed-at", metavar="TIME", type=values.quantity("812 s"),
        help='print the lines of a trace that scuffed at this time after its first row, as "812 s"',
    ),
    o.output("FILE.png", "figure of a trace: its stages, and the rises of friction"),
)  # fmt: skip

COMMANDS = (
    Command(
        "surface", "pipeline.laboratory.answer:surface",
        "describe a scan or profiles: roughness, lay, correlation lengths; print a table for "
        "random surfaces like it",
        'scan.npy --height-unit um --pixel-size "0.8 um"', _SCAN,
    ),
    Command(
        "tests", "pipeline.laboratory.answer:tests",
        "print what is understood of a laboratory's log, and the lines of a scene for it",
        "log.csv --word Fresser=severe", _TESTS,
    ),
)  # fmt: skip
