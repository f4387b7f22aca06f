"""What can be typed after ``irg``: the commands and their options, a function for each."""

from __future__ import annotations

import argparse
import os
import pkgutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.cli import values
from tribo import PRESETS

Command = Callable[[argparse.Namespace], int]


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the options of one command; `function_of` gives its function."""
    parser = argparse.ArgumentParser(
        prog="irg",
        description="Predict where a lubricated sliding contact goes from mild to severe wear.",
        epilog="Begin with: irg new scene.toml. What a command takes: irg COMMAND --help. "
        'Completion in bash and zsh: eval "$(register-python-argcomplete irg)".',
    )
    parser.add_argument(
        "--version", action=values.Version, nargs=0, help="print the version and exit"
    )
    commands = _Commands(parser.add_subparsers(metavar="COMMAND", required=True))
    for add in (
        _new, _run, _check, _status, _verify, _compact, _boundary, _margin, _vary, _point,
        _infer, _risk, _sensitivity, _trade, _reproduce, _plot, _explore,
    ):  # fmt: skip
        add(commands)
    if "_ARGCOMPLETE" in os.environ:  # a shell asks what may follow
        import argcomplete

        argcomplete.autocomplete(parser)
    options, unknown = parser.parse_known_args(arguments)
    if unknown:  # told by the command, whose usage shows what it takes
        options.parser.error(f"unknown option or argument: {' '.join(unknown)}")
    return options


def function_of(options: argparse.Namespace) -> Command:
    """Return the function of a command; its module is imported now, for this command alone."""
    function: Command = pkgutil.resolve_name(f"pipeline.cli.{options.command}")
    return function


class _Commands(NamedTuple):
    """The commands so far; the function of each by its module in this folder, and its name."""

    parsers: Any

    def add(self, name: str, function: str, what: str, example: str) -> argparse.ArgumentParser:
        added: argparse.ArgumentParser = self.parsers.add_parser(
            name,
            help=what,
            description=f"{what[0].upper()}{what[1:]}.",
            epilog=f"example: irg {name} {example.replace('%', '%%')}",
        )
        added.set_defaults(command=function, parser=added)
        added.add_argument("--json", action="store_true", help="print one JSON document")
        added.add_argument(
            "-q", "--quiet", action="store_true", help="show no progress and no notes, only errors"
        )
        return added

    def on_scene(
        self, name: str, function: str, what: str, options: str = ""
    ) -> argparse.ArgumentParser:
        added = self.add(name, function, what, f"workflows/irg_transition.toml {options}".strip())
        added.add_argument("scene", metavar="SCENE.toml", type=Path, help="the scene file")
        added.add_argument(
            "--preset",
            metavar="NAME",
            help=f"fidelity in place of the scene's own: {', '.join(PRESETS)}",
        )
        added.add_argument(
            "--set",
            metavar="KEY=VALUE",
            type=values.setting,
            action="append",
            default=[],
            help="another numerical choice, such as increments=50, or another entry of the "
            "scene, such as wear.pattern=local; may be repeated",
        )
        return added

    def on_store(
        self, name: str, function: str, what: str, options: str = ""
    ) -> argparse.ArgumentParser:
        added = self.add(name, function, what, f"results/irg_transition.zarr {options}".strip())
        added.add_argument(
            "store", metavar="OUT.zarr", type=values.store, help="a store that irg run has made"
        )
        return added


def _new(commands: _Commands) -> None:
    what = "write a commented scene to start from: all tables, keys, units and defaults"
    parser = commands.add("new", "begin:new", what, "scene.toml --from twin_disc")
    parser.add_argument("file", metavar="FILE.toml", type=Path, nargs="?", help="file to write")
    parser.add_argument(
        "--from", metavar="NAME", dest="like", help="shipped scene to begin with; see --list"
    )
    parser.add_argument("--list", action="store_true", help="list the shipped scenes")


def _run(commands: _Commands) -> None:
    parser = commands.on_scene(
        "run", "sweeps:run", "run or resume the sweep of a scene", "--accuracy 2%"
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="OUT.zarr",
        type=values.store,
        help="where to store it; default: results/<scene>.zarr",
    )
    where = parser.add_mutually_exclusive_group()
    _add_workers(where)
    where.add_argument("--scheduler", metavar="ADDRESS", help="a running Dask scheduler to use")
    parser.add_argument(
        "--fill-fields",
        action="store_true",
        help="compute points again that were finished before the scene asked for fields",
    )
    parser.add_argument("--retry-failed", action="store_true", help="compute failed points again")
    parser.add_argument(
        "--boundary-only",
        metavar="TOLERANCE",
        nargs="?",
        const=0.01,
        type=values.share,
        help="choose velocities until the boundary is known to this tolerance; default: 1%%",
    )
    _add_accuracy(parser)


def _check(commands: _Commands) -> None:
    what = "say what a scene means, what would run and what it would cost"
    _add_workers(commands.on_scene("check", "sweeps:check", what))


def _status(commands: _Commands) -> None:
    commands.on_store("status", "stores:status", "count the points done, failed and pending")


def _verify(commands: _Commands) -> None:
    what = "read a whole store and name each damaged point"
    parser = commands.on_store("verify", "stores:verify", what, "--repair")
    parser.add_argument(
        "--repair", action="store_true", help="set damaged points to be computed again"
    )


def _compact(commands: _Commands) -> None:
    commands.on_store("compact", "stores:compact", "rewrite a store in few files, to open faster")


def _boundary(commands: _Commands) -> None:
    what = "find the transition from mild to severe wear, without a new simulation"
    parser = commands.on_store(
        "boundary", "results:boundary", what, "--friction 0.09 --friction 0.103"
    )
    _add_output(parser, "TABLE.csv", "write the table to a file, .csv or .md")
    _add_conditions(parser)


def _margin(commands: _Commands) -> None:
    parser = commands.on_store(
        "margin",
        "margins:margin",
        "tell how far an operating point lies from severe wear",
        '--load "500 N" --velocity "2 m/s"',
    )
    _add_place(parser, required=True, surface=False)
    _add_conditions(parser, several=False)


def _vary(commands: _Commands) -> None:
    parser = commands.on_scene(
        "vary",
        "variations:vary",
        "find the boundary for each value of some inputs, one input at a time",
        "--over friction.coefficient=0.08,0.12 --over wear.specific_wear_rate=-20%,+20%",
    )
    parser.add_argument(
        "--over",
        metavar="KEY=VALUE,VALUE",
        type=values.settings,
        action="append",
        required=True,
        help="an entry of the scene, and the values to give it; such as -20%%,+20%% of the "
        "scene's own; may be repeated",
    )
    _add_output(parser, "FILE.png", "draw a figure; or write a table, to .csv or .md")


def _point(commands: _Commands) -> None:
    parser = commands.on_scene(
        "point", "results:point", "simulate one point", '--load "600 N" --velocity "1.5 m/s"'
    )
    _add_place(parser, required=True)
    _add_conditions(parser, several=False)
    _add_accuracy(parser)


def _infer(commands: _Commands) -> None:
    parser = commands.on_scene(
        "infer",
        "results:infer",
        "find the critical temperature from measured transitions, or a wear rate from a width; of "
        "a store of samples, what the transitions say of all its unknown inputs",
    )
    parser.add_argument(
        "--next",
        action="store_true",
        help="of a store of samples: rank what to measure next",
    )
    _add_scatter(parser)
    parser.add_argument(
        "--contact-width",
        metavar="W",
        type=values.quantity("348 um"),
        help='width measured at --load and --velocity, like "348 um": find the specific wear '
        "rate instead",
    )
    _add_bulk(parser)
    _add_output(
        parser,
        "TABLE.csv",
        "write the table to .csv or .md; of samples, or draw a figure",
    )
    _add_place(parser)


def _risk(commands: _Commands) -> None:
    parser = commands.on_store(
        "risk",
        "unknowns:risk",
        "find the probability of severe wear, where inputs are not known exactly",
        '--load "400 N" --velocity "2 m/s"',
    )
    _add_place(parser, surface=False)
    _add_output(parser, "FILE.png", "draw a figure; or write a table, to .csv or .md")
    _add_measured(parser)


def _sensitivity(commands: _Commands) -> None:
    parser = commands.on_store(
        "sensitivity",
        "unknowns:sensitivity",
        "tell which unknown input moves the boundary how much (Sobol' indices)",
        "-o sensitivity.png",
    )
    _add_output(parser, "FILE.png", "draw a figure; or write a table, to .csv or .md")
    _add_measured(parser)


def _add_measured(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--given-measured",
        action="store_true",
        help="let the measured transitions of the scene say what they do of the inputs",
    )
    _add_scatter(parser)


def _add_scatter(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--scatter",
        metavar="SHARE",
        type=values.share,
        help="relative standard deviation of the measured velocities; default: 5%%",
    )


def _trade(commands: _Commands) -> None:
    parser = commands.on_scene(
        "trade", "studies:trade", "measure speed against accuracy", "-o trade.png"
    )
    parser.add_argument(
        "--base", metavar="NAME", default="fine", help="preset to vary choice by choice"
    )
    parser.add_argument("--diagram", action="store_true", help="compare whole small diagrams")
    _add_output(parser, "FILE.png", "draw a figure; or write a table, to .csv or .md")


def _reproduce(commands: _Commands) -> None:
    parser = commands.add(
        "reproduce",
        "studies:reproduce",
        "recompute a figure or table of the paper, beside what it prints",
        "table4",
    )
    parser.add_argument("name", metavar="NAME", nargs="?", help="one of --list, or all")
    parser.add_argument("--list", action="store_true", help="list the figures and tables")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE.png",
        type=Path,
        help="figure; for all, the folder of the page that shows them",
    )
    parser.add_argument("--preset", metavar="NAME", help=f"fidelity: {', '.join(PRESETS)}")
    parser.add_argument(
        "--surfaces", metavar="N", type=values.count, help="number of random surfaces"
    )
    parser.add_argument("--workers", metavar="N", type=values.count, help="workers for the diagram")


def _plot(commands: _Commands) -> None:
    parser = commands.on_store("plot", "results:plot", "draw a figure of a store", "--kind ramp")
    parser.add_argument(
        "--kind",
        default="diagram",
        choices=("diagram", "ramp", "fields", "temperature", "histogram"),
        help="default: diagram; temperature is over the velocity, histogram over the contact",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE.png",
        type=Path,
        help="where to write it; default: beside the store",
    )
    parser.add_argument(
        "--width",
        metavar="W",
        type=values.quantity("8.5 cm"),
        help='width of the figure, like "8.5 cm"; words stay readable',
    )
    parser.add_argument("--dpi", metavar="N", type=values.count, help="dots per inch of a .png")
    parser.add_argument("--no-title", action="store_true", help="leave the title to the caption")
    parser.add_argument(
        "--log", action="store_true", help="scale both axes of the diagram by the logarithm"
    )
    parser.add_argument(
        "--rival",
        metavar="NAME",
        dest="rivals",
        action="append",
        help="draw what a simpler criterion says into the diagram: blok, power, power-density or "
        "pv; may be repeated",
    )
    _add_conditions(parser)
    _add_place(parser)


def _explore(commands: _Commands) -> None:
    parser = commands.on_store(
        "explore", "results:explore", "write a page to explore a store in a browser", "-o page.html"
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="PAGE.html",
        type=Path,
        help="where to write it; default: beside the store",
    )
    parser.add_argument(
        "--most-fields",
        metavar="N",
        type=values.count,
        help="number of points whose fields the page holds, those nearest to the transition, about "
        "10 kB each; default: 500",
    )
    parser.add_argument("--no-fields", action="store_true", help="leave all fields out")


def _add_output(parser: argparse.ArgumentParser, name: str, what: str) -> None:
    parser.add_argument("-o", "--output", metavar=name, type=Path, help=what)


def _add_workers(parser: Any) -> None:
    parser.add_argument(
        "--workers",
        metavar="N",
        type=values.count,
        help="number of workers; default: one for each core",
    )


def _add_accuracy(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--accuracy",
        metavar="BOUND",
        type=values.share,
        help="pick the cheapest fidelity whose boundary is within a bound, such as 2%%",
    )


def _add_conditions(parser: argparse.ArgumentParser, several: bool = True) -> None:
    """Options to judge by other conditions than the scene's own."""
    group = parser.add_argument_group("conditions, in place of the scene's own")
    if several:
        group.add_argument(
            "--friction",
            metavar="MU",
            type=values.frictions,
            action=values.Several,
            help="coefficient of friction; may be repeated",
        )
    else:
        group.add_argument(
            "--friction", metavar="MU", type=values.friction, help="coefficient of friction"
        )
    _add_bulk(group)
    group.add_argument(
        "--critical-temperature",
        metavar="T",
        type=values.quantity("145 degC"),
        help='like "145 degC"',
    )
    group.add_argument(
        "--share",
        type=values.failing_share,
        help="share of the contact above the critical temperature beyond which wear is severe, "
        "like 10%% or 0.1; 0 for the maximum temperature",
    )


def _add_bulk(group: Any) -> None:
    group.add_argument(
        "--bulk-temperature",
        metavar="T",
        type=values.bulk,
        help='like "25 degC"; "pin=60 degC, disk=25 degC" in a sweep of unequal ones',
    )


def _add_place(
    parser: argparse.ArgumentParser, required: bool = False, surface: bool = True
) -> None:
    """Options for a point of the plane."""
    parser.add_argument(
        "--load",
        metavar="F",
        type=values.quantity("750 N"),
        required=required,
        help='normal load, like "750 N"',
    )
    parser.add_argument(
        "--velocity",
        metavar="V",
        type=values.quantity("1.25 m/s"),
        required=required,
        help='sliding velocity, like "1.25 m/s"',
    )
    if surface:
        parser.add_argument(
            "--realization",
            metavar="SEED",
            type=values.seed,
            help="seed of one of several random surfaces",
        )
