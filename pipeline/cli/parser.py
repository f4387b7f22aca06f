"""The commands of ``irg`` with their options, and the parser of their arguments."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

from pipeline.cli import values
from pipeline.messages import did_you_mean, quoted
from pipeline.paths import FIGURES, TABLES, user_path

_BEGIN = """Begin with:
  irg new scene.toml
  irg check scene.toml
  irg run scene.toml
  irg plot results/scene.zarr
  irg help first-hour
Options of a command:
  irg COMMAND --help"""


class _Parser(argparse.ArgumentParser):
    """Argument parser whose error is one line, and which refuses a second value of an option."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **settings)
        self.register("action", None, _StoreOnce)  # of options without another action

    def error(self, message: str) -> NoReturn:
        """Print the fault, and how to list the options; then exit."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


class _StoreOnce(argparse.Action):
    """Action of an option with one value, of which argparse would take the last one."""

    is_set = False

    def __call__(self, parser: Any, namespace: Any, value: Any, name: str | None = None) -> None:
        if self.is_set:
            parser.error(f"{name} is given twice; give it once")
        self.is_set = True
        setattr(namespace, self.dest, value)


class _StoreEntry(argparse.Action):
    """Action of an option KEY=VALUE that may be repeated: collect the values by key."""

    def __call__(self, parser: Any, namespace: Any, entry: Any, name: str | None = None) -> None:
        key, value = entry
        entries = getattr(namespace, self.dest)
        if key.removeprefix("fidelity.") in {known.removeprefix("fidelity.") for known in entries}:
            parser.error(f"{key} is given twice; give it once")
        setattr(namespace, self.dest, {**entries, key: value})


class _Version(argparse.Action):
    """Action of --version: look up the version, print it, and exit."""

    def __call__(self, parser: Any, *_: Any) -> None:
        print(f"irg {metadata.version('irg-transition')}")
        parser.exit()


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the arguments of one command, by default those of this process."""
    parser = whole_parser()
    words = [*(sys.argv[1:] if arguments is None else arguments)]
    _require_command_first(parser, words)
    options, unknown_words = parser.parse_known_args(words)
    if unknown_words:
        _refuse_word(options.parser, unknown_words[0])
    paths = {name: path for name, path in vars(options).items() if isinstance(path, Path)}
    out = paths.pop("output", None)
    with suppress(OSError):  # such as a name that is too long, which the command reports
        if out and any(path.exists() and path.samefile(out) for path in paths.values()):
            options.parser.error(f"{out} is an input of this command; choose another output file")
    return options


def _refuse_word(parser: argparse.ArgumentParser, word: str) -> NoReturn:
    """Refuse a word that a command does not know, by what to type."""
    if word.startswith("-"):
        hint = did_you_mean(word, re.findall(r"--[a-z-]+", parser.format_usage()))
        parser.error(f"there is no option {quoted(word)}{hint}")
    advice = 'put text with a space in quotes, as in "400 N"'
    if " " in word:
        advice = 'write its option before it, as in --load "400 N"'
    parser.error(f"{quoted(word)} is not expected; {advice}")


