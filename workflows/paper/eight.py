"""Rises at the eight measured transitions of both oils, and the evidence that they give."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.model import Measurement, Sweep
from tribo import Corrections, Cylinder, Stem, Track, contacts, heated, measures
from tribo.criterion import Criterion, columns_of
from tribo.types import Array
from workflows.paper.study import Study
from workflows.paper.transitions import WearPattern, worn

SCENES = ("irg_transition", "oil_a", "oil_a_hot")
_SURFACES = 4
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
    columns : dict
        Columns of the contact by wear pattern, conductivity [W/(m K)] and surface.
    """

    oil: str
    scene: Sweep
    measured: Measurement
    columns: dict[tuple[WearPattern, float], list[Mapping[str, Any]]]

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
        return np.array([self._warming(transition) for transition in transitions])

    def _warming(self, transition: Transition) -> float:
        parts = Corrections()
        if self.holds_heat:
            pin, disk = transition.scene.pin, _conducting(transition.scene, self.conductivity).disk
            across = 2 * pin.radius * (pin.length if isinstance(pin, Cylinder) else pin.radius)
            rod = _STEM, across, self.conductivity, disk.thermal_diffusivity
            parts = Corrections(track=Track.under(pin, disk, _TRACK), stem=Stem.rod(*rod))
        criterion, friction = Criterion(self.criterion), transition.measured.friction or 0.0
        rises = [
            criterion.rise(parts.applied(columns))[0]
            for columns in transition.columns[self.pattern, self.conductivity]
        ]
        return float(np.mean(np.log(friction * np.array(rises))))


def transitions_of(
    study: Study, kinds: Iterable[tuple[WearPattern, Sequence[float]]]
) -> tuple[Transition, ...]:
    """Simulate all transitions on each surface: a contact once for all conductivities.

    Parameters
    ----------
    study : Study
        Scenes and surfaces.
    kinds : iterable
        Wear patterns, each with its conductivities [W/(m K)].
    """
    kinds, transitions = list(kinds), []
    for name in SCENES:
        scene = study.scene(name)
        for measured in scene.measured:
            columns: dict[tuple[WearPattern, float], list[Mapping[str, Any]]] = {}
            for pattern, conductivities in kinds:
                for seed in study.seeds(_SURFACES):
                    surface = worn(scene.on_surface(seed), pattern)
                    for K, column in _columns(surface, measured, conductivities):
                        columns.setdefault((pattern, K), []).append(column)
            oil = "oil A" if "oil_a" in name else "white oil"
            transitions.append(Transition(oil, scene, measured, columns))
            study.tell(f"{oil}, {measured.normal_load:g} N at {measured.velocity:g} m/s")
    return tuple(transitions)


def _columns(
    scene: Sweep, measured: Measurement, conductivities: Sequence[float]
) -> Iterable[tuple[float, Mapping[str, Any]]]:
    *_, contact = contacts(scene, measured.normal_load, measured.velocity)
    for K in conductivities:
        other = _conducting(scene, K)
        state = heated(other, contact, measured.velocity)
        if state.heat is not None:
            record = {**measures(other, state), **columns_of(state.heat)}
            yield K, {name: np.array([value]) for name, value in record.items()}


def _conducting(scene: Sweep, conductivity: float) -> Sweep:
    pin = replace(scene.pin.material, thermal_conductivity=conductivity)
    disk = replace(scene.disk, thermal_conductivity=conductivity)
    return replace(scene, pin=replace(scene.pin, material=pin), disk=disk)


def log_evidence(
    transitions: Sequence[Transition], warming: Array, film: bool = False
) -> tuple[Array, Array, Array]:
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
    tuple of ndarray
        Evidence, shape (...); and the mean critical temperatures of white oil and of oil A [°C],
        NaN for an oil that has no transition.
    """
    sigma = np.geomspace(*_SCATTER, 12)
    shares = np.linspace(0.0, _MOST_SHARE, 6) if film else np.zeros(1)
    films = np.array([transition.film_parameter for transition in transitions])
    lowered = warming[..., None, :] + np.log(1 - np.minimum(0.9, shares[:, None] * films))
    total = np.zeros((*lowered.shape[:-1], len(sigma)))
    means = []
    for oil, temperatures, prior in _temperatures():
        of_oil = np.array([transition.oil == oil for transition in transitions])
        if not of_oil.any():
            means.append(np.full(warming.shape[:-1], np.nan))
            continue
        bulks = np.array([t.bulk_celsius for t in transitions])[of_oil]
        expected = np.log(temperatures[:, None] - bulks)
        squares = ((lowered[..., of_oil][..., None, :] - expected) ** 2).sum(axis=-1)
        log = prior[:, None] - squares[..., None] / (2 * sigma**2) - of_oil.sum() * np.log(sigma)
        total = total + logsumexp(log, axis=-2)
        weight = np.exp(log - log.max(axis=(-3, -2, -1), keepdims=True)).sum(axis=(-3, -1))
        means.append((weight * temperatures).sum(axis=-1) / weight.sum(axis=-1))
    normal = len(transitions) / 2 * np.log(2 * np.pi) + np.log(len(sigma) * len(shares))
    return logsumexp(total, axis=(-2, -1)) - normal, means[0], means[1]


def _temperatures() -> Iterable[tuple[str, Array, Array]]:
    """Critical temperatures of each oil [°C], and the logarithms of their probabilities."""
    mean, sd = _STATIC
    white = np.linspace(mean - 4 * sd, mean + 4 * sd, 33)
    for oil, values, log in (
        ("white oil", white, -(((white - mean) / sd) ** 2) / 2),
        ("oil A", (a := np.linspace(*_OIL_A, 128)), np.zeros(a.size)),
    ):
        yield oil, values, log - logsumexp(log)


def rounded(ratio: float) -> str:
    """Write odds by as many digits as they are known to.

    Examples
    --------
    >>> rounded(7.14), rounded(642693.0)
    ('7.1', '600 000')
    """
    return f"{ratio:.1f}" if ratio < 10 else f"{float(f'{ratio:.1g}'):,.0f}".replace(",", " ")
