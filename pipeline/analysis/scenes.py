"""A sweep scene by scene: answers side by side."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pipeline.quantities import display, shown_in
from pipeline.units import typeset

_OWN = {"m": "mm", "K": "°C", "Pa": "GPa", "m s-1": "m/s"}
"""Usual units for columns that the user added, by SI unit."""


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
    unit, own = str(axis.attrs.get("units", "")), str(axis.attrs.get("shown_in", ""))
    return typeset(own) if own and unit else _OWN.get(unit, unit)


def value_text(axis: xr.DataArray, value: float | str) -> str:
    """Write a value of an entry, whose coordinate is `axis`, as text with a unit."""
    if isinstance(value, str):
        return value
    return display(value, _usual_unit(axis)).removesuffix(" 1").strip()


def words(ds: xr.Dataset, values: Mapping[str, float | str]) -> str:
    """Values of entries in words, such as "pin_radius 2 mm"."""
    return ", ".join(f"{name} {value_text(ds[name], value)}" for name, value in values.items())
