"""The iteration that finds the pressure of a contact.

Two kinds of steps take turns. An *active-set step* holds the nodes at their bounds, solves for the
others with a few iterations of conjugate gradients (as Polonsky & Keer, Wear 231, 1999, do with
a single one), preconditioned by a `stencil`, and clips the result; near the solution it is fast,
but it may cycle. A *projected gradient step* with Barzilai–Borwein length and exact line search
(Birgin, Martínez & Raydan, SIAM J. Optim. 10, 2000) is slower, but always lowers the energy. It
starts the iteration where much of the contact is still to change, and takes over for longer each
time that the active-set steps stop making progress, so that the whole converges from any start.
Where rows of elements are soft as a whole, both go by the metric of `rows`.

Gradient steps update the displacement along with the pressure, which costs digits. No result is
given out before what that may have cost is known to lie within the tolerance, or the displacement
of the very pressure that is given out has been computed.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np

from tribo.contact.elasticity import ElasticHalfSpace
from tribo.contact.rows import RowMetric, SoftRows
from tribo.contact.simplex import LOAD_ERROR, nearest, scaled_to_load, shifted_to_load
from tribo.stencil import Neighbourhood, Preconditioner
from tribo.types import Array, Mask, Nodes

__all__ = ["Iteration"]

Stencil = Callable[[Array, Array], Array]

# Conjugate gradient iterations in the first active-set step. Each later one, which changes fewer
# nodes' state, may take twice as many, but no more than reduce the residual by the factor; by the
# second one if no node has changed its state.
_INNER_ITERATIONS = 2
_INNER_REDUCTION, _FINAL_REDUCTION = 0.2, 1e-4
_SETTLED = 0.3  # share of the contact's nodes on the wrong side at which active-set steps start
_PATIENCE = 3  # active-set steps without progress before gradient steps take over
_FIRST_GRADIENT_STEPS = 8  # then; twice as many each time
_LOCAL_STEPS = 2  # of the correction of a guess

# Conjugate gradients go by single precision, in two thirds of the time: they only lead the way to a
# pressure, the displacement of which is then computed in full. Not so where numbers are too large
# or too small for it, or where the coupling within rows, in units of an element's compliance, would
# magnify its rounding.
_SMALLEST_SINGLE, _MOST_COUPLING = 1e-25, 1.0

# What updates may cost of the displacement, once and each, in rounding errors of its largest
# value: observed are 8 for all updates of a solution together, and 70 where it began far off.
_LOST_AT_ONCE, _LOST_A_STEP = 100.0, 10.0
_AT_ROUNDING = 32.0  # the same, of a residual that rounding keeps from falling
_LOST_BY_TRANSFORM = 3.0  # of that, what no update of the pressure can restore; observed are 2
_STALLED = 40  # iterations without progress at the level of rounding after which to give up
_LOST, _MOST_IDLE = 1000, 20  # the same at any level, and gradient steps without a way down
_MOST_SHIFTS = 3  # of the datum; one does unless heights have no digits left for the contact


class Iteration:
    """A contact problem, and the state of its iteration.

    Parameters
    ----------
    solid : ElasticHalfSpace
    heights : ndarray, shape (nx, ny)
        Separation of the undeformed surfaces, z [m].
    total : float
        Sum of the pressure, F/dA [Pa].
    hardness : float
        Highest pressure [Pa].
    spent : float, optional
        Convolutions on the way here, to be counted along.

    Attributes
    ----------
    pressure, displacement, gap : ndarray, shape (nx, ny)
        After `run`, its result and what follows from it [Pa, m, m].
    residual : float
        Largest violation of the conditions on the gap, in units of D_self·max(p), and what
        rounding may hide of it.
    error : float
        What `run` compared with its tolerance: the residual, or the change of the pressure.
    stalled : bool
        Whether `run` ended because the error did not fall any further.
    convolutions : float
        With the solid's map.
    """

    def __init__(
        self,
        solid: ElasticHalfSpace,
        heights: Array,
        total: float,
        hardness: float,
        spent: float = 0.0,
    ) -> None:
        self.solid, self._total, self._hardness = solid, total, hardness
        # Heights count from a datum near the contact: far from 0 they would have few digits.
        self._heights, self._datum = heights, float(heights.min())
        self._z = heights - self._datum
        self._soft = SoftRows.of(solid)
        coupling = self._soft.coupling if self._soft.matter else 0.0
        self._near = Neighbourhood(solid, self._soft.axis, coupling)
        self._first_length = 1.0 if self._soft.matter else 1 / solid.self_influence
        near_1 = _SMALLEST_SINGLE < solid.self_influence < 1 / _SMALLEST_SINGLE
        single = near_1 and coupling < _MOST_COUPLING * solid.self_influence
        self._inner = solid.in_faster_precision() if single else solid
        self.convolutions = spent
        self._updates = 0  # of the displacement since it was last computed
        self._shifts = 0  # of the datum
        self._idle_steps = 0  # gradient steps in a row that found no way down
        self._lowest, self._lowest_at = math.inf, 0.0  # residual, convolutions
        self._inner_iterations = _INNER_ITERATIONS
        self._settled_nodes = np.empty(0, dtype=np.intp)  # of the last active-set step
        fields = (np.empty(heights.shape) for _ in range(5))
        self.pressure, self.displacement, self.gap, self._direction, self._response = fields

    @property
    def approach(self) -> float:
        """Rigid displacement of the bodies [m], from the datum of the solid."""
        return self._datum + self._level

    @property
    def load_error(self) -> float:
        """|Σp/total − 1|."""
        return abs(float(self.pressure.sum()) / self._total - 1)

    def run(
        self,
        guess: Array,
        tolerance: float,
        max_convolutions: float,
        by_change: bool = False,
        displacement: Array | None = None,
    ) -> bool:
        """Iterate from a guess until the error is within the tolerance; return whether it is.

        Parameters
        ----------
        guess : ndarray, shape (nx, ny)
            Of the pressure [Pa].
        tolerance : float
        max_convolutions : float
        by_change : bool, optional
            Compare the change of the pressure in place of the residual.
        displacement : ndarray, shape (nx, ny), optional
            Under the guess [m], where it is known. The guess then carries the load, but may
            exceed the bounds.
        """
        if displacement is not None:
            guess = self._corrected(guess, displacement)
        self.pressure = scaled_to_load(guess, self._total, self._hardness)
        self._convolve(self.pressure, self.displacement)
        length, change = self._first_length, math.inf
        gradient_steps, next_gradient_steps = math.inf, _FIRST_GRADIENT_STEPS
        best, without_progress = math.inf, 0
        while True:
            nodes, touching, wrong = self._judge()
            self.stalled = self._has_stalled()
            exhausted = self.convolutions >= max_convolutions or not math.isfinite(self.residual)
            self.error, slack = self.residual, tolerance - self.residual
            if by_change:
                self.error, slack = change if self.residual else 0.0, math.inf
            if self.error <= tolerance or self.stalled or exhausted:
                if self._has_restored_digits(slack, exhausted):
                    continue
                self.residual += self._transform_error() / self._unit
                self.error = self.error if by_change else self.residual
                if self.error <= tolerance or self.stalled or exhausted:
                    return self.error <= tolerance
            if gradient_steps == math.inf and wrong <= _SETTLED * touching:
                gradient_steps = 0
            if self.residual < 0.9 * best:
                best, without_progress = self.residual, 0
            else:
                without_progress += 1
            if gradient_steps <= 0 and without_progress >= _PATIENCE:
                gradient_steps, next_gradient_steps = next_gradient_steps, 2 * next_gradient_steps
                best, without_progress = self.residual, 0
            before = self.pressure.copy() if by_change else self.pressure
            if gradient_steps > 0:
                length = self._gradient_step(nodes, length)
                gradient_steps -= 1
            else:
                left = max_convolutions - self.convolutions
                self._active_set_step(nodes, 0.5 * tolerance * self._unit, left)
            if by_change:
                change = float(np.abs(self.pressure - before).sum()) / self._total

    def _judge(self) -> tuple[Nodes, int, int]:
        """Find the gap, the approach and the residual of the present pressure.

        Returns the nodes that are free to move or at a bound that the gap drives them off, the
        number of nodes in contact and the number of those at a wrong bound.
        """
        gap, pressure = np.add(self.displacement, self._z, out=self.gap), self.pressure
        loaded, elastic = pressure > 0, pressure < self._hardness
        free = loaded & elastic
        self._unit = self.solid.self_influence * float(pressure.max())
        self._level = _level(gap, loaded, free)
        gap -= self._level
        nodes = np.flatnonzero(free | (elastic & (gap < 0)) | (loaded & (gap > 0)))
        self.residual = float(np.abs(gap.take(nodes)).max(initial=0.0)) / self._unit
        return nodes, int(np.count_nonzero(loaded)), nodes.size - int(np.count_nonzero(free))

    def _has_stalled(self) -> bool:
        """Whether the residual has stopped falling, mostly because rounding decides about it."""
        if self.residual < 0.9 * self._lowest:
            self._lowest, self._lowest_at = self.residual, self.convolutions
        waited = self.convolutions - self._lowest_at
        if waited <= _STALLED:
            return False
        largest = float(np.abs(self.displacement).max()) + abs(self._level)
        at_rounding = self._lowest * self._unit <= _AT_ROUNDING * self.solid.rounding * largest
        return at_rounding or waited > _LOST or self._idle_steps > _MOST_IDLE

    def _transform_error(self) -> float:
        """What a displacement that has just been computed may be wrong by [m]."""
        return _LOST_BY_TRANSFORM * self.solid.rounding * float(np.abs(self.displacement).max())

    def _has_restored_digits(self, slack: float, exhausted: bool) -> bool:
        """Restore what rounding has cost, if that may be more than `slack` of the residual."""
        largest = float(np.abs(self.displacement).max())
        lost = (_LOST_AT_ONCE + _LOST_A_STEP * self._updates) * self.solid.rounding * largest
        if abs(self._level) > 4 * (largest + self._unit) and self._shifts < _MOST_SHIFTS:
            self._datum += self._level
            self._z = self._heights - self._datum
            self._shifts += 1
            self._lowest = math.inf
        elif not exhausted and self.load_error > LOAD_ERROR:
            self.pressure = scaled_to_load(self.pressure, self._total, self._hardness)
            self._convolve(self.pressure, self.displacement)
        elif self._updates and not lost <= slack * self._unit:
            self._convolve(self.pressure, self.displacement)
        else:
            return False
        return True

    def _convolve(self, field: Array, out: Array) -> None:
        self.solid(field, out=out)
        self.convolutions += 1
        self._updates = 0 if out is self.displacement else self._updates + 1

    def _gradient_step(self, nodes: Nodes, length: float) -> float:
        """Move along the projected gradient to the lowest energy; return the next length."""
        metric = self._metric_on(nodes)
        step = self._direction
        if metric:
            old = self.pressure.take(nodes)
            goal = old - length * metric.raised(self.gap.take(nodes))
            step[...] = 0.0
            step.reshape(-1)[nodes] = self._within_bounds(goal, nodes, metric) - old
        else:
            goal = nearest(self.pressure - length * self.gap, self._total, self._hardness)
            np.subtract(goal, self.pressure, out=step)
        self._convolve(step, self._response)
        curvature = float(np.sum(step * self._response))
        slope = float(np.sum(step * self.gap))
        if not (curvature > 0 and slope < 0):
            self._idle_steps += 1
            return self._first_length
        self._idle_steps = 0
        fraction = min(1.0, -slope / curvature)
        self.pressure += fraction * step
        np.clip(self.pressure, 0.0, self._hardness, out=self.pressure)
        self.displacement += fraction * self._response
        if metric:
            return metric.square(step.take(nodes)) / curvature
        if self.convolutions % 2 < 1:
            return float(np.sum(step * step)) / curvature
        return curvature / float(np.sum(self._response * self._response))

    def _metric_on(self, nodes: Nodes) -> RowMetric | None:
        if not self._soft.matter:
            return None
        rows = self._soft.numbers(nodes, self.solid.grid.shape)
        return RowMetric(self.solid.self_influence, self._soft.coupling, rows)

    def _within_bounds(self, pressure: Array, nodes: Nodes, metric: RowMetric | None) -> Array:
        """Pressure on some nodes, within the bounds and such that all nodes carry the load."""
        carried = float(self.pressure.take(nodes).sum())
        load = self._total - (float(self.pressure.sum()) - carried)
        if metric:
            pressure = metric.nearest(pressure, load, self._hardness)
        return shifted_to_load(pressure, load, self._hardness)

    def _active_set_step(self, nodes: Nodes, enough: float, left: float) -> None:
        """Conjugate gradients on some nodes alone, then back into the bounds."""
        settled = np.array_equal(nodes, self._settled_nodes)
        self._settled_nodes = nodes
        pressure, residual = self.pressure.take(nodes), self.gap.take(nodes)
        residual -= residual.mean()
        # In units of the first residual, and directions in those of the stencil's middle, all
        # numbers are near 1, which single precision can hold.
        scale = float(np.abs(residual).max()) or 1.0
        residual /= scale
        goal = max(_FINAL_REDUCTION if settled else _INNER_REDUCTION, enough / scale)
        stencil = self._near.on(nodes)
        precondition = self._preconditioner(nodes, stencil)
        direction, square = np.zeros(nodes.size), math.inf
        ny = self._z.shape[1]
        rows = int(nodes[0]) // ny, int(nodes[-1]) // ny + 1
        self._direction[...] = 0.0
        for _ in range(int(min(self._inner_iterations, left))):
            steepest = precondition(residual)
            previous, square = square, float(np.sum(residual * steepest))
            if not square > 0:
                break
            direction *= square / previous
            direction += steepest
            self._direction.reshape(-1)[nodes] = direction
            self._inner(self._direction, out=self._response, rows=rows)
            self.convolutions += 1
            response = self._response.take(nodes)
            response -= response.mean()
            curvature = float(np.sum(response * direction))
            if not curvature > 0:  # only rounding is left
                break
            length = square / curvature
            pressure -= scale * length * direction
            response *= length
            residual -= response
            if float(np.abs(residual).max()) <= goal:
                break
        self._inner_iterations *= 2
        if pressure.min() < 0 or pressure.max() > self._hardness:
            metric = self._metric_on(nodes)
            if not metric:
                pressure = self._clipped(pressure, stencil)
            pressure = self._within_bounds(pressure, nodes, metric)
        self.pressure.reshape(-1)[nodes] = pressure
        self._convolve(self.pressure, self.displacement)

    def _preconditioner(self, nodes: Nodes, stencil: Stencil) -> Preconditioner:
        rows = self._soft.numbers(nodes, self.solid.grid.shape)
        coupling = self._soft.coupling if self._soft.matter else 0.0
        middle = self._near.inverse[1, 0]
        inverse = functools.partial(stencil, self._near.inverse / middle)
        return Preconditioner(inverse, rows, coupling * middle)

    def _clipped(self, pressure: Array, stencil: Stencil) -> Array:
        """Clip the pressure on the nodes of `stencil`; neighbours make up for what that changes."""
        clipped = np.clip(pressure, 0.0, self._hardness)
        between = (clipped > 0) & (clipped < self._hardness)
        change = between * stencil(self._near.influence, clipped - pressure)
        clipped -= between * stencil(self._near.inverse, change)
        return clipped

    def _corrected(self, guess: Array, displacement: Array) -> Array:
        """A guess whose displacement is known, within the bounds and with its worst errors undone.

        Nodes that enter or leave the contact are what an extrapolation knows least; they concern
        their neighbours most, and so can be corrected without a convolution.
        """
        gap = displacement + self._z
        loaded = guess > 0
        gap -= _level(gap, loaded, loaded & (guess < self._hardness))
        nodes = np.flatnonzero((guess != 0) | (gap < 0))
        stencil = self._near.on(nodes)
        known_pressure, known_gap = guess.take(nodes), gap.take(nodes)
        pressure = np.clip(known_pressure, 0.0, self._hardness)
        for _ in range(_LOCAL_STEPS):
            gap = known_gap + stencil(self._near.influence, pressure - known_pressure)
            loaded, elastic = pressure > 0, pressure < self._hardness
            free = loaded & elastic
            gap -= _level(gap, loaded, free)
            wrong = free | (elastic & (gap < 0)) | (loaded & (gap > 0))
            gap -= float(np.sum(gap * wrong)) / max(1, int(np.count_nonzero(wrong)))
            change = wrong * stencil(self._near.inverse, wrong * gap)
            pressure = shifted_to_load(pressure - change, self._total, self._hardness)
        corrected = np.zeros(guess.shape)
        corrected.reshape(-1)[nodes] = pressure
        return corrected


def _level(gap: Array, loaded: Mask, free: Mask) -> float:
    """The approach for which the gap vanishes on average where a contact is free to move.

    `loaded` says where there is pressure, and `free` where it is below the hardness too.
    """
    nodes = np.flatnonzero(free)
    if nodes.size:
        return float(gap.take(nodes).mean())
    lowest = float(gap[loaded].max(initial=-math.inf))
    highest = float(gap[~loaded].min(initial=math.inf))
    return lowest if highest == math.inf else (lowest + highest) / 2
