"""Normal contact of an elastic, perfectly plastic half-space.

Find the pressure p and the approach α that minimise ½ pᵀDp + zᵀp over 0 ≤ p ≤ H and Σp·dA = F.
Then the gap g = Dp + z − α is 0 where 0 < p < H, ≥ 0 where p = 0 and ≤ 0 where p = H.

Two iterations take turns. An *active-set step* holds the nodes at their bounds, solves for the
others with a few iterations of conjugate gradients (as Polonsky & Keer, Wear 231, 1999, do with
a single one) and clips the result; near the solution it is fast, but it may cycle. A *projected
gradient step* with Barzilai–Borwein length and exact line search (Birgin, Martínez & Raydan,
SIAM J. Optim. 10, 2000) is slower, but always lowers the energy. It starts the iteration, and
takes over for longer each time that the active-set steps stop making progress, so that the
whole converges from any start.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tribo.elasticity import ElasticHalfSpace
from tribo.errors import ConvergenceError, InputError

__all__ = ["ContactSolution", "solve_contact"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Conjugate gradient iterations in the first active-set step. Each later one, which changes fewer
# nodes' state, may take twice as many, but no more than reduce the residual by the factor.
_INNER_ITERATIONS = 3
_INNER_REDUCTION = 0.1
_SETTLED = 0.2  # share of the contact's nodes that may change state before active-set steps start
_PATIENCE = 3  # active-set steps without progress before gradient steps take over


@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """Pressure and gap of a contact, with the proof of how well they solve it.

    Attributes
    ----------
    pressure : ndarray, shape (nx, ny)
        Between 0 and the hardness [Pa].
    gap : ndarray, shape (nx, ny)
        Deformed gap [m]: 0 where bodies touch, negative where the material yields.
    approach : float
        Rigid displacement α of the bodies towards each other [m], from the datum of the solid.
    iterations : int
        Convolutions with the solid's kernel that were needed.
    residual : float
        Largest violation of the conditions on the gap, in units of D_self·max(p).
    """

    pressure: Array
    gap: Array
    approach: float
    iterations: int
    residual: float


def solve_contact(
    solid: ElasticHalfSpace,
    separation: Array,
    normal_load: float,
    hardness: float = math.inf,
    tolerance: float = 1e-8,
    initial_pressure: Array | None = None,
    max_iterations: int = 5000,
) -> ContactSolution:
    """Press a rigid shape into `solid` with a given load.

    Parameters
    ----------
    solid : ElasticHalfSpace
        The map from pressure to displacement, with its grid.
    separation : ndarray, shape (nx, ny)
        Distance of the undeformed surfaces from an arbitrary plane, z [m].
    normal_load : float
        F on the patch [N], from 0 to hardness times area.
    hardness : float
        Highest pressure that is carried, H [Pa].
    tolerance : float
        Bound on the residual.
    initial_pressure : ndarray, shape (nx, ny), optional
        A guess, scaled to the load; the nearer, the fewer iterations.
    max_iterations : int
        Convolutions after which to give up.

    Returns
    -------
    ContactSolution

    Raises
    ------
    InputError
        If the load exceeds what the hardness can carry, or an input is not finite or of the
        wrong shape.
    ConvergenceError
        If the tolerance is not reached within `max_iterations`.

    Examples
    --------
    A cylinder of radius 8 mm on a flat, 222.2 N/mm (Hertz: 1.010 GPa):

    >>> from tribo.grid import Grid
    >>> grid = Grid((128, 1), (3e-6, 456e-6), periodic=(False, True))
    >>> z = grid.coordinates(0)[:, None] ** 2 / (2 * 8e-3)
    >>> contact = solve_contact(ElasticHalfSpace(grid, 115.385e9), z, 222.2e3 * 456e-6)
    >>> f"{contact.pressure.max() / 1e9:.3f} GPa, residual below 1e-8: {contact.residual < 1e-8}"
    '1.010 GPa, residual below 1e-8: True'
    """
    grid = solid.grid
    z = np.asarray(separation, dtype=np.float64)
    if z.shape != grid.shape:
        raise InputError(f"separation has shape {z.shape}; the grid has {grid.shape}")
    if not np.isfinite(z).all():
        raise InputError("separation holds NaN or inf; every height must be finite")
    capacity = hardness * grid.area
    if not 0 <= normal_load <= capacity * (1 + 1e-12):
        raise InputError(
            f"normal_load is {normal_load:g} N on a patch of {grid.area:g} m²; it must be between 0"
            f" and {capacity:g} N, what the hardness of {hardness:g} Pa carries there"
        )
    total = normal_load / grid.element_area
    if normal_load == 0:
        gap = z - z.min()
        return ContactSolution(np.zeros(z.shape), gap, float(z.min()), 0, 0.0)
    if normal_load >= capacity:
        pressure = np.full(z.shape, hardness)
        gap = solid(pressure) + z
        return ContactSolution(pressure, gap - gap.max(), float(gap.max()), 1, 0.0)
    if initial_pressure is None:
        initial_pressure = _first_guess(z, total, hardness)
    problem = _Problem(solid, z, total, hardness)
    return problem.solve(initial_pressure, tolerance, max_iterations)


class _Problem:
    """One contact problem, and the state of its iteration: pressure and displacement."""

    def __init__(self, solid: ElasticHalfSpace, z: Array, total: float, hardness: float) -> None:
        self.solid, self.z, self.total, self.hardness = solid, z, total, hardness
        self.iterations = 0
        self._inner_iterations = _INNER_ITERATIONS
        self.pressure = np.empty(z.shape)
        self.displacement = np.empty(z.shape)
        self._direction = np.zeros(z.shape)
        self._response = np.empty(z.shape)

    def solve(self, guess: Array, tolerance: float, max_iterations: int) -> ContactSolution:
        self.pressure = _scaled_to_load(guess, self.total, self.hardness)
        self._convolve(self.pressure, self.displacement)
        length = 1 / self.solid.self_influence
        gradient_steps, next_gradient_steps = math.inf, 8.0
        best, without_progress = math.inf, 0
        free_before: Mask | None = None
        while True:
            gap = self.displacement + self.z
            free = (self.pressure > 0) & (self.pressure < self.hardness)
            approach = _approach(gap, free, self.pressure)
            gap -= approach
            inactive = free | _wrong_side(gap, self.pressure, free)
            unit = self.solid.self_influence * float(self.pressure.max())
            residual = float(np.abs(gap[inactive]).max(initial=0.0)) / unit
            if residual <= tolerance or self.iterations >= max_iterations:
                break
            if gradient_steps == math.inf and free_before is not None:
                changed = int(np.count_nonzero(free_before != free))
                if changed <= _SETTLED * max(1, int(np.count_nonzero(self.pressure))):
                    gradient_steps = 0
            free_before = free
            if residual < 0.9 * best:
                best, without_progress = residual, 0
            else:
                without_progress += 1
            if gradient_steps <= 0 and without_progress >= _PATIENCE:
                gradient_steps, next_gradient_steps = next_gradient_steps, 2 * next_gradient_steps
                best, without_progress = residual, 0
            if gradient_steps > 0:
                length = self._gradient_step(gap, length)
                gradient_steps -= 1
            else:
                self._active_set_step(gap, inactive, 0.5 * tolerance * unit)
        solution = ContactSolution(self.pressure, gap, approach, self.iterations, residual)
        if residual > tolerance:
            raise ConvergenceError(
                f"the contact did not converge: residual {residual:.2e} after {self.iterations} "
                f"iterations, asked were {tolerance:.2e}; allow more iterations or a larger "
                "tolerance",
                solution,
            )
        return solution

    def _convolve(self, field: Array, out: Array) -> None:
        self.solid(field, out=out)
        self.iterations += 1

    def _gradient_step(self, gap: Array, length: float) -> float:
        """Move along the projected gradient to the lowest energy; return the next length."""
        step = _projected(self.pressure - length * gap, self.total, self.hardness)
        step -= self.pressure
        self._convolve(step, self._response)
        curvature = float(np.sum(step * self._response))
        slope = float(np.sum(step * gap))
        if not (curvature > 0 and slope < 0):
            return 1 / self.solid.self_influence
        fraction = min(1.0, -slope / curvature)
        self.pressure += fraction * step
        np.clip(self.pressure, 0.0, self.hardness, out=self.pressure)
        self.displacement += fraction * self._response
        if self.iterations % 2:
            return float(np.sum(step * step)) / curvature
        return curvature / float(np.sum(self._response * self._response))

    def _active_set_step(self, gap: Array, inactive: Mask, enough: float) -> None:
        """Conjugate gradients on the inactive nodes alone, then back into the bounds."""
        nodes = np.flatnonzero(inactive)
        pressure = self.pressure.ravel()[nodes]
        residual = gap.ravel()[nodes]
        residual -= residual.mean()
        goal = max(_INNER_REDUCTION * float(np.abs(residual).max()), enough)
        direction = residual.copy()
        square = float(np.sum(residual * residual))
        self._direction[...] = 0.0
        for _ in range(self._inner_iterations):
            if square == 0.0:
                break
            self._direction.ravel()[nodes] = direction
            self._convolve(self._direction, self._response)
            response = self._response.ravel()[nodes]
            response -= response.mean()
            length = square / float(np.sum(response * direction))
            pressure -= length * direction
            residual -= length * response
            self._response *= length
            self.displacement -= self._response
            square, previous = float(np.sum(residual * residual)), square
            if float(np.abs(residual).max()) <= goal:
                break
            direction *= square / previous
            direction += residual
        self._inner_iterations *= 2
        if pressure.min() >= 0 and pressure.max() <= self.hardness:
            self.pressure.ravel()[nodes] = pressure
            return
        at_bounds = self.total - (float(self.pressure.sum()) - float(self.pressure[inactive].sum()))
        self.pressure.ravel()[nodes] = _shifted_to_load(pressure, at_bounds, self.hardness)
        self._convolve(self.pressure, self.displacement)


def _approach(gap: Array, free: Mask, pressure: Array) -> float:
    """The approach for which the gap vanishes on the free nodes on average."""
    if free.any():
        return float(gap[free].mean())
    touching = pressure > 0
    lowest = float(gap[touching].max(initial=-math.inf))
    highest = float(gap[~touching].min(initial=math.inf))
    return lowest if highest == math.inf else (lowest + highest) / 2


def _wrong_side(gap: Array, pressure: Array, free: Mask) -> Mask:
    """Nodes at a bound that the gap drives off it: overlapping, or yielding while apart."""
    wrong: Mask = ~free & ((gap < 0) != (pressure > 0)) & (gap != 0)
    return wrong


def _first_guess(z: Array, total: float, hardness: float) -> Array:
    """A bed of springs under the shape, its stiffness that of the load on its lowest tenth."""
    level = float(np.quantile(z, 0.1))
    penetration = np.maximum(level - z, 0.0)
    weight = float(penetration.sum())
    if weight == 0.0:
        return np.full(z.shape, total / z.size)
    return np.minimum(penetration * (total / weight), hardness)


def _scaled_to_load(guess: Array, total: float, hardness: float) -> Array:
    """Scale a guess towards the sum `total`; what the hardness cuts off goes to its neighbours."""
    pressure = np.clip(guess, 0.0, hardness)
    loaded = pressure > 0
    if total >= hardness * np.count_nonzero(loaded):
        return _projected(pressure, total, hardness)
    scale = total / float(pressure.sum())
    pressure[loaded] = _projected(scale * pressure[loaded], total, hardness)
    return pressure


def _shifted_to_load(pressure: Array, total: float, hardness: float) -> Array:
    """Clip to the bounds, then shift what lies between them so that all sums to `total`."""
    clipped = np.clip(pressure, 0.0, hardness)
    between = (clipped > 0) & (clipped < hardness)
    rest = total - float(clipped.sum()) + float(clipped[between].sum())
    if 0 < rest < hardness * np.count_nonzero(between):
        clipped[between] = _projected(clipped[between], rest, hardness)
        return clipped
    return _projected(pressure, total, hardness)


def _projected(pressure: Array, total: float, hardness: float) -> Array:
    """The nearest field within the bounds that sums to `total`: clip(p + s) with the right s.

    The sum is a continuous, piecewise linear, growing function of s. Newton's method finds its
    root in a few steps, kept inside a bracket that bisection shrinks where Newton leaves it.
    """
    bound = total if hardness == math.inf else hardness
    low = -float(pressure.max())
    high = bound - float(pressure.min())
    shift = 0.0 if low <= 0 <= high else (low + high) / 2
    field = np.empty(pressure.shape)
    for _ in range(200):
        np.add(pressure, shift, out=field)
        moving = np.count_nonzero((field > 0) & (field < hardness))
        np.clip(field, 0.0, hardness, out=field)
        excess = float(field.sum()) - total
        if abs(excess) <= 1e-14 * total or low >= high:
            break
        if excess > 0:
            high = shift
        else:
            low = shift
        following = shift - excess / moving if moving else (low + high) / 2
        if not low < following < high:
            following = (low + high) / 2
        if following == shift:
            break
        shift = following
    return field
