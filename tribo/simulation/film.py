"""The oil film that the inlet of a worn line contact builds up, and whether it carries load.

Oil that is dragged into the inlet builds up the pressure p = −ln(1 − α q)/α at the edge of the
contact, with q = 12 η U ∫ g/(h₀ + g)³ dx over the inlet (Grubin; Reynolds). There g is the gap of
the smooth worn pin beyond the contact, and h₀ the mean gap of the rough surfaces within it. As in
Johnson, Greenwood & Poon (Wear 19, 1972), the film carries a share of the load once this pressure
reaches that share of the mean pressure. On a Hertzian inlet the film agrees with Dowson and Toyoda
(1978) within 5 %. The integral knows no oil; `film_excess` compares it with one.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.material import Oil, contact_modulus
from tribo.numerics import Grid
from tribo.simulation.disk_positions import separation_at
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.temperature import refined_scene
from tribo.types import Array

SHARE = 0.2
"""Share of the load that a film carries at most, within the model."""
_TOUCHES = 0.02  # of the highest pressure, from which on the smooth contact counts as touching
_INSIDE = 0.9  # half-widths within which gaps count as those of the contact
_FARTHEST, _NODES = 30.0, 4001  # end of the inlet over that of the window, and nodes of each part
_TOLERANCES = 0.05, 0.12  # of the smooth contact, and of the rough one that carries the rest
# The rough contact is solved on a quarter of the window along y, which moves `film_excess` by up to
# 0.04 of the shipped scenes, and takes a quarter of the time.
_STRIPS = 4
_OIL_CONDUCTIVITY = 0.13  # [W/(m K)]


def film_inlet(scene: Scene, state: State) -> tuple[float, float]:
    """Integral of the inlet [1/m] and mean pressure [Pa] of a worn line contact.

    The integral is ∫ g/(h₀ + g)³ dx, while summits carry 80 % of the load and a film the rest. Both
    values are NaN under a ball or a crowned pin, and without a contact.

    Examples
    --------
    >>> import tribo
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> tribo.film_inlet(scene, state)  # of a ball
    (nan, nan)
    """
    scene = refined_scene(scene, state)
    if scene.pin.length is None or not state.pressure.any():
        return math.nan, math.nan
    grid, load = scene.grid, state.normal_load * scene.grid.size[1] / scene.pin.length
    modulus = contact_modulus(scene.pin.material, scene.disk)
    row = _solid_of(
        Grid((grid.shape[0], 1), (grid.spacing[0], grid.size[1]), grid.periodic), modulus
    )
    smooth = solve_contact(
        row,
        scene.pin.profile(grid)[:, :1] + state.wear_depth.mean(axis=1, keepdims=True),
        load,
        scene.hardness,
        tolerance=_TOLERANCES[0],
        initial_pressure=state.pressure.mean(axis=1, keepdims=True),
    )
    x, pressure = np.abs(grid.coordinates(0)), smooth.pressure[:, 0]
    half_width = float(x[pressure > _TOUCHES * pressure.max()].max())
    rows = max(grid.shape[1] // _STRIPS, 1)
    strip = Grid((grid.shape[0], rows), grid.spacing, grid.periodic)
    rough = solve_contact(
        _solid_of(strip, modulus),
        (separation_at(scene, None) + state.wear_depth)[:, :rows] + SHARE * row(smooth.pressure),
        (1 - SHARE) * load * rows / grid.shape[1],
        scene.hardness,
        tolerance=_TOLERANCES[1],
        initial_pressure=(1 - SHARE) * state.pressure[:, :rows],
    )
    within = float(np.maximum(rough.gap, 0.0)[x <= _INSIDE * half_width].mean())
    inlet = _inlet_integral(x, smooth.gap[:, 0], half_width, within, scene.pin.radius)
    return inlet, state.normal_load / scene.pin.length / (2 * half_width)


@functools.lru_cache(maxsize=8)
def _solid_of(grid: Grid, modulus: float) -> ElasticHalfSpace:
    return ElasticHalfSpace(grid, modulus)


def _inlet_integral(x: Array, gap: Array, half_width: float, within: float, radius: float) -> float:
    """Integral ∫ g/(h₀ + g)³ dx over |x| > `half_width` of one side [1/m]; h₀ is `within` [m].

    Beyond the window the gap goes on as the parabola of the pin.
    """
    order = np.argsort(x)
    x, gap = x[order], np.maximum(gap[order], 0.0)
    beyond = x >= half_width
    x, gap = np.append(half_width, x[beyond]), np.append(0.0, gap[beyond])
    last = x[-1]
    far = np.geomspace(last * 1.001, last * _FARTHEST, _NODES)
    far_gap = gap[-1] + (far**2 - last**2) / (2 * radius)
    nodes = np.linspace(0, 1, _NODES) ** 2 * (last - half_width) + half_width
    places = np.append(nodes, far)
    g = np.interp(places, np.append(x, far), np.append(gap, far_gap))
    return float(np.trapezoid(g / (within + g) ** 3, places))


def film_excess(
    scene: Scene, oil: Oil, load: float, velocity: float, bulk: float, inlet: float, pressure: float
) -> float:
    """Ln of the pressure that the inlet builds up, over that which carries a fifth of the load.

    Above 0 the film carries more than a fifth of the load, which is outside the model. Pressures
    are as at constant viscosity: 12 η U I over q₂₀ = (1 − exp(−0.2 α p))/α, finite for all films.
    The oil is at the `bulk` temperature [K], thinned by the heat of shear in the inlet (Hsu & Lee
    1994). `inlet` [1/m] and `pressure` p [Pa] are those of `film_inlet`.
    """
    first, second = scene.velocities_at(velocity)
    speed = abs(first + second) / 2
    length = scene.pin.length
    if not (speed and length):
        return -math.inf
    eta, alpha = oil.viscosity(bulk), oil.pressure_coefficient(bulk)
    modulus = 2 * contact_modulus(scene.pin.material, scene.disk)
    slope = math.log(oil.viscosity(bulk - 5) / oil.viscosity(bulk + 5)) / 10
    heating = slope * eta * speed**2 / _OIL_CONDUCTIVITY
    sliding = min(abs(first - second) / (2 * speed), 2.0)
    thinning = 1 / (
        1
        + 0.0766
        * (alpha * modulus) ** 0.687
        * (load / length / (modulus * scene.pin.radius)) ** 0.447
        * heating**0.527
        * math.exp(0.875 * sliding)
    )
    built = 12 * eta * thinning**1.4 * speed * inlet
    needed = -math.expm1(-SHARE * alpha * pressure) / alpha
    return math.log(built / needed) if built > 0 else -math.inf
