"""Normal contact of an elastic, perfectly plastic half-space.

Find the pressure p and the approach α that minimise ½ pᵀDp + zᵀp over 0 ≤ p ≤ H and Σp·dA = F, with
the map D from pressure to displacement, the separation z of the undeformed surfaces, the hardness
H, the load F and the area dA of an element. Then the gap g = Dp + z − α is 0 where 0 < p < H, ≥ 0
where p = 0 and ≤ 0 where p = H. The pressure returned fulfils these conditions within tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tribo.contact.elasticity import ElasticHalfSpace
from tribo.contact.guess import coarser_guess, window_guess
from tribo.contact.iteration import IterationResult, Limits, iterate
from tribo.contact.problem import Problem, soft_rows
from tribo.contact.simplex import LARGEST, SMALLEST
from tribo.errors import ConvergenceError, InputError, finite_field, require_positive
from tribo.types import Array

_MAX_ROW_SOFTNESS = 1e6  # compliance of a row over an element's, beyond any sensible shape
_FULL_LOAD_ROUNDING = 1e-14  # relative distance to the highest load at which every element yields
_WINDOW_SHARE = 0.9  # share of the tolerance for the contact on a window of the grid
_SINGLE_TOLERANCE = 1e-2  # smallest tolerance for single precision
_MIN_SINGLE = 1e-27  # smallest stress or depth that single precision can transform


@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """Pressure and gap of a contact, with measures of how well they solve it.

    Attributes
    ----------
    pressure : ndarray, shape (nx, ny)
        Contact pressure, between 0 and the hardness [Pa].
    gap : ndarray, shape (nx, ny)
        Deformed gap [m]: 0 where bodies touch, negative where the material yields.
    approach : float
        Rigid displacement α of the bodies towards each other [m], counted from the position with
        the `separation` given. With a periodic axis it is known up to a constant.
    iterations : int
        Number of convolutions with the solid's kernel, rounded up. A convolution on fewer elements
        counts as a fraction.
    residual : float
        Largest violation of the conditions on the gap, plus a bound on the rounding error. Both are
        divided by max(p) times the influence of an element on itself.
    load_error : float
        Relative error of the load, ``|Σp·dA/F − 1|``.
    penetration : float
        Deepest overlap of the bodies where the material does not yield [m].
    plastic_fraction : float
        Share of the contact's nodes whose pressure is the hardness.

    Examples
    --------
    >>> import tribo
    >>> grid = tribo.Grid((65, 1), (4e-6, 1e-3))
    >>> separation = grid.coordinates(0)[:, None] ** 2 / (2 * 8e-3)
    >>> solid = tribo.contact.ElasticHalfSpace(grid, 115e9)
    >>> contact = tribo.contact.solve_contact(solid, separation, normal_load=100.0)
    >>> f"{contact.pressure.max() / 1e9:.2f} GPa", contact.residual < 1e-8
    ('0.68 GPa', True)
    """

    pressure: Array
    gap: Array
    approach: float
    iterations: int
    residual: float
    load_error: float = 0.0
    penetration: float = 0.0
    plastic_fraction: float = 0.0


def solve_contact(
    solid: ElasticHalfSpace,
    separation: Array,
    normal_load: float,
    hardness: float = math.inf,
    tolerance: float = 1e-8,
    initial_pressure: Array | None = None,
    max_iterations: int = 5000,
    initial_displacement: Array | None = None,
) -> ContactSolution:
    """Press a rigid shape into `solid` with a given load.

    Parameters
    ----------
    solid : ElasticHalfSpace
        The map from pressure to displacement, with its grid.
    separation : ndarray, shape (nx, ny)
        Gap between the undeformed surfaces, z [m]. A constant may be added to it, which only
        shifts the approach.
    normal_load : float
        F on the window [N], from 0 to hardness times area.
    hardness : float
        Highest pressure that is carried, H [Pa].
    tolerance : float
        Bound on `ContactSolution.residual`. Rounding allows 1e-12 on 240 × 240 elements, and less
        on fewer. If it is 1e-2 or more, transforms on large grids are in single precision; the
        residual includes their rounding errors.
    initial_pressure : ndarray, shape (nx, ny), optional
        A guess [Pa], which is scaled to the load. A better guess saves iterations.
    max_iterations : int
        Number of convolutions after which to give up.
    initial_displacement : ndarray, shape (nx, ny), optional
        Displacement due to `initial_pressure` [m], if known; it saves iterations. The initial
        pressure must then carry the load, but may exceed the bounds, as extrapolated pressures do.

    Returns
    -------
    ContactSolution
        Pressure and gap, with measures of how well they solve the problem.

    Raises
    ------
    InputError
        If the load is negative or exceeds what the hardness can carry, an input is not finite or
        of the wrong shape, another value is not allowed, or rounding cannot resolve the contact.
    ConvergenceError
        If the tolerance is not reached within `max_iterations`, or is too small for rounding. The
        error carries the `ContactSolution` found.

    Examples
    --------
    A cylinder of radius 8 mm on a flat, 222.2 N/mm (Hertz: 1.010 GPa):

    >>> from tribo.numerics import Grid
    >>> grid = Grid((128, 1), (3e-6, 456e-6), periodic=(False, True))
    >>> z = grid.coordinates(0)[:, None] ** 2 / (2 * 8e-3)
    >>> contact = solve_contact(ElasticHalfSpace(grid, 115.385e9), z, 222.2e3 * 456e-6)
    >>> f"{contact.pressure.max() / 1e9:.3f} GPa, residual below 1e-8: {contact.residual < 1e-8}"
    '1.010 GPa, residual below 1e-8: True'
    """
    grid = solid.grid
    z = finite_field("separation", separation, grid.shape)
    _check_arguments(solid, normal_load, hardness, tolerance, max_iterations)
    if normal_load == 0:
        gap = z - z.min()
        return ContactSolution(np.zeros(z.shape), gap, float(z.min()), 0, 0.0)
    if normal_load >= hardness * grid.area * (1 - _FULL_LOAD_ROUNDING):
        pressure = np.full(z.shape, hardness)
        gap = solid(pressure) + z
        load_error = abs(hardness * grid.area / normal_load - 1)
        return ContactSolution(
            pressure, gap - gap.max(), float(gap.max()), 1, 0.0, load_error, 0.0, 1.0
        )
    problem = Problem.from_solid(solid, z, normal_load / grid.element_area, hardness)
    if tolerance >= _SINGLE_TOLERANCE and _fits_single_precision(solid, normal_load):
        problem = replace(problem, solid=problem.fast)
    if initial_pressure is None:
        guess, guess_cost = coarser_guess(problem)
    else:
        guess, guess_cost = finite_field("initial_pressure", initial_pressure, grid.shape), 0.0
    if initial_displacement is not None:
        finite_field("initial_displacement", initial_displacement, grid.shape)
    else:
        window_limits = Limits(_WINDOW_SHARE * tolerance, max_iterations - guess_cost)
        guess, window_cost = window_guess(problem, guess, window_limits)
        guess_cost += window_cost
    limits = Limits(tolerance, max_iterations)
    result = iterate(problem, guess, limits, initial_displacement, guess_cost)
    solution = _solution(result, hardness)
    if not result.converged:
        raise ConvergenceError(_failure_message(result, limits), solution)
    return solution


def _check_arguments(
    solid: ElasticHalfSpace,
    normal_load: float,
    hardness: float,
    tolerance: float,
    max_iterations: int,
) -> None:
    """Raise `InputError` for an argument with which `solve_contact` has no solution."""
    area = solid.grid.area
    require_positive(tolerance=tolerance, max_iterations=max_iterations)
    if not hardness > 0:
        raise InputError(f"hardness is {hardness!r}; it must be greater than 0")
    capacity = hardness * area
    if not (0 <= normal_load <= capacity * (1 + 1e-12) and normal_load < math.inf):
        raise InputError(
            f"normal_load is {normal_load:g} N on a window of {area:g} m²; it must be finite and "
            f"between 0 and {capacity:g} N, the most at a hardness of {hardness:g} Pa"
        )
    softness = soft_rows(solid).coupling / solid.self_influence
    rounding_error = solid.rounding * softness
    if softness > _MAX_ROW_SOFTNESS and rounding_error > 10 * tolerance:
        raise InputError(
            f"tolerance is {tolerance:.1e}; rounding allows no less than {rounding_error:.1e} "
            f"where rows of elements yield {softness:.1e} times as much as one element does. If "
            "wear makes them yield, use shorter steps"
        )
    stress, depth = _scales(solid, normal_load)
    # An iteration multiplies stresses by depths, and depths by depths.
    in_range = all(SMALLEST < product < LARGEST for product in (stress * depth, depth * depth))
    if normal_load and not in_range:
        raise InputError(
            f"normal_load is {normal_load:g} N on a window of {area:g} m² with an influence of "
            f"{solid.self_influence:g} m/Pa; double precision cannot hold a contact of this size"
        )


def _scales(solid: ElasticHalfSpace, normal_load: float) -> tuple[float, float]:
    """Mean pressure of a load [N] on the window [Pa], and one element's displacement by it [m]."""
    stress = normal_load / solid.grid.area
    return stress, stress * solid.self_influence


