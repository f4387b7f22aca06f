"""A contact problem, an iterate of its solution, and the error of the iterate.

Find the pressure p with 0 ≤ p ≤ H and Σp = F/dA whose gap g = Dp + z − α is 0 where 0 < p < H,
≥ 0 where p = 0 and ≤ 0 where p = H. D maps pressure to displacement, z is the separation of the
undeformed surfaces, α the approach, H the hardness, F the load and dA the area of an element.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tribo.contact.elasticity import ElasticHalfSpace
from tribo.contact.simplex import shifted_to_load
from tribo.contact.soft_rows import RowMetric, SoftRows
from tribo.numerics import Neighbourhood, largest
from tribo.types import Array, Mask, Nodes

# Conjugate gradients run in single precision, in two thirds of the time: they only propose a
# pressure, whose displacement is then computed in double precision. Above this coupling within
# rows, relative to an element's compliance, they run in double precision, since the coupling
# amplifies rounding errors.
_MOST_COUPLING = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """A contact problem: the solid, the separation of the surfaces, the load and the hardness.

    Derived from the solid are `soft` (how much elements of a row displace each other),
    `neighbourhood` (influence of neighbouring elements) and `fast` (the solid in single precision
    where possible).
    """

    solid: ElasticHalfSpace  # the map D
    heights: Array  # separation of the undeformed surfaces, z [m]
    total: float  # sum of the pressure, F/dA [Pa]
    hardness: float  # [Pa]
    soft: SoftRows  # rows along x or y: those whose elements displace each other more
    neighbourhood: Neighbourhood  # influence of elements on their next neighbours, and its inverse
    fast: ElasticHalfSpace  # D in the precision of conjugate gradients, single where possible

    @classmethod
    def from_solid(
        cls, solid: ElasticHalfSpace, heights: Array, total: float, hardness: float
    ) -> Problem:
        """Set up the problem of pressing a surface into a solid.

        `heights` is the separation of the undeformed surfaces [m], `total` the sum of the pressure
        over all elements, and `hardness` the upper bound of the pressure [Pa].
        """
        return cls(solid, heights, total, hardness, *_prepare_solid(solid))

    @property
    def coupling(self) -> float:
        """Displacement of a whole row by unit pressure on one of its nodes [m/Pa]; 0 if negligible.

        Rows run along x or y, as `soft` says. The displacement is negligible if it is small against
        that of the loaded node itself. Otherwise the rows are called soft.
        """
        return self.soft.coupling if self.soft.is_needed else 0.0

    def row_indices(self, nodes: Nodes) -> Nodes:
        """Number of the row of each node: its x index if rows lie along y, its y index if along x.

        `nodes` are flat indices. The attribute `soft` says along which axis the rows lie.
        """
        return self.soft.row_indices(nodes, self.heights.shape)

    def metric_on(self, nodes: Nodes) -> RowMetric | None:
        """Metric for pressures at some nodes, which lie in soft rows; None without soft rows.

        Rows are soft if unit pressure on one node displaces its whole row noticeably.
        """
        if not self.soft.is_needed:
            return None
        return RowMetric(self.solid.self_influence, self.soft.coupling, self.row_indices(nodes))

    def bounded_pressure(
        self, new_pressure: Array, nodes: Nodes, pressure: Array, metric: RowMetric | None
    ) -> Array:
        """Correct a new pressure on `nodes` so that it keeps within bounds and carries the load.

        `new_pressure` is the new pressure on the nodes. `pressure` is the old pressure on all
        elements; elements off the nodes keep it. The bounds are 0 and the hardness. Returns the
        corrected pressure on the nodes [Pa]. With a `metric` from `metric_on`, it is the pressure
        nearest to `new_pressure` in this metric. If `metric` is None, the load's error is spread
        evenly.
        """
        node_sum = float(pressure.take(nodes).sum())
        load = self.total - (float(pressure.sum()) - node_sum)
        if metric:
            new_pressure = metric.nearest(new_pressure, load, self.hardness)
        return shifted_to_load(new_pressure, load, self.hardness)


def soft_rows(solid: ElasticHalfSpace) -> SoftRows:
    """Compare rows of elements along x with those along y, and return the softer ones.

    Rows are softer if unit pressure on one element displaces its whole row more. The result has the
    axis along which the softer rows lie, and this displacement of a row as `coupling` [m/Pa].
    """
    return _prepare_solid(solid)[0]


@functools.lru_cache(maxsize=4)  # contacts at all positions of the disk share a solid
def _prepare_solid(solid: ElasticHalfSpace) -> tuple[SoftRows, Neighbourhood, ElasticHalfSpace]:
    """Fields `soft`, `neighbourhood` and `fast` of a `Problem`, computed from its solid; cached."""
    soft, unit = SoftRows.from_solid(solid), solid.self_influence
    coupling = soft.coupling if soft.is_needed else 0.0
    fast = solid.faster_precision(unit) if coupling < _MOST_COUPLING * unit else solid
    return soft, Neighbourhood(solid, soft.axis, coupling), fast


class Iterate(NamedTuple):
    """A pressure that carries the load within the bounds, and its displacement."""

    pressure: Array  # [Pa]
    displacement: Array  # computed, or updated along with the pressure [m]
    datum: float  # height relative to which the separation is measured [m]
    separation: Array  # between the undeformed surfaces [m]
    convolutions: float
    updates: int = 0  # times the displacement was updated since it was computed
    shifts: int = 0  # times the datum was moved

    def pressed(self, problem: Problem, pressure: Array, spent: float = 0.0) -> Iterate:
        """The next iterate: a given pressure [Pa], and the displacement computed from it.

        `spent` is the number of convolutions that finding the pressure took.
        """
        convolutions = self.convolutions + spent + 1
        displacement = problem.solid(pressure)
        return Iterate(
            pressure, displacement, self.datum, self.separation, convolutions, 0, self.shifts
        )

    def load_error(self, total: float) -> float:
        """Relative error of the load that the pressure p carries, |Σp/total − 1|.

        `total` is the sum of the pressure over all elements [Pa] that carries the load exactly.
        """
        return abs(float(self.pressure.sum()) / total - 1)


class Evaluation(NamedTuple):
    """How far an iterate, a trial pressure, is from the solution of the contact problem.

    The pressure has the bounds 0 and the hardness. Where it lies between the bounds, the gap
    between the bodies should be 0. A node is at a wrong bound if it is unloaded where the bodies
    overlap, or at the hardness where a gap remains. `nodes` are those at a wrong bound and those
    between the bounds. `residual` is the largest gap or overlap at `nodes`, divided by `unit`.
    """

    gap: Array  # between the bodies, negative where they overlap [m]
    level: float  # approach of the bodies from the datum of the iterate [m]
    unit: float  # D_self·max(p), displacement of an element by the highest pressure on it [m]
    residual: float  # largest violation of the conditions on the gap, in that unit
    nodes: Nodes  # free to move, or at a bound that the gap drives them off
    in_contact: int  # number of nodes in contact
    at_wrong_bound: int  # number of nodes at a bound that the gap drives them off


def evaluate(problem: Problem, iterate: Iterate) -> Evaluation:
    """Compute the gap, the approach and the residual of an iterate."""
    gap, pressure = iterate.displacement + iterate.separation, iterate.pressure
    highest, loaded = float(pressure.max()), pressure > 0
    unit = problem.solid.self_influence * highest
    elastic = pressure < problem.hardness if highest >= problem.hardness else None
    free = loaded if elastic is None else loaded & elastic
    free_nodes = np.flatnonzero(free)
    level = mean_approach(gap, loaded, free_nodes)
    gap -= level
    moving = loaded | (gap < 0)
    if elastic is not None:
        moving &= elastic | (gap > 0)
    nodes = np.flatnonzero(moving)
    residual = largest(gap.take(nodes)) / unit
    in_contact = free_nodes.size if elastic is None else int(np.count_nonzero(loaded))
    at_wrong_bound = nodes.size - free_nodes.size
    return Evaluation(gap, level, unit, residual, nodes, in_contact, at_wrong_bound)


def mean_approach(gap: Array, loaded: Mask, free: Nodes) -> float:
    """Approach of the bodies [m]: the mean of `gap` [m] over nodes between the bounds.

    Subtracted from `gap`, it makes the gap 0 on average at these nodes, whose flat indices are
    `free`. If there are none, the approach is halfway between the widest gap of `loaded` nodes and
    the narrowest gap of unloaded ones; if all nodes are loaded, it is the widest gap.
    """
    if free.size:
        return float(gap.take(free).sum()) / free.size
    lowest = float(gap[loaded].max(initial=-math.inf))
    highest = float(gap[~loaded].min(initial=math.inf))
    return lowest if highest == math.inf else (lowest + highest) / 2
