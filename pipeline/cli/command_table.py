"""The commands of ``irg``: the purpose of each, an example, and its options."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from pipeline.cli import values
from pipeline.paths import FIGURES, TABLES, user_path


class Option(NamedTuple):
    """An argument of a command: its names, and its settings for argparse."""

    names: list[str]
    settings: dict[str, Any]


class Group(NamedTuple):
    """Options under a title of their own; without a title, only one of them may be used."""

    title: str
    options: Sequence[Option]


class Command(NamedTuple):
    """A command: the function that answers it, its purpose, the arguments of an example."""

    name: str
    function: str
    purpose: str
    example: str
    options: Sequence[Option | Group]


class _StoreEntry(argparse.Action):
    """Action of an option KEY=VALUE that may be repeated: collect the values by key."""

    def __call__(self, parser: Any, namespace: Any, entry: Any, name: str | None = None) -> None:
        key, value = entry
        entries = getattr(namespace, self.dest)
        if key in entries:
            parser.error(f"{key} is given twice; give it once")
        setattr(namespace, self.dest, {**entries, key: value})


Convert = Callable[[str], Any] | None
"""Function that reads the value of an option from text; None for text as it is."""


def with_value(syntax: str, help_text: str, convert: Convert = None, **settings: Any) -> Option:
    """Option with a value; `syntax` has its names and then the name of the value."""
    *names, metavar = syntax.split()
    return Option(names, {"metavar": metavar, "type": convert, "help": help_text, **settings})


def flag(names: str, help_text: str) -> Option:
    """Option without a value."""
    return Option(names.split(), {"action": "store_true", "help": help_text})


def _repeated(syntax: str, help_text: str, convert: Convert = str) -> Option:
    """Option that may be repeated, with its values in a list."""
    help_text = f"{help_text}; can be repeated"
    return with_value(syntax, help_text, convert, action="append", default=[])


def _entries(syntax: str, help_text: str, convert: Convert) -> Option:
    """Option KEY=VALUE that may be repeated, with its values in a dictionary."""
    help_text = f"{help_text}; can be repeated"
    return with_value(syntax, help_text, convert, action=_StoreEntry, default={})


def _quantity(syntax: str, help_text: str, like: str, **settings: Any) -> Option:
    """Option for a quantity above 0 with a unit."""
    convert = partial(values.quantity, like=like)
    return with_value(syntax, f'{help_text}, like "{like}"', convert, **settings)


def _load_and_velocity(**settings: Any) -> list[Option]:
    return [
        _quantity("--load F", "normal load on the whole pin", "750 N", **settings),
        _quantity("--velocity V", "sliding velocity", "1.25 m/s", **settings),
    ]


_SCENE = (
    with_value("scene SCENE.toml", "scene file, or name of a shipped scene", user_path),
    with_value(
        "--preset NAME",
        "numerical preset, replacing the table [fidelity] of the scene: standard, fine or "
        "reference",
    ),
    _entries(
        "--set KEY=VALUE",
        "change a numerical setting, such as increments=50, or a scene entry, such as "
        "wear.pattern=local or without=motion",
        values.setting,
    ),
)
_WORKERS = with_value(
    "-j --workers N", "number of processes; default: one for each core", values.count
)
_STORE = with_value("store OUT.zarr", "results store, or name of its scene", values.stored)
_TABLE = with_value(
    "-o --output TABLE.csv",
    "file of the table, .csv, .md or .json",
    partial(values.writable, suffixes=TABLES),
)
_POINTS = (
    with_value(
        "--points POINTS.csv",
        'operating points, a row each, in columns such as "load [N]" and "velocity [m/s]", as '
        ".csv, .txt or .xlsx; columns of words are passed on as labels",
        user_path,
    ),
    Option(["--decimal"], {"choices": (".", ","), "help": "decimal mark of --points"}),
    _repeated("--ignore HEADING", "column of --points to leave out"),
)
_REALIZATION = with_value(
    "--realization SEED",
    "seed of the random surface, or area of the scan, instead of the scene's",
    partial(values.count, minimum=0),
)
_BULK_TEMPERATURE = _repeated(
    "--bulk-temperature T", 'temperature of the bodies far from the contact, like "25 degC"'
)
_CONDITIONS = Group(
    "conditions that replace those of the scene",
    (
        _repeated("--friction MU", "coefficient of friction, at least 0", values.number),
        _BULK_TEMPERATURE,
        _repeated(
            "--critical-temperature T",
            'temperature above which the lubricant fails, like "145 degC"',
        ),
        _repeated(
            "--critical-area-fraction F",
            "critical area fraction: wear is severe if more of the contact is above the critical "
            "temperature, such as 10%%; 0 for the highest temperature",
        ),
    ),
)
_WITHOUT_TESTS = flag("--without-tests", "ignore the tests of the scene")
_EVALUATED_AT = (
    _entries(
        "--at KEY=VALUE",
        'evaluate at a value of a varied entry (sweep.over), such as "pin.radius=2 mm", or of a '
        'condition, such as "temperature.critical=150 degC" or "model.rise=+6 %%"',
        partial(values.pair, like='"pin.radius=2 mm"'),
    ),
    _CONDITIONS,
    _WITHOUT_TESTS,
)
_ALL_ROWS = flag("--all", "print all rows and notes")

COMMANDS = (
    Command(
        "new", "pipeline.cli.begin:new", "write a scene to start from",
        "scene.toml --from twin_disc",
        [
            Group("", [
                with_value("file FILE.toml", "file to write", user_path, nargs="?"),
                flag("--list", "list the shipped scenes"),
            ]),
            with_value("--from NAME", "shipped scene to begin with; see --list", dest="template"),
        ],
    ),
    Command(
        "run", "pipeline.cli.sweep_commands:run", "run or resume the sweep of a scene",
        "scene.toml --accuracy 2%",
        [
            *_SCENE,
            with_value(
                "-o --output OUT.zarr", "path of the store; default: results/<scene>.zarr",
                values.store,
            ),
            Group("", [
                _WORKERS,
                with_value("--scheduler ADDRESS", "address of a running Dask scheduler"),
                with_value(
                    "--scheduler-file FILE", "file written by a running Dask scheduler", user_path
                ),
            ]),
            with_value(
                "--from OLD.zarr", "copy matching points from another store", values.store,
                dest="source",
            ),
            flag(
                "--dashboard",
                "print the address of Dask's dashboard, which every user of this machine can open",
            ),
            flag("--retry-failed", "simulate the points that failed in an earlier run again"),
            flag("-n --dry-run", "print what irg check prints, and compute nothing"),
            with_value(
                "--accuracy BOUND",
                "compute until the numerical error of the boundary is below this, such as 2%%; the "
                "run chooses preset, points and surface realizations",
                values.share,
            ),
        ],
    ),
    Command(
        "check", "pipeline.cli.check:check", "describe a scene and estimate the cost of its sweep",
        "scene.toml", [*_SCENE, _WORKERS, _TABLE],
    ),
    Command(
        "point", "pipeline.cli.point_commands:point",
        "simulate one point (and the tests of the scene)",
        'scene.toml --load "500 N" --velocity "2 m/s"',
        [
            *_SCENE, *_load_and_velocity(required=True), _WITHOUT_TESTS, _REALIZATION, _CONDITIONS,
            _TABLE,
        ],
    ),
    Command(
        "trade", "pipeline.cli.sweep_commands:trade", "measure computing time against accuracy",
        "scene.toml -o trade.png",
        [
            *_SCENE,
            with_value(
                "--store OUT.zarr",
                "new store for the points; default: results/<scene>-trade.zarr", values.store,
                dest="store_path",
            ),
            _WORKERS,
            with_value(
                "-o --output FILE.png", "file of a figure; or of the table, .csv, .md or .json",
                partial(values.writable, suffixes=(*FIGURES, *TABLES)),
            ),
        ],
    ),
    Command(
        "infer", "pipeline.cli.point_commands:infer",
        "find the critical temperature from tests, or the wear rate from a contact width",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"',
        [
            *_SCENE,
            _quantity(
                "--contact-width W",
                "contact width measured at --load and --velocity; prints the specific wear rate "
                "instead", "348 um",
            ),
            _quantity(
                "--duration T",
                "sliding time before the width was measured, ramp included; default: from the "
                "scene", "8 s",
            ),
            _BULK_TEMPERATURE, _TABLE, *_load_and_velocity(), _REALIZATION,
        ],
    ),
    Command(
        "surface", "pipeline.cli.begin:surface",
        "describe a scan by ISO 25178-2, compare it with a random surface, and print its tables",
        'scan.npy --height-unit um --pixel-size "0.8 um" -o surface.png',
        [
            with_value(
                "scan SCAN", "map of heights: .npy, a matrix in text, or the file of an instrument",
                user_path, nargs="?",
            ),
            with_value(
                "--height-unit UNIT",
                'unit of the heights, such as "um", if the file states none or a wrong one',
            ),
            with_value(
                "--pixel-size DX[,DY]",
                'sides of a pixel, if the file states none, like "0.8 um" or "0.8 um,0.9 um"',
                values.sides,
            ),
            with_value(
                "--missing SHARE",
                "largest fraction of missing heights that is filled; default: 10%%", values.share,
                default=0.1,
            ),
            _quantity(
                "--ra RA", "Ra of a profile or data sheet, with --rsm, without a file", "0.2 um"
            ),
            _quantity("--rsm RSM", "RSm of a profile or data sheet", "60 um"),
            with_value(
                "-o --output FILE.png", "figure of the scan and of the random surface",
                partial(values.writable, suffixes=FIGURES),
            ),
        ],
    ),
    Command(
        "status", "pipeline.cli.store_commands:status",
        "count done, failed and pending points of a store", "results/scene.zarr", [_STORE],
    ),
    Command(
        "verify", "pipeline.cli.store_commands:verify",
        "read a whole store and list damaged points", "results/scene.zarr", [_STORE],
    ),
    Command(
        "boundary", "pipeline.cli.store_commands:boundary",
        "print the boundary between mild and severe wear, without a new simulation",
        "results/scene.zarr --friction 0.09 --friction 0.103",
        [
            _STORE,
            Option(["--by"], {
                "default": "load", "choices": ("load", "velocity", "test"),
                "help": "rows of the table: critical velocity at each load, critical load at each "
                "velocity, or tests compared with the computation; default: load",
            }),
            _ALL_ROWS, _TABLE, *_EVALUATED_AT,
        ],
    ),
    Command(
        "margin", "pipeline.cli.store_commands:margin",
        "print verdict, probability and errors for one operating point, a table of them, or the "
        "cases of the sweep",
        'results/scene.zarr --load "500 N" --velocity "2 m/s"',
        [_STORE, *_load_and_velocity(), *_POINTS, _ALL_ROWS, _TABLE, *_EVALUATED_AT],
    ),
    Command(
        "plot", "pipeline.cli.store_commands:plot", "draw a figure of a store",
        'results/scene.zarr --kind ramp --load "600 N" --velocity "1.6 m/s"',
        [
            _STORE,
            Option(["--kind"], {
                "choices": ("diagram", "rows", "ramp", "fields", "tests"),
                "help": "default: diagram, or rows if each has its own load and velocity",
            }),
            with_value(
                "-o --output FILE.png", "figure file; default: next to the store", user_path
            ),
            _quantity(
                "--width W", "width of the figure; text shrinks less than the figure does", "8.5 cm"
            ),
            with_value("--title TITLE", "title of the figure; default: that of the scene"),
            flag("--plain", "omit title and caption"),
            with_value("--dpi DPI", "resolution in dots per inch; default: 150", values.count),
            flag("--log", "draw the diagram on logarithmic axes"),
            with_value(
                "--step N", "step of fields, counted back from the end of a point: 0, -1, ...", int
            ),
            *_EVALUATED_AT, *_load_and_velocity(action="append", default=[]), _REALIZATION,
        ],
    ),
    Command(
        "report", "pipeline.cli.store_commands:report",
        "write a report to print and pass on: verdict, diagram, boundary, tests, errors, limits",
        'results/scene.zarr --load "500 N" --velocity "2 m/s" -o report.html',
        [
            _STORE, *_load_and_velocity(), *_POINTS,
            with_value(
                "-o --output FILE.html", "file of the report; default: next to the store", user_path
            ),
            with_value("--title TITLE", "title of the report; default: that of the scene"),
            with_value("--author NAME", "name of the author"),
            *_EVALUATED_AT,
        ],
    ),
    Command(
        "help", "pipeline.cli.begin:help_", "print a page of the documentation, or list all pages",
        "first-hour",
        [with_value("topic TOPIC", "name of a page or of a command", nargs="?")],
    ),
)  # fmt: skip
"""All commands, in the order in which the help lists them."""
