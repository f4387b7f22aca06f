"""Options of the commands of ``irg``, each defined once."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.cli import values
from pipeline.cli.documented import expand_help
from pipeline.paths import user_path


class Option:
    """An option or a positional argument, with the settings of `argparse`."""

    def __init__(self, *names: str, help: str, **settings: Any) -> None:
        self.names, self.settings = names, settings | {"help": expand_help(help)}

    def but(self, **settings: Any) -> Option:
        """The option with some settings replaced."""
        return Option(*self.names, **self.settings | settings)


class _Once(argparse.Action):
    """Keep the value of an option, and refuse a second one."""

    def __call__(self, parser: Any, namespace: Any, value: Any, option: str | None = None) -> None:
        if getattr(namespace, self.dest) is not None:
            parser.error(f"{option} is given more than once; give it once")
        setattr(namespace, self.dest, value)


class Group(NamedTuple):
    """Options below a title; without a title, options that exclude each other."""

    title: str
    options: tuple[Option, ...]


class Command(NamedTuple):
    """A command: its name, its function as ``module:name``, its help, and its options."""

    name: str
    function: str
    purpose: str
    example: str
    takes: tuple[Option | Group, ...]


def flag(name: str, use: str, *short: str) -> Option:
    """Option without a value."""
    return Option(*short, name, action="store_true", help=use)


def quantity(name: str, metavar: str, like: str, use: str, is_signed: bool = False) -> Option:
    """Option for a quantity with a unit, such as the example that ends its help."""
    read = values.quantity(like, is_signed)
    return Option(name, metavar=metavar, type=read, help=f'{use}, like "{like}"')


WRITTEN = "output", "kept", "new_scene"
"""Options that name what a command writes."""


def output(name: str, use: str, kind: Callable[[str], Path | str] = user_path) -> Option:
    """Option for the file that a command writes."""
    return Option("-o", "--output", metavar=name, type=kind, help=use)


OF_ALL = (
    flag("--json", "print one JSON document"),
    flag("--quiet", "show no progress and no notes, only errors", "-q"),
)
LIST = flag("--list", "list them")
TABLE = output("TABLE.csv", "file of the table, .csv or .md", values.table)
FIGURE_OR_TABLE = output(
    "FILE.png", "file of a figure; or of the table, .csv or .md",
    partial(values.table, or_figure=True),
)  # fmt: skip

SCENE = Option("scene", metavar="SCENE.toml", type=user_path, help="{load_scene.path}")
PRESET = Option("--preset", metavar="NAME", help="{load_scene.preset}")
SET = Option(
    "--set", metavar="KEY=VALUE", type=values.setting, action="append", default=[],
    help="change a numerical choice, such as increments=50, or an entry of the scene, such as "
    "wear.pattern=local or without=motion; may be repeated for other keys",
)  # fmt: skip
OF_SCENE = (SCENE, PRESET, SET)
ACCURACY = Option(
    "--accuracy", metavar="BOUND", type=values.share,
    help="{choose_fidelity.accuracy}",
)  # fmt: skip
MEASURE = flag(
    "--measure",
    "measure the error of the scene's own numerical choices, before a run or on its finished store",
)
BOUNDARY_ONLY = Option(
    "--boundary-only", metavar="TOLERANCE", nargs="?", const=0.01, type=values.share,
    help="{run_sweep.boundary_only}; default: 1%%",
)  # fmt: skip

STORE = Option("store", metavar="OUT.zarr", type=values.store, help="store that irg run has made")
OTHER_STORE = Option(
    "other", metavar="OTHER.zarr", type=values.store, help="store to compare with the first"
)
STORE_OR_FOLDER = STORE.but(
    metavar="OUT.zarr", nargs="?", default=Path("results"),
    help="store that irg run has made, or a folder of stores; default: results",
)  # fmt: skip


SHEET = Option("--sheet", metavar="NAME", help="sheet of a workbook; default: its first one")
TOPIC = Option("topic", metavar="TOPIC", nargs="?", help="name of a page or of a command")
OF_NEW = (
    Group(
        "",
        (
            Option("file", metavar="FILE.toml", type=user_path, nargs="?", help="file to write"),
            LIST.but(help="list the shipped scenes"),
        ),
    ),
    flag("--full", "{new_scene.full}"),
    Option("--from", metavar="NAME", dest="like", help="shipped scene to begin with; see --list"),
)  # fmt: skip

WORKERS = Option("--workers", metavar="N", type=values.count, help="{run_sweep.workers}")
KEPT = (
    Option(
        "--store", metavar="OUT.zarr", dest="kept", type=values.new_store,
        help="store for the points, resumed if it exists; by default no point is kept",
    ),
    WORKERS,
)  # fmt: skip
OF_RUN = (
    output("OUT.zarr", "path of the store; default: results/<scene>.zarr", values.new_store),
    Group(
        "",
        (
            WORKERS,
            Option("--scheduler", metavar="ADDRESS", help="address of a running Dask scheduler"),
            Option(
                "--scheduler-file", metavar="FILE", type=user_path,
                help="file that a running Dask scheduler has written, instead of its address",
            ),
        ),
    ),
    Option(
        "--from", metavar="OLD.zarr", dest="source", type=values.store, help="{run_sweep.source}"
    ),
    flag("--dashboard", "{run_sweep.dashboard}"),
    flag("--retry-failed", "{run_sweep.retry_failed}"),
    BOUNDARY_ONLY,
    Group("", (ACCURACY, MEASURE)),
)  # fmt: skip

PLACE = (
    quantity("--load", "F", "750 N", "{run_point.load}"),
    quantity("--velocity", "V", "1.25 m/s", "{run_point.velocity}", is_signed=True),
)
NEEDED_PLACE = tuple(option.but(required=True) for option in PLACE)
POINTS = (
    Option(
        "--points", metavar="DUTY.csv", type=user_path,
        help='operating points, a row each, in columns such as "load [N]" and "velocity [m/s]", as '
        ".csv, .txt or .xlsx; further columns are passed on",
    ),
    SHEET,
)  # fmt: skip
REALIZATION = Option(
    "--realization", metavar="SEED", type=partial(values.count, least=0),
    help="{run_point.realization}",
)  # fmt: skip
AT = Option(
    "--at", metavar="KEY=VALUE", type=values.setting, action="append", default=[],
    help='judge at a value: of an entry in sweep.over, like "pin.radius=2 mm", of an unknown input '
    'of samples, or of a condition, like "temperature.critical=150 degC"; may be repeated',
)  # fmt: skip

FRICTION = Option("--friction", metavar="MU", type=values.friction, help="{at.friction}")
FRICTIONS = FRICTION.but(action="append", help="{at.friction}; may be repeated")
BULK = Option(
    "--bulk-temperature", metavar="T", type=values.bulk,
    help='{at.bulk_temperature}, like "25 degC"; "pin=60 degC, disk=25 degC" if they differ',
)  # fmt: skip
CRITERION = Option(
    "--criterion", metavar="NAME", type=values.criterion,
    help="{at.criterion}",
)  # fmt: skip
_THRESHOLD = (
    quantity(
        "--critical-temperature", "T", "145 degC",
        "{at.critical_temperature}", is_signed=True,
    ),
    Option(
        "--share", type=values.failing_share,
        help="{at.share}",
    ),
    CRITERION,
)  # fmt: skip
_ONE_EACH = tuple(option.but(action=_Once) for option in (FRICTION, BULK, *_THRESHOLD))
CONDITIONS = Group("conditions, instead of the scene's", _ONE_EACH)
CONDITIONS_AT_FRICTIONS = CONDITIONS._replace(options=(FRICTIONS, *_ONE_EACH[1:]))

OVER = Option(
    "--over", metavar="KEY=VALUE,VALUE", type=values.settings, action="append", default=[],
    help="{vary.over}, such as 0.08,0.12, or -20%%,+20%% of the value in the scene; may be "
    "repeated",
)  # fmt: skip
SCATTER = Option(
    "--scatter", metavar="SHARE", type=values.share,
    help="{at.scatter}; default: 5%%",
)  # fmt: skip
GIVEN_MEASURED = flag("--given-measured", "{at.given_measured}")
OIL = Option("--oil", metavar="NAME", help="{at.oil}")
WEIGHED = (GIVEN_MEASURED, SCATTER, OIL)
JUDGED = (AT, CONDITIONS)

OF_PLOT = (
    Option(
        "--kind", default="diagram",
        choices=("diagram", "ramp", "fields", "temperature", "tests"),
        help="default: diagram; temperature is drawn over the velocity",
    ),
    output("FILE.png", "file of the figure; default: beside the store"),
    quantity("--width", "W", "8.5 cm", "{plot.width}"),
    flag("--plain", "{plot.plain}"),
    flag("--log", "logarithmic axes of the diagram"),
    Option("--show", metavar="NAME", help="variable that a ramp shows, such as wear_volume"),
)  # fmt: skip
