"""Options that several commands of ``irg`` have, and functions that add an option."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any

from pipeline.cli import values
from pipeline.paths import user_path

AddCommand = Callable[[str, str, str, str], argparse.ArgumentParser]
"""Function that adds a command: its name, its function, its purpose and an example."""
TABLE = "-o --output TABLE.csv", "file of the table, .csv, .md or .json", values.writable("table")


class _StoreEntry(argparse.Action):
    """Action of an option KEY=VALUE that may be repeated: collect the values by key."""

    def __call__(self, parser: Any, namespace: Any, entry: Any, name: str | None = None) -> None:
        key, value = entry
        entries = getattr(namespace, self.dest)
        if key in entries:
            parser.error(f"{key} is given twice; give it once")
        setattr(namespace, self.dest, {**entries, key: value})


def add_value(
    command: Any, syntax: str, help_text: str, convert: Any = None, **settings: Any
) -> None:
    """Add an option with a value; `syntax` has its names and then the name of the value."""
    *names, metavar = syntax.split()
    command.add_argument(*names, metavar=metavar, type=convert, help=help_text, **settings)


def add_several(command: Any, syntax: str, help_text: str, convert: Any) -> None:
    """Add an option that may be repeated, with its values in a list."""
    add_value(
        command, syntax, f"{help_text}; can be repeated", convert, action="append", default=[]
    )


def add_entries(command: Any, syntax: str, help_text: str, convert: Any) -> None:
    """Add an option KEY=VALUE that may be repeated, with its values in a dictionary."""
    add_value(
        command, syntax, f"{help_text}; can be repeated", convert, action=_StoreEntry, default={}
    )


def add_quantity(command: Any, syntax: str, help_text: str, like: str, **settings: Any) -> None:
    """Add an option for a quantity above 0 with a unit."""
    add_value(command, syntax, f'{help_text}, like "{like}"', values.quantity(like), **settings)


def add_flag(command: Any, names: str, help_text: str) -> None:
    """Add an option without a value."""
    command.add_argument(*names.split(), action="store_true", help=help_text)


def add_scene(command: Any) -> None:
    """Add the scene, and options that change it."""
    add_value(command, "scene SCENE.toml", "scene file, or name of a shipped scene", user_path)
    help_text = (
        "numerical preset, replacing the table [fidelity] of the scene: standard, fine or reference"
    )
    add_value(command, "--preset NAME", help_text)
    help_text = (
        "change a numerical setting, such as increments=50, or a scene entry, such as "
        "wear.pattern=local or without=motion"
    )
    add_entries(command, "--set KEY=VALUE", help_text, values.setting)


def add_workers(command: Any) -> None:
    """Add the number of processes."""
    help_text = "number of processes; default: one for each core"
    add_value(command, "-j --workers N", help_text, values.count)


def add_store(command: Any) -> None:
    """Add the store of results."""
    add_value(command, "store OUT.zarr", "results store, or name of its scene", values.stored)


def add_operating_point(command: Any, **settings: Any) -> None:
    """Add load and velocity."""
    add_quantity(command, "--load F", "normal load on the whole pin", "750 N", **settings)
    add_quantity(command, "--velocity V", "sliding velocity", "1.25 m/s", **settings)


def add_points(command: Any) -> None:
    """Add a table of operating points, and how it is read."""
    help_text = (
        'operating points, a row each, in columns such as "load [N]" and "velocity [m/s]", as '
        ".csv, .txt or .xlsx; columns of words are passed on as labels"
    )
    add_value(command, "--points POINTS.csv", help_text, user_path)
    command.add_argument("--decimal", choices=(".", ","), help="decimal mark of --points")
    add_several(command, "--ignore HEADING", "column of --points to leave out", str)


def add_realization(command: Any) -> None:
    """Add the choice of a surface realization."""
    help_text = "seed of the random surface, or area of the scan, instead of the scene's"
    add_value(command, "--realization SEED", help_text, partial(values.count, minimum=0))


def add_bulk_temperature(command: Any) -> None:
    """Add bulk temperatures."""
    help_text = 'temperature of the bodies far from the contact, like "25 degC"'
    add_several(command, "--bulk-temperature T", help_text, str)


def add_conditions(command: argparse.ArgumentParser) -> None:
    """Add conditions that replace those of the scene."""
    group = command.add_argument_group("conditions that replace those of the scene")
    add_several(group, "--friction MU", "coefficient of friction, at least 0", values.number)
    add_bulk_temperature(group)
    help_text = 'temperature above which the lubricant fails, like "145 degC"'
    add_several(group, "--critical-temperature T", help_text, str)
    help_text = (
        "critical area fraction: wear is severe if more of the contact is above the critical "
        "temperature, such as 10%%; 0 for the highest temperature"
    )
    add_several(group, "--critical-area-fraction F", help_text, str)


def add_judgement(command: argparse.ArgumentParser) -> None:
    """Add where an answer is evaluated: cases, conditions, and with or without tests."""
    help_text = (
        'evaluate at a value of a varied entry (sweep.over), such as "pin.radius=2 mm", or of a '
        'condition, such as "temperature.critical=150 degC" or "model.rise=+6 %%"'
    )
    add_entries(
        command, "--at KEY=VALUE", help_text, partial(values.pair, like='"pin.radius=2 mm"')
    )
    add_conditions(command)
    add_flag(command, "--without-tests", "ignore the tests of the scene")
