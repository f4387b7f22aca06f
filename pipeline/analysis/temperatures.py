"""Temperatures of the contact under some conditions, from a stored sweep."""

from __future__ import annotations

import xarray as xr

from pipeline.analysis.conditions import Bulk, attributes_by, conditions_of
from pipeline.analysis.dataset import plane_of, sweep_at_bulks
from pipeline.analysis.decisive import decisive_rise, refined
from pipeline.analysis.scenes import by_scene
from pipeline.sweep.criterion import contact_temperature, failed_fraction


@by_scene
def decisive_temperature(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    resolution: int | None = None,
    own_laws: bool = False,
) -> xr.DataArray:
    """Deciding temperature of the contact at each point, the highest while its load is held.

    Wear is severe where it lies above the critical temperature.

    Parameters
    ----------
    ds, friction, bulk_temperature, critical_temperature, share, criterion, own_laws
        See `boundary`.
    resolution : int, optional
        Interpolate onto so many loads and velocities, evenly spaced.

    Returns
    -------
    DataArray, dims (load, velocity), after ``realization`` over several surfaces
        Temperature [K]; NaN at points that are pending or failed.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> temperature = pipeline.decisive_temperature(ds, friction=0.12)
    >>> temperature.sel(load=600, velocity=1.6).round().item()
    444.0
    """
    ds = plane_of(ds)
    conditions = conditions_of(
        ds, friction, bulk_temperature, critical_temperature, share, criterion, own_laws
    )
    rise = decisive_rise(ds, conditions)
    if resolution is not None:
        rise = refined(rise, resolution)
    temperature = contact_temperature(rise, conditions)
    temperature.attrs = {
        "units": "K",
        "long_name": f"deciding temperature, {conditions.decisive.temperature}",
        **attributes_by(conditions),
    }
    return temperature.rename("decisive_temperature")


@by_scene
def temperatures(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
) -> xr.Dataset:
    """Temperatures of the contact, at each station of each point.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, a part of it, or the path of a store. The whole of a large
        sweep takes much memory: select loads and velocities first.
    friction, bulk_temperature, critical_temperature
        See `boundary`.

    Returns
    -------
    Dataset
        ``max_temperature`` and ``mean_temperature`` of the contact, ``temperature_quantile`` that a
        share ``cooler_share`` of the contact area stays below [K]; and, where there is a critical
        temperature, ``failed_fraction``, the share of the contact area above it.

    Examples
    --------
    >>> import pipeline
    >>> point = pipeline.open_sweep("results/first_try.zarr").sel(load=600, velocity=1.6)
    >>> end = pipeline.end_of_point(point)
    >>> pipeline.temperatures(end)["max_temperature"].round().item()
    436.0
    >>> pipeline.temperatures(end, friction=0.12)["max_temperature"].round().item()
    463.0
    """
    # No temperature depends on the criterion, and that of a store may be code.
    conditions = conditions_of(
        ds, friction, bulk_temperature, critical_temperature, criterion="share"
    )
    rises = sweep_at_bulks(ds, conditions)
    attributes = attributes_by(conditions)
    del attributes["criterion"]
    result = xr.Dataset(attrs=attributes)
    for name, rise, meaning in (
        ("max_temperature", "max_rise", "highest temperature"),
        ("mean_temperature", "mean_rise", "mean temperature"),
        ("temperature_quantile", "rise_quantile", "quantile of the temperature"),
    ):
        result[name] = contact_temperature(rises[rise], conditions).drop_attrs()
        result[name].attrs = {"units": "K", "long_name": f"{meaning} of the contact"}
    if conditions.critical_temperature is not None:
        share = xr.apply_ufunc(
            failed_fraction,
            rises["rise_quantile"],
            input_core_dims=[["cooler_share"]],
            kwargs={"conditions": conditions},
            vectorize=True,
        )
        result["failed_fraction"] = share.where(rises["max_rise"].notnull())
        result["failed_fraction"].attrs = {
            "units": "1",
            "long_name": "share of the contact above the critical temperature",
        }
    return result
