"""Options of the commands of ``irg``, each defined once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.cli import values
from pipeline.paths import user_path


class Option:
    """An option or a positional argument, with the settings of `argparse`."""

    def __init__(self, *names: str, help: str, **settings: Any) -> None:
        self.names, self.settings = names, settings | {"help": help}

    def but(self, **settings: Any) -> Option:
        """Copy of the option with some settings replaced."""
        return Option(*self.names, **self.settings | settings)


class OptionGroup(NamedTuple):
    """Options under a title. Without a title the options exclude each other."""

    title: str
    options: tuple[Option, ...]


class Command(NamedTuple):
    """A command: name, function as ``module:name``, purpose, example and options."""

    name: str
    function: str
    purpose: str
    example: str
    takes: tuple[Option | OptionGroup, ...]


def value(words: str, use: str, read: Callable[[str], Any] | None = None, **more: Any) -> Option:
    """Option with a value.

    `words` has the option's names and then the value's name, such as "-o --output FILE". `use` is
    the help, and `read` converts the text. `more` are further arguments of argparse's
    ``add_argument``.
    """
    *names, metavar = words.split()
    return Option(*names, metavar=metavar, type=read, help=use, **more)


def several(words: str, use: str, read: Callable[[str], Any]) -> Option:
    """Option that may be repeated, with its values in a list; arguments are as for `value`."""
    return value(words, f"{use}; can be repeated", read, action="append", default=[])


def flag(name: str, use: str, *short: str) -> Option:
    """Option without a value, True if given; `use` is its help, `short` a short name."""
    return Option(*short, name, action="store_true", help=use)


def quantity(name: str, metavar: str, like: str, use: str, is_signed: bool = False) -> Option:
    """Option for a quantity with a unit; its help is `use` and the example `like`.

    The quantity may be negative if `is_signed`. `metavar` names the value in the help.
    """
    return value(f"{name} {metavar}", f'{use}, like "{like}"', values.quantity(like, is_signed))


WRITTEN = "output", "store_path", "new_scene"
"""Options that name files which a command writes."""


def output(name: str, use: str, kind: Callable[[str], Path | str] = user_path) -> Option:
    """Option ``-o`` for the file that a command writes; `kind` checks its path.

    `name` stands for the file in the help, such as "TABLE.csv", and `use` is the help.
    """
    return value(f"-o --output {name}", use, kind)


OF_ALL = (
    flag("--json", "print one JSON document"),
    flag("--quiet", "suppress progress and notes; show errors only", "-q"),
)
LIST = flag("--list", "list them")
_TABLES = ".csv, .md or .json"
TABLE = output("TABLE.csv", f"file of the table, {_TABLES}", values.table)
FIGURE_OR_TABLE = output(
    "FILE.png", f"file of a figure; or of the table, {_TABLES}",
    partial(values.table, or_figure=True),
)  # fmt: skip

SCENE = value("scene SCENE.toml", "scene file, or name of a shipped scene", user_path)
PRESET = value(
    "--preset NAME", (
        "numerical preset, replacing the table [fidelity] of the scene: standard, fine or "
        "reference"
    ),
)  # fmt: skip
SET = several(
    "--set KEY=VALUE",
    "change a numerical setting, such as increments=50, or a scene entry, such as "
    "wear.pattern=local or without=motion", values.setting,
)  # fmt: skip
OF_SCENE = (SCENE, PRESET, SET)
ACCURACY = value(
    "--accuracy BOUND", "compute until the whole numerical error of the boundary is below this, "
    "such as 2%%: it chooses preset, points and surface realizations", values.share,
)  # fmt: skip

STORE = value("store OUT.zarr", "results store, or name of its scene", values.stored)
STORE_OR_FOLDER = STORE.but(
    nargs="?", default=Path("results"),
    help="results store, or folder of stores; default: results",
)  # fmt: skip

TOPIC = value("topic TOPIC", "name of a page or of a command", nargs="?")
OF_NEW = (
    OptionGroup("", (
        value("file FILE.toml", "file to write", user_path, nargs="?"),
        LIST.but(help="list the shipped scenes"),
    )),
    value("--from NAME", "shipped scene to begin with; see --list", dest="template"),
)  # fmt: skip

WORKERS = value("-j --workers N", "number of processes; default: one for each core", values.count)
KEPT = (
    value(
        "--store OUT.zarr",
        "store for the simulated points, resumed if it exists; by default they are not kept",
        values.store, dest="store_path",
    ),
    WORKERS,
)  # fmt: skip
OF_TRADE = (
    KEPT[0].but(help="new store for the points; default: results/<scene>-trade.zarr"),
    WORKERS, FIGURE_OR_TABLE,
)  # fmt: skip
OF_RUN = (
    output("OUT.zarr", "path of the store; default: results/<scene>.zarr", values.store),
    OptionGroup("", (
        WORKERS,
        value("--scheduler ADDRESS", "address of a running Dask scheduler"),
        value("--scheduler-file FILE", "file written by a running Dask scheduler", user_path),
    )),
    value(
        "--from OLD.zarr", "copy matching points from another store",
        values.store, dest="source",
    ),
    flag("--dashboard", (
        "print the address of Dask's dashboard, which every user of this machine can open"
    )),
    flag("--retry-failed", "simulate points again that failed in an earlier run"),
    flag("--dry-run", "print what irg check prints, and compute nothing", "-n"),
    ACCURACY,
)  # fmt: skip

PLACE = (
    quantity("--load", "F", "750 N", "normal load on the whole pin"),
    quantity("--velocity", "V", "1.25 m/s", "sliding velocity", is_signed=True),
)
PLACES = tuple(option.but(action="append", default=[]) for option in PLACE)
NEEDED_PLACE = tuple(option.but(required=True) for option in PLACE)
WITHOUT_TESTS = flag("--without-tests", "ignore the tests of the scene")
POINTS = (
    value(
        "--points POINTS.csv",
        'operating points, a row each, in columns such as "load [N]" and "velocity [m/s]", as '
        ".csv, .txt or .xlsx; columns of words are passed on as labels", user_path,
    ),
    Option("--decimal", choices=(".", ","), help="decimal mark of --points"),
    several("--ignore HEADING", "column of --points to leave out", str),
)  # fmt: skip
REALIZATION = value(
    "--realization SEED", "seed of the random surface, or area of the scan, instead of the own one",
    partial(values.count, least=0),
)  # fmt: skip
AT = several(
    "--at KEY=VALUE",
    'evaluate at a value of a varied entry (sweep.over), such as "pin.radius=2 mm", or of a '
    'condition, such as "temperature.critical=150 degC" or "model.rise=+6 %%"',
    partial(values.pair, like='"pin.radius=2 mm"'),
)  # fmt: skip

FRICTION = several("--friction MU", "coefficient of friction, at least 0", values.number)
BULK = several(
    "--bulk-temperature T", 'temperature of the bodies far from the contact, like "25 degC"', str
)
CONDITIONS = OptionGroup("conditions that replace those of the scene", (
    FRICTION,
    BULK,
    several(
        "--critical-temperature T", 'temperature above which the lubricant fails, like "145 degC"',
        str,
    ),
    several(
        "--critical-area-fraction F", (
            "critical area fraction: wear is severe if more of the contact is above the "
            "critical temperature, such as 10%%; 0 for the highest temperature"
        ), str,
    ),
))  # fmt: skip

JUDGED = (AT, CONDITIONS, WITHOUT_TESTS)

OF_INFER = (
    *OF_SCENE, *KEPT,
    quantity(
        "--contact-width", "W", "348 um",
        "contact width measured at --load and --velocity; prints the specific wear rate instead",
    ),
    quantity(
        "--duration", "T", "8 s",
        "sliding time before the width was measured, ramp included; default: from the scene",
    ),
    BULK, TABLE, *PLACE, REALIZATION,
)  # fmt: skip
ALL = flag("--all", "print all rows and notes")
OF_BOUNDARY = (
    Option(
        "--by", default="load", choices=("load", "velocity", "test"),
        help=(
            "rows of the table: critical velocity at each load, critical load at each velocity, "
            "or tests compared with the computation; default: load"
        ),
    ),
    ALL,
)  # fmt: skip
OF_PLOT = (
    Option(
        "--kind", choices=("diagram", "rows", "ramp", "fields", "temperature", "tests"),
        help="default: diagram, or rows if each has its own load and velocity; temperature is "
        "drawn over the velocity",
    ),
    output("FILE.png", "figure file; default: next to the store"),
    quantity("--width", "W", "8.5 cm", (
        "width of the figure; text shrinks less than the figure does"
    )),
    value("--title TITLE", "title of the figure; default: that of the scene"),
    flag("--plain", "omit title and caption"),
    value("--dpi DPI", "resolution in dots per inch; default: 150", values.count),
    flag("--log", "draw the diagram on logarithmic axes"),
    value("--show NAME", "variable to draw in a ramp figure, such as wear_volume"),
    value("--step N", "step of fields, counted back from the end of a point: 0, -1, ...", int),
)  # fmt: skip
OF_REPORT = (
    output("FILE.html", "file of the report; default: beside the store"),
    value("--title TITLE", "title of the report; default: that of the scene"),
    value("--author NAME", "who has written it"),
)
OF_SURFACE = (
    Option(
        "scan", metavar="SCAN", type=user_path, nargs="?",
        help="map of heights: .npy, a matrix in text, or the file of an instrument",
    ),
    Option(
        "--height-unit", metavar="UNIT",
        help='unit of the heights, such as "um", where the file gives none or a wrong one',
    ),
    Option(
        "--pixel-size", metavar="DX[,DY]", type=values.sides,
        help='sides of a pixel, where the file gives none, like "0.8 um" or "0.8 um,0.9 um"',
    ),
    value(
        "--missing SHARE", "share of missing heights up to which they are filled; default: 10%%",
        values.share,
    ).but(default=0.1),
    quantity("--ra", "RA", "0.2 um", "Ra of a profile or data sheet, with --rsm, without a file"),
    quantity("--rsm", "RSM", "60 um", "RSm of a profile or data sheet"),
    output("FILE.png", "figure of the scan beside the random surface", values.figure),
)  # fmt: skip
