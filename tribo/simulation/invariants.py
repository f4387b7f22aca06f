"""Laws that every result obeys, checked on every result.

Errors of a solver may escape its own criteria. Its results are therefore checked by laws that do
not depend on the method of solution:

=====================  ===========================================================================
load balance           Σp·dA is the load
pressure bounds        0 ≤ p ≤ H
complementarity        gap and pressure exclude each other within the tolerance
wear balance           the worn volume is that of the law, and nowhere does the pin grow back
heat balance           the heat flow into both bodies is the frictional heat, and 0 elsewhere
common temperature     both surfaces are equally warm within the tolerance
finite                 no field holds NaN or inf
=====================  ===========================================================================

A violation raises `InvariantError`. The checks take a hundredth of the time of a step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from tribo.errors import InvariantError, RangeError
from tribo.thermal import HeatPartition
from tribo.types import Array, Mask

# Sums over a million nodes lose less than 1e-13, and the contact solver allows itself 1e-12.
_BALANCE = 1e-10
_NO_HEAT = 1e-200  # total flux [W/m²] whose rise is below the range of double precision
_QUIET = np.errstate(over="ignore", invalid="ignore")  # the checks report NaN and infinity


@_QUIET
def check_contact(
    pressure: Array,
    normal_load: float,
    element_area: float,
    hardness: float,
    residual: float,
    tolerance: float,
) -> None:
    """Check that a contact carries its load, keeps the pressure bounds and has a small residual.

    `normal_load` is on the whole pin [N], `element_area` the area that an element represents [m²].
    Raises an `InvariantError` if the contact does not.

    Examples
    --------
    >>> check_contact(np.array([[1e9, 0.0]]), normal_load=2e-3, element_area=1e-12, hardness=2e9,
    ...               residual=1e-9, tolerance=1e-8)
    Traceback (most recent call last):
        ...
    tribo.errors.InvariantError: load balance: the pressure carries 0.001 N, the load is 0.002 N
    """
    carried = float(pressure.sum()) * element_area
    _require_finite("pressure", carried, pressure)
    if not abs(carried - normal_load) <= _BALANCE * normal_load:
        raise InvariantError(
            f"load balance: the pressure carries {carried:.12g} N, the load is {normal_load:.12g} N"
        )
    lowest, highest = float(pressure.min()), float(pressure.max())
    if not 0 <= lowest <= highest <= hardness:
        raise InvariantError(
            f"pressure bounds: pressures from {lowest:.12g} to {highest:.12g} Pa; they must lie "
            f"between 0 and the hardness of {hardness:.12g} Pa"
        )
    if not residual <= tolerance:
        raise InvariantError(
            f"complementarity: the conditions on the gap are violated by {residual:.2e}; "
            f"the tolerance is {tolerance:.2e}"
        )


@_QUIET
def check_wear(before: Array, after: Array, area: float, volume: float) -> None:
    """Check that wear depths after a step add up to the worn `volume`, and that none decreased.

    `before` and `after` are the depths of all elements before and after the step [m]. `volume` is
    the volume that the pin has lost since the start by the wear law [m³]. `area` is the area of the
    whole pin that one element represents [m²]. Raises an `InvariantError` if a check fails.

    Examples
    --------
    >>> h = np.array([[1e-9, 3e-9]])
    >>> check_wear(h, 2 * h, area=1e-12, volume=9e-21)
    Traceback (most recent call last):
        ...
    tribo.errors.InvariantError: wear balance: the pin has lost 8e-21 m³, its law gives 9e-21 m³
    """
    total = float(after.sum())
    _require_finite("wear depth", total, after)
    lost = total * area
    smallest = after.size * float(np.finfo(np.float64).tiny) * area  # smallest representable volume
    if not abs(lost - volume) <= _BALANCE * volume + smallest:
        raise InvariantError(
            f"wear balance: the pin has lost {lost:.12g} m³, its law gives {volume:.12g} m³"
        )
    growth = float((after - before).min())
    if growth < 0:
        raise InvariantError(f"wear balance: the pin has grown back by {-growth:.12g} m somewhere")


@_QUIET
def check_heat(
    heat_flux: Array,
    contact: Mask,
    split: HeatPartition,
    tolerance: float,
) -> None:
    """Check heat balance and common temperature of a contact.

    `heat_flux` is the frictional heat [W/m²], and `split` its partition. `tolerance` is the largest
    `HeatPartition.residual` allowed, the relative difference of both surfaces' temperatures. Raises
    an `InvariantError` if a check fails.
    """
    _require_finite("rise", float(split.rise.sum()), split.rise)
    total_heat = float(heat_flux.sum())
    into_pin = float(split.pin_flux.sum())
    _require_finite("pin flux", into_pin, split.pin_flux)
    on_contact = split.pin_flux[contact]
    magnitude = float(np.abs(on_contact).sum())
    stray_count = np.count_nonzero(split.pin_flux) - np.count_nonzero(on_contact)
    if stray_count:
        raise InvariantError(f"heat balance: heat flows at {stray_count} nodes outside the contact")
    if not total_heat > _NO_HEAT:
        return
    into_disk = (1 - split.pin_share) * total_heat
    if not abs(into_pin + into_disk - total_heat) <= _BALANCE * (total_heat + magnitude):
        raise InvariantError(
            f"heat balance: {into_pin:.12g} flows into the pin and {into_disk:.12g} into the "
            f"disk, {total_heat:.12g} is generated by friction"
        )
    if not split.residual <= tolerance:
        raise InvariantError(
            f"common temperature: the surfaces differ by {split.residual:.2e} of their rise; "
            f"the tolerance is {tolerance:.2e}"
        )


@contextmanager
def guard_range(computation: str) -> Iterator[None]:
    """Context manager: turn numbers beyond double precision into a `RangeError`.

    `computation` names the computation in the message.
    """
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise", under="ignore"):
            yield
    except (FloatingPointError, OverflowError, ZeroDivisionError) as error:
        raise RangeError(
            f"{computation}: {error.args[-1]}; a value of the scene is too large or too small for "
            "double precision"
        ) from error


def _require_finite(name: str, total: float, field: Array) -> None:
    """Raise `InvariantError`, with the location, if the sum `total` of a field is not finite."""
    if math.isfinite(total):
        return
    nonfinite = np.argwhere(~np.isfinite(field))
    location = (
        f"at {tuple(nonfinite[0].tolist())}, counted from 0" if nonfinite.size else "in its sum"
    )
    raise InvariantError(f"finite: the {name} holds NaN or inf {location}")
