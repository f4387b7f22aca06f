"""Heat partition with the full history of the heat flow (Duhamel's principle).

Between the ends t⁰, t¹, … of time steps the flux qᵢ into body i is linear in time. So at tⁿ its
surface is warmer by

    Tᵢ = Bᵢ⁰ qᵢⁿ + Hᵢ,   Hᵢ = Σ_{m<n} Bᵢᵐ qᵢᵐ,                                            (1)

where Bᵢᵐ is the rise now due to a flux that grew from 0 to 1 before tᵐ and fell to 0 after it,
and Bᵢ⁰ the rise due to a flux that has grown since the last step. One temperature on the
contact then replaces Eq. (1) of `partition` by

    (B₁⁰ + B₂⁰) q₁ⁿ = B₂⁰ qⁿ + H₂ − H₁.                                                    (2)

Bᵢᵐ depends only on the age of a step. For steps of equal length it is thus computed once for each
number of steps passed, and Hᵢ is summed in Fourier space with one inverse transform. After a few
steps only the longest waves of a flux along a periodic axis still matter, and no modes of a moving
flux. Other modes are dropped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tribo.material import Material
from tribo.numerics import Convolution, Grid, padded_shape
from tribo.thermal.conduction import HeatedLength, flux_history_spectrum
from tribo.thermal.partition import HeatPartition, partition_heat
from tribo.types import Array, Mask, Spectrum

_AGE_DIGITS = 9  # significant digits of ages, so that equal steps have equal ages


class Conductor(NamedTuple):
    """A heat-conducting half-space that moves along x, under a flux through its surface.

    Attributes
    ----------
    material : Material
        Material of the half-space.
    velocity : float
        Velocity along x [m/s].
    length : float or "nearest-image"
        Length along y that is heated [m], or the window and its nearer periodic images; as in
        `ConductingHalfSpace`.

    Examples
    --------
    >>> import tribo
    >>> disk = Conductor(steel, velocity=1.5)
    >>> disk.length
    inf
    """

    material: Material
    velocity: float
    length: HeatedLength = math.inf


SpectrumOf = Callable[[Grid, Conductor, tuple[float, ...], tuple[float, ...]], Spectrum]
"""Function that returns the spectrum of the map from a past heat flux to the present rise.

