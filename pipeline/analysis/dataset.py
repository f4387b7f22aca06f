"""A stored sweep as a labelled dataset, and the scene that belongs to it."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

import numpy as np
import xarray as xr

from pipeline.paths import found_store
from pipeline.store.place import PathLike
from pipeline.store.read import open_store
from pipeline.store.schema import (
    AT_END,
    COORDINATES,
    INPUTS,
    MADE,
    PLANE,
    STEPPED,
    VARIABLES,
    split_arrays,
)
from pipeline.sweep.conditions import PATHS, UNITS, changes_of
from pipeline.sweep.stored import sweep_of_plain
from pipeline.sweep.sweep import Sweep
from pipeline.sweep.variants import VARIANT, Label, Variant, Variants, dimension_of
from pipeline.units import to_si
from tribo import InputError


@dataclass(frozen=True)
class Origin:
    """Sweep of a dataset as a key for caches: its data as JSON, and digests of its arrays."""

    text: str
    digests: str
    arrays: Any = field(compare=False)

    @classmethod
    def of(cls, ds: xr.Dataset) -> Origin:
        """Take the sweep of a dataset's attributes; raises an `InputError` if they are lost."""
        if "sweep" not in ds.attrs:
            raise InputError(
                "the dataset has no attribute sweep, which describes its scene; give one of "
                "pipeline.open_sweep, or keep attributes with "
                "xarray.set_options(keep_attrs=True)"
            )
        data = ds.variables.get(INPUTS)
        digests = "" if data is None else str(data.attrs["digests"])
        return cls(str(ds.attrs["sweep"]), digests, data)


@functools.lru_cache(maxsize=64)
def judged_sweep(origin: Origin, at: str, variant: Variant = ()) -> Sweep:
    """The sweep of a dataset, judged under the conditions `at`.

    `origin` has the data of the sweep. `at` is JSON with values in SI by the path of their entry.
    `variant` has a pair (dimension, value) for each varied entry, and selects one variant of the
    sweep. If `variant` is empty, the whole sweep is returned.
    """
    if variant:
        whole = judged_sweep(origin, at)
        words = ", ".join(f"{name} {one}" for name, one in whole.variants.in_words(variant).items())
        return replace(whole._take(variant), title=f"{whole.title}, {words}")
    values, data = json.loads(at), origin.arrays
    if not values:
        held = {} if data is None else split_arrays(data.values, data.attrs)
        try:
            plain = json.loads(origin.text)
        except ValueError as error:
            raise InputError(f"the attribute sweep of the dataset is no JSON: {error}") from error
        return sweep_of_plain(plain, held)
    sweep = judged_sweep(origin, "{}")
    given = {name: values[path] for name, path in PATHS.items() if path in values}
    return sweep.judge(changes_of(**given))


def scene_sweep(ds: xr.Dataset) -> Sweep:
    """Sweep of a dataset as stated in its scene file, without values set by `pipeline.at`."""
    return judged_sweep(Origin.of(ds), "{}")


def judged_values(ds: xr.Dataset) -> dict[str, Any]:
    """Values that `pipeline.at` has set in a dataset, in SI, by the path of their scene entry."""
    try:
        return dict(json.loads(str(ds.attrs.get("at", "{}"))))
    except ValueError as error:
        raise InputError(f"attribute `at` is {ds.attrs['at']!r:.60}; it must be JSON") from error


def name_at(table: Variants, ds: xr.Dataset) -> Variant:
    """Name of the variant that a dataset was selected to: pairs (varied entry, value).

    The values are written as in the `table` of variants. The name is empty if an entry still has
    several values in the dataset, or no coordinate.
    """
    if any(one.name in ds.dims or one.name not in ds.coords for one in table.chosen):
        return ()
    names = [one.name for one in table.chosen]
    return tuple((name, _label(table.axes[name], ds[name].item())) for name in names)


def _label(labels: Sequence[Label], value: Any) -> Label:
    """Label nearest to a coordinate's value; the value may have lost its last digits."""
    if isinstance(labels[0], str):
        return str(value)
    return min(labels, key=lambda label: abs(float(label) - value))


_UNITS = {name: variable.units for name, variable in VARIABLES.items()} | {
    dimension_of(path): UNITS.get(name) for name, path in PATHS.items()
}
"""SI units of variables and of conditions."""


