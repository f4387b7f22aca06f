"""Friction by temperature as one equation: the friction of each element heats all of them.

Each element of the contact C has the friction of its own temperature,

    T = T_b + A q + r µ̄,   q(x) = µ(V, T(x)) V p(x)   on C.                               (1)

T is the temperature, T_b the bulk temperature, q the friction heat per area, µ the friction
coefficient, V the sliding velocity, p the pressure. A is the partition of heat between the bodies
(`tribo.thermal.partition_heat`), which is linear. Warm bodies, a stem and a film add the rise r per
unit friction coefficient evenly, at the mean friction µ̄ = Σq/ΣVp.

The iteration starts from cold: its first heat has the friction of the bulk temperature, and each
further partition adds the change of heat by the last temperature. So where friction rises,
temperatures only rise on the way, and reach the lowest solution, as a contact that warms up does.

Near a steep rise of friction there may be no solution close to the cold one: the contact ignites.
That is the outcome if the mean rise has grown by a quarter, and an iteration adds at least as much
as the iteration before. It cannot happen where friction rises more slowly than T − T_b to the power
of 0.7. Where friction falls, the plain iteration would oscillate. So the last few iterations are
combined (Anderson, J. ACM 12, 1965), unless the contact may ignite and no temperature falls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from tribo.errors import ConvergenceError
from tribo.simulation.friction import STEEP, Friction
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.temperature import bodies_at, friction_heat, refined_scene
from tribo.thermal import contact_quantiles, partition_heat
from tribo.types import Array

Outcome = Literal["solved", "ignites", "not converged"]

_MOST_ROUNDS = 60
_CLOSE = 2e-4  # largest change in a round, relative to the highest rise, that ends the iteration
_TOLERANCE = 1e-3  # tolerance of the partitions, where the fidelity's is larger
_LOOSEST = 0.1  # largest tolerance of a partition, for a small change of the flux
# A contact whose rise grows by ever larger steps ignites once the mean rise exceeds this multiple
# of the mean rise with the friction at the bulk temperature.
_GROWN = 1.25
_KEPT = 4  # rounds that Anderson mixing combines


class CoupledRise(NamedTuple):
    """Temperature rise of a contact whose friction depends on temperature.

    Rises are divided by the coefficient of friction [K]. `rise` is infinite if the contact
    "ignites": friction heats it ever faster (thermal runaway). `rise` is NaN if the iteration did
    not converge, or if there was no iteration.
    """

    rise: float  # the rise that the criterion compares with its limit
    outcome: Outcome | None = None  # how the iteration ended; None if none was needed
    rise_quantile: Array | None = None  # over the contact area, where it is solved [K]


UNSOLVED = CoupledRise(math.nan)


@dataclass(frozen=True, slots=True, eq=False)
class CoupledHeat:
    """Temperature rise of a contact in which each element's friction depends on its temperature.

    Rises are for the friction as it is, not per unit friction coefficient.

    Attributes
    ----------
    outcome : {"solved", "ignites", "not converged"}
        How the iteration ended; "ignites" is a thermal runaway. Unless it is "solved", the rises
        are NaN.
    partitions : int
        Number of heat partitions that the iteration took.
    rise_quantile : ndarray, shape (len(QUANTILES),)
        Quantiles of the rise over the contact area [K].
    mean_rise : float
        Mean rise over the contact area [K].

    Examples
    --------
    >>> import tribo
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> falling = tribo.Friction(0.1, by_temperature=((298.0, 1.0), (398.0, 0.8)))
    >>> found = coupled_heat(scene, state, 0.065, falling, bulk=298.0)
    >>> f"{found.rise_quantile[-1]:.2f} K for {0.1 * state.heat.max_rise:.2f} with one friction"
    '7.36 K for 7.45 with one friction'
    """

    outcome: Outcome
    partitions: int
    rise_quantile: Array
    mean_rise: float

    @property
    def columns(self) -> dict[str, Any]:
        """Temperature rises that a criterion uses, by the names of a sweep's variables."""
        return {"rise_quantile": self.rise_quantile, "mean_rise": self.mean_rise}


def coupled_heat(
    scene: Scene, state: State, velocity: float, law: Friction, bulk: float, added: float = 0.0
) -> CoupledHeat:
    """Find the temperature rises of a contact whose friction depends on temperature.

    Each element has the friction of its own temperature, and its heat warms all elements: Eq. (1)
    of this module.

    Parameters
    ----------
    scene : Scene
        System that was simulated, whose bodies have one bulk temperature and no history of heat.
    state : State
        State of a simulation, in contact.
    velocity : float
        Sliding velocity [m/s].
    law : Friction
        Friction by velocity and temperature.
    bulk : float
        Temperature of both bodies far from the contact [K].
    added : float, optional
        Rise per unit friction that is added evenly to all elements [K].

    Returns
    -------
    CoupledHeat
        Rises [K], averaged over the same positions of the disk as the state's temperature.
    """
    scene = refined_scene(scene, state)
    passing = (replace(state, pressure=pressure) for pressure in state.passing)
    frictions = _Frictions(law, velocity, bulk)
    found = [_at_position(scene, one, frictions, added) for one in (state, *passing)]
    outcomes = {one.outcome for one in found}
    worst = next(one for one in ("ignites", "not converged", "solved") if one in outcomes)
    return CoupledHeat(
        outcome=worst,
        partitions=sum(one.partitions for one in found),
        rise_quantile=np.mean([one.rise_quantile for one in found], axis=0),
        mean_rise=float(np.mean([one.mean_rise for one in found])),
    )


