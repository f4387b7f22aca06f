"""Read the options of a command: scene, conditions, operating points and dataset."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import pipeline
from pipeline.answers.scene_wording import value_words
from pipeline.cli.output import print_note
from pipeline.condition_kinds import CONDITIONS, OperatingPoints
from pipeline.messages import did_you_mean
from pipeline.paths import user_path
from pipeline.quantities import ROUNDING
from pipeline.store.location import StoreError
from pipeline.store.schema import PLANE
from pipeline.sweep.case_table import CASE, dimension_of
from pipeline.sweep.sweep import Sweep
from pipeline.units import to_si
from tribo import InputError

if TYPE_CHECKING:
    import xarray as xr

    from pipeline.store.store import Store

_PATH_ENTRIES = ("disk.roughness.file", "loading.file", "sweep.along")
_CONDITION_OF = {condition.entry: name for name, condition in CONDITIONS.items()}


def values_in(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Values by name of the options in `names` that the user gave."""
    values = {name: getattr(options, name, None) for name in names}
    return {
        name: value
        for name, value in values.items()
        if value is not None and value is not False and value != []
    }


def path_beside(store: Path | str, ending: str) -> Path:
    """Path of a store with another ending, in the same folder."""
    path = Path(store)
    return path.with_name(f"{path.stem}{ending}")


def scene_in(options: argparse.Namespace) -> Sweep:
    """Load the command's scene, changed by the options for conditions and numerical choices.

    A critical temperature is left to the answers, as it is not that of the scene and its tests.
    """
    conditions = {CONDITIONS[name].entry: value for name, value in conditions_in(options).items()}
    if lists := [path for path, value in conditions.items() if isinstance(value, list)]:
        raise InputError(f"{lists[0]} takes a single value here; give it once")
    conditions.pop(CONDITIONS["critical_temperature"].entry, None)
    settings = dict[str, Any]()
    for path, value in options.set.items():
        is_path = path in _PATH_ENTRIES and isinstance(value, str)  # relative to the shell's folder
        settings[path.removeprefix("fidelity.")] = (
            str(Path.cwd() / user_path(value)) if is_path else value
        )
    if repeated := settings.keys() & conditions.keys():
        raise InputError(f"{min(repeated)} is given twice; give it once")
    return pipeline.load_scene(options.scene, options.preset, settings | conditions)


def one_scene_in(options: argparse.Namespace, finds_row: bool = False) -> Sweep:
    """Load the scene of a command that uses only one value of each varied entry.

    A note names this value, except the row of a table if the command finds it (`finds_row`).
    """
    sweep = scene_in(options)
    for column in sweep.case_table.chosen_columns:
        if finds_row and column.name == CASE:
            continue
        print_note(
            f"note: {column.name} varies in this scene; the scene's own value or the first one is "
            "used; choose another by --set"
        )
    return sweep


def stored_tests_of(sweep: Sweep) -> Store | None:
    """The scene's store in results, whose tests need not be simulated; None if there is none.

    A note is printed if the store cannot be read.
    """
    from pipeline.store.store import opened  # Zarr, which irg check does without

    path = Path("results") / f"{sweep.name}.zarr"
    if not path.is_dir():
        return None
    try:
        return opened(path)
    except StoreError as error:
        print_note(f"note: the tests are simulated, since no results can be copied: {error}")
        return None


def conditions_in(options: argparse.Namespace) -> dict[str, Any]:
    """Conditions given as options such as --friction, by name; several values are a list."""
    option_values = values_in(options, *CONDITIONS).items()
    conditions = {name: values[0] if len(values) == 1 else values for name, values in option_values}
    for path, value in getattr(options, "at", {}).items():
        if path in _CONDITION_OF:
            if _CONDITION_OF[path] in conditions:
                raise InputError(f"{path} is given twice; give it once")
            conditions[_CONDITION_OF[path]] = value
    return conditions


def operating_points_in(options: argparse.Namespace) -> OperatingPoints | None:
    """Operating points of the file --points; None without this option."""
    if options.points is None:
        return None
    if options.load is not None or options.velocity is not None:
        raise InputError("--points already gives loads and velocities; leave out the others")
    return OperatingPoints.read(options.points, options.decimal, options.ignore)


def dataset_in(options: argparse.Namespace) -> xr.Dataset:
    """Dataset of the command's store, at the values of entries in --at."""
    from pipeline.answers.results import dataset_of  # imports xarray and Zarr

    ds = pipeline.open_sweep(options.store)
    for path, value in options.at.items():
        if path not in _CONDITION_OF:
            ds = _select_entry(ds, path, value)
    return dataset_of(ds, options.without_tests)


def _select_entry(ds: xr.Dataset, name: str, value: str) -> xr.Dataset:
    """Select a value of an entry that varies in a sweep, or the rows with a label in a column."""
    columns = {
        str(key): column
        for key, column in ds.coords.items()
        if column.ndim == 1 and column.dims[0] in ds["status"].dims and key not in PLANE
    }
    name = name.partition(" [")[0]  # a printed heading has its unit
    key = name if name in columns else dimension_of(name.replace(" ", "_"))
    if key not in columns:
        if suggestion := did_you_mean(name, [*_CONDITION_OF, *columns]):
            raise InputError(f"{name} does not vary in this sweep{suggestion}")
        raise InputError(
            f"{name} does not vary in this sweep, only "
            f"{', '.join(columns) or 'load and velocity'}; "
            f"run the scene with {name} = {value} into another store"
        )
    column, labels = columns[key], columns[key].values
    is_text = labels.dtype.kind not in "if"
    is_equal = labels == value if is_text else np.isclose(labels, to_si(value, value), ROUNDING, 0)
    if not is_equal.any():
        known_values = ", ".join(value_words(column, label) for label in labels.tolist())
        raise InputError(f"{name} {value} is not in the sweep, which has {known_values}")
    rows = np.flatnonzero(is_equal).tolist()
    return ds.isel({column.dims[0]: rows[0] if len(rows) == 1 else rows})
