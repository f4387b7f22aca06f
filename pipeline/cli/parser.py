"""Commands of ``irg``: their table, and the parser made from it."""

from __future__ import annotations

import argparse
import pkgutil
import re
import sys
import textwrap
from collections.abc import Callable, Sequence
from contextlib import suppress
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

from pipeline.cli import options as o
from pipeline.cli.options import Command

_AT = '--load "500 N" --velocity "2 m/s"'

COMMANDS = (
    Command(
        "new", "begin:new",
        "write a scene to start from",
        "scene.toml --from twin_disc", o.OF_NEW,
    ),
    Command(
        "run", "sweeps:run", "run or resume the sweep of a scene",
        "scene.toml --accuracy 2%", (*o.OF_SCENE, *o.OF_RUN),
    ),
    Command(
        "check", "check:check", "print the meaning of a scene, and the cost of its sweep",
        "scene.toml", (*o.OF_SCENE, o.WORKERS, o.TABLE),
    ),
    Command(
        "status", "stores:status",
        "count the points done, failed and pending; or list the stores of a folder",
        "results", (o.STORE_OR_FOLDER,),
    ),
    Command(
        "verify", "stores:verify", "read a whole store and name each damaged point",
        "results/scene.zarr", (o.STORE,),
    ),
    Command(
        "boundary", "verdicts:boundary",
        "find the transition from mild to severe wear, without a new simulation",
        "results/scene.zarr --friction 0.09 --friction 0.103",
        (o.STORE, *o.OF_BOUNDARY, o.TABLE, *o.JUDGED),
    ),
    Command(
        "margin", "verdicts:margin",
        "verdict on operating points, its probability and errors: one, a table, or rows of pairs",
        f"results/scene.zarr {_AT}",
        (o.STORE, *o.PLACE, *o.POINTS, o.ALL, o.TABLE, *o.JUDGED),
    ),
    Command(
        "point", "points:point", "simulate one point and the tests of its scene",
        f"scene.toml {_AT}",
        (*o.OF_SCENE, *o.NEEDED_PLACE, o.WITHOUT_TESTS, o.REALIZATION, o.CONDITIONS, o.TABLE),
    ),
    Command(
        "trade", "studies:trade", "measure speed against accuracy",
        "scene.toml -o trade.png", (*o.OF_SCENE, *o.OF_TRADE),
    ),
    Command(
        "infer", "infer:infer",
        "find the critical temperature from tests, or a wear rate from a contact width",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"', o.OF_INFER,
    ),
    Command(
        "plot", "figures:plot", "draw a figure of a store",
        'results/scene.zarr --kind ramp --load "600 N" --velocity "1.6 m/s"',
        (o.STORE, *o.OF_PLOT, *o.JUDGED, *o.PLACE, o.REALIZATION),
    ),
    Command(
        "surface", "surface:surface",
        "describe a scan by ISO 25178-2, beside a random surface like it, and print its tables",
        'scan.npy --height-unit um --pixel-size "0.8 um" -o surface.png', o.OF_SURFACE,
    ),
    Command(
        "report", "figures:report",
        "write a report to print and pass on: verdict, diagram, boundary, tests, errors, limits",
        f"results/scene.zarr {_AT} -o report.html",
        (o.STORE, *o.PLACE, *o.POINTS, *o.OF_REPORT, *o.JUDGED),
    ),
    Command(
        "help", "begin:help_", "print a page of the documentation, or list them",
        "first-hour", (o.TOPIC,),
    ),
)  # fmt: skip


@cache
def commands() -> tuple[Command, ...]:
    """All commands of ``irg``; that of the paper comes last, where its folder is there."""
    for package in ("pipeline.workflows", "workflows"):  # in a checkout beside `pipeline`
        if find_spec(package) and find_spec(f"{package}.commands"):
            return (*COMMANDS, *import_module(f"{package}.commands").COMMANDS)
    return COMMANDS


