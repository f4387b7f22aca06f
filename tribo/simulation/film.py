"""Oil film at the inlet of a worn line contact, and its share of the load.

Oil that is dragged into the inlet builds up the pressure p = −ln(1 − α q)/α at the edge of the
contact, with q = 12 η U ∫ g/(h₀ + g)³ dx over the inlet (Grubin; Reynolds). There g is the gap of
the smooth worn pin beyond the contact, and h₀ the mean gap of the rough surfaces within it. As in
Johnson, Greenwood & Poon (Wear 19, 1972), the film carries a share of the load once this pressure
reaches that share of the mean pressure. On a Hertzian inlet the film agrees with Dowson and Toyoda
(1978) within 5 %. The integral does not depend on the oil, for which `film_excess` evaluates it.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import scipy

from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.material import Oil, contact_modulus
from tribo.numerics import Grid
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.disk_positions import separation_at
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.temperature import refined_scene
from tribo.types import Array, Mask

FILM_SHARE = 0.2
"""Largest share of the load that a film carries within the model."""
_CONTACT_SHARE = 0.02  # of the highest pressure, above which the smooth contact touches
_INNER_SHARE = 0.9  # share of the half-width within which gaps are averaged
_INLET_LENGTH = 30.0  # end of the inlet over that of the window
_NODES = 1001  # of each part of the inlet
_MAX_CONTACT_NODES = 200  # of a smooth contact, whose cost grows with their third power
_MAX_ROUNDS = 30  # of a smooth contact, which needs 4 to 8
_TOLERANCE = 0.2  # of the rough contact, used if nearly all summits yield
_OIL_CONDUCTIVITY = 0.13  # [W/(m K)]


def film_inlet(scene: Scene, state: State) -> tuple[float, float]:
    """Integral of the inlet [1/m] and mean pressure [Pa] of a worn line contact.

    The integral is ∫ g/(h₀ + g)³ dx, while summits carry 80 % of the load and a film the rest. It
    is NaN between smooth bodies. Both values are NaN under a ball or a crowned pin, and without a
    contact.

    Examples
    --------
    >>> import tribo
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> film_inlet(scene, state)  # of a ball
    (nan, nan)
    """
    scene = refined_scene(scene, state)
    length = scene.pin.length
    if length is None or not state.pressure.any():
        return math.nan, math.nan
    x, touches = scene.grid.coordinates(0), state.pressure.max(axis=1) > 0
    step = math.ceil(np.count_nonzero(touches) / _MAX_CONTACT_NODES)
    pin = scene.pin.profile(scene.grid)[:, 0] + state.wear_depth.mean(axis=1)
    displacement, gap, half_width = _smooth_contact(
        _influence_matrix(
            Grid((x[::step].size, 1), (scene.grid.spacing[0] * step, scene.grid.size[1])),
            contact_modulus(scene.pin.material, scene.disk),
        ),
        (x[::step], pin[::step], touches[::step]),
        state.normal_load / length / (scene.grid.spacing[0] * step),
    )
    film = FILM_SHARE * np.interp(x, x[::step], displacement)
    mean_gap = _mean_gap(scene, state, film, np.abs(x) <= _INNER_SHARE * half_width)
    inlet = _inlet_integral(np.abs(x[::step]), gap, half_width, mean_gap, scene.pin.radius)
    return inlet, state.normal_load / length / (2 * half_width)


@functools.lru_cache(maxsize=8)
def _influence_matrix(row: Grid, modulus: float) -> Array:
    """Displacement of each element of a row by unit pressure on each of them [m/Pa]."""
    unit = np.zeros(row.shape)
    unit[0] = 1.0
    influence: Array = scipy.linalg.toeplitz(ElasticHalfSpace(row, modulus)(unit)[:, 0])
    return influence


def _smooth_contact(
    influence: Array, row: tuple[Array, Array, Mask], total: float
) -> tuple[Array, Array, float]:
    """Displacement and gap [m] of an elastic contact of a row, and its half-width [m]."""
    x, separation, touches = row
    for _ in range(_MAX_ROUNDS):
        nodes = np.flatnonzero(touches)
        right_sides = np.stack((np.ones(nodes.size), -separation[nodes]), axis=1)
        cholesky_factor = scipy.linalg.cho_factor(
            influence[np.ix_(nodes, nodes)], check_finite=False
        )
        unit_solution, closing_pressure = scipy.linalg.cho_solve(
            cholesky_factor, right_sides, check_finite=False
        ).T
        approach = (total - closing_pressure.sum()) / unit_solution.sum()
        pressure = np.zeros(x.size)
        pressure[nodes] = closing_pressure + approach * unit_solution
        displacement = influence @ pressure
        gap = displacement + separation - approach
        previous, touches = touches, np.where(touches, pressure > 0, gap < 0)
        if np.array_equal(touches, previous):
            break
    is_loaded = pressure > _CONTACT_SHARE * pressure.max()
    return displacement, gap, float(np.abs(x[is_loaded]).max())


def _mean_gap(scene: Scene, state: State, film: Array, inner_rows: Mask) -> float:
    """Mean gap of the rough contact in the rows `inner_rows` [m], if a film carries its share."""
    solid, dry_pressure = elastic_bodies(scene).solid, state.pressure
    separation = separation_at(scene, None) + state.wear_depth + film[:, None]
    yields = dry_pressure >= scene.hardness
    elastic_sum = float(dry_pressure.sum(where=~yields))
    reduced_sum = elastic_sum - FILM_SHARE * float(dry_pressure.sum())
    # Yielding summits keep their pressure, and other pressures fall in proportion. This is within
    # 1 % of the solution.
    if reduced_sum > 0:
        pressure = np.where(yields, dry_pressure, dry_pressure * (reduced_sum / elastic_sum))
        rows = np.flatnonzero(pressure.any(axis=1) | inner_rows)
        gap = solid(pressure, rows=(int(rows[0]), int(rows[-1]) + 1)) + separation
        gap -= gap.mean(where=(pressure > 0) & ~yields)
    else:
        load = (1 - FILM_SHARE) * float(dry_pressure.sum()) * scene.grid.element_area
        rough_contact = solve_contact(
            solid, separation, load, scene.hardness, _TOLERANCE, (1 - FILM_SHARE) * dry_pressure
        )
        pressure, gap = rough_contact.pressure, rough_contact.gap
    return float(np.where(pressure > 0, 0.0, np.maximum(gap, 0.0))[inner_rows].mean())


def _inlet_integral(
    x: Array, gap: Array, half_width: float, mean_gap: float, radius: float
) -> float:
    """Integral ∫ g/(h₀ + g)³ dx over |x| > `half_width` of one side [1/m]; h₀ is `mean_gap` [m]."""
    if not mean_gap:  # between smooth bodies, where the integral diverges
        return math.nan
    order = np.argsort(x)
    x, gap = x[order], np.maximum(gap[order], 0.0)
    beyond = x >= half_width
    x, gap = np.append(half_width, x[beyond]), np.append(0.0, gap[beyond])
    last = x[-1]
    # Beyond the window the gap is that of the pin's parabola.
    far = np.geomspace(last * 1.001, last * _INLET_LENGTH, _NODES)
    far_gap = gap[-1] + (far**2 - last**2) / (2 * radius)
    nodes = np.linspace(0, 1, _NODES) ** 2 * (last - half_width) + half_width
    positions = np.append(nodes, far)
    g = np.interp(positions, np.append(x, far), np.append(gap, far_gap))
    return float(np.trapezoid(g / (mean_gap + g) ** 3, positions))


def film_excess(
    scene: Scene, oil: Oil, load: float, velocity: float, bulk: float, inlet: float, pressure: float
) -> float:
    """Ln of the ratio of the inlet pressure to the pressure that carries a fifth of the load.

    Above 0 the film carries more than a fifth of the load, which is outside the model. Pressures
    are as at constant viscosity: 12 η U I over q₂₀ = (1 − exp(−0.2 α p))/α, finite for all films.
    The oil is at the `bulk` temperature [K], thinned by the heat of shear in the inlet (Hsu & Lee,
    ASME J. Tribol. 116, 1994). `inlet` [1/m] and `pressure` p [Pa] are those of `film_inlet`.

    The slip in their formula is taken as |u₁ − u₂|/|u₁ + u₂|, which is 1 under a pin at rest. The
    thermal reduction factor of Gupta et al. (Tribology Transactions 35, 1992) supports this. In
    four conditions, the factor is 0.82, 0.91, 0.89 and 0.45 here, and 0.78, 0.90, 0.88 and 0.51
    by their formula. The slide–roll ratio over the mean velocity, twice this slip, makes the factor
    smaller and the difference larger: 0.57 under the pin of the paper at 200 N and 3.75 m/s, where
    this slip gives 0.76 and their formula 0.80. It also lowers the
    result by 0.3 to 0.6 for a pin at rest, so that fewer points are outside the model.
    """
    pin, disk = scene.velocities_at(velocity)
    speed = abs(pin + disk) / 2
    length = scene.pin.length
    viscosity, pressure_coefficient = oil.viscosity(bulk), oil.pressure_coefficient
    if not (speed and length and pressure_coefficient):
        return -math.inf
    modulus = 2 * contact_modulus(scene.pin.material, scene.disk)
    thinning_slope = math.log(oil.viscosity(bulk - 5) / oil.viscosity(bulk + 5)) / 10
    heating_ratio = thinning_slope * viscosity * speed**2 / _OIL_CONDUCTIVITY
    slip_ratio = min(abs(pin - disk) / (2 * speed), 2.0)
    thinning = 1 / (
        1
        + 0.0766
        * (pressure_coefficient * modulus) ** 0.687
        * (load / length / (modulus * scene.pin.radius)) ** 0.447
        * heating_ratio**0.527
        * math.exp(0.875 * slip_ratio)
    )
    inlet_pressure = 12 * viscosity * thinning**1.4 * speed * inlet
    carrying_pressure = (
        -math.expm1(-FILM_SHARE * pressure_coefficient * pressure) / pressure_coefficient
    )
    return math.log(inlet_pressure / carrying_pressure) if inlet_pressure > 0 else -math.inf