Arguments: grid, body, ages of the flux [s], and its dimensionless strengths at these ages.
"""


def conducted_spectrum(
    grid: Grid, body: Conductor, ages: tuple[float, ...], strengths: tuple[float, ...]
) -> Spectrum:
    """Spectrum of the map from a past heat flux into a body to its present rise [K m²/W].

    The flux varied as `strengths`, dimensionless, at the `ages` before now [s], and linearly in
    between. The shape is (mx, c): columns after the first c are 0, and omitted.
    """
    return flux_history_spectrum(
        grid, body.material, body.velocity, ages, strengths, length=body.length
    )


@dataclass(frozen=True, slots=True, eq=False)
class HeatHistory:
    """Heat flux into both bodies up to now. It is linear in time between the `times`.

    Attributes
    ----------
    times : tuple of float
        Ends of the time steps [s]. The first time is 0, when there was no flux.
    pin_flux, disk_flux : tuple of ndarray, shape (mx, n)
        Fourier transforms of the flux into each body [W/m²], one for each time after the first.
        There are mx modes along x, and the n lowest modes along y. Higher modes along y are left
        out once they no longer affect the temperature.

    Examples
    --------
    >>> import numpy as np
    >>> history = HeatHistory()
    >>> history.times
    (0.0,)
    """

    times: tuple[float, ...] = (0.0,)
    pin_flux: tuple[Spectrum, ...] = ()
    disk_flux: tuple[Spectrum, ...] = ()


def partition_with_history(
    grid: Grid,
    pin: Conductor,
    disk: Conductor,
    history: HeatHistory,
    time: float,
    heat_flux: Array,
    contact: Mask,
    tolerance: float = 1e-8,
    spectrum_of: SpectrumOf = conducted_spectrum,
) -> tuple[HeatPartition, HeatHistory]:
    """Divide the present frictional heat between the bodies, with the effect of earlier heat.

    Parameters
    ----------
    grid : Grid
        Grid of all fields, at rest relative to the heat sources.
    pin, disk : Conductor
        The two bodies.
    history : HeatHistory
        Heat that has flowed up to an earlier time.
    time : float
        Present time, counted from when the heat began [s].
    heat_flux, contact, tolerance
        Present friction heat [W/m²], elements that touch, and the accuracy of the division; as in
        `tribo.thermal.partition_heat`.
    spectrum_of : callable, optional
        Function that returns the spectrum of the map from a past flux to the present rise [K m²/W].
        It may be cached: steps of equal length need the same spectra again.

    Returns
    -------
    HeatPartition
        Present partition; its rise includes the remaining rise due to earlier heat.
    HeatHistory
        Heat that has flowed up to now.

    Examples
    --------
    Under a flux that grows in proportion to time, a plane gets 2/3 of the rise that the final flux
    would cause if it had acted from the start. Half of the heat flows into each body.

    >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> plane = Grid((2, 2), (1e-6, 1e-6), periodic=(True, True))
    >>> body, history, everywhere = Conductor(steel, 0.0), HeatHistory(), np.ones((2, 2), bool)
    >>> for time in (0.5, 1.0, 1.5, 2.0):
    ...     flux = np.full((2, 2), 1e6 * time)
    ...     split, history = partition_with_history(
    ...         plane, body, body, history, time, flux, everywhere)
    >>> from tribo.analytic import uniform_flux_rise
    >>> print(f"{split.rise[0, 0] / uniform_flux_rise(1e6, 2.0, steel.thermal_effusivity):.9f}")
    0.666666667
    """
    (pin_past, pin_fluxes), (disk_past, disk_fluxes) = (
        _past_rise(grid, body, history.times, time, fluxes, spectrum_of)
        for body, fluxes in ((pin, history.pin_flux), (disk, history.disk_flux))
    )
    step = _rounded_age(time - history.times[-1])
    present_pin, present_disk = (
        Convolution(grid, spectrum_of(grid, body, (0.0, step), (1.0, 0.0))) for body in (pin, disk)
    )
    split = partition_heat(
        present_pin,
        present_disk,
        heat_flux,
        contact,
        tolerance=tolerance,
        bulk_difference=disk_past - pin_past,
    )
    pin_flux, disk_flux = (
        np.fft.rfft2(flux, s=padded_shape(grid))
        for flux in (split.pin_flux, heat_flux - split.pin_flux)
    )
    return (
        replace(split, rise=split.rise + pin_past),
        HeatHistory((*history.times, time), (*pin_fluxes, pin_flux), (*disk_fluxes, disk_flux)),
    )


def _past_rise(
    grid: Grid,
    body: Conductor,
    times: tuple[float, ...],
    present: float,
    fluxes: tuple[Spectrum, ...],
    spectrum_of: SpectrumOf,
) -> tuple[Array, list[Spectrum]]:
    """Present rise due to earlier fluxes [K], and the spectra of these without faded modes."""
    mx, my = padded_shape(grid)
    total = np.zeros((mx, my // 2 + 1), dtype=complex)
    cropped_fluxes = []
    ages = [_rounded_age(present - time) for time in times] + [0.0]
    for old, middle, young, flux in zip(ages, ages[1:], ages[2:], fluxes, strict=False):
        if flux.shape[1]:
            influence = spectrum_of(grid, body, (young, middle, old), (0.0, 1.0, 0.0))
            mode_count = min(flux.shape[1], influence.shape[1])
            total[:, :mode_count] += influence[:, :mode_count] * flux[:, :mode_count]
            flux = flux[:, :mode_count].copy() if mode_count < flux.shape[1] else flux
        cropped_fluxes.append(flux)
    rise = np.fft.irfft2(total, s=(mx, my))[: grid.shape[0], : grid.shape[1]]
    return rise, cropped_fluxes


def _rounded_age(time: float) -> float:
    return float(f"{time:.{_AGE_DIGITS}g}")
