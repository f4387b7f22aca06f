"""The commands of ``irg``, each with its options."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

from pipeline.cli import values
from pipeline.cli.options import (
    TABLE,
    add_bulk_temperature,
    add_conditions,
    add_flag,
    add_judgement,
    add_operating_point,
    add_points,
    add_quantity,
    add_realization,
    add_scene,
    add_store,
    add_value,
    add_workers,
)
from pipeline.messages import did_you_mean
from pipeline.paths import user_path

AddCommand = Callable[[str, str, str, str], argparse.ArgumentParser]
"""Function that adds a command: its name, its function, its purpose and an example."""
_LOAD_AND_VELOCITY = '--load "500 N" --velocity "2 m/s"'
_BEGIN = """Begin with:
  irg new scene.toml
  irg check scene.toml
  irg run scene.toml
  irg plot results/scene.zarr
  irg help first-hour
What a command takes:
  irg COMMAND --help"""


class _Parser(argparse.ArgumentParser):
    """Argument parser whose error is one line, and which refuses a second value of an option."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.register("action", None, _StoreOnce)  # of options without another action

    def error(self, message: str) -> NoReturn:
        """Print the fault, and how to list the options; then exit."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is no choice, and suggest the choice of a similar name."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            error.message += did_you_mean(value, action.choices or ())
            raise


class _StoreOnce(argparse.Action):
    """Action of an option with one value, of which argparse would take the last one."""

    is_set = False

    def __call__(self, parser: Any, namespace: Any, value: Any, name: str | None = None) -> None:
        if self.is_set:
            parser.error(f"{name} is given twice; give it once")
        self.is_set = True
        setattr(namespace, self.dest, value)


class _Version(argparse.Action):
    """Action of --version: look up the version, print it, and exit."""

    def __call__(self, parser: Any, *_: Any) -> None:
        print(f"irg {metadata.version('irg-transition')}")
        parser.exit()


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the arguments of one command, by default those of this process."""
    irg = whole_parser()
    options, unknown = irg.parse_known_args(arguments)
    if unknown:  # reported by the command's parser, whose help has its options
        hint = _hint(unknown[0].partition("=")[0], options.parser)
        options.parser.error(f"unknown option or argument: {' '.join(unknown)}{hint}")
    if options.parser is irg:
        irg.print_help(sys.stderr)
        irg.exit(2, "irg: give a command\n")
    _refuse_to_overwrite_an_input(options)
    return options


def _hint(word: str, command: argparse.ArgumentParser) -> str:
    """Hint for an unknown option, such as an option of a similar name; empty for other words."""
    names = re.findall(r"--?[a-z][a-z-]*", command.format_help())
    if word in names:
        return f"; options stand after the command: {command.prog} … {word}"
    if not word.startswith("-"):
        return ""
    suggestion = did_you_mean(word, names)
    if not suggestion and "--set" in names:
        return "; to change an entry of the scene, use --set KEY=VALUE"
    return suggestion


def _refuse_to_overwrite_an_input(options: argparse.Namespace) -> None:
    """Exit with an error if the output of a command is a file that it reads."""
    paths = {name: path for name, path in vars(options).items() if isinstance(path, Path)}
    out = paths.pop("output", None)
    with suppress(OSError):  # such as a name that is too long, which the command reports
        if out and out.is_file() and any(p.exists() and out.samefile(p) for p in paths.values()):
            options.parser.error(f"{out} is an input of this command; choose another output file")


def whole_parser() -> argparse.ArgumentParser:
    """Parser of all commands."""
    raw = argparse.RawDescriptionHelpFormatter
    description = "Predict when a lubricated sliding contact changes from mild to severe wear."
    irg = _Parser(prog="irg", description=description, epilog=_BEGIN, formatter_class=raw)
    irg.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = irg.add_subparsers(metavar="COMMAND", title="commands")
    irg.set_defaults(parser=irg, commands=commands.choices)

    def add(name: str, function: str, purpose: str, example: str) -> argparse.ArgumentParser:
        description = textwrap.fill(f"{purpose[0].upper()}{purpose[1:]}.")
        example = f"example:\n  irg {name} {example}"
        command = commands.add_parser(
            name, help=purpose, description=description, epilog=example, formatter_class=raw
        )
        command.set_defaults(command=name, function=function, parser=command)
        add_flag(command, "--json", "print one JSON document")
        add_flag(command, "-q --quiet", "suppress progress and notes; show errors only")
        return command

    _add_commands_on_scenes(add)
    _add_commands_on_stores(add)
    command = add(
        "help", "pipeline.cli.begin:help_", "print a page of the documentation, or list all pages",
        "first-hour",
    )  # fmt: skip
    add_value(command, "topic TOPIC", "name of a page or of a command", nargs="?")
    for package in ("pipeline.workflows", "workflows"):  # in a checkout beside `pipeline`
        if find_spec(package) and find_spec(f"{package}.commands"):
            import_module(f"{package}.commands").add_paper(add)
            break
    return irg


