"""Rises at the eight measured transitions of both oils, and the evidence that they give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from pipeline.figures.style import celsius
from pipeline.sweep.model import Sweep
from tribo import Corrections, Cylinder, Scene, State, Stem, Track, contacts, heated
from tribo.corrections import moment_of
from tribo.criterion import Criterion
from tribo.types import Array
from workflows.paper.report import mean
from workflows.paper.study import Study
from workflows.paper.transitions import WearPattern, film_parameter, oil_a, white_oil, worn

SURFACES = 4
_STATIC = 145.0, 8.0  # °C and K: critical temperature of the white oil on the rig
_OIL_A = 120.0, 500.0  # °C: critical temperature of oil A, evenly
_SCATTER = 0.03, 0.3  # standard deviation of the rise, evenly in its logarithm
_MOST_SHARE = 0.5  # of the load on an oil film, over the film parameter
_TRACK, _STEM = 0.34, 4e-3  # m, as in pipeline.run.physics


@dataclass(frozen=True, slots=True)
class Transitions:
    """The eight measured transitions, and the contacts there.

    Attributes
    ----------
    oil : ndarray of str, shape (8,)
        ``"white oil"`` or ``"oil A"``.
    load, friction, bulk_celsius, film_parameter : ndarray, shape (8,)
        Normal load [N], friction, bulk temperature [°C], and minimum film over the roughness, Λ.
    ends : dict
        Scene and last state at each transition on each surface, by wear pattern and conductivity
        [W/(m K)].
    """

    oil: Any
    load: Array
    friction: Array
    bulk_celsius: Array
    film_parameter: Array
    ends: dict[tuple[WearPattern, float], list[list[tuple[Scene, State]]]]


@dataclass(frozen=True, slots=True)
class Physics:
    """Assumptions of a model that the eight transitions may tell apart.

    Attributes
    ----------
    conductivity : float
        Of both bodies [W/(m K)].
    criterion : str
        Temperature that decides, one of `tribo.CRITERIA`; "share" is that of 10 %.
    pattern : {"swept", "local"}
        Pattern of the wear.
    holds_heat : bool
        True if the stem of the pin and the track of the disk keep heat.
    film : bool
        True if an oil film carries a share of the load, in proportion to Λ.
    """

    conductivity: float = 45.0
    criterion: str = "share"
    pattern: WearPattern = "swept"
    holds_heat: bool = False
    film: bool = False

    def warming(self, transitions: Transitions) -> Array:
        """Logarithm of the deciding warming at each transition, its mean over surfaces."""
        criterion = Criterion(self.criterion)
        rises = [
            [criterion.rise(moment_of(*end, self._corrections(end[0]))) for end in surfaces]
            for surfaces in transitions.ends[self.pattern, self.conductivity]
        ]
        return mean(np.log(transitions.friction[:, None] * np.array(rises)))

    def _corrections(self, scene: Scene) -> Corrections:
        if not self.holds_heat:
            return Corrections()
        pin, disk = scene.pin, scene.disk
        across = 2 * pin.radius * (pin.length if isinstance(pin, Cylinder) else pin.radius)
        stem = Stem.rod(_STEM, across, self.conductivity, disk.thermal_diffusivity)
        return Corrections(track=Track.under(pin, disk, _TRACK), stem=stem)


def transitions_of(
    study: Study, patterns: Sequence[WearPattern], conductivities: Sequence[float]
) -> Transitions:
    """Simulate all transitions with each pattern of wear and conductivity [W/(m K)].

    A contact is simulated once for all conductivities.
    """
    tests = [("white oil", *test) for test in white_oil(study)]
    tests += [("oil A", *test) for test in oil_a(study)]
    ends: Any = {(pattern, K): [[] for _ in tests] for pattern in patterns for K in conductivities}
    for number, (oil, scene, row) in enumerate(tests):
        for pattern in patterns:
            for seed in study.seeds(SURFACES):
                surface = worn(scene.on_surface(seed), pattern)
                *_, contact = contacts(surface.scene, row.normal_load, row.velocity)
                for K in conductivities:
                    other = _conducting(surface, K)
                    state = heated(other.scene, contact, row.velocity)
                    ends[pattern, K][number].append((other.scene, state))
        study.tell(f"{oil}, {row.normal_load:g} N at {row.velocity:g} m/s")
    return Transitions(
        oil=np.array([oil for oil, *_ in tests]),
        load=np.array([row.normal_load for *_, row in tests]),
        friction=np.array([row.friction for *_, row in tests]),
        bulk_celsius=celsius(np.array([s.conditions.bulk_temperature for _, s, _ in tests])),
        film_parameter=np.array([film_parameter(scene, row) for _, scene, row in tests]),
        ends=ends,
    )


def _conducting(sweep: Sweep, conductivity: float) -> Sweep:
    pin = replace(sweep.scene.pin.material, thermal_conductivity=conductivity)
    disk = replace(sweep.scene.disk, thermal_conductivity=conductivity)
    return sweep.changed(pin=replace(sweep.scene.pin, material=pin), disk=disk)


def log_evidence(
    transitions: Transitions,
    warming: Array,
    film: bool = False,
    oils: Sequence[str] = ("white oil", "oil A"),
) -> tuple[Array, dict[str, Array]]:
    """Logarithm of the evidence for a model, over critical temperatures and scatters.

    ln(µr) at each transition is normal about ln(Θcr − Θb), with a scatter that is not known.

    Parameters
    ----------
    transitions : Transitions
        Transitions, whose oils have a critical temperature each.
    warming : ndarray, shape (..., 8)
        Logarithms of the deciding warming at each transition, as `Physics.warming` gives them.
    film : bool
        True to take a share of the load, from 0 to half of Λ, off the warming.
    oils : sequence of str
        Oils whose transitions count.

    Returns
    -------
    log : ndarray, shape (...)
        Evidence.
    critical : dict of ndarray, shape (...)
        Mean critical temperature of each oil [°C].
    """
    sigma = np.geomspace(*_SCATTER, 12)
    shares = np.linspace(0.0, _MOST_SHARE, 6) if film else np.zeros(1)
    carried = np.minimum(0.9, shares[:, None] * transitions.film_parameter)
    lowered = warming[..., None, :] + np.log(1 - carried)
    total, critical = np.zeros((*lowered.shape[:-1], len(sigma))), {}
    for oil in oils:
        (temperatures, prior), of_oil = _temperatures()[oil], transitions.oil == oil
        expected = np.log(temperatures[:, None] - transitions.bulk_celsius[of_oil])
        squares = ((lowered[..., of_oil][..., None, :] - expected) ** 2).sum(axis=-1)
        log = prior[:, None] - squares[..., None] / (2 * sigma**2) - of_oil.sum() * np.log(sigma)
        total = total + logsumexp(log, axis=-2)
        weight = np.exp(log - log.max(axis=(-3, -2, -1), keepdims=True)).sum(axis=(-3, -1))
        critical[oil] = (weight * temperatures).sum(axis=-1) / weight.sum(axis=-1)
    number = np.isin(transitions.oil, oils).sum()
    normal = number / 2 * np.log(2 * np.pi) + np.log(len(sigma) * len(shares))
    return logsumexp(total, axis=(-2, -1)) - normal, critical


def _temperatures() -> dict[str, tuple[Array, Array]]:
    """Critical temperatures of each oil [°C], and the logarithms of their probabilities."""
    middle, sd = _STATIC
    white, other = np.linspace(middle - 4 * sd, middle + 4 * sd, 33), np.linspace(*_OIL_A, 128)
    log = -(((white - middle) / sd) ** 2) / 2
    even = np.zeros(other.size)
    return {"white oil": (white, log - logsumexp(log)), "oil A": (other, even - logsumexp(even))}


def rounded(ratio: float) -> str:
    """Write odds by as many digits as they are known to.

    Examples
    --------
    >>> rounded(7.14), rounded(642693.0)
    ('7.1', '600 000')
    """
    return f"{ratio:.1f}" if ratio < 10 else f"{float(f'{ratio:.1g}'):,.0f}".replace(",", " ")
