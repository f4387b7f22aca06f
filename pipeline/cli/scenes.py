"""The scene and the conditions that the options of a command ask for."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.cli.output import tell
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.selection import KEPT_FIELDS
from tribo import InputError

if TYPE_CHECKING:
    import xarray as xr

CONDITIONS = ("friction", "bulk_temperature", "critical_temperature", "share", "criterion")
"""Options that `pipeline.boundary` and `Conditions.changed` take by these names."""
PLACE = ("load", "velocity", "realization")
"""Options that `pipeline.plot` takes by these names."""


def scene_of(
    options: argparse.Namespace, points: Sequence[Point] | None = None, store: Path | None = None
) -> Sweep:
    """Return the scene with the fidelity and the conditions that the user asked for.

    Parameters
    ----------
    options : Namespace
        Options of the command.
    points : sequence of Point, optional
        Points at which an accuracy is to hold; some near the boundary if not given.
    store : path, optional
        A store whose fidelity to go on with, if it is accurate enough.
    """
    sweep: Sweep = pipeline.load_scene(
        options.scene, preset=options.preset, overrides=settings_of(options)
    )
    if conditions := given(options, *CONDITIONS):
        changed = sweep.conditions.changed(**conditions)
        has_heat = sweep.friction_heat or changed.friction > 0
        sweep = replace(
            sweep,
            conditions=changed,
            friction_heat=has_heat,
            unequal_bulks=changed.disk_temperature is not None,
        )
    if getattr(options, "accuracy", None) is not None:
        sweep = _accurate(options, sweep, points, store)
    return sweep


def _accurate(
    options: argparse.Namespace, sweep: Sweep, points: Sequence[Point] | None, store: Path | None
) -> Sweep:
    settings = settings_of(options)
    choices = [f"--set {key}" for key in settings if "." not in key and key not in KEPT_FIELDS]
    if chosen := [*(["--preset"] if options.preset else []), *choices]:
        raise InputError(
            f"--accuracy picks the numerical choices itself; leave out {', '.join(chosen)}"
        )
    sweep = pipeline.at_accuracy(
        sweep, options.accuracy, points, store, lambda line: tell(f"probing: {line}")
    )
    tell(str(sweep.selection))
    return sweep


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """Return the entries of --set, keys without the prefix that those of a fidelity may have."""
    settings: dict[str, Any] = {}
    for path, value in options.set:
        key = path.removeprefix("fidelity.")
        if key in settings:
            raise InputError(f"--set: {key} is given more than once; give it once")
        settings[key] = value
    return settings


def selected(sweep: Sweep) -> dict[str, Any]:
    """Return why the fidelity was picked, for a JSON document; nothing if it was not."""
    return {"selection": sweep.selection.as_dict()} if sweep.selection else {}


def opened(options: argparse.Namespace) -> xr.Dataset:
    """The store, at the wear rate that the user asked for."""
    ds = pipeline.open_sweep(options.store)
    return ds if options.wear_rate is None else pipeline.at_wear_rate(ds, options.wear_rate)


def given(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Return the options of these names that the command has and the user gave."""
    values = {name: getattr(options, name, None) for name in names}
    return {name: value for name, value in values.items() if value is not None}
