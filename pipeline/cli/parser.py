"""Commands of ``irg``: their table, and the parser that is made of it."""

from __future__ import annotations

import argparse
import os
import pkgutil
import re
import sys
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from difflib import get_close_matches
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NoReturn

from pipeline import extras
from pipeline.cli import options as o
from pipeline.cli.completion import OFFERED
from pipeline.cli.options import Command

FIRST = ("new", "check", "run", "status", "boundary", "margin", "plot", "help")
"""Commands that everybody needs, in the order of work."""
_AT = '--load "500 N" --velocity "2 m/s"'

COMMANDS = (
    Command(
        "new", "begin:new",
        "write a scene to start from; --full has every entry",
        "scene.toml --from twin_disc", o.OF_NEW,
    ),
    Command(
        "run", "sweeps:run", "run or resume the sweep of a scene",
        "scene.toml --accuracy 2%", (*o.OF_SCENE, *o.OF_RUN),
    ),
    Command(
        "check", "sweeps:check", "print the meaning of a scene, and the cost of its sweep",
        "scene.toml --accuracy 2%", (*o.OF_SCENE, o.WORKERS, o.BOUNDARY_ONLY, o.ACCURACY, o.TABLE),
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
        (o.STORE, o.TABLE, *o.WEIGHED, o.AT, o.CONDITIONS_AT_FRICTIONS),
    ),
    Command(
        "margin", "verdicts:margin",
        "verdict on operating points, its probability and errors: one, a table, or rows of pairs",
        f"results/scene.zarr {_AT}",
        (
            o.STORE, *o.PLACE, *o.POINTS, o.TABLE, *o.WEIGHED, o.AT, o.CONDITIONS_AT_FRICTIONS,
        ),
    ),
    Command(
        "diff", "stores:diff",
        "differences between two stores: of scenes, boundaries and points",
        "results/scene.zarr results/other.zarr",
        (o.STORE, o.OTHER_STORE, o.AT, o.OIL, o.TABLE, o.CRITERION),
    ),
    Command(
        "vary", "studies:vary",
        "find the boundary for each value of some inputs, one input at a time",
        "scene.toml --over friction.coefficient=0.08,0.12 --over wear.specific_wear_rate=-20%,+20%",
        (*o.OF_SCENE, o.OVER, o.FIGURE_OR_TABLE, *o.KEPT),
    ),
    Command(
        "point", "points:point", "simulate one point", f"scene.toml {_AT}",
        (*o.OF_SCENE, *o.NEEDED_PLACE, o.REALIZATION, o.CONDITIONS, o.ACCURACY, o.TABLE),
    ),
    Command(
        "trade", "studies:trade", "measure speed against accuracy",
        "scene.toml -o trade.png", (*o.OF_SCENE, o.FIGURE_OR_TABLE),
    ),
    Command(
        "plot", "figures:plot", "draw a figure of a store",
        'results/scene.zarr --kind ramp --load "600 N" --velocity "1.6 m/s"',
        (
            o.STORE, *o.OF_PLOT, *o.WEIGHED, o.AT, o.CONDITIONS_AT_FRICTIONS,
            *o.PLACE, o.REALIZATION,
        ),
    ),
    Command(
        "help", "begin:help_", "print a page of the documentation, or list them",
        "first-hour", (o.TOPIC,),
    ),
)  # fmt: skip


@cache
def commands() -> tuple[Command, ...]:
    """All commands, those of extras last."""
    return (*COMMANDS, *(one for module in extras.modules("commands") for one in module.COMMANDS))


class _Help(argparse.HelpFormatter):
    """Help in which an example stays on one line, so that it can be copied."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return "\n".join(
            line if line.startswith("  ") else textwrap.fill(line, width)
            for line in text.split("\n")
        )


class _Parser(argparse.ArgumentParser):
    """Parser with such help, in which words such as -5% are values, as from Python 3.14 on."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(formatter_class=_Help, **settings)
        # A private name of argparse; not needed once 3.14 is the oldest Python.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        """Print one line: what is wrong, what was perhaps meant, and where options are listed."""
        if wrong := re.fullmatch(r"argument (.*): invalid choice: '(.*?)' \(choose.*\)", message):
            words = re.findall(r"[\w-]+", message.partition("(choose from")[2])
            if near := get_close_matches(wrong[2], words, 1):
                message = f"{wrong[1].lower()} is {wrong[2]!r}; did you mean {near[0]!r}?"
                self.exit(2, f"{self.prog}: {message} See {self.prog} --help\n")
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def whole_parser() -> argparse.ArgumentParser:
    """Parser of all commands."""
    parser = _Parser(
        prog="irg",
        description="Predict where a lubricated sliding contact goes from mild to severe wear.\n\n"
        + "\n".join(_listed()),
        epilog="Begin with:\n  irg new scene.toml\n  irg check scene.toml\n  irg run scene.toml\n"
        "  irg plot results/scene.zarr\n  irg help first-hour\n"
        "What a command takes:\n  irg COMMAND --help\n"
        "Completion in bash and zsh, with argcomplete installed:\n"
        '  eval "$(register-python-argcomplete irg)"',
    )
    parser.add_argument(
        "--version",
        action="version",
        version=f"irg {_version()}",
        help="print the version and exit",
    )
    parser.set_defaults(parser=parser)
    parsers = parser.add_subparsers(metavar="COMMAND", help="one of these; see irg COMMAND --help")
    for command in commands():
        _add(parsers, command)
    return parser


