"""The scene and the conditions that the options of a command ask for."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pipeline
from pipeline.cli.output import tell
from pipeline.scene.over import notes_on_first_values
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.selection import KEPT_FIELDS
from pipeline.tradeoff.choose import at_accuracy
from tribo import InputError

CONDITIONS = ("friction", "bulk_temperature", "critical_temperature", "share", "criterion")
"""Options that `pipeline.boundary` and `Conditions.changed` take by these names."""
PLACE = ("load", "velocity", "realization")
"""Options that `pipeline.plot` takes by these names."""


def scene_of(
    options: argparse.Namespace, points: Sequence[Point] | None = None, store: Path | None = None
) -> Sweep:
    """The scene with the fidelity and the conditions that the user asked for.

    An accuracy is to hold at the points, or at some near the boundary; the fidelity of the store
    is kept if it is accurate enough.
    """
    settings = settings_of(options)
    sweep: Sweep = pipeline.load_scene(
        options.scene, options.preset, settings, own_laws=options.own_laws
    )
    if conditions := conditions_in(options):
        changed = sweep.conditions.changed(**conditions)
        sweep = sweep.changed(
            conditions=changed,
            friction_heat=sweep.scene.friction_heat or changed.friction > 0,
            unequal_bulks=changed.disk_temperature is not None,
        )
    if getattr(options, "accuracy", None) is None:
        return sweep
    choices = [f"--set {key}" for key in settings if "." not in key and key not in KEPT_FIELDS]
    if chosen := [*(["--preset"] if options.preset else []), *choices]:
        raise InputError(
            f"--accuracy picks the numerical choices itself; leave out {', '.join(chosen)}"
        )
    sweep = at_accuracy(
        sweep, options.accuracy, points, store, lambda line: tell(f"probing: {line}")
    )
    tell(str(sweep.about.selection))
    return sweep


def one_scene_of(options: argparse.Namespace, points: Sequence[Point] | None = None) -> Sweep:
    """The scene, for a command that takes one value of each entry; a note says if it has more."""
    sweep = scene_of(options, points)
    for note in notes_on_first_values(sweep.variants):
        tell(note)
    return sweep


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """Entries of --set; keys without the prefix that those of a fidelity may have."""
    settings: dict[str, Any] = {}
    for path, value in options.set:
        key = path.removeprefix("fidelity.")
        if key in settings:
            raise InputError(f"--set: {key} is given more than once; give it once")
        settings[key] = value
    return settings


def selected(sweep: Sweep) -> dict[str, Any]:
    """Reason for the fidelity that was picked, for a JSON document; nothing if none was."""
    return {"selection": sweep.about.selection.as_dict()} if sweep.about.selection else {}


def at_in(options: argparse.Namespace) -> dict[str, Any]:
    """Values of --at by their paths, each of which is given once."""
    values = dict(options.at)
    if len(values) < len(options.at):
        twice = next(path for path in values if [p for p, _ in options.at].count(path) > 1)
        raise InputError(f"--at: {twice} is given more than once; give it once")
    return values


def beside(store: Path | str, ending: str) -> Path:
    """File beside a store, or here for a store at an address."""
    path = Path(store) if "://" not in str(store) else Path(Path(store).name)
    return path.with_name(f"{path.stem}{ending}")


def conditions_in(options: argparse.Namespace) -> dict[str, Any]:
    """Conditions that the user gave in place of the scene's own; several frictions as a tuple."""
    conditions = values_in(options, *CONDITIONS)
    frictions = conditions.get("friction")
    if isinstance(frictions, list):
        conditions["friction"] = tuple(frictions) if len(frictions) > 1 else frictions[0]
    return conditions | criterion_in(options)


def criterion_in(options: argparse.Namespace) -> dict[str, Any]:
    """The criterion that the user gave, and permission to run it if that is code."""
    given = values_in(options, "criterion")
    return given | ({"own_laws": options.own_laws} if ":" in given.get("criterion", "") else {})


def values_in(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Options of these names that the command has and the user gave."""
    values = {name: getattr(options, name, None) for name in names}
    return {
        name: value
        for name, value in values.items()
        if not (value is None or value is False or value == [])
    }


def weighing(options: argparse.Namespace) -> list[str]:
    """Options by which measurements are to weigh the unknown inputs."""
    return [*values_in(options, "scatter", "given_measured")]


def flags_of(names: Sequence[str]) -> str:
    """Options as they are typed, one after the other."""
    return ", ".join(f"--{name.replace('_', '-')}" for name in names)
