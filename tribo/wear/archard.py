"""Archard's wear of the pin, dh = k p dS, in steps of the sliding distance S.

h is the worn depth, k the specific wear rate. The pressure p follows at once from h and the load F,
and wear relaxes it: a wave of h decays as exp(−kS/λ). Here λ is the compliance of the half-space to
a pressure of this wave, an eigenvalue of the elastic map D from pressure to displacement. So the
shortest waves make the equation stiff. A scheme that takes the pressure at the end of a step solves
the contact with D + k·dS instead of D, which only adds a constant to some entries of the spectrum.
The worn volume is k∫F dS in every scheme.

A user's law gives k for each step, from distance, pressure and velocity. It is any object with the
attributes of `WearLaw`. If its method `mean_wear` returns anything but a `tribo.Wear`,
`evaluate_wear` raises an `InvariantError`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol, get_args

import numpy as np

from tribo.constants import MAX_DISTANCE_FACTOR
from tribo.contact import ElasticHalfSpace
from tribo.errors import InputError, InvariantError, law_errors, require_number
from tribo.types import Array

WearPattern = Literal["local", "swept"]
WEAR_PATTERNS: tuple[WearPattern, ...] = get_args(WearPattern)
WearScheme = Literal["implicit", "sdirk2"]


class Stage(NamedTuple):
    """A contact to be solved within a step: its load [N], and two sliding distances [m].

    Its pressure wears the pin over `distance` [m]. The shape of the pin for which the contact is
    solved already includes the wear by this pressure over `implicit_distance` [m].
    """

    normal_load: float  # on the whole pin [N]
    distance: float  # sliding distance over which the pressure of this contact wears the pin [m]
    implicit_distance: float  # sliding distance whose wear is solved with the pressure [m]


@dataclass(frozen=True, slots=True)
class RungeKutta:
    """A Runge-Kutta scheme of one or more stages for Archard's law, dh/dS = k p(h, F).

    h is the wear depth [m], S the sliding distance [m], k the specific wear rate [m²/N], and p the
    pressure [Pa] on the worn shape under the load F [N]. cᵢ, bᵢ and γ are the scheme's
    ``fractions``, ``weights`` and ``implicitness``.

    Stage i has the load Fᵢ at the fraction cᵢ of the step, as if the load changed linearly. It is
    solved for its pressure pᵢ on the shape worn by h + k ΔS (b₁p₁ + … + bᵢ₋₁pᵢ₋₁ + γpᵢ). The step
    ends at the wear depth h + k ΔS Σ bᵢpᵢ. For a step over the sliding distance L at the mean load
    F̄, ΔS is L F̄/Σ bᵢFᵢ: so the worn volume is kF̄L, whatever the load does within the step.
    """

    fractions: tuple[float, ...]  # c
    weights: tuple[float, ...]  # b
    implicitness: float  # γ

    def stages(
        self, loads: tuple[float, float], mean_load: float, distance: float
    ) -> Iterator[Stage]:
        """Yield the contacts to solve in a step, in order; the last contact is at the step's end.

        `loads` are the loads at the start and end of the step, `mean_load` is the mean load over
        the step [N]. `distance` is the sliding distance of the step [m]. If the stages would carry
        less than half of `mean_load` on average, there are two contacts instead: one at `mean_load`
        that wears the pin, and one at the end without wear.

        Examples
        --------
        >>> implicit = WEAR_SCHEMES["implicit"]
        >>> list(implicit.stages((0.0, 80.0), mean_load=40.0, distance=1.0))
        [Stage(normal_load=80.0, distance=0.5, implicit_distance=0.5)]
        """
        begin, end = loads
        stage_loads = [(1 - c) * begin + c * end for c in self.fractions]
        weighted_load = sum(b * F for b, F in zip(self.weights, stage_loads, strict=True))
        # Stages under almost no load, as when the load falls to zero, do not show where the pin
        # wears. Instead, one stage wears the pin at the mean load, and a stage without wear ends
        # the step.
        if mean_load > MAX_DISTANCE_FACTOR * weighted_load:
            yield Stage(mean_load, distance, distance)
            yield Stage(end, 0.0, 0.0)
            return
        stage_distance = distance * mean_load / weighted_load if weighted_load else 0.0
        for b, F in zip(self.weights, stage_loads, strict=True):
            yield Stage(F, b * stage_distance, self.implicitness * stage_distance)


_GAMMA = 1 - 1 / math.sqrt(2)

WEAR_SCHEMES: dict[WearScheme, RungeKutta] = {
    "implicit": RungeKutta((1.0,), (1.0,), implicitness=1.0),
    "sdirk2": RungeKutta((_GAMMA, 1.0), (1 - _GAMMA, _GAMMA), implicitness=_GAMMA),
}
"""Schemes by name.