def _listed() -> Iterator[str]:
    """Commands with their purposes: those that everybody needs, the others, and those of extras."""
    named = {command.name: command for command in COMMANDS}
    others = [command for command in COMMANDS if command.name not in FIRST]
    groups = {
        "what everybody needs": [named[name] for name in FIRST],
        "further": others,
        "extras": commands()[len(COMMANDS) :],
    }
    for group, members in groups.items():
        yield from [f"{group}:"] if members else ()
        for command in members:
            begin = f"  {command.name:<13} "
            rest = " " * len(begin)
            yield textwrap.fill(command.purpose, 78, initial_indent=begin, subsequent_indent=rest)


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the options of one command; `function_of` gives its function."""
    parser = whole_parser()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks what may follow
        with suppress(ImportError):  # that extra may not be installed
            import argcomplete

            argcomplete.autocomplete(parser)
    options, unknown = parser.parse_known_args(arguments)
    if unknown:  # an error of the command, whose usage shows its options
        flags = re.findall(r"--[a-z-]+", options.parser.format_usage())
        near = get_close_matches(unknown[0].partition("=")[0], flags, 1)
        hint = f'did you mean "{near[0]}"?' if near else "options stand after the command"
        options.parser.error(f"unknown option or argument: {' '.join(unknown)}; {hint}")
    if options.parser is parser:
        parser.print_help(sys.stderr)
        parser.exit(2, "irg: give a command\n")
    for out in (value for name, value in vars(options).items() if name in o.WRITTEN and value):
        if os.path.realpath(out) in _files_read(options):
            options.parser.error(f"{out} is read by this command; name another file to write")
    return options


def _files_read(options: argparse.Namespace) -> set[str]:
    """Real paths of the files that a command is given to read, and of all that its scene names."""
    taken = [value for name, value in vars(options).items() if name not in o.WRITTEN]
    paths = [Path(x) for x in taken if isinstance(x, str | Path) and Path(x).is_file()]
    found = set[str]()
    while paths:
        file, text = os.path.realpath(path := paths.pop()), ""
        if path.suffix == ".toml" and file not in found:
            with suppress(OSError):  # which the command tells
                text = path.read_text("utf-8", errors="replace")
        named = (path.parent / name for name in re.findall(r"""["']([^"'\n]+)["']""", text))
        paths += [one for one in named if os.path.isfile(one)]  # noqa: PTH113 — long names, too
        found.add(file)
    return found


def _version() -> str:
    try:
        return version("irg-transition")
    except PackageNotFoundError:
        return "of unknown version, since it is not installed"


def function_of(options: argparse.Namespace) -> Callable[[argparse.Namespace], Any]:
    """Function of a command, whose module is imported now, for this command alone."""
    is_whole = options.command.startswith("pipeline.")  # as of an extra
    name = options.command if is_whole else f"pipeline.cli.{options.command}"
    function: Callable[[argparse.Namespace], Any] = pkgutil.resolve_name(name)
    return function


def _add(parsers: Any, command: Command) -> None:
    """Add the parser of a command."""
    added = parsers.add_parser(
        command.name,
        description=f"{command.purpose[0].upper()}{command.purpose[1:]}.",
        epilog=f"example:\n  irg {command.name} {command.example}",
    )
    added.set_defaults(command=command.function, parser=added)
    for taken in (*o.OF_ALL, *command.takes):
        if isinstance(taken, o.Option):
            _add_option(added, taken)
            continue
        group = (
            added.add_argument_group(taken.title)
            if taken.title
            else added.add_mutually_exclusive_group()
        )
        for option in taken.options:
            _add_option(group, option)


def _add_option(parser: Any, option: o.Option) -> None:
    """Add an option, with what a shell offers for it."""
    action = parser.add_argument(*option.names, **option.settings)
    action.completer = OFFERED.get(action.dest)
