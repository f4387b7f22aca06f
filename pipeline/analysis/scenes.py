"""A sweep scene by scene: answers side by side, and points told apart by the id of their scene.

xarray joins datasets of different scenes silently, and keeps the attributes of the first. So each
point has the coordinate ``scene_id``. The attribute of this name has the ids of the rows of the
scene that answers are about.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.quantities import display, shown_in
from pipeline.scene.reference import number_at, path_of_dimension
from pipeline.scene.units import typeset
from pipeline.store.schema import DONE, IDS, SCENE_ID
from pipeline.sweep.variants import Label, Variants
from tribo import InputError
from tribo.types import Array

_OWN = {"m": "mm", "K": "°C", "Pa": "GPa", "m s-1": "m/s"}
"""Usual units for columns that the user added, by SI unit."""
_NAMED = 6  # most values of an axis in a message


def side_by_side(answers: list[xr.Dataset], axes: Sequence[xr.DataArray]) -> xr.Dataset:
    """Join answers for several scenes along `axes`; differing attributes become coordinates."""
    rows = [result.attrs for result in answers]
    names: list[str] = [str(axis.name) for axis in axes]
    sizes = [axis.size for axis in axes]
    alike: dict[str, Any] = {
        k: v for k, v in rows[0].items() if all(k in row and row[k] == v for row in rows)
    }
    others = {
        name: (names, np.reshape([row.get(name) for row in rows], sizes))
        for name in dict.fromkeys(itertools.chain(*rows))
        if name not in {*alike, *names}
    }
    for axis in reversed(axes):
        labels = {name: label for name, label in axis.coords.items() if label.dims == axis.dims}
        parts = [one.drop_vars(labels, errors="ignore") for one in answers]
        answers = [
            xr.concat(
                parts[start : start + axis.size], axis, data_vars="all", coords="minimal",
                compat="override", join="override", combine_attrs="drop_conflicts",
            ).assign_coords(labels)
            for start in range(0, len(parts), axis.size)
        ]  # fmt: skip
    whole = answers[0].assign_coords(others)
    whole.attrs = alike
    return whole


def attribute_values(boundaries: xr.Dataset, name: str) -> list[Any]:
    """Values of an attribute of a boundary: a single one, or one for each scene if they differ."""
    if name in boundaries.coords:
        return list(boundaries[name].values.ravel().tolist())
    return [boundaries.attrs[name]] if name in boundaries.attrs else []


def heads_of(ds: xr.Dataset, names: Iterable[str]) -> dict[str, str]:
    """Column headings with units for coordinates of a dataset, by name."""
    heads = {}
    for name in names:
        unit = _usual_unit(ds[name])
        heads[name] = name if unit in ("", "1") else f"{name} [{unit}]"
    return heads


def shown_label(axis: xr.DataArray, value: Any) -> Any:
    """Convert a value of the coordinate `axis` from SI to the unit of its column heading."""
    unit = _usual_unit(axis)
    is_other = unit != axis.attrs.get("units") and not isinstance(value, str)
    return shown_in(value, unit) if is_other else value


def _usual_unit(axis: xr.DataArray) -> str:
    """Unit in which users are shown values of the coordinate `axis`, such as "mm" for a radius."""
    path, unit = path_of_dimension(str(axis.name)), str(axis.attrs.get("units", ""))
    own = typeset(number_at(path).unit)
    return own if own and unit else _OWN.get(unit, unit)


def value_text(axis: xr.DataArray, value: float | str) -> str:
    """Write a value of an entry, whose coordinate is `axis`, as text with a unit."""
    if isinstance(value, str):
        return value
    return display(value, _usual_unit(axis)).removesuffix(" 1").strip()


def words(ds: xr.Dataset, values: Mapping[str, float | str]) -> str:
    """Values of entries in words, such as "pin_radius 2 mm"."""
    return ", ".join(f"{name} {value_text(ds[name], value)}" for name, value in values.items())


def identify(ds: xr.Dataset, ids: Sequence[int], table: Variants) -> xr.Dataset:
    """Copy of a dataset with the scene id of each point as a coordinate, and `ids` as attribute.

    `ids` has the id of each row of the sweep's `table` of variants.
    """
    about, rows = IDS[SCENE_ID], _row_ids(ds, ids, table)
    rows = rows.isel(dict.fromkeys(set(rows.dims) - set(ds["status"].dims), 0))
    here = xr.zeros_like(ds["status"].variable, about.dtype) + rows
    attributes = {"long_name": about.long_name, "units": about.units}
    coordinate = xr.Variable(here.dims, here.values.astype(about.dtype), attributes)
    return ds.assign_coords({SCENE_ID: coordinate}).assign_attrs({SCENE_ID: json.dumps(ids)})


def require_one_sweep(ds: xr.Dataset, table: Variants) -> None:
    """Raise an `InputError` if points belong to another scene than the attributes describe.

    `table` has the rows of the sweep that the attributes describe. A dataset without the coordinate
    ``scene_id`` is not checked.
    """
    if SCENE_ID not in ds.variables:
        return
    if SCENE_ID not in ds.attrs:
        raise InputError(
            f"the dataset has lost its attribute {SCENE_ID}, as happens if datasets of several "
            "scenes are joined; answer each scene by itself"
        )
    ids, wanted = ds[SCENE_ID].variable, _row_ids(ds, json.loads(ds.attrs[SCENE_ID]), table)
    is_same = np.rint(ids) == wanted  # interpolation leaves a float
    for dim in set(is_same.dims) - set(ids.dims):  # a single row was selected
        matches = is_same.sum([other for other in is_same.dims if other != dim])
        is_same = is_same.isel({dim: int(np.argmax(matches.values))})
    not_computed = np.isnan(ids)
    if "status" in ds:
        not_computed = not_computed & (ds["status"].variable != DONE)
    if (wrong := ~(is_same | not_computed)).any():
        raise InputError(
            f"the dataset mixes scenes: points at {_places_in_words(ds, wrong)} are of another "
            f"scene than its attributes describe, by {SCENE_ID}; answer each scene by itself"
        )


def _row_ids(ds: xr.Dataset, ids: Sequence[int], table: Variants) -> xr.Variable:
    """Scene ids of a dataset's rows, from `ids` of all rows; dimensions that it lacks are kept."""
    axes = table.axes
    whole = xr.Variable([*axes], np.reshape(ids, [len(values) for values in axes.values()]))
    return whole.isel(
        {
            name: xr.Variable(ds[name].dims, _numbers(values, ds[name].values))
            for name, values in axes.items()
            if name in ds.coords
        }
    )


def _numbers(values: Sequence[Label], labels: Any) -> Array:
    """Index in `values` of the value nearest to each label, which may have lost its last digits."""
    index, flat = pd.Index(values), np.ravel(labels)
    if index.dtype.kind in "if":
        order = index.argsort()
        numbers = order[index[order].get_indexer(flat, method="nearest")]
    else:
        numbers = index.get_indexer(flat)
    return np.reshape(numbers, np.shape(labels))


def _places_in_words(ds: xr.Dataset, wrong: xr.Variable) -> str:
    """List where `wrong` marks points of another scene, by load and by axes that matter."""
    words = []
    for dim in sorted(map(str, wrong.dims), key=lambda dim: dim != "load"):
        among = wrong.any([other for other in wrong.dims if other != dim]).values
        if dim == "load" or not among.all():
            unit = ds[dim].attrs.get("units", "")
            values = ds[dim].values[among].tolist()
            shown = [f"{one:g}" if isinstance(one, float) else str(one) for one in values[:_NAMED]]
            listed = ", ".join(shown) + ", …" * (len(values) > _NAMED)
            words.append(f"{dim} {listed} {unit}".removesuffix(" 1").strip())
    return ", ".join(words) or "its place"