``"implicit"``, backward Euler: of first order, stable for any step. ``"sdirk2"`` (Alexander, SIAM
J. Numer. Anal. 14, 1977): of second order, stable for any step, at twice the cost. Where much area
comes into contact within a step, this scheme needs a short implicit step at its end; see
`tribo.simulation.requested_state`.
"""


@dataclass(frozen=True, slots=True)
class Wear:
    """Wear of the pin.

    Parameters
    ----------
    specific_wear_rate : float
        Worn volume per load and sliding distance, k [m²/N].
    pattern : {"local", "swept"}
        ``"local"``: each point of the pin wears by the pressure on it, as if it always faced the
        same part of the disk (Bosman & de Rooij, Eq. 26). ``"swept"``: the roughness moves past
        the pin. If the window is periodic along y, all points of the pin at the same x wear by the
        mean pressure along y. Over a sliding distance dS their depth grows by k dS ⟨p(x, ·)⟩_y, and
        a simulation takes this mean over positions of the disk. If y is not periodic, as under a
        ball, each point wears by its mean pressure over positions of the disk. See
        `tribo.simulation.disk_positions`.

    Examples
    --------
    >>> steel = Wear(specific_wear_rate=1.2e-15, pattern="swept")
    >>> steel.depth(np.array([[1e9, 3e9]]), distance=0.0625)
    array([[1.5e-07, 1.5e-07]])
    """

    specific_wear_rate: float
    pattern: WearPattern = "swept"

    def __post_init__(self) -> None:
        require_number(specific_wear_rate=self.specific_wear_rate)
        if not 0 <= self.specific_wear_rate < np.inf:
            raise InputError(
                f"specific_wear_rate is {self.specific_wear_rate!r}; it must be finite and ≥ 0"
            )
        if self.pattern not in WEAR_PATTERNS:
            raise InputError(
                f"wear pattern is {self.pattern!r}; allowed are {', '.join(WEAR_PATTERNS)}"
            )

    def depth(self, pressure: Array, distance: float) -> Array:
        """Depth [m] that a `pressure` [Pa] wears over a sliding `distance` [m], at each element."""
        source = pressure.mean(axis=1, keepdims=True) if self.pattern == "swept" else pressure
        return np.broadcast_to(self.specific_wear_rate * distance * source, pressure.shape)

    def yielding(self, solid: ElasticHalfSpace, distance: float) -> ElasticHalfSpace:
        """Return a copy of `solid` whose displacement includes the wear by the same pressure.

        The pressure wears over the sliding `distance` [m]. Raises an `InputError` for the pattern
        "swept" if y is not periodic.
        """
        compliance = self.specific_wear_rate * distance
        if self.pattern == "swept" and not solid.grid.periodic[1]:
            raise InputError(
                "swept wear averages along y, which needs a window that is periodic along y; "
                "use the pattern 'local'"
            )
        if self.pattern == "local" or solid.grid.shape[1] == 1:
            worn = solid.replace_spectrum(solid.spectrum + compliance)
            worn.self_influence += compliance
            return worn
        spectrum = solid.spectrum.copy()
        spectrum[:, 0] += compliance
        return solid.replace_spectrum(spectrum)


@dataclass(frozen=True, slots=True)
class RollingWear(Wear):
    """Wear of a pin that rolls: its depth is the same all along the track around the pin.

    With the `pattern` "local", the depth at each y is in proportion to the mean pressure along x at
    this y; with "swept", to the mean pressure on the whole window. `window_share` is the length of
    the window along x divided by the length of the track, above 0 and at most 1. The equation is
    Eq. (1) of `tribo.simulation.motion`.

    Examples
    --------
    Half of the window is pressed, and the window is a tenth of the track:

    >>> roller = RollingWear(specific_wear_rate=1e-15, pattern="local", window_share=0.1)
    >>> roller.depth(np.array([[1e9], [0.0]]), distance=1.0)
    array([[5.e-08],
           [5.e-08]])
    """

    window_share: float = 1.0

    def __post_init__(self) -> None:
        Wear.__post_init__(self)  # a slotted dataclass has no super()
        if not 0 < self.window_share <= 1:
            raise InputError(
                f"window_share is {self.window_share!r}; it must be above 0 and at most 1"
            )

    def depth(self, pressure: Array, distance: float) -> Array:
        """Depth [m] that a `pressure` [Pa] wears over a sliding `distance` [m], at each element."""
        axes = (0, 1) if self.pattern == "swept" else (0,)
        source = pressure.mean(axis=axes, keepdims=True) * self.window_share
        return np.broadcast_to(self.specific_wear_rate * distance * source, pressure.shape)

    def yielding(self, solid: ElasticHalfSpace, distance: float) -> ElasticHalfSpace:
        """Return a copy of `solid` whose displacement includes the wear by the same pressure.

        The pressure wears over the sliding `distance` [m].
        """
        spectrum = solid.spectrum.copy()
        waves = slice(1) if self.pattern == "swept" else slice(None)
        # The spectrum's first mode along x is a sum over the padded axis.
        padding = len(solid.spectrum) / solid.grid.shape[0]
        spectrum[0, waves] += self.specific_wear_rate * distance * self.window_share * padding
        return solid.replace_spectrum(spectrum)


class WearLaw(Protocol):
    """A law of wear in proportion to pressure, with one specific wear rate in each step.

    The rate may depend on the distance slid, on the pressure in the contact and on the sliding
    velocity.

    Examples
    --------
    A rate that falls as the pin slides, to a half after 2 m, and grows with the velocity:

    >>> import math
    >>> from dataclasses import dataclass
    >>> import tribo
    >>> @dataclass(frozen=True)
    ... class Fading:
    ...     rate: float  # at 1 m/s
    ...     distance: float
    ...     pattern: str = "swept"
    ...
    ...     def mean_wear(self, begin, end, pressure, velocity):
    ...         mean = math.log((self.distance + end) / (self.distance + begin)) / (end - begin)
    ...         return tribo.Wear(self.rate * velocity * self.distance * mean, self.pattern)
    >>> law: tribo.WearLaw = Fading(6e-15, 2.0)
    >>> f"{law.mean_wear(2.0, 2.001, pressure=5e8, velocity=1.5).specific_wear_rate:.1e} m²/N"
    '4.5e-15 m²/N'
    """

    @property
    def pattern(self) -> WearPattern:
        """Pattern of the wear, see `tribo.Wear`.

        ``"local"``: each point of the pin wears by the pressure on it. ``"swept"``: by a mean
        pressure, as the disk's roughness moves past the pin.
        """

    def mean_wear(self, begin: float, end: float, pressure: float, velocity: float) -> Wear:
        """A `Wear` with the law's mean rate in a step, from sliding distance `begin` to `end` [m].

        `pressure` is the nominal pressure at the step's begin [Pa]: the load over the area that
        the contact spans, width × length under a line contact, else the ellipse of its two widths.
        It is 0 before the first contact. A rate that depends on it is of first order in the steps.
        `velocity` is the sliding velocity, not negative [m/s].
        """


def evaluate_wear(
    wear: Wear | WearLaw, begin: float, end: float, pressure: float, velocity: float
) -> Wear:
    """A `Wear` with a constant rate: the mean from sliding distance `begin` to `end` [m].

    `wear` is a law, called with the arguments of `WearLaw.mean_wear`, or a `Wear`, which is
    returned unchanged. If `end` does not exceed `begin`, a law gives a `Wear` with the rate 0.

    Raises
    ------
    InputError, InvariantError
        If the law fails, or if it returns no `Wear`.
    """
    if isinstance(wear, Wear):
        return wear
    if not end > begin:
        return Wear(0.0, wear.pattern)
    with law_errors(f"wear law {wear!r}"):
        step_wear: object = wear.mean_wear(begin, end, pressure, velocity)
    if not isinstance(step_wear, Wear):
        raise InvariantError(
            f"wear law: its wear over {begin:g} to {end:g} m is {step_wear!r}; it must be a "
            "tribo.Wear"
        )
    return step_wear


def require_wear(wear: object) -> None:
    """Raise `InputError` unless `wear` is None, a `Wear` or has the attributes of a `WearLaw`."""
    if wear is None or isinstance(wear, Wear):
        return
    if missing := ", ".join(name for name in ("pattern", "mean_wear") if not hasattr(wear, name)):
        raise InputError(f"the wear law {wear!r} has no {missing}; see tribo.WearLaw")
