"""Commands of ``irg``: their table, and the parser made from it."""

from __future__ import annotations

import argparse
import itertools
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
        "check", "check:check", "describe a scene and estimate the cost of its sweep",
        "scene.toml", (*o.OF_SCENE, o.WORKERS, o.TABLE),
    ),
    Command(
        "status", "stores:status",
        "count done, failed and pending points of a store, or list the stores in a folder",
        "results", (o.STORE_OR_FOLDER,),
    ),
    Command(
        "verify", "stores:verify", "read a whole store and list damaged points",
        "results/scene.zarr", (o.STORE,),
    ),
    Command(
        "boundary", "verdicts:boundary",
        "print the boundary between mild and severe wear, without a new simulation",
        "results/scene.zarr --friction 0.09 --friction 0.103",
        (o.STORE, *o.OF_BOUNDARY, o.TABLE, *o.JUDGED),
    ),
    Command(
        "margin", "verdicts:margin",
        "print verdict, probability and errors for one operating point, a table of them, or the "
        "cases of the sweep",
        f"results/scene.zarr {_AT}",
        (o.STORE, *o.PLACE, *o.POINTS, o.ALL, o.TABLE, *o.JUDGED),
    ),
    Command(
        "point", "points:point", "simulate one point (and the tests of the scene)",
        f"scene.toml {_AT}",
        (*o.OF_SCENE, *o.NEEDED_PLACE, o.WITHOUT_TESTS, o.REALIZATION, o.CONDITIONS, o.TABLE),
    ),
    Command(
        "trade", "studies:trade", "measure computing time against accuracy",
        "scene.toml -o trade.png", (*o.OF_SCENE, *o.OF_TRADE),
    ),
    Command(
        "infer", "infer:infer",
        "find the critical temperature from tests, or the wear rate from a contact width",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"', o.OF_INFER,
    ),
    Command(
        "plot", "figures:plot", "draw a figure of a store",
        'results/scene.zarr --kind ramp --load "600 N" --velocity "1.6 m/s"',
        (o.STORE, *o.OF_PLOT, *o.JUDGED, *o.PLACES, o.REALIZATION),
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
        "help", "begin:help_", "print a page of the documentation, or list all pages",
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
            known = [*re.findall(r"[\w-]+", wrong[3]), *["--version"] * (wrong[1] == "COMMAND")]
            meant = _meant([wrong[2]], known) or f" ({wrong[3]})"
            message = f'{wrong[1].lower()} is "{wrong[2]}"{meant}'
        message = message.removeprefix("argument ").replace(": is given twice", " is given twice")
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


class _Once(argparse.Action):
    """Action of an option with one value, which is not given twice."""

    def __call__(self, parser: Any, namespace: Any, value: Any, name: str | None = None) -> None:
        if self.dest in vars(namespace).setdefault("given", set()):
            raise argparse.ArgumentError(self, "is given twice; give it once")
        namespace.given.add(self.dest)
        setattr(namespace, self.dest, value)


_SYNONYMS = {
    "new": "init create start template",
    "run": "simulate compute sweep resume",
    "check": "validate lint estimate",
    "status": "info list ls",
    "boundary": "limit transition",
    "margin": "judge verdict predict",
    "plot": "draw figure diagram show",
    "infer": "fit calibrate",
    "help": "doc docs man",
    "--version": "version",
    "--load": "force normal-load normal-force",
    "--velocity": "speed sliding-speed sliding-velocity",
    "--friction": "mu cof",
    "--bulk-temperature": "temperature bulk oil-temperature",
    "--workers": "jobs cores threads processes",
    "--output": "file outfile",
    "--realization": "seed",
    "--from": "template like",
    "--points": "csv table",
    "--set": "option setting config",
    "--accuracy": "error tolerance precision",
}
"""Words of other tools for commands and options, without hyphens in front."""
_IN_SCENE = {
    "--load": "sweep.loads",
    "--velocity": "sweep.velocities",
    "--friction": "friction.coefficient",
    "--bulk-temperature": "temperature.bulk",
    "--critical-temperature": "temperature.critical",
    "--critical-area-fraction": "temperature.critical_area_fraction",
}
"""Entries of a scene, by the options that other commands have for them."""
_ALIKE = 0.75  # least likeness of a misspelt word: "version" is not "verify", nor "init" "point"


def _meant(words: Sequence[str], known: Sequence[str]) -> str:
    """Question such as "; did you mean X?": names of the meaning of `words`, or misspelt."""
    found = list[str]()
    for word in words:
        bare = word.lstrip("-").lower()
        same = [name for name, others in _SYNONYMS.items() if bare in others.split()]
        near = [name for name in same if name in known]
        if not near and "--set" in known:
            near = [f"--set {_IN_SCENE[one]}=…" for one in (word, *same) if one in _IN_SCENE]
        found += near or get_close_matches(word.lower(), known, 1, _ALIKE)
    names = " and ".join(f'"{name}"' for name in dict.fromkeys(found))
    return f"; did you mean {names}?" if found else ""


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
        description="Predict when a lubricated sliding contact changes from mild to severe wear.",
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
            once = {"action": _Once} if taken.names[0].startswith("-") else {}
            parser.add_argument(*taken.names, **once | taken.settings)
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
        words = [one.partition("=")[0] for one in unknown if one.startswith("-")] or unknown[:1]
        takes = [one.takes for one in commands() if options.parser.prog == f"irg {one.name}"]
        flags = _flags([*o.OF_ALL, *itertools.chain(*takes)])
        flags += ["--version"] * (options.parser is parser)
        hint = _meant(words, flags)
        if words[0] in flags:
            hint = f"; options stand after the command: {options.parser.prog} … {words[0]}"
        options.parser.error(f"unknown option or argument: {' '.join(unknown)}{hint}")
    if options.parser is parser:
        parser.print_help(sys.stderr)
        parser.exit(2, "irg: give a command\n")
    paths = {name: value for name, value in vars(options).items() if isinstance(value, str | Path)}
    read = [Path(value) for name, value in paths.items() if name not in o.WRITTEN]
    for out in (Path(value) for name, value in paths.items() if name in o.WRITTEN):
        with suppress(OSError):  # such as a name that is too long, which the command reports
            if out.is_file() and any(one.exists() and out.samefile(one) for one in read):
                options.parser.error(
                    f"{out} is an input of this command; choose another output file"
                )
    return options


def _flags(takes: Sequence[o.Option | o.OptionGroup]) -> list[str]:
    """Names of options, as typed."""
    found = list[str]()
    for taken in takes:
        found += _flags(taken.options) if isinstance(taken, o.OptionGroup) else taken.names
    return [name for name in found if name.startswith("-")]


def function_of(options: argparse.Namespace) -> Callable[[argparse.Namespace], Any]:
    """Function of a command; imports the command's module."""
    is_whole = "." in options.command  # a command of an extra
    name = options.command if is_whole else f"pipeline.cli.{options.command}"
    function: Callable[[argparse.Namespace], Any] = pkgutil.resolve_name(name)
    return function
