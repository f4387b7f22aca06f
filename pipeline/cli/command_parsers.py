"""The commands of ``irg``: the purpose of each, an example, and its options."""

from __future__ import annotations

from pipeline.cli import values
from pipeline.cli.options import (
    TABLE,
    AddCommand,
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
from pipeline.paths import user_path

_LOAD_AND_VELOCITY = '--load "500 N" --velocity "2 m/s"'


def add_commands(add: AddCommand) -> None:
    """Add all commands, in the order in which the help lists them."""
    functions = (
        _add_new, _add_run, _add_check, _add_point, _add_trade, _add_infer, _add_surface,
        _add_status, _add_verify, _add_boundary, _add_margin, _add_plot, _add_report, _add_help,
    )  # fmt: skip
    for add_command in functions:
        add_command(add)


def _add_new(add: AddCommand) -> None:
    command = add(
        "new", "pipeline.cli.begin:new", "write a scene to start from",
        "scene.toml --from twin_disc",
    )  # fmt: skip
    exclusive = command.add_mutually_exclusive_group()
    add_value(exclusive, "file FILE.toml", "file to write", user_path, nargs="?")
    add_flag(exclusive, "--list", "list the shipped scenes")
    add_value(command, "--from NAME", "shipped scene to begin with; see --list", dest="template")


def _add_run(add: AddCommand) -> None:
    command = add(
        "run", "pipeline.cli.sweep_commands:run", "run or resume the sweep of a scene",
        "scene.toml --accuracy 2%",
    )  # fmt: skip
    add_scene(command)
    help_text = "path of the store; default: results/<scene>.zarr"
    add_value(command, "-o --output OUT.zarr", help_text, values.store)
    exclusive = command.add_mutually_exclusive_group()
    add_workers(exclusive)
    add_value(exclusive, "--scheduler ADDRESS", "address of a running Dask scheduler")
    add_value(
        exclusive, "--scheduler-file FILE", "file written by a running Dask scheduler", user_path
    )
    help_text = "copy matching points from another store"
    add_value(command, "--from OLD.zarr", help_text, values.store, dest="source")
    help_text = "print the address of Dask's dashboard, which every user of this machine can open"
    add_flag(command, "--dashboard", help_text)
    add_flag(command, "--retry-failed", "simulate the points that failed in an earlier run again")
    add_flag(command, "-n --dry-run", "print what irg check prints, and compute nothing")
    help_text = (
        "compute until the numerical error of the boundary is below this, such as 2%%; the run "
        "chooses preset, points and surface realizations"
    )
    add_value(command, "--accuracy BOUND", help_text, values.share)


def _add_check(add: AddCommand) -> None:
    command = add(
        "check", "pipeline.cli.check:check",
        "describe a scene and estimate the cost of its sweep", "scene.toml",
    )  # fmt: skip
    add_scene(command)
    add_workers(command)
    add_value(command, *TABLE)


def _add_point(add: AddCommand) -> None:
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


def _add_trade(add: AddCommand) -> None:
    command = add(
        "trade", "pipeline.cli.sweep_commands:trade", "measure computing time against accuracy",
        "scene.toml -o trade.png",
    )  # fmt: skip
    add_scene(command)
    help_text = "new store for the points; default: results/<scene>-trade.zarr"
    add_value(command, "--store OUT.zarr", help_text, values.store, dest="store_path")
    add_workers(command)
    help_text = "file of a figure; or of the table, .csv, .md or .json"
    add_value(command, "-o --output FILE.png", help_text, values.writable("figure", "table"))


def _add_infer(add: AddCommand) -> None:
    command = add(
        "infer", "pipeline.cli.point_commands:infer",
        "find the critical temperature from tests, or the wear rate from a contact width",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"',
    )  # fmt: skip
    add_scene(command)
    help_text = (
        "contact width measured at --load and --velocity; prints the specific wear rate instead"
    )
    add_quantity(command, "--contact-width W", help_text, "348 um")
    help_text = "sliding time before the width was measured, ramp included; default: from the scene"
    add_quantity(command, "--duration T", help_text, "8 s")
    add_bulk_temperature(command)
    add_value(command, *TABLE)
    add_operating_point(command)
    add_realization(command)


def _add_surface(add: AddCommand) -> None:
    command = add(
        "surface", "pipeline.cli.figure_commands:surface",
        "describe a scan by ISO 25178-2, compare it with a random surface, and print its tables",
        'scan.npy --height-unit um --pixel-size "0.8 um" -o surface.png',
    )  # fmt: skip
    help_text = "map of heights: .npy, a matrix in text, or the file of an instrument"
    add_value(command, "scan SCAN", help_text, user_path, nargs="?")
    help_text = 'unit of the heights, such as "um", if the file states none or a wrong one'
    add_value(command, "--height-unit UNIT", help_text)
    help_text = 'sides of a pixel, if the file states none, like "0.8 um" or "0.8 um,0.9 um"'
    add_value(command, "--pixel-size DX[,DY]", help_text, values.sides)
    help_text = "largest fraction of missing heights that is filled; default: 10%%"
    add_value(command, "--missing SHARE", help_text, values.share, default=0.1)
    help_text = "Ra of a profile or data sheet, with --rsm, without a file"
    add_quantity(command, "--ra RA", help_text, "0.2 um")
    add_quantity(command, "--rsm RSM", "RSm of a profile or data sheet", "60 um")
    help_text = "figure of the scan and of the random surface"
    add_value(command, "-o --output FILE.png", help_text, values.writable("figure"))


def _add_status(add: AddCommand) -> None:
    command = add(
        "status", "pipeline.cli.store_commands:status",
        "count done, failed and pending points of a store", "results/scene.zarr",
    )  # fmt: skip
    add_store(command)


def _add_verify(add: AddCommand) -> None:
    command = add(
        "verify", "pipeline.cli.store_commands:verify",
        "read a whole store and list damaged points", "results/scene.zarr",
    )  # fmt: skip
    add_store(command)


def _add_boundary(add: AddCommand) -> None:
    command = add(
        "boundary", "pipeline.cli.store_commands:boundary",
        "print the boundary between mild and severe wear, without a new simulation",
        "results/scene.zarr --friction 0.09 --friction 0.103",
    )  # fmt: skip
    add_store(command)
    help_text = (
        "rows of the table: critical velocity at each load, critical load at each velocity, or "
        "tests compared with the computation; default: load"
    )
    rows = "load", "velocity", "test"
    command.add_argument("--by", default="load", choices=rows, help=help_text)
    add_flag(command, "--all", "print all rows and notes")
    add_value(command, *TABLE)
    add_judgement(command)


def _add_margin(add: AddCommand) -> None:
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


def _add_plot(add: AddCommand) -> None:
    command = add(
        "plot", "pipeline.cli.figure_commands:plot", "draw a figure of a store",
        'results/scene.zarr --kind ramp --load "600 N" --velocity "1.6 m/s"',
    )  # fmt: skip
    add_store(command)
    help_text = "default: diagram, or rows if each has its own load and velocity"
    kinds = "diagram", "rows", "ramp", "fields", "tests"
    command.add_argument("--kind", choices=kinds, help=help_text)
    add_value(command, "-o --output FILE.png", "figure file; default: next to the store", user_path)
    help_text = "width of the figure; text shrinks less than the figure does"
    add_quantity(command, "--width W", help_text, "8.5 cm")
    add_value(command, "--title TITLE", "title of the figure; default: that of the scene")
    add_flag(command, "--plain", "omit title and caption")
    add_value(command, "--dpi DPI", "resolution in dots per inch; default: 150", values.count)
    add_flag(command, "--log", "draw the diagram on logarithmic axes")
    help_text = "step of fields, counted back from the end of a point: 0, -1, ..."
    add_value(command, "--step N", help_text, int)
    add_judgement(command)
    add_operating_point(command, action="append", default=[])
    add_realization(command)


def _add_report(add: AddCommand) -> None:
    command = add(
        "report", "pipeline.cli.figure_commands:report",
        "write a report to print and pass on: verdict, diagram, boundary, tests, errors, limits",
        f"results/scene.zarr {_LOAD_AND_VELOCITY} -o report.html",
    )  # fmt: skip
    add_store(command)
    add_operating_point(command)
    add_points(command)
    help_text = "file of the report; default: next to the store"
    add_value(command, "-o --output FILE.html", help_text, user_path)
    add_value(command, "--title TITLE", "title of the report; default: that of the scene")
    add_value(command, "--author NAME", "name of the author")
    add_judgement(command)


def _add_help(add: AddCommand) -> None:
    command = add(
        "help", "pipeline.cli.begin:help_", "print a page of the documentation, or list all pages",
        "first-hour",
    )  # fmt: skip
    add_value(command, "topic TOPIC", "name of a page or of a command", nargs="?")
