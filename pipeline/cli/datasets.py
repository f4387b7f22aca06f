"""The dataset of a store that the options of a command ask for, and its scene."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

import pipeline
from pipeline.analysis.dataset import attributes_of, is_emulated
from pipeline.analysis.scenes import taken
from pipeline.cli.output import tell
from pipeline.cli.scenes import at_in, criterion_in, flags_of, values_in, weighing
from pipeline.cli.values import setting
from pipeline.scene.along import OperatingPoints, Place
from pipeline.store.attributes import describe, scene_hash
from pipeline.sweep.conditions import changes_of
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.uncertain.certify import SceneWith

_FIXING = ("unknowns:risk", "margins:margin", "margins:boundary", "studies:design")
"""Commands that take ``--at`` for unknown inputs of samples, too."""


def opened(options: argparse.Namespace, store: Path | str | None = None) -> xr.Dataset:
    """The store, or another one, at the entries and the wear rate that the user asked for."""
    ds = pipeline.open_sweep(store or options.store)
    tell_of_another_law(options, ds)
    ds = pipeline.at_wear_rate(ds, getattr(options, "wear_rate", None))
    wanted = {path: at for path, at in at_in(options).items() if store is None or path in ds.dims}
    if not is_emulated(ds):
        return pipeline.at_entries(ds, wanted)
    ds, to_fix = taken(ds, wanted)
    if to_fix and options.command not in _FIXING:
        raise InputError(
            "--at fixes unknown inputs of samples in irg risk, irg margin, irg boundary, irg infer "
            f"and irg design alone; leave out {', '.join(to_fix)}, or run the scene with --set "
            "into another store"
        )
    return ds


def tell_of_another_law(options: argparse.Namespace, ds: xr.Dataset) -> None:
    """Note that the criterion which the user gave is not the text that the store was judged by."""
    given, stored = criterion_in(options), attributes_of(ds).get("conditions") or {}
    if not given.get("own_laws") or given["criterion"] != stored.get("criterion"):
        return
    digest, of_store = changes_of(**given)["own_criterion"].digest, stored.get("criterion_hash")
    if digest != of_store:
        tell(
            f"note: {given['criterion']} here (SHA-256 {digest[:8]}) is not the text that the "
            f"store was judged by ({str(of_store)[:8]})"
        )


def operating_points_in(options: argparse.Namespace) -> OperatingPoints:
    """Operating points of a table, or the one of --load and --velocity."""
    place = values_in(options, "load", "velocity")
    if options.points is None and len(place) < 2:
        raise InputError("no operating point is given; give --load and --velocity, or --points")
    if options.points is None:
        return OperatingPoints((Place(options.load, options.velocity),), {})
    if place:
        raise InputError(f"--points has each load and velocity; leave out {flags_of([*place])}")
    return OperatingPoints.read(options.points)


def by_samples(options: argparse.Namespace, ds: xr.Dataset) -> bool:
    """True if the answer is one of samples: the sweep has them, or they are asked for."""
    return is_emulated(ds) or bool(weighing(options))


def scene_with_of(ds: xr.Dataset) -> SceneWith:
    """Reader of the scene of a store with other entries, if its file is still the same."""
    attributes = attributes_of(ds)
    path, *words = attributes.get("arguments") or [""]
    given = [setting(word.removeprefix("--set=")) for word in words if word.startswith("--set=")]
    presets = [word.removeprefix("--preset=") for word in words if word.startswith("--preset=")]
    settings, preset = dict(given), presets[0] if presets else None
    if any("hash" in part for part in attributes["scene"].values() if isinstance(part, dict)):
        raise InputError("it has laws of its own, and no code runs because a store names it")
    read = partial(pipeline.load_scene, path, preset)  # also without the user's own laws
    if not path or scene_hash(describe(read(settings))) != attributes["scene_hash"]:
        raise InputError(f"{path or 'the scene'} is not the scene of the store any more")
    left_out = settings.pop("without", [])
    left_out = [left_out] if isinstance(left_out, str) else left_out
    alone = {"without": [*left_out, "unknown", "sweep.samples"]}
    return lambda entries: read(settings | alone | dict(entries))
