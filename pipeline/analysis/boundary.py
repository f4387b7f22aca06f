"""The boundary between mild and severe wear, from a stored sweep and without a new simulation.

Friction, bulk temperature, critical temperature and failing share enter only here, by
`pipeline.sweep.criterion`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.band import with_band
from pipeline.analysis.conditions import Bulk, attributes_by, conditions_of
from pipeline.analysis.dataset import asked, plane_of, variant_of, variants
from pipeline.analysis.decisive import decisive_rise, with_rises
from pipeline.analysis.interpolation import exponent
from pipeline.analysis.scenes import by_scene
from pipeline.analysis.transition import OUTCOMES, UNITS, Transition, range_of
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.lubrication import Lubrication
from tribo import InputError
from tribo.types import Array, Mask

_OUTCOMES = {
    "long_name": "why there is no crossing",
    "flag_values": np.array(list(OUTCOMES), dtype=np.int8),
    "flag_meanings": " ".join(words.replace(" ", "_") for words in OUTCOMES.values()),
}


@by_scene
def boundary(
    ds: xr.Dataset,
    friction: float | Iterable[float] | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
) -> xr.Dataset:
    """Critical velocity for each load and critical load for each velocity.

    Over several random surfaces there is a boundary for each of them, and the band of them all.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or folder or address of the store. Points that are pending
        or failed are skipped.
    friction : float or several, optional
        Coefficient of friction, at least 0; like the following the sweep's own if not given.
        Several give a dimension ``friction``.
    bulk_temperature, critical_temperature : float, str or mapping, optional
        Temperature far from the contact, and the one above which the lubricant fails [K]; or text
        with a unit, such as ``"80 degC"``. In a sweep of bodies of unequal bulk temperatures, such
        as ``{"pin": "60 degC", "disk": "25 degC"}`` for both.
    share : float or str, optional
        Wear is severe where more than this share of the contact area is hotter than the critical
        temperature, such as 0.1 or ``"10%"``; 0 is Blok's criterion, the maximum temperature.
    criterion : str, optional
        Temperature that decides: ``"share"``, which that share exceeds, ``"highest"`` or
        ``"mean"``; see `tribo.CRITERIA`.

    At another wear rate take the boundary of `pipeline.at_wear_rate`.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` [m/s] and ``critical_load(velocity)`` [N]: the first crossing
        from mild to severe wear, NaN where the computed points do not cross. ``outcome_at_load``
        and ``outcome_at_velocity`` give the reason: mild throughout or severe throughout,
        where the outermost points of the scene's own range are done and say so; above or below what
        was computed, where they are not; or not known for want of points. ``computed_from_at_load``
        and ``computed_to_at_load`` are the lowest and highest velocity computed [m/s], likewise
        ``computed_from_at_velocity``. ``rise_exponent_at_load`` is d ln(rise) over
        d ln(velocity) at the crossing: an error of the rise, divided by it, is that of the critical
        velocity. ``missing_at_load`` and
        ``missing_at_velocity`` count the points that are pending or failed. The conditions are
        attributes, and ``missing_points`` their total. Where the scene gives an oil,
        ``film_parameter_at_load`` and ``film_parameter_at_velocity`` are the film parameters at
        the crossings (see `pipeline.sweep.lubrication`).

        All of these have a dimension ``realization`` more over several surfaces, and there are
        ``critical_velocity_quantile(quantile, load)``, the velocity below which 10, 50 and 90 %
        of the surfaces turn severe: those that stay mild or are severe throughout are counted,
        beyond all velocities, so that a quantile among them is NaN. ``critical_velocity_mean``
        and ``critical_velocity_spread`` (standard deviation) are NaN unless every surface
        crosses. ``crossing_at_load`` counts those that do, ``known_at_load`` those that are known
        to cross or not. Likewise for ``critical_load``.

    Raises
    ------
    InputError
        If a condition lies outside its range.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.boundary(ds)["critical_velocity"].round(2).to_series()
    load
    200.0    3.53
    400.0    2.23
    600.0    1.56
    750.0    1.24
    Name: critical_velocity, dtype: float64
    >>> warmer = pipeline.boundary(ds, friction=0.09, bulk_temperature="40 degC")
    >>> warmer["critical_velocity"].sel(load=600).round(2).item()
    1.48
    """
    if isinstance(friction, str):
        raise InputError(f'friction: "{friction}" is text; give a number such as 0.1, or several')
    ds = plane_of(ds)
    others = (bulk_temperature, critical_temperature, share, criterion)
    frictions = list(friction) if isinstance(friction, Iterable) else [friction]
    several = [conditions_of(ds, value, *others) for value in frictions]
    by_variant = [[conditions] * len(variants(ds)) for conditions in several]
    ds = with_rises(ds, [conditions for part in by_variant for conditions in part])
    boundaries = [
        _boundary(ds, conditions, judged)
        for conditions, judged in zip(several, by_variant, strict=True)
    ]
    if not isinstance(friction, Iterable):
        return boundaries[0]
    attrs = {"units": "1", "long_name": "friction coefficient"}
    axis = xr.DataArray([judged.friction for judged in several], dims="friction", attrs=attrs)
    stacked: xr.Dataset = xr.concat(
        boundaries,
        axis.rename("friction"),
        data_vars="all",
        coords="minimal",
        compat="override",
        join="override",
        combine_attrs="drop_conflicts",
    )
    return stacked


def _boundary(
    ds: xr.Dataset, conditions: Conditions, by_variant: Sequence[Conditions]
) -> xr.Dataset:
    """The boundary under some conditions, and those of each surface or sample."""
    axis = variant_of(ds)
    rise = decisive_rise(ds, by_variant)
    rises = rise.values.reshape(len(by_variant), *rise.shape[-2:])
    is_asked = asked(ds).transpose(..., "load", "velocity").values.reshape(rises.shape)
    missing = is_asked & ~np.isfinite(rises)
    columns = _along("velocity", ds, rises, missing, by_variant) | _along(
        "load", ds, rises.swapaxes(1, 2), missing.swapaxes(1, 2), by_variant
    )
    kept = ("load", "velocity", "realization", "sample")
    boundaries = xr.Dataset(
        {
            name: ((axis, dim), values, attrs) if axis else ((dim,), values[0], attrs)
            for name, (dim, values, attrs) in columns.items()
        },
        {name: ds[name].variable for name in kept if name in ds.coords},
        attributes_by(conditions if axis else by_variant[0])
        | {"missing_points": int(np.count_nonzero(missing))}
        | {name: ds.attrs[name] for name in ("wear_rate",) if name in ds.attrs},
    )
    return with_band(boundaries, axis) if axis else boundaries


_Columns = dict[str, tuple[str, Any, dict[str, Any]]]
"""Dimension, values by surface or sample, and attributes of each variable."""


def _along(
    axis: str, ds: xr.Dataset, rises: Array, missing: Mask, by_variant: Sequence[Conditions]
) -> _Columns:
    """Transitions along the velocity or the load.

    Parameters
    ----------
    axis : str
        ``"velocity"`` or ``"load"``; the other one is the lines' dimension.
    ds : Dataset
        Dataset of the sweep.
    rises : ndarray, shape (n_variant, n_line, n)
        Decisive rise along each line [K].
    missing : ndarray of bool, shape (n_variant, n_line, n)
        Points that were asked for and are not done.
    by_variant : sequence of Conditions
        Conditions of each surface or sample.
    """
    line = "load" if axis == "velocity" else "velocity"
    x, ends = ds[axis].values, range_of(ds, axis)
    transitions = [
        [Transition.along(x, row, rise_limit(judged), ends) for row in plane]
        for plane, judged in zip(rises, by_variant, strict=True)
    ]
    places = np.array([[transition.place for transition in row] for row in transitions])
    outcomes = np.array([[transition.outcome for transition in row] for row in transitions])
    computed = np.array([[transition.computed for transition in row] for row in transitions])
    noun = {"velocity": "velocity", "load": "normal load"}[axis]
    columns: _Columns = {
        f"critical_{axis}": (
            line,
            places,
            {"units": UNITS[axis], "long_name": f"{noun} at the transition to severe wear"},
        ),
        f"outcome_at_{line}": (line, outcomes.astype(np.int8), _OUTCOMES),
    }
    for number, end in enumerate(("from", "to")):
        attrs = {"units": UNITS[axis], "long_name": f"{axis} computed {end} at this {line}"}
        columns[f"computed_{end}_at_{line}"] = line, computed[..., number], attrs
    columns[f"missing_at_{line}"] = (
        line,
        np.count_nonzero(missing, axis=-1),
        {"units": "1", "long_name": f"pending or failed points at this {line}"},
    )
    if axis == "velocity":
        columns["rise_exponent_at_load"] = (
            line,
            np.array(
                [
                    [exponent(x, row, place) for row, place in zip(*plane, strict=True)]
                    for plane in zip(rises, places, strict=True)
                ]
            ),
            {"units": "1", "long_name": "d ln(rise) / d ln(velocity) at the crossing"},
        )
    return columns | _film(axis, ds, places, by_variant)


def _film(axis: str, ds: xr.Dataset, places: Array, by_variant: Sequence[Conditions]) -> _Columns:
    """Film parameter at the transitions along an axis, where the scene gives an oil."""
    lubrication = Lubrication.stored(attributes_of(ds))
    if lubrication is None:
        return {}
    line = "load" if axis == "velocity" else "velocity"
    films = [
        lubrication.film_parameter(
            temperature=judged.mean_bulk_temperature, **{line: ds[line].values, axis: row}
        )
        for row, judged in zip(places, by_variant, strict=True)
    ]
    attrs = {"units": "1", "long_name": "film parameter at the crossing"}
    return {f"film_parameter_at_{line}": (line, np.array(films), attrs)}
