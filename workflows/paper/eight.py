"""Rises at the eight measured transitions of both oils, and the evidence that they give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.model import Measurement, Sweep
from tribo import Corrections, Cylinder, State, Stem, Track, contacts, heated
from tribo.corrections import moment_of
from tribo.criterion import Criterion
from tribo.types import Array
from workflows.paper.study import Study
from workflows.paper.transitions import WearPattern, worn

SURFACES = 4
SCENES = {"irg_transition": "white oil", "oil_a": "oil A", "oil_a_hot": "oil A"}
_STATIC = 145.0, 8.0  # °C and K: critical temperature of the white oil on the rig
_OIL_A = 120.0, 500.0  # °C: critical temperature of oil A, evenly
_SCATTER = 0.03, 0.3  # standard deviation of the rise, evenly in its logarithm
_MOST_SHARE = 0.5  # of the load on an oil film, over the film parameter
_TRACK, _STEM = 0.34, 4e-3  # m, as in pipeline.run.physics


@dataclass(frozen=True, slots=True)
class Transition:
    """A measured transition, and the contact there.

    Attributes
    ----------
    oil : str
        ``"white oil"`` or ``"oil A"``.
    scene : Sweep
        Its scene.
    measured : Measurement
        Load, velocity and friction.
    ends : dict
        Scenes and last states, one for each surface, by wear pattern and conductivity [W/(m K)].
    """

    oil: str
    scene: Sweep
    measured: Measurement
    ends: dict[tuple[WearPattern, float], list[tuple[Sweep, State]]]

    @property
    def bulk_celsius(self) -> float:
        """Bulk temperature [°C]."""
        return self.scene.conditions.bulk_temperature - 273.15

    @property
    def film_parameter(self) -> float:
        """Minimum film over the roughness, Λ."""
        lubrication = Lubrication.of(self.scene)
        if lubrication is None:
            return 0.0
        place, bulk = self.measured, self.scene.conditions.bulk_temperature
        return float(lubrication.film_parameter(place.normal_load, place.velocity, bulk))


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

    def warming(self, transitions: Sequence[Transition]) -> Array:
        """Logarithm of the deciding warming at each transition, its mean over surfaces."""
        criterion, means = Criterion(self.criterion), []
        for transition in transitions:
            rises = [
                criterion.rise(moment_of(scene, state, self._corrections(scene)))
                for scene, state in transition.ends[self.pattern, self.conductivity]
            ]
            means.append(np.mean(np.log((transition.measured.friction or 0.0) * np.array(rises))))
        return np.array(means)

    def _corrections(self, scene: Sweep) -> Corrections:
        if not self.holds_heat:
            return Corrections()
        pin, disk = scene.pin, scene.disk
        across = 2 * pin.radius * (pin.length if isinstance(pin, Cylinder) else pin.radius)
        stem = Stem.rod(_STEM, across, self.conductivity, disk.thermal_diffusivity)
        return Corrections(track=Track.under(pin, disk, _TRACK), stem=stem)


def transitions_of(
    study: Study, patterns: Sequence[WearPattern], conductivities: Sequence[float]
) -> tuple[Transition, ...]:
    """Simulate all transitions with each pattern of wear and conductivity [W/(m K)].

    A contact is simulated once for all conductivities.
    """
    transitions = []
    for name, oil in SCENES.items():
        scene = study.scene(name)
        for measured in scene.measured:
            ends: Any = {(pattern, K): [] for pattern in patterns for K in conductivities}
            for pattern in patterns:
                for seed in study.seeds(SURFACES):
                    surface = worn(scene.on_surface(seed), pattern)
                    *_, contact = contacts(surface, measured.normal_load, measured.velocity)
                    for K in conductivities:
                        other = _conducting(surface, K)
                        state = heated(other, contact, measured.velocity)
                        ends[pattern, K].append((other, state))
            transitions.append(Transition(oil, scene, measured, ends))
            study.tell(f"{oil}, {measured.normal_load:g} N at {measured.velocity:g} m/s")
    return tuple(transitions)


def _conducting(scene: Sweep, conductivity: float) -> Sweep:
    pin = replace(scene.pin.material, thermal_conductivity=conductivity)
    disk = replace(scene.disk, thermal_conductivity=conductivity)
    return replace(scene, pin=replace(scene.pin, material=pin), disk=disk)


def log_evidence(
    transitions: Sequence[Transition], warming: Array, film: bool = False
) -> tuple[Array, dict[str, Array]]:
    """Logarithm of the evidence for a model, over critical temperatures and scatters.

    ln(µr) at each transition is normal about ln(Θcr − Θb), with a scatter that is not known.

    Parameters
    ----------
    transitions : sequence of Transition
        Transitions, whose oils have a critical temperature each.
    warming : ndarray, shape (..., n)
        Logarithms of the deciding warming at each transition, as `Physics.warming` gives them.
    film : bool
        True to take a share of the load, from 0 to half of Λ, off the warming.

    Returns
    -------
    log : ndarray, shape (...)
        Evidence.
    critical : dict of ndarray, shape (...)
        Mean critical temperature of each oil that has transitions [°C].
    """
    sigma = np.geomspace(*_SCATTER, 12)
    shares = np.linspace(0.0, _MOST_SHARE, 6) if film else np.zeros(1)
    films = np.array([transition.film_parameter for transition in transitions])
    lowered = warming[..., None, :] + np.log(1 - np.minimum(0.9, shares[:, None] * films))
    bulks = np.array([transition.bulk_celsius for transition in transitions])
    total, critical = np.zeros((*lowered.shape[:-1], len(sigma))), {}
    for oil, (temperatures, prior) in _temperatures().items():
        of_oil = np.array([transition.oil == oil for transition in transitions])
        if not of_oil.any():
            continue
        expected = np.log(temperatures[:, None] - bulks[of_oil])
        squares = ((lowered[..., of_oil][..., None, :] - expected) ** 2).sum(axis=-1)
        log = prior[:, None] - squares[..., None] / (2 * sigma**2) - of_oil.sum() * np.log(sigma)
        total = total + logsumexp(log, axis=-2)
        weight = np.exp(log - log.max(axis=(-3, -2, -1), keepdims=True)).sum(axis=(-3, -1))
        critical[oil] = (weight * temperatures).sum(axis=-1) / weight.sum(axis=-1)
    normal = len(transitions) / 2 * np.log(2 * np.pi) + np.log(len(sigma) * len(shares))
    return logsumexp(total, axis=(-2, -1)) - normal, critical


def _temperatures() -> dict[str, tuple[Array, Array]]:
    """Critical temperatures of each oil [°C], and the logarithms of their probabilities."""
    mean, sd = _STATIC
    white, oil_a = np.linspace(mean - 4 * sd, mean + 4 * sd, 33), np.linspace(*_OIL_A, 128)
    log = -(((white - mean) / sd) ** 2) / 2
    even = np.zeros(oil_a.size)
    return {"white oil": (white, log - logsumexp(log)), "oil A": (oil_a, even - logsumexp(even))}


def rounded(ratio: float) -> str:
    """Write odds by as many digits as they are known to.

    Examples
    --------
    >>> rounded(7.14), rounded(642693.0)
    ('7.1', '600 000')
    """
    return f"{ratio:.1f}" if ratio < 10 else f"{float(f'{ratio:.1g}'):,.0f}".replace(",", " ")
