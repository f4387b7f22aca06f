"""Read the options of a command: scene, conditions, operating points and dataset."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import pipeline
from pipeline.answers.discretization_error import KEPT_FIELDS
from pipeline.answers.units import value_words
from pipeline.cli.output import print_note
from pipeline.cli.values import setting
from pipeline.operating_points import OperatingPoints
from pipeline.paths import user_path
from pipeline.quantities import ALIKE
from pipeline.sweep.case_table import CASE, dimension_of
from pipeline.sweep.conditions import CONDITION_ENTRIES, PATHS
from pipeline.sweep.sweep import Sweep
from pipeline.units import to_si
from tribo import Fidelity, InputError

if TYPE_CHECKING:
    import xarray as xr

_FILES = ("disk.roughness.file", "loading.file", "sweep.along")
CONDITIONS = tuple(CONDITION_ENTRIES)
"""Options on conditions, named as in `pipeline.margin`."""
_NUMERICAL = {"preset", *(one.name for one in fields(Fidelity))} - {*KEPT_FIELDS}
"""Numerical choices, which an accuracy replaces."""
_OF_CONDITIONS = {path: name for name, path in PATHS.items()}
PLACE = ("load", "velocity", "realization")
"""Options that select the point of a figure, named as in `pipeline.plot`."""


def values_in(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Values by name of the options in `names` that the user gave."""
    values = {name: getattr(options, name, None) for name in names}
    return {
        name: value
        for name, value in values.items()
        if not (value is None or value is False or value == [])
    }


def flags_of(names: Iterable[str]) -> str:
    """Names of options as typed on the command line, such as "--load, --velocity"."""
    typed = ("store" if name == "store_path" else name.replace("_", "-") for name in names)
    return ", ".join(f"--{name}" for name in typed)


def path_beside(store: Path | str, ending: str) -> Path:
    """Path of a store with another ending; in the working directory if the store is in a bucket."""
    path = Path(store) if "://" not in str(store) else Path(Path(store).name)
    return path.with_name(f"{path.stem}{ending}")


def settings_in(options: argparse.Namespace) -> dict[str, Any]:
    """Values set by --set, keyed by entry path; a prefix `fidelity.` of the path is removed.

    The path of a file is relative to the shell's folder, not to that of the scene.
    """
    files = {
        path: str(Path.cwd() / user_path(value))
        for path, value in options.set
        if path in _FILES and isinstance(value, str)
    }
    return {path.removeprefix("fidelity."): files.get(path, value) for path, value in options.set}


def conditions_in(options: argparse.Namespace) -> dict[str, Any]:
    """Conditions given as options such as --friction, by name; several values are a list."""
    given = values_in(options, *CONDITIONS).items()
    conditions = {name: values[0] if len(values) == 1 else [*values] for name, values in given}
    for path, value in getattr(options, "at", ()):
        if path in _OF_CONDITIONS:
            if _OF_CONDITIONS[path] in conditions:
                raise InputError(f"{path} is given twice; give it once")
            conditions[_OF_CONDITIONS[path]] = value
    return conditions


def operating_points_in(options: argparse.Namespace) -> OperatingPoints | None:
    """Operating points from --points, or from --load and --velocity; None without these options."""
    place = values_in(options, "load", "velocity")
    if options.points is not None:
        if place:
            raise InputError(f"--points already gives load and velocity; remove {flags_of(place)}")
        return OperatingPoints.read(options.points, options.decimal, options.ignore)
    if len(place) == 1:
        (given,) = place
        lacks, such = ("velocity", "2 m/s") if given == "load" else ("load", "500 N")
        raise InputError(f'--{given} also needs --{lacks}, such as "{such}"')
    return OperatingPoints(((options.load, options.velocity),), {}) if place else None


def scene_in(options: argparse.Namespace) -> Sweep:
    """Load the command's scene, changed by the options for conditions and numerical choices."""
    settings = settings_in(options)
    conditions = {PATHS[name]: one for name, one in conditions_in(options).items()}
    if several := [path for path, value in conditions.items() if isinstance(value, list)]:
        raise InputError(f"{several[0]} takes a single value here")
    sweep: Sweep = pipeline.load_scene(options.scene, options.preset, settings | conditions)
    if getattr(options, "accuracy", None) is not None:
        named = ["--preset"] if options.preset else []
        named += [f"--set {key}" for key in settings if key in _NUMERICAL]
        if named:
            raise InputError(f"--accuracy picks the preset; leave out {', '.join(named)}")
    return sweep


def one_scene_in(options: argparse.Namespace) -> Sweep:
    """Load the scene of a command that uses only one value of each varied entry.

    A note is printed for each varied entry, as its other values are ignored.
    """
    sweep = scene_in(options)
    for column in sweep.case_table.chosen:
        key, what = "over", f"{column.name} is the scene's own or the first listed"
        if column.name == CASE:
            key, what = "along", "values are the scene's own or those of its first row"
        print_note(f"note: sweep.{key} is ignored here; {what}; choose another by --set")
    return sweep


def stored_tests_of(sweep: Sweep) -> str | None:
    """Path of the scene's store in results, if there is one, whose tests need not be simulated."""
    path = Path("results") / f"{sweep.name}.zarr"
    return str(path) if path.is_dir() else None


def dataset_in(options: argparse.Namespace) -> xr.Dataset:
    """Dataset of the command's store, at the values of entries in --at."""
    ds = pipeline.open_sweep(options.store)
    for path, value in options.at:
        if path not in _OF_CONDITIONS:
            ds = select_entry(ds, path, value)
    return ds.assign_attrs(without_tests="yes") if options.without_tests else ds


def select_entry(ds: xr.Dataset, path: str, value: Any) -> xr.Dataset:
    """Select a value of an entry that varies in a sweep."""
    dim = dimension_of(path)
    if dim not in ds.dims:
        others = ", ".join(map(str, ds["status"].dims[:-2])) or "nothing"
        raise InputError(
            f"{path} does not vary in this sweep ({others} does); run the scene with {path} = "
            f"{value} into another store"
        )
    values = ds[dim].values
    wanted = value if values.dtype.kind not in "if" else to_si(str(value), like=str(value))
    close = (
        values == wanted if values.dtype.kind not in "if" else np.isclose(values, wanted, ALIKE, 0)
    )
    if not close.any():
        known = ", ".join(value_words(ds[dim], one) for one in values.tolist())
        from pipeline.answers.words import extending  # only where it is printed: xarray is slow

        entry = "sweep.realizations" if dim == "realization" else f"sweep.over.{path}"
        new = {entry: [setting(f"{path}={value}")[1]]}
        advice = "" if dim == CASE else f"; {extending(ds, new)}"  # rows are those of a table
        raise InputError(f"{path} {value} is not in the sweep, which has {known}{advice}")
    return ds.isel({dim: int(np.flatnonzero(close)[0])})