def _add_commands_on_scenes(add: AddCommand) -> None:
    command = add(
        "new", "pipeline.cli.begin:new", "write a scene to start from",
        "scene.toml --from twin_disc",
    )  # fmt: skip
    exclusive = command.add_mutually_exclusive_group()
    add_value(exclusive, "file FILE.toml", "file to write", user_path, nargs="?")
    add_flag(exclusive, "--list", "list the shipped scenes")
    add_value(command, "--from NAME", "shipped scene to begin with; see --list", dest="template")

    command = add(
        "run", "pipeline.cli.sweep_commands:run", "run or resume the sweep of a scene",
        "scene.toml --accuracy 2%",
    )  # fmt: skip
    add_scene(command)
    words = "path of the store; default: results/<scene>.zarr"
    add_value(command, "-o --output OUT.zarr", words, values.store)
    exclusive = command.add_mutually_exclusive_group()
    add_workers(exclusive)
    add_value(exclusive, "--scheduler ADDRESS", "address of a running Dask scheduler")
    add_value(
        exclusive, "--scheduler-file FILE", "file written by a running Dask scheduler", user_path
    )
    words = "copy matching points from another store"
    add_value(command, "--from OLD.zarr", words, values.store, dest="source")
    words = "print the address of Dask's dashboard, which every user of this machine can open"
    add_flag(command, "--dashboard", words)
    add_flag(command, "--retry-failed", "simulate points again that failed in an earlier run")
    add_flag(command, "-n --dry-run", "print what irg check prints, and compute nothing")
    words = (
        "compute until the whole numerical error of the boundary is below this, such as 2%%: it "
        "chooses preset, points and surface realizations"
    )
    add_value(command, "--accuracy BOUND", words, values.share)

    command = add(
        "check", "pipeline.cli.check:check",
        "describe a scene and estimate the cost of its sweep", "scene.toml",
    )  # fmt: skip
    add_scene(command)
    add_workers(command)
    add_value(command, *TABLE)

    command = add(
        "point", "pipeline.cli.point_commands:point",
        "simulate one point (and the tests of the scene)", f"scene.toml {_LOAD_AND_VELOCITY}",
    )  # fmt: skip
    add_scene(command)
    add_operating_point(command, required=True)
    add_flag(command, "--without-tests", "ignore the tests of the scene")
    add_realization(command)
    add_conditions(command)
    add_value(command, *TABLE)

    command = add(
        "trade", "pipeline.cli.sweep_commands:trade", "measure computing time against accuracy",
        "scene.toml -o trade.png",
    )  # fmt: skip
    add_scene(command)
    words = "new store for the points; default: results/<scene>-trade.zarr"
    add_value(command, "--store OUT.zarr", words, values.store, dest="store_path")
    add_workers(command)
    words = "file of a figure; or of the table, .csv, .md or .json"
    add_value(command, "-o --output FILE.png", words, values.writable("figure", "table"))

    command = add(
        "infer", "pipeline.cli.point_commands:infer",
        "find the critical temperature from tests, or the wear rate from a contact width",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"',
    )  # fmt: skip
    add_scene(command)
    words = "contact width measured at --load and --velocity; prints the specific wear rate instead"
    add_quantity(command, "--contact-width W", words, "348 um")
    words = "sliding time before the width was measured, ramp included; default: from the scene"
    add_quantity(command, "--duration T", words, "8 s")
    add_bulk_temperature(command)
    add_value(command, *TABLE)
    add_operating_point(command)
    add_realization(command)

    command = add(
        "surface", "pipeline.cli.figure_commands:surface",
        "describe a scan by ISO 25178-2, compare it with a random surface, and print its tables",
        'scan.npy --height-unit um --pixel-size "0.8 um" -o surface.png',
    )  # fmt: skip
    words = "map of heights: .npy, a matrix in text, or the file of an instrument"
    add_value(command, "scan SCAN", words, user_path, nargs="?")
    words = 'unit of the heights, such as "um", if the file states none or a wrong one'
    add_value(command, "--height-unit UNIT", words)
    words = 'sides of a pixel, if the file states none, like "0.8 um" or "0.8 um,0.9 um"'
    add_value(command, "--pixel-size DX[,DY]", words, values.sides)
    words = "share of missing heights up to which they are filled; default: 10%%"
    add_value(command, "--missing SHARE", words, values.share, default=0.1)
    words = "Ra of a profile or data sheet, with --rsm, without a file"
    add_quantity(command, "--ra RA", words, "0.2 um")
    add_quantity(command, "--rsm RSM", "RSm of a profile or data sheet", "60 um")
    words = "figure of the scan and of the random surface"
    add_value(command, "-o --output FILE.png", words, values.writable("figure"))