def _fits_single_precision(solid: ElasticHalfSpace, normal_load: float) -> bool:
    """True if the pressures and displacements of a contact are in the range of single precision."""
    scales = _scales(solid, normal_load)
    return all(_MIN_SINGLE < scale < 1 / _MIN_SINGLE for scale in scales)


def _solution(result: IterationResult, hardness: float) -> ContactSolution:
    """Convert the result of an iteration to a `ContactSolution` with its measures of error."""
    pressure, gap = result.pressure, result.gap
    saturated = pressure >= hardness
    yielding, touching = np.count_nonzero(saturated), np.count_nonzero(pressure)
    elastic = gap[~saturated] if yielding else gap
    return ContactSolution(
        pressure,
        gap,
        result.approach,
        math.ceil(result.convolutions),
        result.residual,
        load_error=result.load_error,
        penetration=max(0.0, -float(elastic.min(initial=0.0))),
        plastic_fraction=yielding / touching if touching else 0.0,
    )


def _failure_message(result: IterationResult, limits: Limits) -> str:
    """Error message for an iteration that has not converged, with advice to the user."""
    advice = f"allow more than {limits.convolutions} iterations or a larger tolerance"
    if result.stalled:
        largest = float(np.abs(result.displacement).max())
        advice = (
            f"rounding of displacements of {largest:.1e} m allows no less; set a tolerance of at "
            f"least {2 * result.residual:.0e}"
        )
    return (
        f"the contact did not converge: residual {result.residual:.2e} after "
        f"{math.ceil(result.convolutions)} iterations, above {limits.tolerance:.2e}; {advice}"
    )