def open_sweep(path: PathLike) -> xr.Dataset:
    """Open a stored sweep.

    Parameters
    ----------
    path : str or path
        Path or URL of a store made by `pipeline.run_sweep`, which may still be running; or the
        name of a scene, whose store is in ``results``.

    Returns
    -------
    Dataset
        The stored variables, with ascending loads, velocities and seeds of surfaces. ``step`` 0 is
        the end of each point, −1 the step before. Values are NaN at steps that a point does not
        have, and at points that are not done. Data are read when they are used. Attributes are
        text, so that ``to_netcdf`` can write them. See `pipeline.temperatures` for contact
        temperatures.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> ds["max_rise"].dims
    ('load', 'velocity', 'step')
    >>> end = pipeline.end_of_point(ds)
    >>> end["contact_width"].sel(load=600, velocity=1.6).round(6).item()
    0.000292
    """
    return ordered(open_store(found_store(path))).drop_vars("message", errors="ignore")


def dataset_of(source: xr.Dataset | PathLike) -> xr.Dataset:
    """Open the dataset of a store; or check a given one, sort its axes and load its Dask arrays.

    Contact fields, and data of a store, are read only when used. Time, load and distance of each
    step, which a store has only once, are repeated for every point.
    """
    if isinstance(source, str | os.PathLike):
        return _per_point(open_sweep(source))
    if not isinstance(source, xr.Dataset):
        raise InputError(
            f"a sweep cannot be a {type(source).__name__}; give a dataset of pipeline.open_sweep, "
            "or the path of a store"
        )
    axes = [str(dim) for dim in source.dims if dim in source.coords and dim not in source.indexes]
    for dim in axes:  # interp drops indexes beside a coordinate that is no number
        source = source.set_xindex(dim)
    table = scene_sweep(source).variants
    for name in PLANE:
        _require_axis(source, name)
    _require_known_axes(source, table)
    lazy = {
        name: source[name].compute()
        for name, data in source.variables.items()
        if data.chunks and name not in AT_END
    }
    return _per_point(ordered(source.assign(lazy) if lazy else source))


def _require_axis(ds: xr.Dataset, name: str) -> None:
    """Raise an `InputError` unless the axis `name` of a dataset has finite values, each once."""
    if name not in ds.coords:
        raise InputError(f"the dataset has no {name}; keep its coordinates, and their names")
    if not ds[name].size:
        raise InputError(f"the dataset has no {name} left; select at least one")
    if ds[name].dtype.kind not in "fiu" or not np.isfinite(ds[name]).all():
        raise InputError(f"the dataset has a {name} that is no finite number; drop such points")
    # Not by the index's is_unique, which threads disturb in pandas.
    if ds[name].dims == (name,) and len(np.unique(ds[name])) < ds.sizes[name]:
        raise InputError(
            f"the dataset has a {name} twice; keep each once, such as by "
            f"ds.drop_duplicates({name!r})"
        )


def _require_known_axes(ds: xr.Dataset, table: Variants) -> None:
    """Raise an `InputError` for dimensions or units that the sweep lacks, or a lost coordinate."""
    units = _UNITS | {column.name: column.unit for column in table.columns}
    dims = entry_dims(ds["status"]) if "status" in ds else ()
    if unknown := [dim for dim in dims if dim not in units]:
        raise InputError(
            f"the dataset has a dimension {unknown[0]}, which its sweep does not have; select one "
            f"of its values, such as ds.isel({unknown[0]}=0)"
        )
    for name in [one.name for one in table.chosen if one.key not in judged_values(ds)]:
        if name not in ds.coords or ds[name].dims not in ((), (name,)):
            raise InputError(
                f"the dataset has lost its coordinate {name}, or has it along another dimension; "
                "keep it, and take each of its values separately"
            )
    for label, data in ds.coords.items():
        given, unit = data.attrs.get("units"), units.get(str(label))
        if given and unit and not _is_same_unit(given, unit):
            raise InputError(f"{label} of the dataset is in {given}; convert it to {unit}")


def _is_same_unit(given: str, unit: str) -> bool:
    """True if `given` is another spelling of the SI unit `unit`."""
    with suppress(ValueError):
        return given == unit or to_si(f"1 {given}", like=f"1 {unit}") == 1
    return False


