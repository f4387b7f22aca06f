"""The command ``irg``.

Results go to stdout, as text or with ``--json`` as one document; progress and messages to stderr.
Exit codes: 0 done, 1 some points failed, 2 wrong use or scene, 3 the store belongs to another
scene, 130 interrupted.
"""

from __future__ import annotations

import argparse
import atexit
import gc
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pipeline
from pipeline.cli import commands
from pipeline.cli.output import tell
from tribo import PRESETS, TriboError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    # What is imported is no garbage, neither now nor at the end: looking takes 0.1 and 0.2 s.
    gc.set_threshold(100_000)
    atexit.register(gc.freeze)
    options = _parser().parse_args(arguments)
    try:
        return int(options.command(options))
    except KeyboardInterrupt:
        tell("interrupted; finished points are safe: run the same command again to go on")
        return commands.INTERRUPTED
    except pipeline.SceneFileError as error:
        tell(str(error))
        return commands.WRONG_USE
    except pipeline.StoreMismatchError as error:
        tell(str(error))
        return commands.OTHER_SCENE
    except TriboError as error:
        tell(str(error))
        return commands.WRONG_USE
    except BrokenPipeError:
        sys.stderr.close()
        return commands.DONE


def _quantity(like: str) -> Callable[[str], float]:
    """A parser of quantities with a unit, such as `like`."""

    def parse(text: str) -> float:
        try:
            return pipeline.to_si(text, like)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f'{error}; give one like "{like}"') from error

    return parse


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="irg",
        description="Predict where a lubricated sliding contact goes from mild to severe wear.",
    )
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)

    def command(
        name: str, function: Callable[[argparse.Namespace], int], what: str, given: str
    ) -> argparse.ArgumentParser:
        added = subparsers.add_parser(name, help=what, description=f"{what[0].upper()}{what[1:]}.")
        added.set_defaults(command=function)
        if given == "scene":
            added.add_argument("scene", metavar="SCENE.toml", type=Path)
            added.add_argument(
                "--preset",
                metavar="NAME",
                help=f"fidelity in place of the scene's own: {', '.join(PRESETS)}",
            )
            added.add_argument(
                "--set",
                metavar="KEY=VALUE",
                type=commands.setting,
                action="append",
                default=[],
                help="another numerical choice, such as increments=50, or another entry of the "
                "scene, such as wear.pattern=local; may be repeated",
            )
        else:
            added.add_argument("store", metavar="OUT.zarr", type=_store)
        added.add_argument("--json", action="store_true", help="print one JSON document")
        return added

    run = command("run", commands.run, "run or resume the sweep of a scene", "scene")
    run.add_argument(
        "-o", "--output", metavar="OUT.zarr", type=_store, help="default: results/<scene>.zarr"
    )
    where = run.add_mutually_exclusive_group()
    where.add_argument("--workers", metavar="N", type=_count, help="default: one for each core")
    where.add_argument("--scheduler", metavar="ADDRESS", help="a running Dask scheduler to use")
    run.add_argument(
        "--fill-fields",
        action="store_true",
        help="compute points again that were finished before the scene asked for fields",
    )
    run.add_argument("--retry-failed", action="store_true", help="compute failed points again")
    run.add_argument(
        "--boundary-only",
        metavar="TOLERANCE",
        nargs="?",
        const=0.01,
        type=_share,
        help="choose velocities until the boundary is known to this tolerance, 1%% if not given",
    )

    check = command("check", commands.check, "validate a scene and say what would run", "scene")
    check.add_argument("--workers", metavar="N", type=_count, help="default: one for each core")

    command("status", commands.status, "count the points done, failed and pending", "store")

    verify = command("verify", commands.verify, "read a whole store, name what is damaged", "store")
    verify.add_argument(
        "--repair", action="store_true", help="set damaged points to be computed again"
    )

    command(
        "compact",
        commands.compact,
        "rewrite a store in few files, to open faster",
        "store",
    )

    boundary = command(
        "boundary", commands.boundary, "find the transition, without a new simulation", "store"
    )
    point = command("point", commands.point, "simulate one point", "scene")
    for added in (run, point):
        added.add_argument(
            "--accuracy",
            metavar="BOUND",
            type=_share,
            help="pick the cheapest fidelity whose boundary is within a bound, such as 2%%",
        )

    infer = command(
        "infer",
        commands.infer,
        "find the critical temperature from measured transitions, or a wear rate from a width",
        "scene",
    )
    infer.add_argument(
        "--contact-width",
        metavar="W",
        type=_quantity("348 um"),
        help='measured after a loading, like "348 um": find the specific wear rate instead',
    )

    trade = command("trade", commands.trade, "measure speed against accuracy", "scene")
    trade.add_argument(
        "--base", metavar="NAME", default="fine", help="preset to vary choice by choice"
    )
    trade.add_argument("--diagram", action="store_true", help="compare whole small diagrams")
    trade.add_argument("-o", "--output", metavar="FILE.png", type=Path, help="draw a figure")

    reproduce = subparsers.add_parser(
        "reproduce", help="recompute a figure or table of the paper, beside what it prints"
    )
    reproduce.set_defaults(command=commands.reproduce)
    reproduce.add_argument("name", metavar="NAME", nargs="?", help="one of --list, or all")
    reproduce.add_argument("--list", action="store_true", help="what there is")
    reproduce.add_argument(
        "-o",
        "--output",
        metavar="FILE.png",
        type=Path,
        help="figure; for all, the folder of the page that shows them",
    )
    reproduce.add_argument("--preset", metavar="NAME", help=", ".join(PRESETS))
    reproduce.add_argument("--surfaces", metavar="N", type=_count, help="random surfaces")
    reproduce.add_argument("--workers", metavar="N", type=_count, help="for the diagram")
    reproduce.add_argument("--json", action="store_true", help="print one JSON document")

    plot = command("plot", commands.plot, "draw a figure", "store")
    plot.add_argument("--kind", default="diagram", choices=("diagram", "ramp", "fields"))
    plot.add_argument(
        "-o", "--output", metavar="FILE.png", type=Path, help="default: beside the store"
    )
    for added in (boundary, plot):
        added.add_argument(
            "--friction",
            metavar="MU",
            type=_frictions,
            help="coefficient of friction, or several such as 0.09,0.103",
        )
        added.add_argument(
            "--bulk-temperature", metavar="T", type=_quantity("25 degC"), help='like "25 degC"'
        )
        added.add_argument(
            "--critical-temperature",
            metavar="T",
            type=_quantity("145 degC"),
            help='like "145 degC"',
        )
        added.add_argument(
            "--share", type=float, help="of the contact above the critical temperature, like 0.1"
        )
    for added, required in ((point, True), (plot, False), (infer, False)):
        added.add_argument(
            "--load", metavar="F", type=_quantity("750 N"), required=required, help='like "750 N"'
        )
        added.add_argument(
            "--velocity",
            metavar="V",
            type=_quantity("1.25 m/s"),
            required=required,
            help='like "1.25 m/s"',
        )
        added.add_argument(
            "--realization", metavar="SEED", type=_seed, help="of several random surfaces, which"
        )
    return parser


def _store(text: str) -> Path | str:
    """The folder or address of a store."""
    return text if "://" in text else Path(text)


def _count(text: str, least: int = 1) -> int:
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if number < least:
        raise argparse.ArgumentTypeError(f'"{text}": give a whole number of at least {least}')
    return number


def _frictions(text: str) -> float | tuple[float, ...]:
    """Read a number, or several between commas."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'"{text}": give a number such as 0.1, or several such as 0.09,0.103'
        ) from None
    return values if len(values) > 1 else values[0]


def _seed(text: str) -> int:
    return _count(text, least=0)


def _share(text: str) -> float:
    """Read a share such as 2% or 0.02."""
    try:
        value = float(text[:-1]) / 100 if text.endswith("%") else float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f'"{text}": give a share between 0 and 1, such as 2%')
    return value