def _require_command_first(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Refuse options before the command, and an unknown command, by what to type."""
    commands = parser.get_default("commands")
    if not words:
        parser.error("a command is missing, such as irg run first_try")
    if words[0] in ("-h", "--help", "--version"):
        return
    if words[0].startswith("-"):
        command = next((word for word in words if word in commands), "COMMAND")
        parser.error(f"options stand after the command: irg {command} ... {words[0]}")
    if words[0] not in commands:
        parser.error(f"there is no command {quoted(words[0])}{did_you_mean(words[0], commands)}")


def whole_parser() -> argparse.ArgumentParser:
    """Parser of all commands, in the order in which the help lists them."""
    irg = _Parser(
        prog="irg",
        description="Predict when a lubricated sliding contact changes from mild to severe wear.",
        epilog=_BEGIN,
    )
    irg.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = irg.add_subparsers(metavar="COMMAND", title="commands", required=True)
    irg.set_defaults(commands=commands.choices)
    _add_commands_without_a_store(commands)
    _add_commands_on_sweeps(commands)
    _add_commands_on_points(commands)
    _add_commands_on_stores(commands)
    for package in ("pipeline.workflows", "workflows"):  # in a checkout beside `pipeline`
        if find_spec(package) and find_spec(f"{package}.commands"):
            import_module(f"{package}.commands").add_paper(commands)
            break
    return irg


def add_command(commands: Any, name: str, function: str, purpose: str, example: str) -> Any:
    """Add a command, which `function` answers ("module:name"), and return its parser."""
    parser = commands.add_parser(
        name,
        help=purpose,
        description=textwrap.fill(f"{purpose[0].upper()}{purpose[1:]}."),
        epilog=f"example:\n  irg {name} {example}",
    )
    parser.set_defaults(command=name, function=function, parser=parser)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument(
        "-q", "--quiet", action="store_true",
        help="suppress progress and notes; show warnings and errors",
    )  # fmt: skip
    return parser


# fmt: off
def _add_commands_without_a_store(commands: Any) -> None:
    new = add_command(commands, "new", "pipeline.cli.begin:new", "write a scene to start from",
        "scene.toml --from twin_disc")
    choice = new.add_mutually_exclusive_group()
    choice.add_argument("file", metavar="FILE.toml", type=user_path, nargs="?",
        help="file to write")
    choice.add_argument("--list", action="store_true", help="list the shipped scenes")
    new.add_argument("--from", metavar="NAME", dest="template",
        help="shipped scene to copy; see --list")

    help_ = add_command(commands, "help", "pipeline.cli.begin:help_",
        "print a page of the documentation, or list all pages", "first-hour")
    help_.add_argument("topic", metavar="TOPIC", nargs="?", help="name of a page or of a command")


def _add_commands_on_sweeps(commands: Any) -> None:
    run = add_command(commands, "run", "pipeline.cli.sweep_commands:run",
        "run or resume the sweep of a scene", "scene.toml --accuracy 2%")
    _add_scene(run)
    run.add_argument("-o", "--output", metavar="OUT.zarr", type=values.store,
        help="path of the store; default: results/<scene>.zarr")
    cluster = run.add_mutually_exclusive_group()
    _add_workers(cluster)
    cluster.add_argument("--scheduler", metavar="ADDRESS",
        help="address of a running Dask scheduler")
    cluster.add_argument("--scheduler-file", metavar="FILE", type=user_path,
        help="file written by a running Dask scheduler")
    run.add_argument("--from", metavar="OLD.zarr", type=values.store, dest="source",
        help="copy matching points from another store")
    run.add_argument("--dashboard", action="store_true",
        help="print the address of Dask's dashboard, which every user of this machine can open")
    run.add_argument("--retry-failed", action="store_true",
        help="simulate again the points that failed in an earlier run")
    run.add_argument("-n", "--dry-run", action="store_true",
        help="describe the sweep as irg check does, and simulate nothing")
    run.add_argument("--accuracy", metavar="BOUND", type=values.accuracy,
        help="compute until the numerical error of the boundary is below this, such as 2%%; the "
        "run chooses preset, points and surface realizations")

    check = add_command(commands, "check", "pipeline.cli.check:check",
        "describe a scene and estimate the cost of its sweep", "scene.toml")
    _add_scene(check)
    _add_workers(check)
    _add_output(check, "file of the table, .csv, .md or .json", TABLES)


def _add_commands_on_points(commands: Any) -> None:
    point = add_command(commands, "point", "pipeline.cli.point_commands:point",
        "simulate one point (and the tests of the scene)",
        'scene.toml --load "500 N" --velocity "2 m/s"')
    _add_scene(point)
    _add_load_and_velocity(point, required=True)
    _add_without_tests(point)
    _add_realization(point)
    _add_conditions(point)
    _add_output(point, "file of the table, .csv, .md or .json", TABLES)

    trade = add_command(commands, "trade", "pipeline.cli.sweep_commands:trade",
        "measure computing time against accuracy", "scene.toml -o trade.png")
    _add_scene(trade)
    trade.add_argument("--store", metavar="OUT.zarr", type=values.store, dest="store_path",
        help="new store for the points; default: results/<scene>-trade.zarr")
    _add_workers(trade)
    _add_output(trade, "file of a figure; or of the table, .csv, .md or .json", (*FIGURES, *TABLES))

    sensitivity = add_command(commands, "sensitivity", "pipeline.cli.sweep_commands:sensitivity",
        "compute how much each input of a scene changes rise and critical velocity",
        'scene.toml --load "400 N" --velocity "2.25 m/s" -o inputs.png')
    _add_scene(sensitivity)
    _add_load_and_velocity(sensitivity)
    sensitivity.add_argument("--store", metavar="OUT.zarr", type=values.store, dest="store_path",
        help="store for the points; default: results/<scene>-sensitivity.zarr")
    _add_workers(sensitivity)
    _add_output(sensitivity, "file of a figure; or of the table, .csv, .md or .json",
        (*FIGURES, *TABLES))

    infer = add_command(commands, "infer", "pipeline.cli.point_commands:infer",
        "find the critical temperature from tests, or the wear rate from a contact width",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"')
    _add_scene(infer)
    _add_quantity(infer, "--contact-width", "W", "348 um",
        "contact width measured at --load and --velocity; prints the specific wear rate instead")
    _add_quantity(infer, "--duration", "T", "8 s",
        "sliding time before the width was measured, ramp included; default: from the scene")
    _add_condition(infer, "--bulk-temperature", "T",
        'temperature of the bodies far from the contact, like "25 degC"')
    _add_output(infer, "file of the table, .csv, .md or .json", TABLES)
    _add_load_and_velocity(infer)
    _add_realization(infer)


def _add_commands_on_stores(commands: Any) -> None:
    status = add_command(commands, "status", "pipeline.cli.store_commands:status",
        "count done, failed and pending points of a store", "results/scene.zarr")
    _add_store(status)

    verify = add_command(commands, "verify", "pipeline.cli.store_commands:verify",
        "read a whole store and list damaged points", "results/scene.zarr")
    _add_store(verify)

    boundary = add_command(commands, "boundary", "pipeline.cli.store_commands:boundary",
        "print the boundary between mild and severe wear, without a new simulation",
        "results/scene.zarr --friction 0.09 --friction 0.103")
    _add_store(boundary)
    boundary.add_argument("--by", choices=("load", "velocity", "test"), default="load",
        help="rows of the table: limits and critical velocity at each load, limits and critical "
        "load at each velocity, or tests compared with the computation; default: load")
    _add_output(boundary, "file of the table, .csv, .md or .json", TABLES)
    _add_evaluated_at(boundary)

    margin = add_command(commands, "margin", "pipeline.cli.store_commands:margin",
        "print verdict, probability and errors for one operating point, a table of them, or the "
        "cases of the sweep", 'results/scene.zarr --load "500 N" --velocity "2 m/s"')
    _add_store(margin)
    _add_load_and_velocity(margin)
    _add_points(margin)
    margin.add_argument("--all", action="store_true", help="print all rows")
    _add_output(margin, "file of the table, .csv, .md or .json", TABLES)
    _add_evaluated_at(margin)

    plot = add_command(commands, "plot", "pipeline.cli.store_commands:plot",
        "draw a figure of a store",
        'results/scene.zarr --load "600 N" --velocity "1.6 m/s"')
    _add_store(plot)
    plot.add_argument("--kind", choices=("diagram", "rows", "tests"),
        help="default: diagram, or rows if each has its own load and velocity")
    plot.add_argument("-o", "--output", metavar="FILE.png", type=user_path,
        help="figure file; default: next to the store")
    _add_quantity(plot, "--width", "W", "8.5 cm",
        "width of the figure; text keeps a readable size")
    plot.add_argument("--plain", action="store_true", help="omit title and caption")
    plot.add_argument("--log", action="store_true", help="draw the diagram on logarithmic axes")
    plot.add_argument("--dpi", metavar="DPI", type=values.count,
        help="resolution in dots per inch; default: 150")
    _add_evaluated_at(plot)
    _add_load_and_velocity(plot, action="append", default=[])

    report = add_command(commands, "report", "pipeline.cli.store_commands:report",
        "write a printable report: verdict, diagram, boundary, tests, errors, limits",
        'results/scene.zarr --load "500 N" --velocity "2 m/s" -o report.html')
    _add_store(report)
    _add_load_and_velocity(report)
    _add_points(report)
    report.add_argument("-o", "--output", metavar="FILE.html", type=user_path,
        help="file of the report; default: next to the store")
    report.add_argument("--title", metavar="TITLE",
        help="title of the report; default: that of the scene")
    report.add_argument("--author", metavar="NAME", help="name of the author")
    _add_evaluated_at(report)


def _add_quantity(parser: Any, name: str, metavar: str, like: str, text: str, **more: Any) -> None:
    """Add an option for a quantity above 0 with a unit, such as `like`."""
    read = partial(values.quantity, like=like)
    parser.add_argument(name, metavar=metavar, type=read, help=f'{text}, like "{like}"', **more)


def _add_output(parser: Any, text: str, suffixes: Sequence[str]) -> None:
    parser.add_argument("-o", "--output", metavar=f"FILE{suffixes[0]}", help=text,
        type=partial(values.writable, suffixes=suffixes))


def _add_load_and_velocity(parser: Any, **more: Any) -> None:
    _add_quantity(parser, "--load", "F", "750 N", "normal load on the whole pin", **more)
    _add_quantity(parser, "--velocity", "V", "1.25 m/s", "sliding velocity", **more)


def _add_scene(parser: Any) -> None:
    parser.add_argument("scene", metavar="SCENE.toml", type=user_path,
        help="scene file, or name of a shipped scene")
    parser.add_argument("--preset", metavar="NAME",
        help="numerical preset, standard, fine or reference, instead of [fidelity] of the scene")
    parser.add_argument("--set", metavar="KEY=VALUE", type=values.setting, action=_StoreEntry,
        default={}, help="change a numerical setting, such as increments=50, or a scene entry, "
        "such as wear.pattern=local or without=motion; can be repeated")


def _add_workers(parser: Any) -> None:
    parser.add_argument("-j", "--workers", metavar="N", type=values.count,
        help="number of processes; default: one for each core")


def _add_store(parser: Any) -> None:
    parser.add_argument("store", metavar="OUT.zarr", type=values.stored,
        help="results store, or name of its scene")


def _add_points(parser: Any) -> None:
    parser.add_argument("--points", metavar="POINTS.csv", type=user_path,
        help='operating points, a row each, in columns such as "load [N]" and "velocity [m/s]", '
        "as .csv or .txt; columns of words are passed on as labels")
    parser.add_argument("--decimal", choices=(".", ","), help="decimal mark of --points")
    parser.add_argument("--ignore", metavar="HEADING", action="append", default=[],
        help="column of --points to leave out; can be repeated")


def _add_realization(parser: Any) -> None:
    parser.add_argument("--realization", metavar="SEED", type=partial(values.count, minimum=0),
        help="seed of the random surface, or area of the scan, instead of the scene's")


def _add_without_tests(parser: Any) -> None:
    parser.add_argument("--without-tests", action="store_true",
        help="ignore the tests of the scene")


def _add_condition(parser: Any, name: str, metavar: str, text: str) -> None:
    read = partial(values.condition, name=name.removeprefix("--").replace("-", "_"))
    parser.add_argument(name, metavar=metavar, type=read, action="append", default=[],
        help=f"{text}; can be repeated")


def _add_conditions(parser: Any) -> None:
    conditions = parser.add_argument_group("conditions that replace those of the scene")
    _add_condition(conditions, "--friction", "MU",
        "coefficient of friction, at least 0")
    _add_condition(conditions, "--bulk-temperature", "T",
        'temperature of the bodies far from the contact, like "25 degC"')
    _add_condition(conditions, "--critical-temperature", "T",
        'temperature above which the lubricant fails, like "145 degC"')
    _add_condition(conditions, "--critical-area-fraction", "F",
        "critical area fraction: wear is severe if more of the contact is above the critical "
        "temperature, such as 10%%; 0 for the highest temperature")


def _add_evaluated_at(parser: Any) -> None:
    parser.add_argument("--at", metavar="KEY=VALUE", action=_StoreEntry, default={},
        type=partial(values.pair, like='"pin.radius=2 mm"'),
        help='evaluate at a value of a varied entry (sweep.over), such as "pin.radius=2 mm", or of '
        'a condition, such as "temperature.critical=150 degC" or "model.rise=+6 %%"; can be '
        "repeated")
    _add_conditions(parser)
    _add_without_tests(parser)