class _Parser(argparse.ArgumentParser):
    """Argument parser that takes words such as -5% for values, as Python 3.14 does."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **settings)
        # A private name of argparse; not needed once 3.14 is the oldest Python.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        """Print one line, with the fault, a suggestion, and how to list the options; then exit."""
        if wrong := re.fullmatch(r"argument (.*): invalid choice: '(.*?)' \((choose.*)\)", message):
            near = get_close_matches(wrong[2], re.findall(r"[\w-]+", wrong[3]), 1)
            meant = f"; did you mean {near[0]!r}?" if near else f" ({wrong[3]})"
            message = f"{wrong[1].lower()} is {wrong[2]!r}{meant}"
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


class _Version(argparse.Action):
    """Action of --version: look up the version, print it, and exit."""

    def __call__(self, parser: Any, *_: Any) -> None:
        from importlib.metadata import PackageNotFoundError, version

        try:
            installed = version("irg-transition")
        except PackageNotFoundError:
            installed = "of unknown version: not installed"
        print(f"irg {installed}")
        parser.exit()


_BEGIN = """Begin with:
  irg new scene.toml
  irg check scene.toml
  irg run scene.toml
  irg plot results/scene.zarr
  irg help first-hour
What a command takes:
  irg COMMAND --help"""


def whole_parser(name: str | None = None) -> argparse.ArgumentParser:
    """Parser of all commands, with the options of command `name` only; of all if None."""
    parser = _Parser(
        prog="irg",
        description="Predict where a lubricated sliding contact goes from mild to severe wear.",
        epilog=_BEGIN,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    parser.set_defaults(parser=parser)
    parsers = parser.add_subparsers(metavar="COMMAND", title="commands")
    for command in commands():
        added = parsers.add_parser(
            command.name,
            help=command.purpose.replace("%", "%%"),
            description=textwrap.fill(f"{command.purpose[0].upper()}{command.purpose[1:]}."),
            epilog=f"example:\n  irg {command.name} {command.example}",
        )
        added.set_defaults(command=command.function, parser=added)
        if name in (None, command.name):
            _add_options(added, (*o.OF_ALL, *command.takes))
    return parser


def _add_options(parser: Any, takes: Sequence[o.Option | o.OptionGroup]) -> None:
    """Add to a parser the options and groups of options that a command takes."""
    for taken in takes:
        if isinstance(taken, o.Option):
            parser.add_argument(*taken.names, **taken.settings)
        elif taken.title:
            _add_options(parser.add_argument_group(taken.title), taken.options)
        else:
            _add_options(parser.add_mutually_exclusive_group(), taken.options)


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the arguments of one command; `function_of` gives its function."""
    given = sys.argv[1:] if arguments is None else arguments
    parser = whole_parser(next((word for word in given if not word.startswith("-")), ""))
    options, unknown = parser.parse_known_args(given)
    if unknown:  # reported by the command's parser, whose usage has its options
        flags = re.findall(r"--[a-z-]+", options.parser.format_usage())
        near = get_close_matches(unknown[0].partition("=")[0], flags, 1)
        hint = f'did you mean "{near[0]}"?' if near else "options stand after the command"
        options.parser.error(f"unknown option or argument: {' '.join(unknown)}; {hint}")
    if options.parser is parser:
        parser.print_help(sys.stderr)
        parser.exit(2, "irg: give a command\n")
    paths = {name: value for name, value in vars(options).items() if isinstance(value, str | Path)}
    read = [Path(value) for name, value in paths.items() if name not in o.WRITTEN]
    for out in (Path(value) for name, value in paths.items() if name in o.WRITTEN):
        with suppress(OSError):  # such as a name that is too long, which the command reports
            if out.is_file() and any(one.exists() and out.samefile(one) for one in read):
                options.parser.error(f"{out} is read by this command; name another file to write")
    return options


def function_of(options: argparse.Namespace) -> Callable[[argparse.Namespace], Any]:
    """Function of a command; imports the command's module."""
    is_whole = "." in options.command  # a command of an extra
    name = options.command if is_whole else f"pipeline.cli.{options.command}"
    function: Callable[[argparse.Namespace], Any] = pkgutil.resolve_name(name)
    return function
