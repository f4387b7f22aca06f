"""Judge a stored sweep under other conditions or values, without a new simulation.

Conditions that act after the simulation are replaced. Values of entries that vary in the sweep
select its rows. Unknown inputs are fixed. The dataset carries these values with it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, TypedDict

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import (
    dataset_of,
    entry_dims,
    judged_values,
    name_at,
    scene_sweep,
)
from pipeline.analysis.reading import ResultsLike, results
from pipeline.analysis.results import Results
from pipeline.analysis.scenes import value_text
from pipeline.quantities import ALIKE, display
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.conditions import (
    DIMENSIONS,
    FIELDS,
    OIL_WORKS,
    PATHS,
    UNITS,
    Bulk,
    CriterionName,
)
from pipeline.sweep.variants import dimension_of
from pipeline.units import in_si, share_of, to_si
from pipeline.words import did_you_mean
from tribo import InputError
from tribo.types import Array

COLDEST_OIL, HOTTEST_OIL = (in_si("temperature.bulk", end, "1 K") for end in OIL_WORKS)
"""Lowest and highest bulk temperature at which an oil may work [K]."""
_NAMES = {path: name for name, path in PATHS.items()}
_UNITS = {path: UNITS[name] for name, path in FIELDS.items() if name in UNITS}


class ConditionKeywords(TypedDict, total=False):
    """Conditions that answers take as keywords, as `at` does."""

    friction: float | str | Sequence[float] | Array
    bulk_temperature: Bulk | Sequence[float | str]
    critical_temperature: float | str | Sequence[float | str]
    share: float | str | Sequence[float | str]
    criterion: CriterionName
    without_tests: bool


CONDITIONS = {*ConditionKeywords.__annotations__}
"""Names of the conditions that answers take as keywords."""


def at(
    ds: xr.Dataset | PathLike,
    friction: float | str | Sequence[float] | Array | None = None,
    bulk_temperature: Bulk | Sequence[float | str] | None = None,
    critical_temperature: float | str | Sequence[float | str] | None = None,
    share: float | str | Sequence[float | str] | None = None,
    criterion: str | None = None,
    without_tests: Any = False,
    **entries: Any,
) -> xr.Dataset:
    """Judge a sweep under other conditions or values, without a new simulation.

    All answers and figures of the returned dataset are for these values. Several values of a
    condition become a dimension, named by the path of the condition's entry, such as
    ``friction_coefficient`` for ``friction.coefficient``.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path or URL of the store.
    friction : float or several, optional
        Coefficient of friction, at least 0.
    bulk_temperature : float, str or mapping, optional
        Temperature of the bodies far from the contact, as a number in K or text such as
        ``"80 degC"``. If the bodies of the sweep have different temperatures, give both:
        ``{"pin": "60 degC", "disk": "25 degC"}``.
    critical_temperature : float or str, optional
        Temperature above which the lubricant fails, as a number in K or text with a unit.
    share : float or str, optional
        Wear is severe if more than this share of the contact is above the critical temperature,
        such as 0.1 or ``"10%"``. 0 is Blok's criterion: wear is severe if the maximum is above.
    criterion : str, optional
        Contact temperature that is compared with the critical temperature: ``"highest"``,
        ``"mean"``, or ``"share"``, the temperature that `share` of the contact exceeds. In Python
        also a rule of your own, like those in `tribo.CRITERIA`.
    without_tests : bool, optional
        True to leave the tests of the scene out of all answers.
    **entries
        Values by the path of an entry or by its dimension, such as ``pin_radius`` for
        ``pin.radius``, in SI or as text with a unit. An entry with several values
        in the sweep (``[sweep] over``) is restricted to the given values, and ``realization`` to
        the surface with this seed. A condition is replaced, as by the arguments above.

    Returns
    -------
    Dataset
        The same sweep, judged at these values. A single selected load or velocity becomes a
        dimension of size 1.

    Raises
    ------
    InputError
        If a value is outside its range, or an entry needs a new simulation.

    Examples
    --------
    >>> import pipeline
    >>> warmer = pipeline.at("results/first_try.zarr", friction=0.09, bulk_temperature="40 degC")
    >>> pipeline.boundary(warmer)["critical_velocity"].sel(load=600).round(2).item()
    1.51
    >>> several = pipeline.at("results/first_try.zarr", friction=(0.09, 0.103))
    >>> pipeline.boundary(several)["critical_velocity"].sel(load=600).round(2).values
    array([1.93, 1.5 ])
    """
    ds = dataset_of(ds)
    given = {
        "friction": friction,
        "bulk_temperature": bulk_temperature,
        "critical_temperature": critical_temperature,
        "share": share,
        "criterion": criterion,
    }
    wanted = {PATHS[name]: value for name, value in given.items() if value is not None}
    entries = {DIMENSIONS.get(dimension_of(name), name): one for name, one in entries.items()}
    if twice := wanted.keys() & entries.keys():
        path = min(twice)
        raise InputError(f"{path} is given twice, also as {_NAMES[path]}; give it once")
    if without_tests:
        ds = ds.assign_attrs(without_tests="yes")
    ds, wanted = _select_entries(ds, wanted | entries)
    if others := [path for path in wanted if path not in _NAMES]:
        raise InputError(_needs_run(ds, others[0], wanted[others[0]]))
    wanted = {path: _si_value(path, value) for path, value in wanted.items()}
    several = {path: values for path, values in wanted.items() if isinstance(values, list)}
    ds = _record_values(ds, {k: v for k, v in wanted.items() if k not in several})
    for path, values in reversed(several.items()):
        dim = dimension_of(path)
        if path not in _UNITS or (dim in ds.coords and ds[dim].ndim):  # a column of the rows
            raise InputError(f"{path} takes one value at a time here; give one")
        axis = (dim, values, {"units": _UNITS[path], "long_name": path})
        # Only the status gets the new dimension; other variables would be read just to be repeated.
        status = ds["status"].expand_dims({dim: values})
        ds = ds.assign(status=status).assign_coords({dim: axis})
    names = ds.drop_vars("step", errors="ignore").isel(step=[-1], missing_dims="ignore")
    for scene in results(names).scenes if wanted else ():
        _ = scene.plain_conditions  # raises if the sweep lacks what a condition needs
    return ds


def asked_at(ds: ResultsLike, conditions: Mapping[str, Any]) -> Results:
    """Results of a sweep, judged under `conditions` as `at` takes them."""
    if not conditions:
        return results(ds)
    if isinstance(ds, Results):
        names = ", ".join(conditions)
        raise InputError(f"{names} cannot be given for results that were read; give the dataset")
    return results(at(ds, **conditions))


def _si_value(path: str, value: Any) -> Any:
    """Convert one or more values of a condition to SI; a criterion is returned unchanged."""
    name = _NAMES[path]
    if isinstance(value, np.generic | np.ndarray | xr.DataArray):
        value = np.asarray(value).tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        if not len(value):
            raise InputError(f"{name} has no value; give one, or several")
        values = [_si_value(path, one) for one in value]
        if repeated := [given for k, given in enumerate(value) if values[k] in values[:k]]:
            raise InputError(f"{name} is {repeated[0]} twice; give each value once")
        return values
    match name:
        case "bulk_temperature" if isinstance(value, Mapping):
            return {body: oil_temperature(name, one) for body, one in value.items()}
        case "bulk_temperature" | "critical_temperature":
            return oil_temperature(name, value)
        case "criterion":
            return value
        case "share" | "unmodelled_rise":
            return share_of(value)
    if isinstance(value, str):
        with suppress(ValueError):
            return float(value)
        raise InputError(f"{name} is {value!r}; give a number such as 0.1, or several")
    return value


def oil_temperature(name: str, value: float | str) -> float:
    """Convert a temperature, given as a number in K or as text such as "80 degC", to K.

    `name` says which one it is: "bulk_temperature" or "critical_temperature". Raises an
    `InputError` with this name if no oil works at the temperature.
    """
    kelvin = in_si(name, value, "80 degC")
    hottest = HOTTEST_OIL if name == "bulk_temperature" else math.inf
    if kelvin < COLDEST_OIL or hottest < kelvin < math.inf:
        raise InputError(
            f"{name} is {display(kelvin, '°C', 4)} ({kelvin:g} K), at which no oil works; give "
            f"at least {display(COLDEST_OIL, '°C', 4)}; in Python a number is in kelvins, and "
            'text has its unit, such as "80 degC"'
        )
    return kelvin


def _record_values(ds: xr.Dataset, values: Mapping[str, Any]) -> xr.Dataset:
    """Copy of a dataset with `values` [SI], by path of their entry, recorded in its attributes."""
    if not values:
        return ds
    attributes, values = dict(ds.attrs), dict(values)
    both = judged_values(ds) | values
    if PATHS["share"] in values and PATHS["criterion"] not in values:
        both.pop(PATHS["criterion"], None)  # a share alone makes "share" the criterion
    attributes["at"] = json.dumps(both)
    # Drop labels of conditions that are replaced.
    labels = [dimension_of(path) for path in values if path in _NAMES]
    return ds.drop_vars(labels, errors="ignore").assign_attrs(attributes)


def _select_entries(ds: xr.Dataset, values: Mapping[str, Any]) -> tuple[xr.Dataset, dict[str, Any]]:
    """Restrict a dataset to `values` of entries that vary in it; return the other values, too."""
    taken = {name for name, _ in name_at(scene_sweep(ds).variants, ds)}
    columns = {*entry_dims(ds), *taken, *{"realization"}.intersection(map(str, ds.dims))}
    chosen = {dim: one for path, one in values.items() if (dim := dimension_of(path)) in columns}
    for dim, given in chosen.items():
        several = isinstance(given, list | tuple | np.ndarray)
        places = [_value_index(ds[dim], value) for value in (given if several else [given])]
        if dim in ds.dims:
            ds = ds.isel({dim: places if several else places[0]})
    ds = ds.expand_dims([name for name in PLANE if not ds[name].ndim])  # if it is a table's row
    return ds, {path: one for path, one in values.items() if dimension_of(path) not in chosen}


def _value_index(axis: xr.DataArray, value: float | str) -> int:
    """Index of a value along the dimension `axis` of an entry; `InputError` if it is missing."""
    values = np.atleast_1d(axis.values).tolist()
    if isinstance(values[0], str):
        matches = [number for number, one in enumerate(values) if one == value]
    else:
        wanted = _number(value)
        matches = np.flatnonzero(np.isclose(values, wanted, rtol=ALIKE, atol=0)).tolist()
    if not matches:
        known = ", ".join(value_text(axis, one) for one in values)
        raise InputError(f"{axis.name} is {value}, which the sweep does not have; it has {known}")
    return int(matches[0])


def _number(value: float | str) -> float:
    """Convert a number, or text such as "5 N", to SI; NaN for text that is not a quantity."""
    for read in (float, lambda text: to_si(text, like=text)):
        with suppress(ValueError):
            return read(value)
    return math.nan


def _needs_run(ds: xr.Dataset, path: str, value: Any) -> str:
    """Error message: a value of the entry at `path` needs a new run."""
    meant = did_you_mean(path, (*FIELDS, *FIELDS.values()))
    has = f"; it has several values of {', '.join(entry_dims(ds))}" if entry_dims(ds) else ""
    return (
        f"{path} is not one of the entries that this sweep can be judged at{meant}{has}; run the "
        f"scene with {path} = {value} into another store, or into the same one if it acts after "
        "the simulation (irg help scene)"
    )
