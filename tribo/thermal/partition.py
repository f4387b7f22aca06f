"""Partition of frictional heat between two sliding bodies.

On the contact C both surfaces have one temperature. With T₁ and T₂ the maps from heat flux to
surface temperature rise of pin and disk, q the frictional heat, q₁ the flux into the pin and q − q₁
the flux into the disk, T_b,1 + T₁q₁ = T_b,2 + T₂(q − q₁) on C, that is

    (T₁ + T₂) q₁ = T₂ q + ΔT_b  on C,   q₁ = 0 off C,   ΔT_b = T_b,2 − T_b,1.           (1)

The unknown is the flux instead of the fraction q₁/q, which is unbounded where q → 0: a hot pin may
warm the cold leading edge of a contact (q₁ < 0).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribo.errors import ConvergenceError, InputError
from tribo.numerics import Convolution, Neighbourhood
from tribo.types import Array, Mask, Nodes

# Number of directions that the iteration keeps orthogonal; it rarely needs as many.
_MAX_DIRECTIONS = 60
_ITERATION_SHARE = 0.9  # share of the tolerance for the iteration; the rest is for rounding
# Down to this tolerance the iteration runs in single precision, in two thirds of the time. Its
# result is checked in double precision.
_SINGLE_TOLERANCE = 1e-4


@dataclass(frozen=True, slots=True)
class HeatPartition:
    """Temperature of a contact and the heat that enters the pin.

    Attributes
    ----------
    rise : ndarray, shape ``grid.shape``
        Rise of the pin's surface above its own bulk temperature, T₁q₁ [K]. On the contact it is
        the disk's rise plus ``bulk_difference``.
    pin_flux : ndarray, shape ``grid.shape``
        Heat flux into the pin q₁ [W/m²], 0 outside the contact.
    pin_share : float
        Share of the heat that enters the pin, Σq₁/Σq; NaN if there is no frictional heat at all.
    iterations : int
        Iterations of the solver, each one convolution.
    residual : float
        Difference between the two surface temperatures, relative to T₂q + ΔT_b: the disk's rise if
        all heat entered the disk, plus ``bulk_difference``. Both are root mean squares over the
        contact.

    Examples
    --------
    >>> import tribo
    >>> import numpy as np
    >>> window = tribo.Grid((8, 8), (1e-6, 1e-6))
    >>> body = tribo.thermal.ConductingHalfSpace(window, steel, velocity=0.0, time=1e-5)
    >>> flux = np.zeros((8, 8))
    >>> flux[2:5, 3:6] = 1e9
    >>> split = tribo.thermal.partition_heat(body, body, flux, flux > 0)
    >>> f"{split.pin_share:.3f} to the pin"
    '0.500 to the pin'
    """

    rise: Array
    pin_flux: Array
    pin_share: float
    iterations: int
    residual: float


def partition_heat(
    pin: Convolution,
    disk: Convolution,
    heat_flux: Array,
    contact: Mask,
    tolerance: float = 1e-8,
    bulk_difference: ArrayLike = 0.0,
    max_iterations: int = 500,
) -> HeatPartition:
    """Divide frictional heat so that both surfaces have one temperature.

    Parameters
    ----------
    pin, disk : Convolution
        Maps from heat flux [W/m²] to surface temperature rise [K] of both bodies.
    heat_flux : ndarray, shape ``grid.shape``
        Frictional heat q = µVp [W/m²], 0 outside the contact.
    contact : ndarray of bool, shape ``grid.shape``
        True at elements that touch.
    tolerance : float, optional
        Largest `HeatPartition.residual` that is accepted, from 1e-14 to below 1.
    bulk_difference : float or ndarray, shape ``grid.shape``, optional
        Disk's temperature minus the pin's before this heat acts, ΔT_b [K].
    max_iterations : int, optional
        Iterations after which the solver gives up.

    Returns
    -------
    HeatPartition
        The partition; its fields are 0 if there is no contact, or neither heat nor a temperature
        difference.

    Raises
    ------
    InputError
        If a value or field is not allowed, such as heat outside the contact, shapes or grids
        differ, or the bodies have had no time to conduct.
    ConvergenceError
        If the solver does not reach `tolerance`; it carries the `HeatPartition` found.

    Examples
    --------
    A conductor three times as good takes three quarters of the heat.

    >>> from tribo import Grid, Material
    >>> from tribo.thermal import ConductingHalfSpace
    >>> window = Grid((8, 8), (1e-6, 1e-6))
    >>> poor, good = (Material(210e9, 0.3, K, K * 100.0, 1.0) for K in (15.0, 45.0))
    >>> pin, disk = (ConductingHalfSpace(window, m, 0.0, 1e-5) for m in (poor, good))
    >>> flux = np.zeros((8, 8))
    >>> flux[2:5, 3:6] = 1e9
    >>> split = partition_heat(pin, disk, flux, flux > 0)
    >>> print(f"{split.pin_share:.6f} to the pin, {split.rise[3, 4]:.2f} K")
    0.250000 to the pin, 51.76 K
    """
    grid = pin.grid
    difference = np.broadcast_to(np.asarray(bulk_difference, dtype=float), grid.shape)
    if not 1e-14 <= tolerance < 1:
        raise InputError(f"tolerance is {tolerance!r}; it must be from 1e-14 to below 1")
    _check_fields(pin, disk, heat_flux, contact, difference)
    nodes = np.flatnonzero(contact)
    q, delta = heat_flux.take(nodes), difference.take(nodes)
    target = disk(heat_flux).take(nodes) + delta if q.any() else delta
    if not target.any():
        return HeatPartition(np.zeros(grid.shape), np.zeros(grid.shape), math.nan, 0, 0.0)
    total_map, neighbourhood = _join_maps(pin, disk)
    if not neighbourhood.influence[1, 0] > 0:
        raise InputError(
            "bulk_difference is not 0; it must be, since the bodies have had no time to conduct"
        )
    solution, iterations = _iterate_flux(
        total_map, neighbourhood, nodes, target, tolerance, max_iterations
    )
    pin_flux = np.zeros(grid.shape)
    pin_flux.reshape(-1)[nodes] = solution
    total = float(np.sum(q))
    share = float(np.sum(solution)) / total if total else math.nan
    rise = pin(pin_flux)
    # Computed from both temperatures, since the residual that the iteration updates drifts from
    # the true residual by rounding.
    mismatch = (disk(heat_flux - pin_flux) - rise).take(nodes) + delta
    residual = _norm(mismatch) / _norm(target)
    partition = HeatPartition(rise, pin_flux, share, iterations, residual)
    if not residual <= tolerance:
        advice = (
            "Raise max_iterations or tolerance"
            if iterations >= max_iterations
            else f"Rounding allows no less; set it to at least {2 * residual:.0e}"
        )
        raise ConvergenceError(
            f"heat partition stopped at a residual of {residual:.1e} after {iterations} "
            f"iterations; the tolerance is {tolerance:.1e}. {advice}",
            partition,
        )
    return partition


@functools.lru_cache(maxsize=2)  # successive contacts use the same maps
def _join_maps(pin: Convolution, disk: Convolution) -> tuple[Convolution, Neighbourhood]:
    """The sum of both bodies' maps from heat flux to rise, and its stencils among neighbours."""
    total_map = pin + disk
    return total_map, Neighbourhood(total_map)


