"""A sweep at values of entries and wear rates that it was computed for, and scene by scene.

A point at the velocity V and the sweep's own wear rate k has the contacts of V' = Vk/k' at the rate
k', so that rows at several rates share contacts. Between them the logarithm of the rise is
interpolated over that of the rate, as it is between velocities.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import scipy  # loads its parts when they are used
import xarray as xr

from pipeline.analysis.dataset import (
    attributes_of,
    dataset_of,
    entry_dims,
    has_plane,
    is_emulated,
    own_wear_rate,
    with_wear_rates,
)
from pipeline.analysis.tables import frame_of
from pipeline.scene.units import display, in_si, to_si
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.variants import WEAR_RATE
from tribo import InputError
from tribo.types import Array

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
        The sweep without these dimensions. With a value of every entry its attributes are those
        of the scene with these values.

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


def at_wear_rate(ds: xr.Dataset | PathLike, wear_rate: float | str | None) -> xr.Dataset:
    """Take a sweep at a specific wear rate, without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store, of a scene with
        ``[sweep] wear_rates``.
    wear_rate : float or str or None
        Specific wear rate [m²/N] or text such as ``"2e-6 mm^3/(N m)"``, within those of the sweep;
        its own if None.

    Returns
    -------
    Dataset
        The sweep with its contacts at the velocities at which this rate has them, and their rises;
        these only from when the load of a point is reached on. Without fields, since those were
        stored at the sweep's own rate alone. The attribute ``wear_rate`` is the rate [m²/N].

    Raises
    ------
    InputError
        If the sweep does not answer for that wear rate.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.at_wear_rate(ds, "2e-6 mm^3/(N m)")
    Traceback (most recent call last):
        ...
    tribo.errors.InputError: wear_rate is 2e-06 mm³/(N m); the sweep was computed for its own \
rate alone, 1.2e-06 mm³/(N m): give its scene sweep.wear_rates, and run it into another store
    """
    rows, ds = with_wear_rates(ds), dataset_of(ds)
    if wear_rate is None:
        return ds
    rate = in_si("wear_rate", wear_rate, "2e-6 mm^3/(N m)")
    if is_emulated(ds):
        raise InputError(
            f"wear_rate is {display(rate, 'mm³/(N m)', 4)}, but these samples have it as an input; "
            f'give --at "wear.specific_wear_rate={rate * 1e9:g} mm^3/(N m)", in Python '
            "pipeline.Ensemble.of"
        )
    attributes = attributes_of(ds)
    stored_rate = own_wear_rate(ds)
    if rate == stored_rate:
        return ds.assign_attrs(wear_rate=rate)
    _require_known(rate, stored_rate, rows)

    def at_rate(name: str) -> xr.DataArray:
        values = rows[name].transpose(*ds[name].dims, WEAR_RATE).values
        return ds[name].copy(data=_power_law(rows[WEAR_RATE].values, values, rate))

    scale, quantile = stored_rate / rate, at_rate("rise_quantile")
    changed = {
        "rise_quantile": quantile,
        "mean_rise": at_rate("mean_rise"),
        "max_rise": quantile.isel(cooler_share=-1),
        "sliding_distance": ds["sliding_distance"] * scale,
        "pin_heat_share": at_rate("pin_heat_share"),
    }
    changed = {name: values.assign_attrs(ds[name].attrs) for name, values in changed.items()}
    velocities = (ds["velocity"] * scale).assign_attrs(ds["velocity"].attrs)
    left_out = [name for name in ds.data_vars if "x" in ds[name].dims]
    coords = {"velocity": velocities, WEAR_RATE: rate}
    return (
        ds.drop_vars(left_out)
        .assign(changed)
        .assign_coords(coords)
        .assign_attrs(
            wear_rate=rate,
            velocities=json.dumps([v * scale for v in attributes.get("velocities", [])]),
            title=f"{attributes.get('title')}, wear rate {display(rate, 'mm³/(N m)', 4)}",
        )
    )


def _require_known(rate: float, stored_rate: float, rows: xr.Dataset) -> None:
    text = f"wear_rate is {display(rate, 'mm³/(N m)', 4)}; the sweep was computed for"
    if not stored_rate:
        raise InputError(f"{text} a pin that does not wear, and has no others")
    if WEAR_RATE not in rows.dims:
        raise InputError(
            f"{text} its own rate alone, {display(stored_rate, 'mm³/(N m)', 4)}: give its scene "
            "sweep.wear_rates, and run it into another store"
        )
    low, high = rows[WEAR_RATE].values[[0, -1]].tolist()
    if not low * (1 - 1e-9) <= rate <= high * (1 + 1e-9):
        ends = " to ".join(display(end, "mm³/(N m)", 4) for end in (low, high))
        raise InputError(f"{text} {ends}: give one within")


def _power_law(rates: Array, rises: Array, rate: float) -> Array:
    """Rises at a rate, between those at others along the last axis; NaN where one is not known."""
    positive = np.all(rises > 0, axis=-1, keepdims=True)
    logarithms = np.log(np.where(positive, rises, 1.0))
    curve = scipy.interpolate.PchipInterpolator(np.log(rates), logarithms, axis=-1)
    power_law = np.exp(curve(np.log(rate)))
    is_finite = np.isfinite(rises).all(axis=-1)
    return np.where(is_finite, np.where(positive[..., 0], power_law, 0.0), np.nan)


def taken(
    ds: xr.Dataset, values: Mapping[str, float | str]
) -> tuple[xr.Dataset, dict[str, float | str]]:
    """Take a sweep at those values that its table of variants has, and return the others."""
    columns = {*entry_dims(ds), *(attributes_of(ds).get("entries") or ())}
    places = {path: _place(ds[path], values[path]) for path in values if path in columns}
    ds = ds.isel({path: place for path, place in places.items() if path in ds.dims})
    ds = ds.expand_dims([name for name in PLANE if not ds[name].ndim])  # of a row of pairs
    return dataset_of(ds), {path: value for path, value in values.items() if path not in columns}


def scenes(ds: xr.Dataset | PathLike) -> Iterator[xr.Dataset]:
    """The sweep of each scene: with each combination of the values of its entries."""
    return map(dataset_of, with_all_wear_rates(ds))


def planes(ds: xr.Dataset) -> list[xr.Dataset]:
    """The sweep of each scene; none where rows have places of their own, and no plane."""
    return [*scenes(ds)] if has_plane(ds) else []


def with_all_wear_rates(ds: xr.Dataset | PathLike) -> Iterator[xr.Dataset]:
    """The sweep of each scene at all its wear rates."""
    ds = with_wear_rates(ds)
    names = entry_dims(ds)
    for places in np.ndindex(*(ds.sizes[name] for name in names)):
        yield ds.isel(dict(zip(names, places, strict=True)))


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
    entries = attributes_of(scene).get("entries") or {}
    return ", ".join(f"{path} {text}" for path, text in entries.items())


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