def _at_position(scene: Scene, state: State, frictions: _Frictions, added: float) -> CoupledHeat:
    """Find the temperature rises for one position of the disk, from the pressure of `state`.

    `added` is a rise per unit friction that is added evenly to all elements [K].
    """
    contact = state.pressure > 0
    nodes = np.flatnonzero(contact)
    pin, disk = bodies_at(scene, state, frictions.velocity)
    tolerance = min(scene.fidelity.heat_tolerance, _TOLERANCE)
    heat = friction_heat(scene, state, frictions.velocity).take(nodes)

    def rise_by(flux: Array, total: Array) -> Array:
        """Temperature rise [K] of each touching element due to the friction heat `flux` [W/m²].

        `flux` may be a small part of the contact's friction heat, `total` [W/m²]. The smaller this
        part is, the looser is the tolerance of the heat partition.
        """
        size = float(np.linalg.norm(flux))
        if not size:
            return np.zeros(nodes.size)
        field = np.zeros(contact.shape)
        field.reshape(-1)[nodes] = flux
        share = min(tolerance * float(np.linalg.norm(total)) / size, _LOOSEST)
        method = scene.fidelity.partition
        split = partition_heat(pin, disk, field, contact, method, max(share, tolerance))
        evenly = added * float(flux.sum()) / float(heat.sum())
        return split.rise.take(nodes) + evenly

    rise, outcome, rounds = _solve_rise(heat, frictions, rise_by)
    if outcome != "solved":
        rise = np.full(rise.shape, np.nan)
    field = np.zeros(contact.shape)
    field.reshape(-1)[nodes] = rise
    rows = scene.rows_per_element
    return CoupledHeat(
        outcome=outcome,
        partitions=rounds,
        rise_quantile=contact_quantiles(field.repeat(rows, 1), contact.repeat(rows, 1)),
        mean_rise=float(rise.mean()),
    )


@dataclass(frozen=True, slots=True)
class _Frictions:
    """Coefficient of friction as a function of the rise above bulk, at one velocity."""

    law: Friction
    velocity: float
    bulk: float

    def __call__(self, rise: Array) -> Array:
        return np.asarray(self.law.at(self.velocity, self.bulk + rise))

    def may_ignite(self, cold_rise: Array) -> bool:
        """True if friction may rise so steeply that the contact heats itself ever faster (ignites).

        `cold_rise` is the rise with the friction at the bulk temperature [K].
        """
        highest = self.law.highest(self.bulk) / self.law.at(temperature=self.bulk)
        hottest = self.bulk + float(highest * cold_rise.max())
        return self.law.steepness(self.bulk, hottest) >= STEEP


def _solve_rise(
    heat: Array, frictions: _Frictions, rise_by: Callable[[Array, Array], Array]
) -> tuple[Array, Outcome, int]:
    """Iterate to the rise of each element [K]; return rise, outcome and number of iterations.

    `heat` is the elements' friction heat per unit friction coefficient [W/m²]. Each iteration adds
    the rise due to the change of the heat since the last iteration. ``rise_by(change, total)``
    returns this rise [K], to a tolerance relative to ``total``, the present heat.
    """
    flux = frictions(np.zeros(heat.size)) * heat
    rise = guess = rise_by(flux, flux)
    may_ignite, cold = frictions.may_ignite(rise), float(rise.mean())
    rounds, grown = 1, math.inf
    mixed = _AndersonMixing()
    while rounds < _MOST_ROUNDS:
        changed = frictions(guess) * heat
        try:
            rise = rise + rise_by(changed - flux, changed)
        except ConvergenceError:
            break
        flux, rounds = changed, rounds + 1
        step = rise - guess
        if float(np.abs(step).max()) <= _CLOSE * float(rise.max()):
            return rise, "solved", rounds
        only_rises = may_ignite and float(step.min()) >= -_CLOSE * float(rise.max())
        before, grown = grown, float(step.mean())
        if only_rises and grown >= before and float(rise.mean()) > _GROWN * cold:
            return rise, "ignites", rounds
        guess = rise if only_rises else mixed(guess, step)
    return rise, "not converged", rounds


class _AndersonMixing:
    """Anderson mixing: guesses a fixed point from the last guesses and their residuals.

    It is called with a guess, and with the step that the plain iteration would take from this
    guess. It returns the next guess.
    """

    def __init__(self) -> None:
        self._guesses: list[Array] = []
        self._steps: list[Array] = []

    def __call__(self, guess: Array, step: Array) -> Array:
        self._guesses = [*self._guesses[-_KEPT:], guess]
        self._steps = [*self._steps[-_KEPT:], step]
        following = guess + step
        if len(self._steps) > 1:
            moved, changed = (np.diff(one, axis=0) for one in (self._guesses, self._steps))
            weights = np.linalg.lstsq(changed.T, step, rcond=1e-8)[0]
            following -= weights @ (moved + changed)
        return following.clip(0.0)
