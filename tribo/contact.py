"""Normal contact of an elastic, perfectly plastic half-space.

Find the pressure p and the approach α that minimise ½ pᵀDp + zᵀp over 0 ≤ p ≤ H and Σp·dA = F.
Then the gap g = Dp + z − α is 0 where 0 < p < H, ≥ 0 where p = 0 and ≤ 0 where p = H.

Two iterations take turns. An *active-set step* holds the nodes at their bounds, solves for the
others with a few iterations of conjugate gradients (as Polonsky & Keer, Wear 231, 1999, do with
a single one) and clips the result; near the solution it is fast, but it may cycle. A *projected
gradient step* with Barzilai–Borwein length and exact line search (Birgin, Martínez & Raydan,
SIAM J. Optim. 10, 2000) is slower, but always lowers the energy. It starts the iteration, and
takes over for longer each time that the active-set steps stop making progress, so that the
whole converges from any start. Where rows of elements are soft as a whole, both go by the metric
of `rows`.

Displacements are updated along with the pressure rather than computed anew, which costs digits.
No result is given out before what that may have cost is known to lie within the tolerance, or the
displacement of the very pressure that is given out has been computed. A tolerance below what
rounding allows ends in an error that says so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from tribo.elasticity import ElasticHalfSpace
from tribo.errors import ConvergenceError, InputError, finite_field, require_positive
from tribo.rows import RowMetric

__all__ = ["ContactCriterion", "ContactSolution", "solve_contact"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ContactCriterion = Literal["gap", "pressure-change"]

# Conjugate gradient iterations in the first active-set step. Each later one, which changes fewer
# nodes' state, may take twice as many, but no more than reduce the residual by the factor.
_INNER_ITERATIONS = 3
_INNER_REDUCTION = 0.1
_SETTLED = 0.2  # share of the contact's nodes that may change state before active-set steps start

_SOFT = 0.05  # coupling within rows, in units of an element's compliance, worth a `RowMetric`
_VERY_SOFT = 1e6  # the same, far beyond elements of any shape
_PATIENCE = 3  # active-set steps without progress before gradient steps take over

# What updates may cost of the displacement, once and each, in rounding errors of its largest
# value: observed are 8 for all updates of a solution together, and 70 where it began far off.
_LOST_AT_ONCE, _LOST_A_STEP = 100.0, 10.0
_AT_ROUNDING = 32.0  # the same, of a residual that rounding keeps from falling
_LOST_BY_TRANSFORM = 3.0  # of that, what no update of the pressure can restore; observed are 2
_STALLED = 40  # iterations without progress at the level of rounding after which to give up
_LOST, _MOST_IDLE = 1000, 20  # the same at any level, and gradient steps without a way down
_MOST_SHIFTS = 3  # of the datum; one does unless heights have no digits left for the contact
_FULL = 1e-14  # of the load that the hardness carries, within which all of it is asked for
_LOAD_ERROR = 1e-12  # of the load, beyond which the pressure is scaled again
_SMALLEST, _LARGEST = 1e-280, 1e280  # of squares and products on the way
_SMALLEST_SINGLE = 1e-27  # of stresses and depths, a transform of which single precision can hold
_DOUBLE_ROUNDING = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """Pressure and gap of a contact, with the proof of how well they solve it.

    All of the proof is evaluated on the pressure that is returned.

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
        Largest violation of the conditions on the gap, in units of D_self·max(p), and what
        rounding may hide of it.
    load_error : float
        |Σp·dA/F − 1|.
    penetration : float
        Deepest overlap of the bodies where the material does not yield [m]; it counts in the
        residual.
    saturated_fraction : float
        Share of the contact's nodes that carry the hardness.
    """

    pressure: Array
    gap: Array
    approach: float
    iterations: int
    residual: float
    load_error: float = 0.0
    penetration: float = 0.0
    saturated_fraction: float = 0.0


def solve_contact(
    solid: ElasticHalfSpace,
    separation: Array,
    normal_load: float,
    hardness: float = math.inf,
    tolerance: float = 1e-8,
    initial_pressure: Array | None = None,
    max_iterations: int = 5000,
    criterion: ContactCriterion = "gap",
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
        Bound on the residual. Rounding allows 1e-12 on 240 × 240 elements, and less on fewer.
    initial_pressure : ndarray, shape (nx, ny), optional
        A guess, scaled to the load; the nearer, the fewer iterations.
    max_iterations : int
        Convolutions after which to give up.
    criterion : {"gap", "pressure-change"}
        What must be below the tolerance: the residual, or the change Σ|p − p_old|/Σp of the
        pressure in the last iteration, Eq. (24) of Bosman & de Rooij. The latter is there for
        comparison. It is no test of convergence: begun near a solution, the iteration changes
        little from the first, and the residual that is returned may then be large.

    Returns
    -------
    ContactSolution

    Raises
    ------
    InputError
        If the load exceeds what the hardness can carry, or an input is not finite or of the
        wrong shape.
    ConvergenceError
        If the tolerance is not reached within `max_iterations`, or lies below what rounding
        allows. It carries the `ContactSolution` found.

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
    z = finite_field("separation", separation, grid.shape)
    _check(solid, normal_load, hardness, tolerance, max_iterations)
    if criterion not in get_args(ContactCriterion):
        raise InputError(
            f"criterion is {criterion!r}; allowed are {', '.join(get_args(ContactCriterion))}"
        )
    if normal_load == 0:
        gap = z - z.min()
        return ContactSolution(np.zeros(z.shape), gap, float(z.min()), 0, 0.0)
    if normal_load >= hardness * grid.area * (1 - _FULL):
        pressure = np.full(z.shape, hardness)
        gap = solid(pressure) + z
        load_error = abs(hardness * grid.area / normal_load - 1)
        return ContactSolution(
            pressure, gap - gap.max(), float(gap.max()), 1, 0.0, load_error, 0.0, 1.0
        )
    total = normal_load / grid.element_area
    if initial_pressure is None:
        initial_pressure = _first_guess(z, total, hardness)
    else:
        initial_pressure = finite_field("initial_pressure", initial_pressure, grid.shape)
    problem = _Problem(solid, z, total, hardness)
    return problem.solve(initial_pressure, tolerance, max_iterations, criterion)


def _check(
    solid: ElasticHalfSpace,
    normal_load: float,
    hardness: float,
    tolerance: float,
    max_iterations: int,
) -> None:
    """Raise `InputError` for a number that allows no solution."""
    area = solid.grid.area
    require_positive(tolerance=tolerance, max_iterations=max_iterations)
    if not hardness > 0:
        raise InputError(f"hardness is {hardness!r}; it must be greater than 0")
    capacity = hardness * area
    if not (0 <= normal_load <= capacity * (1 + 1e-12) and normal_load < math.inf):
        raise InputError(
            f"normal_load is {normal_load:g} N on a patch of {area:g} m²; it must be finite and "
            f"between 0 and {capacity:g} N, what the hardness of {hardness:g} Pa carries there"
        )
    softness = _soft_rows(solid)[1] / solid.self_influence
    lost = solid.rounding * softness
    if softness > _VERY_SOFT and lost > 10 * tolerance:
        raise InputError(
            f"tolerance is {tolerance:.1e}; rounding allows no less than {lost:.1e} "
            f"where rows of elements yield {softness:.1e} times as much as one element does. If "
            "that is by wear, take shorter steps"
        )
    stress = normal_load / area
    depth = stress * solid.self_influence
    # An iteration multiplies stresses by depths, and depths by depths.
    in_range = all(_SMALLEST < product < _LARGEST for product in (stress * depth, depth * depth))
    precision = "double"
    if _is_single(solid):
        precision = "single"
        in_range = all(_SMALLEST_SINGLE < x < 1 / _SMALLEST_SINGLE for x in (stress, depth))
    if normal_load and not in_range:
        raise InputError(
            f"normal_load is {normal_load:g} N on a patch of {area:g} m² of an influence of "
            f"{solid.self_influence:g} m/Pa; {precision} precision cannot hold a contact of this "
            "size"
        )


def _is_single(solid: ElasticHalfSpace) -> bool:
    return solid.rounding > _DOUBLE_ROUNDING


class _Problem:
    """One contact problem, and the state of its iteration: pressure and displacement."""

    def __init__(self, solid: ElasticHalfSpace, z: Array, total: float, hardness: float) -> None:
        self.solid, self.total, self.hardness = solid, total, hardness
        # Heights count from a datum near the contact: far from 0 they would have few digits.
        self._heights, self.datum = z, float(z.min())
        self.z = z - self.datum
        self.iterations = 0
        self._updates = 0  # of the displacement since it was last computed
        self._shifts = 0  # of the datum
        self._idle_steps = 0  # gradient steps in a row that found no way down
        self._lowest, self._lowest_at = math.inf, 0  # residual, iteration
        self._inner_iterations = _INNER_ITERATIONS
        self._soft_axis, self._coupling = _soft_rows(solid)
        self._is_soft = self._coupling > _SOFT * solid.self_influence
        self._first_length = 1.0 if self._is_soft else 1 / solid.self_influence
        self.pressure = np.empty(z.shape)
        self.displacement = np.empty(z.shape)
        self._direction = np.zeros(z.shape)
        self._response = np.empty(z.shape)

    def solve(
        self, guess: Array, tolerance: float, max_iterations: int, criterion: ContactCriterion
    ) -> ContactSolution:
        self.pressure = _scaled_to_load(guess, self.total, self.hardness)
        self._convolve(self.pressure, self.displacement)
        length = self._first_length
        gradient_steps, next_gradient_steps = math.inf, 8.0
        best, without_progress = math.inf, 0
        change = math.inf
        free_before: Mask | None = None
        while True:
            gap = self.displacement + self.z
            free = (self.pressure > 0) & (self.pressure < self.hardness)
            approach = _approach(gap, free, self.pressure)
            gap -= approach
            inactive = free | _wrong_side(gap, self.pressure, free)
            unit = self.solid.self_influence * float(self.pressure.max())
            residual = float(np.abs(gap[inactive]).max(initial=0.0)) / unit
            stalled = self._has_stalled(residual, approach, unit)
            exhausted = self.iterations >= max_iterations or not math.isfinite(residual)
            error, slack = residual, tolerance - residual
            if criterion == "pressure-change":
                error, slack = change if residual else 0.0, math.inf
            if error <= tolerance or stalled or exhausted:
                if self._has_restored_digits(approach, unit, slack, exhausted):
                    continue
                residual += self._transform_error() / unit
                error = residual if criterion == "gap" else error
                if error <= tolerance or stalled or exhausted:
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
            old_pressure = self.pressure.copy() if criterion == "pressure-change" else self.pressure
            if gradient_steps > 0:
                length = self._gradient_step(gap, inactive, length)
                gradient_steps -= 1
            else:
                left = max_iterations - self.iterations
                self._active_set_step(gap, inactive, 0.5 * tolerance * unit, left)
            if criterion == "pressure-change":
                change = float(np.abs(self.pressure - old_pressure).sum()) / self.total
        solution = self._solution(gap, approach, residual)
        if not error <= tolerance:
            advice = f"allow more than {max_iterations} iterations or a larger tolerance"
            if stalled:
                largest = float(np.abs(self.displacement).max())
                advice = (
                    f"with displacements of {largest:.1e} m it falls no further, so ask for at "
                    f"least {2 * residual:.0e}"
                )
                if _is_single(self.solid):
                    advice += " or for double precision"
            raise ConvergenceError(
                f"the contact did not converge: residual {error:.2e} after {self.iterations} "
                f"iterations, asked were {tolerance:.2e}; {advice}",
                solution,
            )
        return solution

    def _solution(self, gap: Array, approach: float, residual: float) -> ContactSolution:
        """The present state, with what proves it."""
        saturated = self.pressure >= self.hardness
        yielding, touching = np.count_nonzero(saturated), np.count_nonzero(self.pressure)
        elastic = gap[~saturated] if yielding else gap
        return ContactSolution(
            self.pressure,
            gap,
            self.datum + approach,
            self.iterations,
            residual,
            load_error=self._load_error(),
            penetration=max(0.0, -float(elastic.min(initial=0.0))),
            saturated_fraction=yielding / touching if touching else 0.0,
        )

    def _load_error(self) -> float:
        return abs(float(self.pressure.sum()) / self.total - 1)

    def _has_stalled(self, residual: float, approach: float, unit: float) -> bool:
        """Whether the residual has stopped falling, mostly because rounding decides about it."""
        if residual < 0.9 * self._lowest:
            self._lowest, self._lowest_at = residual, self.iterations
        waited = self.iterations - self._lowest_at
        if waited <= _STALLED:
            return False
        largest = float(np.abs(self.displacement).max()) + abs(approach)
        at_rounding = self._lowest * unit <= _AT_ROUNDING * self.solid.rounding * largest
        return at_rounding or waited > _LOST or self._idle_steps > _MOST_IDLE

    def _transform_error(self) -> float:
        """What a displacement that has just been computed may be wrong by [m]."""
        return _LOST_BY_TRANSFORM * self.solid.rounding * float(np.abs(self.displacement).max())

    def _has_restored_digits(
        self, approach: float, unit: float, slack: float, exhausted: bool
    ) -> bool:
        """Restore what rounding has cost, if that may be more than `slack` of the residual."""
        largest = float(np.abs(self.displacement).max())
        lost = (_LOST_AT_ONCE + _LOST_A_STEP * self._updates) * self.solid.rounding * largest
        if abs(approach) > 4 * (largest + unit) and self._shifts < _MOST_SHIFTS:
            self.datum += approach
            self.z = self._heights - self.datum
            self._shifts += 1
            self._lowest = math.inf
        elif not exhausted and self._load_error() > _LOAD_ERROR:
            self.pressure = _scaled_to_load(self.pressure, self.total, self.hardness)
            self._convolve(self.pressure, self.displacement)
        elif self._updates and not lost <= slack * unit:
            self._convolve(self.pressure, self.displacement)
        else:
            return False
        return True

    def _convolve(self, field: Array, out: Array) -> None:
        self.solid(field, out=out)
        self.iterations += 1
        self._updates = 0 if out is self.displacement else self._updates + 1

    def _gradient_step(self, gap: Array, inactive: Mask, length: float) -> float:
        """Move along the projected gradient to the lowest energy; return the next length."""
        nodes = np.flatnonzero(inactive)
        metric = self._metric_on(nodes)
        if metric:
            old = self.pressure.ravel()[nodes]
            goal = old - length * metric.raised(gap.ravel()[nodes])
            step = np.zeros(gap.shape)
            step.ravel()[nodes] = self._within_bounds(goal, inactive, metric) - old
        else:
            step = _projected(self.pressure - length * gap, self.total, self.hardness)
            step -= self.pressure
        self._convolve(step, self._response)
        curvature = float(np.sum(step * self._response))
        slope = float(np.sum(step * gap))
        if not (curvature > 0 and slope < 0):
            self._idle_steps += 1
            return self._first_length
        self._idle_steps = 0
        fraction = min(1.0, -slope / curvature)
        self.pressure += fraction * step
        np.clip(self.pressure, 0.0, self.hardness, out=self.pressure)
        self.displacement += fraction * self._response
        if metric:
            return metric.square(step.ravel()[nodes]) / curvature
        if self.iterations % 2:
            return float(np.sum(step * step)) / curvature
        return curvature / float(np.sum(self._response * self._response))

    def _metric_on(self, nodes: NDArray[np.intp]) -> RowMetric | None:
        if not self._is_soft:
            return None
        ny = self.z.shape[1]
        rows = nodes // ny if self._soft_axis == 1 else nodes % ny
        return RowMetric(self.solid.self_influence, self._coupling, rows)

    def _within_bounds(self, pressure: Array, inactive: Mask, metric: RowMetric | None) -> Array:
        """Pressure on the inactive nodes, within the bounds and such that all carry the load."""
        at_bounds = float(self.pressure.sum()) - float(self.pressure[inactive].sum())
        load = self.total - at_bounds
        if metric:
            pressure = metric.nearest(pressure, load, self.hardness)
        return _shifted_to_load(pressure, load, self.hardness)

    def _active_set_step(self, gap: Array, inactive: Mask, enough: float, left: int) -> None:
        """Conjugate gradients on the inactive nodes alone, then back into the bounds."""
        nodes = np.flatnonzero(inactive)
        pressure = self.pressure.ravel()[nodes]
        residual = gap.ravel()[nodes]
        residual -= residual.mean()
        goal = max(_INNER_REDUCTION * float(np.abs(residual).max()), enough)
        metric = self._metric_on(nodes)
        steepest = metric.balanced(residual) if metric else residual
        direction = steepest.copy()
        square = float(np.sum(residual * steepest))
        self._direction[...] = 0.0
        for _ in range(min(self._inner_iterations, left)):
            if square == 0.0:
                break
            self._direction.ravel()[nodes] = direction
            self._convolve(self._direction, self._response)
            response = self._response.ravel()[nodes]
            response -= response.mean()
            curvature = float(np.sum(response * direction))
            if not curvature > 0:  # only rounding is left
                break
            length = square / curvature
            pressure -= length * direction
            residual -= length * response
            self._response *= length
            self.displacement -= self._response
            steepest = metric.balanced(residual) if metric else residual
            square, previous = float(np.sum(residual * steepest)), square
            if float(np.abs(residual).max()) <= goal:
                break
            direction *= square / previous
            direction += steepest
        self._inner_iterations *= 2
        if pressure.min() >= 0 and pressure.max() <= self.hardness:
            self.pressure.ravel()[nodes] = pressure
            return
        self.pressure.ravel()[nodes] = self._within_bounds(pressure, inactive, metric)
        self._convolve(self.pressure, self.displacement)


def _soft_rows(solid: ElasticHalfSpace) -> tuple[int, float]:
    """The axis along which rows yield most as a whole, and c/n of `rows` [m/Pa].

    c is what waves across the rows yield, in the median, beyond what an element does.
    """
    (nx, ny), spectrum = solid.grid.shape, solid.spectrum.real
    couplings = [
        (float(np.median(across)) - solid.self_influence) / n if len(across) else 0.0
        for n, across in ((nx, spectrum[0, 1:]), (ny, spectrum[1:, 0]))
    ]
    axis = int(couplings[1] >= couplings[0])
    return axis, max(0.0, couplings[axis])


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
    largest = float(guess.max())
    if not _SMALLEST**0.5 < largest < _LARGEST**0.5:  # nor could it be summed
        return _projected(np.zeros(guess.shape), total, hardness)
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
    for _ in range(3):
        field, shift = _shifted(pressure, total, hardness)
        if abs(float(field.sum()) - total) <= 0.1 * _LOAD_ERROR * total:
            break
        pressure = pressure + shift  # what is left after this has more digits
    return field


def _shifted(pressure: Array, total: float, hardness: float) -> tuple[Array, float]:
    """clip(p + s) that sums to `total` as nearly as the digits of p allow, and s."""
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
    return field, shift
