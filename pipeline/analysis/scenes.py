"""A sweep at values of entries that it was computed for, and scene by scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.dataset import dataset_of, entry_dims, has_plane, taken_entries
from pipeline.analysis.tables import frame_of
from pipeline.scene.units import display, to_si
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from tribo import InputError

Result = TypeVar("Result", xr.Dataset, xr.DataArray)

_SHOWN = {"m s-1": "m/s", "m": "mm", "K": "°C", "Pa": "GPa", "m2 N-1": "mm³/(N m)"}
_SHORT = 1e-4  # m: lengths of an entry that are all shorter are shown in µm


def at_entries(ds: xr.Dataset | PathLike, values: Mapping[str, float | str]) -> xr.Dataset:
    """Take a sweep at values of entries for which it was computed.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store, of a scene with ``[sweep] over``.
    values : mapping
        Value by the path of an entry [SI], or text such as ``"2 mm"``.

    Returns
    -------
    Dataset
        The sweep without these dimensions.

    Raises
    ------
    InputError
        If the sweep was not computed for such an entry or value.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.at_entries(ds, {"pin.radius": "2 mm"})
    Traceback (most recent call last):
        ...
    tribo.errors.InputError: pin.radius has one value alone in this sweep; leave it out, or give \
its scene sweep.over, and run it into another store
    """
    ds, others = taken(dataset_of(ds), values)
    for path in others:
        names = entry_dims(ds)
        several = f"; it has several of {', '.join(names)}" if names else ""
        raise InputError(
            f"{path} has one value alone in this sweep{several}; leave it out, or give its "
            "scene sweep.over, and run it into another store"
        )
    return ds


def taken(
    ds: xr.Dataset, values: Mapping[str, float | str]
) -> tuple[xr.Dataset, dict[str, float | str]]:
    """Take a sweep at those values that its table of variants has, and return the others."""
    columns = {*entry_dims(ds), *taken_entries(ds)}
    places = {path: _place(ds[path], values[path]) for path in values if path in columns}
    ds = ds.isel({path: place for path, place in places.items() if path in ds.dims})
    ds = ds.expand_dims([name for name in PLANE if not ds[name].ndim])  # of a row of pairs
    return ds, {path: value for path, value in values.items() if path not in columns}


def scenes(ds: xr.Dataset | PathLike) -> Iterator[xr.Dataset]:
    """The sweep of each scene: with each combination of the values of its entries."""
    ds = dataset_of(ds)
    names = entry_dims(ds)
    for places in np.ndindex(*(ds.sizes[name] for name in names)):
        yield ds.isel(dict(zip(names, places, strict=True)))


def planes(ds: xr.Dataset) -> list[xr.Dataset]:
    """The sweep of each scene; none where rows have places of their own, and no plane."""
    return [*scenes(ds)] if has_plane(ds) else []


def by_scene(ds: xr.Dataset | PathLike, answer: Callable[[xr.Dataset], Result]) -> Result:
    """Answers on each scene side by side; attributes in which they differ become coordinates."""
    ds = dataset_of(ds)
    results, axes = [answer(scene) for scene in scenes(ds)], [ds[name] for name in entry_dims(ds)]
    rows = [result.attrs for result in results]
    names, sizes = [axis.name for axis in axes], [axis.size for axis in axes]
    alike = {k: v for k, v in rows[0].items() if all(k in row and row[k] == v for row in rows)}
    others = {
        name: (names, np.reshape([row.get(name) for row in rows], sizes))
        for name in rows[0]
        if name not in alike
    }
    whole = stacked(results, axes).assign_coords(others)
    whole.attrs = alike
    return whole


def parts_of(boundaries: xr.Dataset) -> Iterator[tuple[tuple[Any, ...], xr.Dataset]]:
    """Boundaries of all scenes one by one, each with the values of its entries."""
    names = entry_dims(boundaries["critical_velocity"])
    for places in np.ndindex(*(boundaries.sizes[name] for name in names)):
        part = boundaries.isel(dict(zip(names, places, strict=True)))
        values = tuple(part[name].item() for name in names)
        attributes = {
            str(name): coord.item()
            for name, coord in part.coords.items()
            if name not in names and set(names) & set(boundaries[name].dims)
        }
        yield values, part.drop_vars([*names, *attributes]).assign_attrs(attributes)


def heads_of(ds: xr.Dataset | xr.DataArray, names: Iterable[str] | None = None) -> dict[str, str]:
    """Heads in a data frame of labels of rows, by default of entries with several values."""
    heads = {}
    for name in entry_dims(ds) if names is None else names:
        unit = _usual_unit(ds[name])
        heads[name] = name if unit in ("", "1") else f"{name} [{unit}]"
    return heads


def _usual_unit(axis: xr.DataArray) -> str:
    """Unit in which the values of an entry are shown."""
    unit = str(axis.attrs.get("units", ""))
    if unit == "m" and abs(axis).max() < _SHORT:
        return "µm"
    return _SHOWN.get(unit, unit)


def frame_by_scene(
    ds: xr.Dataset, frame_of_scene: Callable[[xr.Dataset], pd.DataFrame]
) -> pd.DataFrame:
    """Frames of all scenes below each other, with the values of their entries in front."""
    heads, frames = heads_of(ds["status"]), []
    for scene in scenes(ds):
        frame = frame_of_scene(scene)
        values = frame_of([*heads.values()], [[scene[name].item() for name in heads]] * len(frame))
        frames.append(pd.concat([values, frame], axis="columns"))
    return pd.concat(frames, ignore_index=True)


def stacked(results: Sequence[Result], axes: Sequence[xr.DataArray]) -> Result:
    """Results of all combinations of values along the dimensions of the entries."""
    if not axes:
        return results[0]
    axis, size = axes[0], len(results) // axes[0].size
    parts: list[Any] = [
        stacked(results[begin : begin + size], axes[1:]) for begin in range(0, len(results), size)
    ]
    labels = {name: label for name, label in axis.coords.items() if label.dims == axis.dims}
    parts = [part.drop_vars(labels, errors="ignore") for part in parts]
    options: dict[str, Any] = {"data_vars": "all"} if isinstance(parts[0], xr.Dataset) else {}
    result: Result = xr.concat(
        parts, axis, coords="minimal", compat="override", join="override",
        combine_attrs="drop_conflicts", **options,
    )  # fmt: skip
    return result.assign_coords(labels)


def value_text(axis: xr.DataArray, value: float | str) -> str:
    """A value of an entry in a usual unit."""
    if isinstance(value, str):
        return value
    return display(value, _usual_unit(axis)).removesuffix(" 1").strip()


def words(ds: xr.Dataset, values: Mapping[str, float | str]) -> str:
    """Values of entries of a sweep in words."""
    return ", ".join(f"{path} {value_text(ds[path], value)}" for path, value in values.items())


def entries_in_words(scene: xr.Dataset) -> str:
    """Values of the entries of one of `scenes` in words, as its sweep gives them."""
    return ", ".join(f"{path} {text}" for path, text in taken_entries(scene).items())


def _place(axis: xr.DataArray, value: float | str) -> int:
    """Place of a value along the dimension of an entry."""
    values = np.atleast_1d(axis.values).tolist()
    if isinstance(values[0], str):
        matches = [number for number, held in enumerate(values) if held == value]
    else:
        wanted = _number(value)
        matches = np.flatnonzero(np.isclose(values, wanted, rtol=1e-9, atol=0)).tolist()
    if not matches:
        held = ", ".join(value_text(axis, one) for one in values)
        raise InputError(f"{axis.name} is {value}, which the sweep does not have; it has {held}")
    return int(matches[0])


def _number(value: float | str) -> float:
    """Value of a number or of a quantity [SI]; NaN if it is neither."""
    for read in (float, lambda text: to_si(text, like=text)):
        with suppress(ValueError):
            return read(value)
    return math.nan
