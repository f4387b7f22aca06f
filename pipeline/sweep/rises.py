"""Rises at the bulk temperatures of some conditions, and with their corrections.

Where the disk's bulk is Δ warmer than the pin's, rises count from the colder body, at the ratio Δ/µ
(`tribo.thermal.quantiles`), so that they are never negative.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import TYPE_CHECKING, Any

from pipeline.sweep.conditions import Conditions, in_celsius
from tribo import InputError
from tribo.simulation.corrections import NEEDED
from tribo.thermal import with_bulk_ratio

if TYPE_CHECKING:
    import xarray as xr

RISES = ("max_rise", "mean_rise", "rise_quantile")
"""Columns that depend on the bulk temperatures where these differ."""


def at_bulks(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Rises of the contact above the colder body, for each unit of `Conditions.rise_factor` [K].

    Columns are ``rise_quantile`` (..., n_quantile), ``mean_rise`` and ``max_rise`` (...) above the
    pin's bulk at friction 1 [K], and `columns_needed`; all come back, those of `RISES` changed.
    """
    columns = corrected(columns, conditions)
    ratio = conditions.bulk_ratio
    if ratio == 0:
        return columns
    require_bulks(columns, conditions)
    return above_colder(columns, ratio)


def above_colder(columns: Mapping[str, Any], bulk_ratio: float) -> Mapping[str, Any]:
    """Columns with rises at friction 1 above the colder body, at a bulk ratio [K]."""
    above_pin = with_bulk_ratio(columns, bulk_ratio)
    pin = max(0.0, -bulk_ratio)
    return {**above_pin, **{name: above_pin[name] + pin for name in RISES if name in above_pin}}


def columns_needed(conditions: Conditions) -> tuple[str, ...]:
    """Columns that `at_bulks` needs besides the deciding ones of some conditions."""
    unequal = ("bulk_rise_quantile", "mean_bulk_response") if conditions.bulk_ratio else ()
    return unequal + (NEEDED if conditions.corrections else ())


def corrected(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Columns whose rises have the corrections of some conditions, at all bulk ratios."""
    return conditions.corrections.applied(columns) if conditions.corrections else columns


def require_bulks(columns: Container[Any] | xr.Dataset, conditions: Conditions) -> None:
    """Refuse unequal bulk temperatures where nothing is kept for them."""
    kept = "bulk_rise_quantile" in columns or "mean_bulk_response" in columns
    if conditions.disk_temperature is None or kept:
        return
    raise InputError(
        f"bulk_temperature is {in_celsius(conditions.bulk_temperature)} of the pin and "
        f"{in_celsius(conditions.disk_temperature)} of the disk; the sweep was computed for "
        "bodies of one bulk temperature: give one, or run the scene into another store with "
        "bulk = { pin = ..., disk = ... } under [temperature]"
    )
