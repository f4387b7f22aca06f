"""Options of the commands of ``irg``: each of them once, whichever commands take it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from pipeline.cli import values

_PRESETS = "draft, standard, fine, reference, as-published"  # as `tribo.PRESETS`, told sooner


class Option(NamedTuple):
    """An option or a positional argument: what `argparse` is told of it."""

    names: tuple[str, ...]
    settings: dict[str, Any]

    def but(self, **settings: Any) -> Option:
        """The option with other settings in place of its own."""
        return Option(self.names, self.settings | settings)


class Group(NamedTuple):
    """Options below a title of their own; or, without a title, of which one may be given."""

    title: str
    options: tuple[Option, ...]


def _option(*names: str, **settings: Any) -> Option:
    return Option(names, settings)


def _flag(*names: str, **settings: Any) -> Option:
    return Option(names, {"action": "store_true", **settings})


def output(name: str, use: str) -> Option:
    """Option for the file that a command writes."""
    return _option("-o", "--output", metavar=name, type=Path, help=use)


OF_ALL = (
    _flag("--json", help="print one JSON document"),
    _flag("-q", "--quiet", help="show no progress and no notes, only errors"),
)

SCENE = _option("scene", metavar="SCENE.toml", type=Path, help="the scene file")
PRESET = _option("--preset", metavar="NAME", help=f"fidelity: {_PRESETS}")
SET = _option(
    "--set",
    metavar="KEY=VALUE",
    type=values.setting,
    action="append",
    default=[],
    help="another numerical choice, such as increments=50, or another entry of the scene, such as "
    "wear.pattern=local or without=motion; may be repeated for other keys",
)
OF_SCENE = (SCENE, PRESET.but(help=f"fidelity in place of the scene's own: {_PRESETS}"), SET)
STORE = _option(
    "store", metavar="OUT.zarr", type=values.store, help="a store that irg run has made"
)
OTHER_STORE = _option(
    "other", metavar="OTHER.zarr", type=values.store, help="the store to compare it with"
)
FOLDER = _option(
    "folder", metavar="FOLDER", type=Path, nargs="?", default=Path("results"),
    help="folder to search, with those in it; default: results",
)  # fmt: skip

SCAN = _option(
    "scan", metavar="SCAN", type=Path, help="heights: .npy, .csv, or the file of an instrument"
)
OF_SCAN = (
    SCAN,
    _option(
        "--height-unit",
        metavar="UNIT",
        help='unit of the heights, like "um", where the file gives none or a wrong one',
    ),
    _option(
        "--pixel-size",
        metavar="DX[,DY]",
        type=values.sides,
        help='sides of a pixel along x and y, like "0.8 um" or "0.8 um,0.9 um", where the file '
        "gives none; after --transpose",
    ),
    _flag("--transpose", help="exchange x and y of the file"),
    _option(
        "--flip",
        choices=("no", "x", "y", "heights"),
        default="no",
        help="reverse an axis, or the heights, as of a replica",
    ),
)

NEW_FILE = _option("file", metavar="FILE.toml", type=Path, nargs="?", help="file to write")
FROM = _option(
    "--from", metavar="NAME", dest="like", help="shipped scene to begin with; see --list"
)
SCHEMA = _option(
    "--schema",
    metavar="FILE.json",
    type=Path,
    help="write the format as a JSON schema instead, by which an editor completes and explains "
    "scenes",
)
LIST = _flag("--list")
TOPIC = _option("topic", metavar="TOPIC", nargs="?", help="name of a page or of a command")

WORKERS = _option(
    "--workers",
    metavar="N",
    type=values.count,
    help="number of workers; default: one for each core",
)
SCHEDULER = _option("--scheduler", metavar="ADDRESS", help="a running Dask scheduler to use")
CLUSTER = _option(
    "--cluster",
    metavar="SYSTEM",
    choices=("slurm",),
    help="compute in the jobs of a batch system: slurm; with --jobs, --walltime and --site",
)
OF_CLUSTER = Group(
    "jobs of --cluster",
    (
        _option(
            "--jobs", metavar="N", type=values.count, help="jobs at the same time; default: 10"
        ),
        _option(
            "--walltime",
            metavar="T",
            type=values.positive("2 h"),
            help="time that a job may take, like 2h; default: 1h",
        ),
        _option(
            "--site",
            metavar="FILE.toml",
            type=Path,
            help="options of the site, such as queue and account; irg new --site writes a sample",
        ),
        _flag("--dry-run", help="print the script of a job, and submit none"),
    ),
)
NEW_SITE = _option(
    "--site",
    metavar="FILE.toml",
    type=Path,
    help="write a sample of the options of a batch system instead, for irg run --cluster",
)
RETRY_FAILED = _flag("--retry-failed", help="compute failed points again")
NEW_STORE = output("OUT.zarr", "path of the store; default: results/<scene>.zarr").but(
    type=values.new_store
)
BOUNDARY_ONLY = _option(
    "--boundary-only",
    metavar="TOLERANCE",
    nargs="?",
    const=0.01,
    type=values.tolerance,
    help="choose velocities until the boundary is known to this tolerance; default: 1%%",
)
ACCURACY = _option(
    "--accuracy",
    metavar="BOUND",
    type=values.share,
    help="pick the cheapest fidelity whose boundary errs by no more than this, such as 2%%",
)
REPAIR = _flag("--repair", help="set damaged points to be computed again")

LOAD = _option(
    "--load", metavar="F", type=values.positive("750 N"), help='normal load, like "750 N"'
)
VELOCITY = _option(
    "--velocity",
    metavar="V",
    type=values.quantity("1.25 m/s"),
    help='sliding velocity, like "1.25 m/s"',
)
REALIZATION = _option(
    "--realization",
    metavar="SEED",
    type=values.seed,
    help="seed of one of several random surfaces",
)
PLACE = (LOAD, VELOCITY)
POINTS = _option(
    "--points",
    metavar="DUTY.csv",
    type=Path,
    help='operating points, a row each, in columns "load [N]" and "velocity [m/s]" or in other '
    "units; further columns are passed on",
)
NEEDED_PLACE = tuple(each.but(required=True) for each in PLACE)

FRICTION = _option("--friction", metavar="MU", type=values.friction, help="coefficient of friction")
FRICTIONS = FRICTION.but(
    type=values.frictions, action=values.Several, help="coefficient of friction; may be repeated"
)
BULK = _option(
    "--bulk-temperature",
    metavar="T",
    type=values.bulk,
    help='bulk temperature, like "25 degC"; "pin=60 degC, disk=25 degC" in a sweep of unequal ones',
)
CRITICAL = _option(
    "--critical-temperature",
    metavar="T",
    type=values.quantity("145 degC"),
    help='temperature above which the lubricant fails, like "145 degC"',
)
SHARE = _option(
    "--share",
    type=values.failing_share,
    help="share of the contact above the critical temperature beyond which wear is severe, like "
    "10%% or 0.1; 0 for the maximum temperature",
)
CRITERION = _option(
    "--criterion",
    metavar="NAME",
    type=values.criterion,
    help="temperature that decides: share (the one that the share exceeds), highest or mean",
)
WEAR_RATE = _option(
    "--wear-rate",
    metavar="K",
    type=values.positive("2e-6 mm^3/(N m)"),
    help='specific wear rate, like "2e-6 mm^3/(N m)", of a store whose scene has wear_rates',
)
AT = _option(
    "--at",
    metavar="KEY=VALUE",
    type=values.setting,
    action="append",
    default=[],
    help='value of an entry with several, like "pin.radius=2 mm", of a store whose scene has over; '
    "may be repeated for other entries",
)
_INSTEAD = "conditions, in place of the scene's own"
CONDITIONS = Group(_INSTEAD, (FRICTION, BULK, CRITICAL, SHARE, CRITERION))
CONDITIONS_AT_FRICTIONS = Group(_INSTEAD, (FRICTIONS, BULK, CRITICAL, SHARE, CRITERION))

OVER = _option(
    "--over",
    metavar="KEY=VALUE,VALUE",
    type=values.settings,
    action="append",
    default=[],
    help="an entry of the scene, and the values to give it, such as 0.08,0.12; or -20%%,+20%% of "
    "what the scene gives; may be repeated",
)
PHYSICS = _flag(
    "--physics",
    help="physics that the scene leaves out, each with its size here and how sure it is",
)
NEXT = _option(
    "--next",
    metavar="COUNT",
    nargs="?",
    const=1,
    type=values.count,
    help="of samples: rank what to measure next, or plan so many tests at once",
)
FOR = _option(
    "--for",
    metavar="ENTRY",
    dest="target",
    help="target of the next test: an unknown input, such as temperature.critical, or a load, such "
    'as "400 N", for the boundary there; default: the whole boundary',
)
SCATTER = _option(
    "--scatter",
    metavar="SHARE",
    type=values.share,
    help="relative standard deviation of measured velocities that give none; default: 5%%",
)
GIVEN_MEASURED = _flag(
    "--given-measured",
    help="let the scene's measured transitions narrow down the unknown inputs",
)
CONTACT_WIDTH = _option(
    "--contact-width",
    metavar="W",
    type=values.positive("348 um"),
    help='width measured at --load and --velocity, like "348 um": find the specific wear rate '
    "instead",
)
DURATION = _option(
    "--duration",
    metavar="T",
    type=values.positive("8 s"),
    help="sliding from the start of the ramp until the width was measured; default: the scene's",
)
BASE = _option("--base", metavar="NAME", default="fine", help="preset to vary choice by choice")
DIAGRAM = _flag("--diagram", help="compare whole small diagrams")
RESULT = _option("name", metavar="NAME", nargs="?", help="one of --list, or all")
SURFACES = _option("--surfaces", metavar="N", type=values.count, help="number of random surfaces")
TABLE = output("TABLE.csv", "write the table to a file, .csv or .md")
FIGURE_OR_TABLE = output("FILE.png", "draw a figure; or write a table, to .csv or .md")

KIND = _option(
    "--kind",
    default="diagram",
    choices=("diagram", "ramp", "fields", "temperature", "histogram", "animation"),
    help="default: diagram; temperature is over the velocity, histogram over the contact, "
    "animation of the fields while the load grows",
)
LOOK = (
    _option(
        "--width",
        metavar="W",
        type=values.positive("8.5 cm"),
        help='width of the figure, like "8.5 cm"; words stay readable',
    ),
    _option("--dpi", metavar="N", type=values.count, help="dots per inch of a .png or .gif"),
    _flag("--no-title", help="draw no title, where a caption gives it"),
    _flag("--log", help="scale both axes of the diagram by the logarithm"),
)
RIVAL = _option(
    "--rival",
    metavar="NAME",
    dest="rivals",
    action="append",
    help="draw what a simpler criterion says into the diagram: blok, power, power-density or pv; "
    "may be repeated",
)
WATCH = _flag(
    "--watch",
    help="draw again as points come, until the run ends: in a window, or into the file of -o",
)
WATCHED_RUN = _option(
    "--watch",
    metavar="FILE.png",
    nargs="?",
    const="",
    help="draw the diagram as points come: in a window, or into a file",
)
FIELDS = (
    _option(
        "--most-fields",
        metavar="N",
        type=values.count,
        help="number of points whose fields the page holds, those nearest to the transition, about "
        "10 kB each; default: 500",
    ),
    _flag("--no-fields", help="leave all fields out"),
)
