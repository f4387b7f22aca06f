"""Parse the arguments of ``irg``."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

from pipeline.cli.command_table import COMMANDS, Group, Option, flag
from pipeline.messages import did_you_mean

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
        if (
            out
            and out.is_file()
            and any(path.exists() and out.samefile(path) for path in paths.values())
        ):
            options.parser.error(f"{out} is an input of this command; choose another output file")


def whole_parser() -> argparse.ArgumentParser:
    """Parser of all commands."""
    irg = _Parser(
        prog="irg",
        description="Predict when a lubricated sliding contact changes from mild to severe wear.",
        epilog=_BEGIN,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    irg.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    parsers = irg.add_subparsers(metavar="COMMAND", title="commands")
    irg.set_defaults(parser=irg, commands=parsers.choices)
    commands = [*COMMANDS]
    for package in ("pipeline.workflows", "workflows"):  # in a checkout beside `pipeline`
        if find_spec(package) and find_spec(f"{package}.commands"):
            commands.append(import_module(f"{package}.commands").PAPER)
            break
    for command in commands:
        parser = parsers.add_parser(
            command.name,
            help=command.purpose,
            description=textwrap.fill(f"{command.purpose[0].upper()}{command.purpose[1:]}."),
            epilog=f"example:\n  irg {command.name} {command.example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        parser.set_defaults(command=command.name, function=command.function, parser=parser)
        _add(parser, flag("--json", "print one JSON document"))
        _add(parser, flag("-q --quiet", "suppress progress and notes; show warnings and errors"))
        for option in command.options:
            _add(parser, option)
    return irg


def _add(parser: Any, option: Option | Group) -> None:
    """Add an option, or all of a group, to the parser of a command."""
    if isinstance(option, Option):
        parser.add_argument(*option.names, **option.settings)
        return
    if option.title:
        group = parser.add_argument_group(option.title)
    else:
        group = parser.add_mutually_exclusive_group()
    for member in option.options:
        _add(group, member)