@functools.lru_cache(maxsize=2)
def _faster_map(total_map: Convolution, influence: float) -> Convolution:
    return total_map.faster_precision(influence)


def _check_fields(
    pin: Convolution, disk: Convolution, heat_flux: Array, contact: Mask, difference: Array
) -> None:
    """Raise `InputError` for bodies or fields that `partition_heat` cannot use."""
    grid = pin.grid
    if disk.grid != grid:
        raise InputError(f"pin has {grid} and disk has {disk.grid}; they must be the same")
    if heat_flux.shape != grid.shape or contact.shape != grid.shape:
        raise InputError(
            f"heat_flux has shape {heat_flux.shape} and contact {contact.shape}; both must be "
            f"{grid.shape}, like the grid"
        )
    if contact.dtype != np.bool_:
        raise InputError(f"contact holds {contact.dtype}; it must hold bool, as pressure > 0 does")
    if not (np.isfinite(heat_flux).all() and np.isfinite(difference).all()):
        raise InputError("heat_flux or bulk_difference holds a NaN or an infinity")
    if heat_flux[~contact].any():
        raise InputError("heat_flux is not 0 everywhere outside the contact; it must be")


def _iterate_flux(
    total_map: Convolution,
    neighbourhood: Neighbourhood,
    nodes: Nodes,
    target: Array,
    tolerance: float,
    max_iterations: int,
) -> tuple[Array, int]:
    """Flux into the pin on the nodes by iteration [W/m²], and the number of iterations."""
    if tolerance >= _SINGLE_TOLERANCE:
        total_map = _faster_map(total_map, float(neighbourhood.influence[1, 0]))
    precondition = functools.partial(neighbourhood.stencil_on(nodes), neighbourhood.inverse)
    return _conjugate_residuals(
        _node_map(total_map, nodes),
        precondition,
        target,
        _ITERATION_SHARE * tolerance,
        max_iterations,
    )


def _node_map(body: Convolution, nodes: Nodes) -> Callable[[Array], Array]:
    """Return a function from heat flux [W/m²] to rise [K] of a body, both at `nodes` only."""
    field, rise = np.zeros(body.grid.shape), np.empty(body.grid.shape)
    ny = body.grid.shape[1]
    rows = int(nodes[0]) // ny, int(nodes[-1]) // ny + 1

    def apply(flux: Array) -> Array:
        scale = float(np.abs(flux).max()) or 1.0  # scaled to the range of single precision
        field.reshape(-1)[nodes] = flux / scale
        body(field, out=rise, rows=rows)
        return rise.take(nodes) * scale

    return apply


def _norm(vector: Array) -> float:
    return math.sqrt(float(vector @ vector))


def _conjugate_residuals(
    operator: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    target: Array,
    tolerance: float,
    max_iterations: int,
) -> tuple[Array, int]:
    """Solve operator(x) = target by generalised conjugate residuals; and count iterations."""
    solution, residual, scale = np.zeros_like(target), target.copy(), _norm(target)
    # One array for both: if two large arrays are freed, the allocator returns their memory, and
    # page faults on the next call cost more than much of the iteration.
    directions, images = np.empty((2, _MAX_DIRECTIONS, target.size))
    iteration, error = 0, 1.0
    while error > tolerance and iteration < max_iterations:
        direction = precondition(residual)
        image = operator(direction)
        count = min(iteration, _MAX_DIRECTIONS)
        # Images are made orthogonal, as by GMRES (Eisenstat, Elman & Schultz 1983, SIAM J. Numer.
        # Anal. 20). It cannot break down: the operator's symmetric part is positive definite.
        overlap = images[:count] @ image
        direction -= overlap @ directions[:count]
        image -= overlap @ images[:count]
        length = _norm(image)
        if not length > 0:  # a residual of rounding errors, or NaN
            break
        slot = iteration % _MAX_DIRECTIONS
        directions[slot], images[slot] = direction / length, image / length
        step = float(images[slot] @ residual)
        solution += step * directions[slot]
        residual -= step * images[slot]
        iteration, error = iteration + 1, _norm(residual) / scale
    return solution, iteration