def _add_commands_on_stores(add: AddCommand) -> None:
    command = add(
        "status", "pipeline.cli.store_commands:status",
        "count done, failed and pending points of a store", "results/scene.zarr",
    )  # fmt: skip
    add_store(command)

    command = add(
        "verify", "pipeline.cli.store_commands:verify",
        "read a whole store and list damaged points", "results/scene.zarr",
    )  # fmt: skip
    add_store(command)

    command = add(
        "boundary", "pipeline.cli.store_commands:boundary",
        "print the boundary between mild and severe wear, without a new simulation",
        "results/scene.zarr --friction 0.09 --friction 0.103",
    )  # fmt: skip
    add_store(command)
    words = (
        "rows of the table: critical velocity at each load, critical load at each velocity, or "
        "tests compared with the computation; default: load"
    )
    rows = "load", "velocity", "test"
    command.add_argument("--by", default="load", choices=rows, help=words)
    add_flag(command, "--all", "print all rows and notes")
    add_value(command, *TABLE)
    add_judgement(command)

    command = add(
        "margin", "pipeline.cli.store_commands:margin",
        "print verdict, probability and errors for one operating point, a table of them, or the "
        "cases of the sweep",
        f"results/scene.zarr {_LOAD_AND_VELOCITY}",
    )  # fmt: skip
    add_store(command)
    add_operating_point(command)
    add_points(command)
    add_flag(command, "--all", "print all rows and notes")
    add_value(command, *TABLE)
    add_judgement(command)

    command = add(
        "plot", "pipeline.cli.figure_commands:plot", "draw a figure of a store",
        'results/scene.zarr --kind ramp --load "600 N" --velocity "1.6 m/s"',
    )  # fmt: skip
    add_store(command)
    words = "default: diagram, or rows if each has its own load and velocity"
    kinds = "diagram", "rows", "ramp", "fields", "tests"
    command.add_argument("--kind", choices=kinds, help=words)
    add_value(command, "-o --output FILE.png", "figure file; default: next to the store", user_path)
    words = "width of the figure; text shrinks less than the figure does"
    add_quantity(command, "--width W", words, "8.5 cm")
    add_value(command, "--title TITLE", "title of the figure; default: that of the scene")
    add_flag(command, "--plain", "omit title and caption")
    add_value(command, "--dpi DPI", "resolution in dots per inch; default: 150", values.count)
    add_flag(command, "--log", "draw the diagram on logarithmic axes")
    words = "step of fields, counted back from the end of a point: 0, -1, ..."
    add_value(command, "--step N", words, int)
    add_judgement(command)
    add_operating_point(command, action="append", default=[])
    add_realization(command)

    command = add(
        "report", "pipeline.cli.figure_commands:report",
        "write a report to print and pass on: verdict, diagram, boundary, tests, errors, limits",
        f"results/scene.zarr {_LOAD_AND_VELOCITY} -o report.html",
    )  # fmt: skip
    add_store(command)
    add_operating_point(command)
    add_points(command)
    words = "file of the report; default: next to the store"
    add_value(command, "-o --output FILE.html", words, user_path)
    add_value(command, "--title TITLE", "title of the report; default: that of the scene")
    add_value(command, "--author NAME", "name of the author")
    add_judgement(command)
