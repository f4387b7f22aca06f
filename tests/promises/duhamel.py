"""Temperature by all heat so far (Duhamel's principle): what the model with present heat misses.

Between the ends t⁰, t¹, … of steps the flux qᵢ into body i is linear in time. So at tⁿ its surface
is warmer by

    Tᵢ = Bᵢⁿ qᵢⁿ + Hᵢ,   Hᵢ = Σ_{m<n} Bᵢᵐ qᵢᵐ,                                            (1)

where Bᵢᵐ is the present rise due to a flux that grew from 0 to 1 until tᵐ and fell to 0 until tᵐ⁺¹.
By partial integration it follows from means over time of the rise Tᵢ(u) under a constant flux that
began a time u before the present: Bᵢᵐ is the mean between the ages of tᵐ and tᵐ⁻¹, minus the mean
between those of tᵐ⁺¹ and tᵐ. One temperature on the contact then divides the present heat,

    (B₁ⁿ + B₂ⁿ) q₁ⁿ = B₂ⁿ qⁿ + H₂ − H₁.                                                    (2)
"""

import functools
import itertools
import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tribo import Material
from tribo.numerics import Convolution
from tribo.simulation import advance, fit_elements, heat, start
from tribo.thermal import ConductingHalfSpace, contact_quantiles, partition_heat, rise_exceeded

_PANELS = 8  # of the mean from age 0 on, each up to four times the age of the one before
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_AGE_DIGITS = 9  # significant digits of ages, so that equal steps have equal ages


class Conductor(NamedTuple):
    """A half-space that moves along x, heated over a length along y."""

    material: Material
    velocity: float = 0.0  # [m/s]
    length: float = math.inf  # [m]


@functools.lru_cache(maxsize=200)
def mean_spectrum(grid, body, young, old):
    """Spectrum of the map from a constant flux to the rise, averaged over its age [K m²/W]."""
    material, velocity, length = body

    def spectrum(age):
        return ConductingHalfSpace(grid, material, velocity, age, length=length).spectrum

    if young == old:
        return spectrum(old)
    edges = [old]
    while edges[-1] > max(young, old / 4**_PANELS):
        edges.append(max(young, edges[-1] / 4))
    roots, total = np.sqrt(edges[::-1]), 0.0
    for low, high in itertools.pairwise(roots):  # of √u, in which the rise is smooth
        for node, weight in zip(_NODES, _WEIGHTS, strict=True):
            root = (high + low) / 2 + (high - low) / 2 * node
            total = total + weight * (high - low) * root * spectrum(root**2)
    return total / (old - young)


def divide_heat(grid, bodies, times, fluxes, contacts):
    """Divide the heat of each time in turn; return the last `HeatPartition`, by all heat so far.

    `bodies` are the conductors pin and disk, `fluxes` the frictional heat [W/m²] at the `times`
    [s], and `contacts` the masks of the elements that touch.
    """
    into_bodies = [], []
    for step, (time, flux, contact) in enumerate(zip(times, fluxes, contacts, strict=True)):
        ages = [_rounded(time - past) for past in (0.0, *times[: step + 1])]
        earlier_rises = [
            _earlier_rise(grid, body, ages, into_body)
            for body, into_body in zip(bodies, into_bodies, strict=True)
        ]
        maps = [Convolution(grid, mean_spectrum(grid, body, 0.0, ages[-2])) for body in bodies]
        difference = earlier_rises[1] - earlier_rises[0]
        split = partition_heat(*maps, flux, contact, bulk_difference=difference)
        into_bodies[0].append(split.pin_flux)
        into_bodies[1].append(flux - split.pin_flux)
    return replace(split, rise=split.rise + earlier_rises[0])


def _earlier_rise(grid, body, ages, fluxes):
    """Rise due to the fluxes at the earlier times [K]; `ages` begin with that of time 0."""
    rise = np.zeros(grid.shape)
    for old, middle, young, flux in zip(ages, ages[1:], ages[2:], fluxes, strict=False):
        rising = mean_spectrum(grid, body, middle, old)
        rise += Convolution(grid, rising - mean_spectrum(grid, body, young, middle))(flux)
    return rise


def _rounded(age):
    return float(f"{age:.{_AGE_DIGITS}g}")


def rises(scene, load, velocity, share=0.1):
    """Rises for friction 1 that a share of the contact exceeds [K]: by present heat, and by all.

    Both are on the same contact at the end of the loading, with the disk at one position.
    """
    scene = fit_elements(scene, load)
    scene = replace(scene, fidelity=replace(scene.fidelity, history_coarsening=1))
    state, states = start(scene), []
    for load_step in scene.all_load_steps(load):
        state = advance(scene, state, load_step, velocity)
        states.append(state)
    velocities, length = scene.velocities_at(velocity), scene.heated_length
    bodies = (
        Conductor(scene.pin.material, velocities.pin, length),
        Conductor(scene.disk, velocities.disk, length),
    )
    pressures = [state.pressure for state in states]
    split = divide_heat(
        scene.grid,
        bodies,
        [state.time for state in states],
        [velocity * pressure for pressure in pressures],
        [pressure > 0 for pressure in pressures],
    )
    rows = scene.rows_per_element
    quantiles = contact_quantiles(split.rise.repeat(rows, 1), (pressures[-1] > 0).repeat(rows, 1))
    present = heat(scene, state, velocity).rise_quantile
    return tuple(float(rise_exceeded(rise, share)) for rise in (present, quantiles))
