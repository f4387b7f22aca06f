"""A stored sweep as a labelled dataset, whose attributes any format of file can hold."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.store.place import PathLike
from pipeline.store.read import open_store
from pipeline.store.schema import COORDINATES, PLANE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import RISES, at_bulks, columns_needed, corrected_columns
from pipeline.sweep.variants import VARIANT, Variant
from tribo import InputError
from tribo.types import Array

_ENCODED = "json_attributes"
_decoded = functools.lru_cache(maxsize=64)(json.loads)  # each surface has the attributes of all
_INTERNAL = ("axes", "root_hash", "points_per_chunk", "generation")


def portable(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes of a store as netCDF holds them, others as JSON, and what computed the data."""
    kept = {k: v for k, v in attributes.items() if v is not None and k not in _INTERNAL}
    plain = (name for name, value in kept.items() if type(value) in (str, int, float))
    encoded = sorted(kept.keys() - set(plain))
    return (
        kept
        | {name: json.dumps(kept[name], ensure_ascii=False) for name in encoded}
        | {_ENCODED: " ".join(encoded)}
        | _provenance(attributes)
    )


def with_changes(attributes: Mapping[Any, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Portable attributes after changes; a change to None removes an attribute."""
    new = portable(changes)
    names = {*str(attributes.get(_ENCODED, "")).split(), *new[_ENCODED].split()}
    kept = {name: value for name, value in attributes.items() if name not in changes}
    return kept | new | {_ENCODED: " ".join(sorted(names & {*kept, *new}))}


def attributes_of(ds: xr.Dataset | xr.DataArray) -> dict[Any, Any]:
    """Attributes of a sweep as plain data, with JSON read; cached, so do not change them."""
    attributes = dict(ds.attrs)
    for name in str(attributes.get(_ENCODED, "")).split():
        if isinstance(attributes.get(name), str):
            attributes[name] = _decoded(attributes[name])
    return attributes


def _provenance(attributes: Mapping[Any, Any]) -> dict[str, str]:
    """Versions that computed a store, and the times at which others went on with it."""
    versions = attributes.get("versions")
    if not versions:
        return {}

    def listed(versions: Mapping[str, str]) -> str:
        others = ", ".join(f"{name} {it}" for name, it in versions.items() if name != "tribo")
        return f"irg-transition {versions['tribo']} with {others}"

    later = attributes.get("later_versions", [])
    lines = [f"computed by {listed(versions)}"]
    lines += [f"{entry['since']}: gone on with by {listed(entry['versions'])}" for entry in later]
    for entry in attributes.get("worker_versions", []):
        others = ", ".join(f"{name} {version}" for name, version in entry["versions"].items())
        lines.append(f"{entry['since']}: some points computed by workers with {others}")
    return {
        "source": f"simulated by irg-transition {versions['tribo']}",
        "history": "\n".join(lines),
        "license": "BSD-3-Clause for the program that computed this; the data are their author's",
    }


_USUAL = {*COORDINATES, "friction"}
_ORDER = (*PLANE, "step", "bulk_ratio", "cooler_share")


def open_sweep(path: PathLike) -> xr.Dataset:
    """Open a stored sweep.

    Parameters
    ----------
    path : str or path
        Folder or address of a store that `pipeline.run_sweep` has made; it may still be growing.

    Returns
    -------
    Dataset
        The stored variables, with loads, velocities and seeds of surfaces ascending. At ``step`` 0
        is the end of each point, at −1 the station before; steps before a point's first station and
        points that are not done are NaN. Data are read when they are used.
        Attributes are text and numbers, those that are more as JSON, so that ``to_netcdf`` writes
        them. `pipeline.temperatures` gives the temperatures of the contact.

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
    0.00029
    """
    ds = ordered(open_store(path))
    ds = ds.drop_vars("checksum")
    words = [name for name, values in ds.coords.items() if values.dtype.kind == "T"]
    ds = ds.assign_coords({name: ds[name].astype(object) for name in words})  # as netCDF has text
    return ds.drop_attrs(deep=False).assign_attrs(portable(ds.attrs))


def dataset_of(source: xr.Dataset | PathLike) -> xr.Dataset:
    """The dataset of a sweep, with what one scene says alone where entries have one value each."""
    return _of_one_scene(opened(source))


def opened(source: xr.Dataset | PathLike) -> xr.Dataset:
    """The dataset of a sweep, opened if given by its path."""
    return ordered(source) if isinstance(source, xr.Dataset) else open_sweep(source)


def entry_dims(ds: xr.Dataset | xr.DataArray) -> list[str]:
    """Dimensions of rows that are not drawn, such as entries with several values by their paths."""
    dims = ds["status"].dims if isinstance(ds, xr.Dataset) and "status" in ds else ds.dims
    return [
        str(dim)
        for dim in dims
        if dim not in _USUAL or (dim == VARIANT and VARIANT not in _drawn(ds))
    ]


def _of_one_scene(ds: xr.Dataset) -> xr.Dataset:
    """The sweep with the attributes of its one scene, where entries have one value each."""
    attributes = attributes_of(ds)
    paths = attributes.get("over", [])
    if not paths or any(path in ds.dims or path not in ds.coords for path in paths):
        return ds
    values = [ds[path].item() for path in paths]
    here = next(scene for scene in attributes["scenes"] if scene["values"] == values)
    words = ", ".join(f"{path} {text}" for path, text in zip(paths, here["written"], strict=True))
    changes = here["attributes"] | {
        "over": None,
        "scenes": None,
        "scene": attributes["scene"] | here["scene"],
        "title": f"{attributes['title']}, {words}",
        "entries": dict(zip(paths, here["written"], strict=True)),
    }
    return ds.drop_attrs(deep=False).assign_attrs(with_changes(ds.attrs, changes))


def plane_of(source: xr.Dataset | PathLike) -> xr.Dataset:
    """Dataset of a sweep with loads and velocities; one of rows with own places is refused."""
    ds = dataset_of(source)
    require_plane(ds)
    require_one_scene(ds)
    return ds


def require_plane(ds: xr.Dataset) -> None:
    """Raise an `InputError` at a sweep whose rows have places of their own."""
    if not has_plane(ds):
        raise InputError(
            "the sweep has rows with places of their own, and no plane of velocities and loads; "
            "irg margin, plot, report and diff take pairs row by row, and of samples irg risk, "
            "boundary, margin and plot tell the probabilities, in Python pipeline.Ensemble.of(ds)"
        )


def has_plane(ds: xr.Dataset) -> bool:
    """True if all rows share the velocities, and none has one of its own."""
    return all(set(ds[name].dims) <= {name} for name in PLANE)


def is_emulated(ds: xr.Dataset) -> bool:
    """True if rows were drawn from distributions, and an emulator of them answers."""
    return bool(attributes_of(ds).get("unknown"))


def require_samples(ds: xr.Dataset, given_measured: bool, scatter: float | None) -> None:
    """Refuse to weigh inputs by tests where there are no samples of them."""
    if not is_emulated(ds) and (given_measured or scatter is not None):
        raise InputError(
            "the sweep has no samples, to which --given-measured and --scatter belong (in Python "
            "given_measured and scatter)"
        )


def require_one_scene(ds: xr.Dataset) -> None:
    """Raise an `InputError` at a sweep in which entries have several values."""
    if names := entry_dims(ds):
        several = " and ".join(names)
        options = " ".join(f'--at "{name}=..."' for name in names)
        raise InputError(
            f"the sweep has several values of {several}; take one of each: {options}, in Python "
            "pipeline.at_entries"
        )


def ordered(ds: xr.Dataset) -> xr.Dataset:
    """Sort the axes of a sweep, which a store keeps in the order in which they grew."""
    numbers = [name for name in entry_dims(ds) if ds[name].dtype.kind == "f"]
    axes = [*numbers, *(name for name in (*_drawn(ds), *PLANE) if name in ds.dims)]
    unsorted = [name for name in axes if (np.diff(ds[name].values) < 0).any()]
    return ds.sortby(unsorted) if unsorted else ds


def variant_of(ds: xr.Dataset | xr.DataArray) -> str | None:
    """Dimension of the surfaces or samples: ``"realization"``, ``"variant"`` or none."""
    return next((name for name in _drawn(ds) if name in ds.dims), None)


def _drawn(ds: xr.Dataset | xr.DataArray) -> tuple[str, ...]:
    """Dimensions of rows that differ by chance; those of the table may be chosen, or samples."""
    return ("realization", VARIANT) if "sample" in ds.coords else ("realization",)


def values_of(ds: xr.Dataset, name: str) -> Any:
    """Values of a variable, its dimensions in the usual order, those of the rows first."""
    return _in_order(ds[name]).values


def _in_order(array: xr.DataArray) -> xr.DataArray:
    return array.transpose(..., *_ORDER, missing_dims="ignore")


def at_realization(ds: xr.Dataset, seed: int | None) -> xr.Dataset:
    """Take the sweep on the surface of a seed; the whole sweep if None."""
    if seed is None:
        return ds
    held = ds.indexes.get("realization", pd.Index([]))
    if seed not in held:
        others = f"it holds {', '.join(map(str, held))}" if len(held) else "it has no others"
        raise InputError(f"realization is {seed}, which the sweep does not hold; {others}")
    return ds.sel(realization=seed)


def one_row(ds: xr.Dataset, seed: int | None) -> xr.Dataset:
    """Take the sweep of one scene on the surface of a seed, on the first one if None."""
    ds = at_realization(plane_of(ds), seed)
    return ds.isel({name: 0 for name in _drawn(ds) if name in ds.dims})


def drawn_row(ds: xr.Dataset) -> Variant:
    """Seed of the surface, or number of the sample, at which a sweep was taken."""
    return tuple(
        (name, ds[name].item()) for name in _drawn(ds) if name in ds.coords.keys() - ds.dims
    )


def asked(ds: xr.Dataset) -> xr.DataArray:
    """Points that the last run asked for: all of its scene, or those it chose."""
    return ds["asked"] != 0 if "asked" in ds else xr.ones_like(ds["status"], bool)


def sweep_at_bulks(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """Take rises of a sweep at the bulk temperatures of conditions, above the colder body."""
    if conditions.bulk_ratio == 0 and not conditions.corrections:
        return ds
    return _with_rises(ds, conditions, at_bulks)


def corrected_sweep(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """Take the rises of a sweep with the corrections of some conditions, at all bulk ratios."""
    return _with_rises(ds, conditions, corrected_columns) if conditions.corrections else ds


def corrected_field(point: xr.Dataset, rise: Array, conditions: Conditions) -> Array:
    """Rise over the window at the end of a point with corrections, shape of `rise` [K]."""
    columns = {name: point[name].values for name in columns_needed(conditions)}
    line = {"rise_quantile": np.tile([0.0, 1.0], (len(columns["time"]), 1))}
    zero, one = corrected_columns(columns | line, conditions)["rise_quantile"][-1]
    field: Array = zero + (one - zero) * rise
    return field


def _with_rises(
    ds: xr.Dataset,
    conditions: Conditions,
    judged: Callable[[Mapping[str, Any], Conditions], Mapping[str, Any]],
) -> xr.Dataset:
    """The sweep with rises under some conditions in place of its own."""
    if conditions.corrections and "step" not in ds.dims:
        return _with_rises(ds.expand_dims("step"), conditions, judged).isel(step=0)
    names = [name for name in (*RISES, "bulk_rise_quantile") if name in ds]
    needed = ("bulk_rise_quantile", "mean_bulk_response", *columns_needed(conditions))
    columns = {name: values_of(ds, name) for name in dict.fromkeys((*names, *needed)) if name in ds}
    changed = judged(columns, conditions)
    return ds.assign(
        {name: (_in_order(ds[name]).dims, changed[name], ds[name].attrs) for name in names}
    )


def end_of_point(ds: xr.Dataset | PathLike) -> xr.Dataset:
    """Take each point at its end, at the load that it is named after.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `open_sweep`, or path of the store.

    Returns
    -------
    Dataset
        At ``step`` 0, without that dimension; NaN where a point is not done.

    Examples
    --------
    >>> import pipeline
    >>> end = pipeline.end_of_point("results/first_try.zarr")
    >>> end["contact_width"].sel(load=600, velocity=1.6).round(6).item()
    0.00029
    """
    return dataset_of(ds).isel(step=-1).drop_vars("step")