def _per_point(ds: xr.Dataset) -> xr.Dataset:
    """Repeat time, load and distance of each step along the dimensions of the points."""
    names = [name for name in (*MADE, "own_grid") if name in ds.coords]
    if not names:  # expanded before
        return ds
    ds = ds.reset_coords(names)
    if "status" not in ds:
        return ds
    status = ds["status"]
    spread = {name: ds[name].broadcast_like(status) for name in names}
    return ds.assign({name: array.transpose(*status.dims, ...) for name, array in spread.items()})


def entry_dims(ds: xr.Dataset | xr.DataArray) -> list[str]:
    """Names of dimensions of varied scene entries and of table rows, not of surfaces."""
    dims = ds["status"].dims if isinstance(ds, xr.Dataset) and "status" in ds else ds.dims
    return [str(dim) for dim in dims if dim not in COORDINATES or dim == VARIANT]


class Layout(Enum):
    """Arrangement of a sweep's points: a grid of loads and velocities, or listed pairs."""

    PLANE = "rows that share loads and velocities"
    PLACES = "rows with a load and a velocity of their own"


def sweep_kind(ds: xr.Dataset) -> Layout:
    """Arrangement of a sweep's points: grid of loads and velocities, or listed pairs."""
    return Layout.PLANE if all(set(ds[name].dims) <= {name} for name in PLANE) else Layout.PLACES


def require_kind(kind: Layout, *kinds: Layout) -> None:
    """Raise an `InputError` unless `kind` is one of the allowed `kinds`."""
    if kind not in kinds:
        raise InputError(_NO_PLANE[kind])


_NO_PLANE = {
    Layout.PLACES: "each row of the sweep has its own load and velocity, so there is no plane of "
    "them; irg margin answers row by row",
}


def require_one_scene(names: Sequence[str]) -> None:
    """Raise an `InputError` if a sweep has several scenes.

    `names` are the entries with several values in the sweep; empty for a single scene.
    """
    if names:
        several = " and ".join(names)
        options = " ".join(f'--at "{name}=..."' for name in names)
        raise InputError(
            f"the sweep has several values of {several}; take one of each: {options}, in Python "
            "pipeline.at"
        )


def ordered(ds: xr.Dataset) -> xr.Dataset:
    """Sort the numeric axes of a dataset, values ascending."""
    numbers = [name for name in entry_dims(ds) if ds[name].dtype.kind == "f"]
    axes = [*numbers, *(dim for dim in ("realization", *PLANE, "cooler_share") if dim in ds.dims)]
    unsorted = [name for name in axes if (np.diff(ds[name].values) < 0).any()]
    return ds.sortby(unsorted) if unsorted else ds


def restore_step(ds: xr.Dataset, *names: str) -> xr.Dataset:
    """Restore the dimension ``step``, of size 1, if a single step was selected from a dataset.

    A dataset that still has this dimension is returned unchanged. Raises an `InputError` if one of
    the variables `names` is missing, or if step 0, the end of each point, was not selected.
    """
    if missing := [name for name in names if name not in ds.variables]:
        raise InputError(f"the dataset has no {', '.join(missing)}; take all of its variables")
    if "step" in ds.coords and not (ds["step"] == 0).any():
        raise InputError(
            "the dataset lacks step 0, the end of each point, which decides: take it, too, "
            "such as by ds.sel(step=0)"
        )
    if "step" in ds.dims:
        return ds
    stepped = [name for name in ds.data_vars if name in STEPPED or name in MADE]
    return ds.drop_vars("step", errors="ignore").assign(
        {name: ds[name].drop_vars("step", errors="ignore").expand_dims("step") for name in stepped}
    )


def end_of_point(ds: xr.Dataset | PathLike) -> xr.Dataset:
    """Select the end of each point: the step at the point's nominal load.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `open_sweep`, or path of the store.

    Returns
    -------
    Dataset
        The dataset at ``step`` 0, without this dimension; NaN at points that are not done.

    Raises
    ------
    InputError
        If step 0 was not selected from the dataset.

    Examples
    --------
    >>> import pipeline
    >>> end = pipeline.end_of_point("results/first_try.zarr")
    >>> end["contact_width"].sel(load=600, velocity=1.6).round(6).item()
    0.000292
    """
    end = restore_step(dataset_of(ds)).isel(step=-1).drop_vars("step", errors="ignore")
    return end.set_coords([name for name in (*MADE, "own_grid") if name in end])
