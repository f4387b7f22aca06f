"""The commands of ``irg``: the purpose of each, an example, and its options."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
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


def value(syntax: str, convert: Any, help_text: str, **settings: Any) -> Option:
    """Option with a value; `syntax` has its names and then the name of the value.

    `convert` reads the value from text; None leaves it text.
    """
    *names, metavar = syntax.split()
    return Option(names, {"metavar": metavar, "type": convert, "help": help_text, **settings})


def flag(names: str, help_text: str) -> Option:
    """Option without a value."""
    return Option(names.split(), {"action": "store_true", "help": help_text})


def _choice(name: str, choices: Sequence[str], help_text: str, **settings: Any) -> Option:
    """Option whose value is one of a few words."""
    return Option([name], {"choices": choices, "help": help_text, **settings})


def _repeated(syntax: str, convert: Any, help_text: str) -> Option:
    """Option that may be repeated, with its values in a list."""
    return value(syntax, convert, f"{help_text}; can be repeated", action="append", default=[])


def _entries(syntax: str, convert: Any, help_text: str) -> Option:
    """Option KEY=VALUE that may be repeated, with its values in a dictionary."""
    return value(syntax, convert, f"{help_text}; can be repeated", action=_StoreEntry, default={})


def _quantity(syntax: str, like: str, help_text: str, **settings: Any) -> Option:
    """Option for a quantity above 0 with a unit."""
    convert = partial(values.quantity, like=like)
    return value(syntax, convert, f'{help_text}, like "{like}"', **settings)


def _load_and_velocity(**settings: Any) -> list[Option]:
    return [
        _quantity("--load F", "750 N", "normal load on the whole pin", **settings),
        _quantity("--velocity V", "1.25 m/s", "sliding velocity", **settings),
    ]


# fmt: off
_SCENE = [
    value("scene SCENE.toml", user_path, "scene file, or name of a shipped scene"),
    value("--preset NAME", None,
        "numerical preset, standard, fine or reference, instead of [fidelity] of the scene"),
    _entries("--set KEY=VALUE", values.setting,
        "change a numerical setting, such as increments=50, or a scene entry, such as "
        "wear.pattern=local or without=motion"),
]
_WORKERS = value("-j --workers N", values.count,
    "number of processes; default: one for each core")
_STORE = value("store OUT.zarr", values.stored, "results store, or name of its scene")
_TABLE = value("-o --output TABLE.csv", partial(values.writable, suffixes=TABLES),
    "file of the table, .csv, .md or .json")
_POINTS = [
    value("--points POINTS.csv", user_path,
        'operating points, a row each, in columns such as "load [N]" and "velocity [m/s]", as '
        ".csv, .txt or .xlsx; columns of words are passed on as labels"),
    _choice("--decimal", (".", ","), "decimal mark of --points"),
    _repeated("--ignore HEADING", str, "column of --points to leave out"),
]
_REALIZATION = value("--realization SEED", partial(values.count, minimum=0),
    "seed of the random surface, or area of the scan, instead of the scene's")
_BULK_TEMPERATURE = _repeated("--bulk-temperature T", str,
    'temperature of the bodies far from the contact, like "25 degC"')
_CONDITIONS = Group("conditions that replace those of the scene", [
    _repeated("--friction MU", values.number, "coefficient of friction, at least 0"),
    _BULK_TEMPERATURE,
    _repeated("--critical-temperature T", str,
        'temperature above which the lubricant fails, like "145 degC"'),
    _repeated("--critical-area-fraction F", str,
        "critical area fraction: wear is severe if more of the contact is above the critical "
        "temperature, such as 10%%; 0 for the highest temperature"),
])
_WITHOUT_TESTS = flag("--without-tests", "ignore the tests of the scene")
_EVALUATED_AT: list[Option | Group] = [
    _entries("--at KEY=VALUE", partial(values.pair, like='"pin.radius=2 mm"'),
        'evaluate at a value of a varied entry (sweep.over), such as "pin.radius=2 mm", or of a '
        'condition, such as "temperature.critical=150 degC" or "model.rise=+6 %%"'),
    _CONDITIONS,
    _WITHOUT_TESTS,
]
_ALL_ROWS = flag("--all", "print all rows and notes")

COMMANDS = (
    Command("new", "pipeline.cli.begin:new", "write a scene to start from",
        "scene.toml --from twin_disc", [
        Group("", [
            value("file FILE.toml", user_path, "file to write", nargs="?"),
            flag("--list", "list the shipped scenes"),
        ]),
        value("--from NAME", None, "shipped scene to copy; see --list", dest="template"),
    ]),
    Command("run", "pipeline.cli.sweep_commands:run", "run or resume the sweep of a scene",
        "scene.toml --accuracy 2%", [
        *_SCENE,
        value("-o --output OUT.zarr", values.store,
            "path of the store; default: results/<scene>.zarr"),
        Group("", [
            _WORKERS,
            value("--scheduler ADDRESS", None, "address of a running Dask scheduler"),
            value("--scheduler-file FILE", user_path, "file written by a running Dask scheduler"),
        ]),
        value("--from OLD.zarr", values.store, "copy matching points from another store",
            dest="source"),
        flag("--dashboard",
            "print the address of Dask's dashboard, which every user of this machine can open"),
        flag("--retry-failed", "simulate again the points that failed in an earlier run"),
        flag("-n --dry-run", "describe the sweep as irg check does, and simulate nothing"),
        value("--accuracy BOUND", values.share,
            "compute until the numerical error of the boundary is below this, such as 2%%; the "
            "run chooses preset, points and surface realizations"),
    ]),
    Command("check", "pipeline.cli.check:check",
        "describe a scene and estimate the cost of its sweep", "scene.toml",
        [*_SCENE, _WORKERS, _TABLE]),
    Command("point", "pipeline.cli.point_commands:point",
        "simulate one point (and the tests of the scene)",
        'scene.toml --load "500 N" --velocity "2 m/s"', [
        *_SCENE, *_load_and_velocity(required=True), _WITHOUT_TESTS, _REALIZATION, _CONDITIONS,
        _TABLE,
    ]),
    Command("trade", "pipeline.cli.sweep_commands:trade",
        "measure computing time against accuracy", "scene.toml -o trade.png", [
        *_SCENE,
        value("--store OUT.zarr", values.store,
            "new store for the points; default: results/<scene>-trade.zarr", dest="store_path"),
        _WORKERS,
        value("-o --output FILE.png", partial(values.writable, suffixes=(*FIGURES, *TABLES)),
            "file of a figure; or of the table, .csv, .md or .json"),
    ]),
    Command("infer", "pipeline.cli.point_commands:infer",
        "find the critical temperature from tests, or the wear rate from a contact width",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"', [
        *_SCENE,
        _quantity("--contact-width W", "348 um",
            "contact width measured at --load and --velocity; prints the specific wear rate "
            "instead"),
        _quantity("--duration T", "8 s",
            "sliding time before the width was measured, ramp included; default: from the scene"),
        _BULK_TEMPERATURE, _TABLE, *_load_and_velocity(), _REALIZATION,
    ]),
    Command("surface", "pipeline.cli.begin:surface",
        "describe a scan by ISO 25178-2, compare it with a random surface, and print its tables",
        'scan.npy --height-unit um --pixel-size "0.8 um" -o surface.png', [
        value("scan SCAN", user_path,
            "map of heights: .npy, a matrix in text, or the file of an instrument", nargs="?"),
        value("--height-unit UNIT", None,
            'unit of the heights, such as "um", if the file states none or a wrong one'),
        value("--pixel-size DX[,DY]", values.sides,
            'sides of a pixel, if the file states none, like "0.8 um" or "0.8 um,0.9 um"'),
        value("--missing SHARE", values.share,
            "largest fraction of missing heights that is filled; default: 10%%", default=0.1),
        _quantity("--ra RA", "0.2 um", "Ra of a profile or data sheet, with --rsm, without a file"),
        _quantity("--rsm RSM", "60 um", "RSm of a profile or data sheet"),
        value("-o --output FILE.png", partial(values.writable, suffixes=FIGURES),
            "figure of the scan and of the random surface"),
    ]),
    Command("status", "pipeline.cli.store_commands:status",
        "count done, failed and pending points of a store", "results/scene.zarr", [_STORE]),
    Command("verify", "pipeline.cli.store_commands:verify",
        "read a whole store and list damaged points", "results/scene.zarr", [_STORE]),
    Command("boundary", "pipeline.cli.store_commands:boundary",
        "print the boundary between mild and severe wear, without a new simulation",
        "results/scene.zarr --friction 0.09 --friction 0.103", [
        _STORE,
        _choice("--by", ("load", "velocity", "test"),
            "rows of the table: critical velocity at each load, critical load at each velocity, or "
            "tests compared with the computation; default: load", default="load"),
        _ALL_ROWS, _TABLE, *_EVALUATED_AT,
    ]),
    Command("margin", "pipeline.cli.store_commands:margin",
        "print verdict, probability and errors for one operating point, a table of them, or the "
        "cases of the sweep",
        'results/scene.zarr --load "500 N" --velocity "2 m/s"',
        [_STORE, *_load_and_velocity(), *_POINTS, _ALL_ROWS, _TABLE, *_EVALUATED_AT]),
    Command("plot", "pipeline.cli.store_commands:plot", "draw a figure of a store",
        'results/scene.zarr --kind ramp --load "600 N" --velocity "1.6 m/s"', [
        _STORE,
        _choice("--kind", ("diagram", "rows", "ramp", "fields", "tests"),
            "default: diagram, or rows if each has its own load and velocity"),
        value("-o --output FILE.png", user_path, "figure file; default: next to the store"),
        _quantity("--width W", "8.5 cm",
            "width of the figure; text shrinks less than the figure does"),
        value("--title TITLE", None, "title of the figure; default: that of the scene"),
        flag("--plain", "omit title and caption"),
        value("--dpi DPI", values.count, "resolution in dots per inch; default: 150"),
        flag("--log", "draw the diagram on logarithmic axes"),
        value("--step N", int, "step of fields, counted back from the end of a point: 0, -1, ..."),
        *_EVALUATED_AT, *_load_and_velocity(action="append", default=[]), _REALIZATION,
    ]),
    Command("report", "pipeline.cli.store_commands:report",
        "write a report to print and pass on: verdict, diagram, boundary, tests, errors, limits",
        'results/scene.zarr --load "500 N" --velocity "2 m/s" -o report.html', [
        _STORE, *_load_and_velocity(), *_POINTS,
        value("-o --output FILE.html", user_path, "file of the report; default: next to the store"),
        value("--title TITLE", None, "title of the report; default: that of the scene"),
        value("--author NAME", None, "name of the author"),
        *_EVALUATED_AT,
    ]),
    Command("help", "pipeline.cli.begin:help_",
        "print a page of the documentation, or list all pages", "first-hour",
        [value("topic TOPIC", None, "name of a page or of a command", nargs="?")]),
)
"""All commands, in the order in which the help lists them."""
# fmt: on
