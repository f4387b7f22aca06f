"""Physics beside the two half-spaces, which acts after the simulation.

Friction that falls with velocity multiplies the rise at friction 1. A film on the disk, the stem
that holds the pin, and heat of earlier passes in the disk's track add to it: resistances and
warmings of the thermal circuit `tribo.thermal.circuit_rise`, in proportion to friction. So all of
it follows from what a simulation records, and costs none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np
import scipy  # parts of it are loaded where they are used

from tribo.analytic import hertz_contact
from tribo.criterion import columns_of
from tribo.errors import InputError, require_positive
from tribo.material import Material
from tribo.simulation import Ball, Crowned, Cylinder, Scene, State, measures
from tribo.thermal import circuit_rise, stem_fraction, track_warming
from tribo.types import Array, Mask

NEEDED = (
    "time", "normal_load", "sliding_distance", "mean_pressure", "contact_width", "pin_heat_share",
    "mean_rise",
)  # fmt: skip
"""Columns of a step that corrections need."""


@dataclass(frozen=True, slots=True)
class Stem:
    """The rod between the heated end of the pin and its holder.

    Attributes
    ----------
    resistance : float
        Thermal resistance in the steady state, L/(K A) for a rod [K/W].
    settling_time : float
        L²/κ [s]; 0 for a resistance without heat capacity.

    Examples
    --------
    >>> Stem.rod(5e-3, 13.6e-6, thermal_conductivity=45.0, thermal_diffusivity=1.2275e-5)
    Stem(resistance=8.169..., settling_time=2.036...)
    """

    resistance: float
    settling_time: float = 0.0

    def __post_init__(self) -> None:
        require_positive(resistance=self.resistance)
        if not 0 <= self.settling_time < math.inf:
            raise InputError(f"settling_time is {self.settling_time!r}; it must be finite and ≥ 0")

    @classmethod
    def rod(
        cls, length: float, area: float, thermal_conductivity: float, thermal_diffusivity: float
    ) -> Self:
        """A rod of a length [m], cross section [m²], K [W/(m K)] and κ [m²/s]."""
        require_positive(length=length, area=area)
        return cls(length / (thermal_conductivity * area), length**2 / thermal_diffusivity)

    def resistance_after(self, time: Array) -> Array:
        """Resistance after a time under constant heat [K/W]."""
        if self.settling_time == 0:
            return np.full(np.shape(time), self.resistance)
        return self.resistance * stem_fraction(np.asarray(time) / self.settling_time)


@dataclass(frozen=True, slots=True)
class Track:
    """The ring of the disk that passes under the pin again and again.

    Attributes
    ----------
    length : float
        Length of the track [m].
    width : float or None
        Its width [m]; None for that of the contact times `aspect`.
    aspect : float
        Width of the contact across the track over that along it, of a ball or a crowned pin.
    thermal_diffusivity, heat_capacity : float
        κ [m²/s] and ρc [J/(m³ K)] of the disk.

    Examples
    --------
    >>> Track(0.34, 3.4e-3, 1.0, thermal_diffusivity=1.2275e-5, heat_capacity=3.666e6).length
    0.34
    """

    length: float
    width: float | None
    aspect: float
    thermal_diffusivity: float
    heat_capacity: float

    @classmethod
    def under(cls, pin: Cylinder | Ball | Crowned, disk: Material, length: float) -> Self:
        """The track under a pin at rest, of a length [m].

        Examples
        --------
        >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
        >>> Track.under(Crowned(10e-3, 50e-3, steel), steel, 0.34).aspect
        2.8...
        """
        of_point = hertz_contact(1.0, 1e11, pin.radius, crown_radius=pin.crown_radius)
        capacity = disk.density * disk.specific_heat
        return cls(length, pin.length, of_point.aspect, disk.thermal_diffusivity, capacity)

    def __post_init__(self) -> None:
        require_positive(**{k: v for k, v in asdict(self).items() if v is not None})


@dataclass(frozen=True, slots=True, kw_only=True)
class Corrections:
    """Physics beside the two half-spaces, each left out where it is not given.

    Attributes
    ----------
    friction : tuple of tuple of float
        Sliding velocities above 0, ascending [m/s], and friction there over the coefficient of
        friction; smooth and monotonic in between, and beyond the ends as there.
    track : Track or None
        Track of the disk, which earlier passes have warmed.
    stem : Stem or None
        Stem of the pin.
    film_resistance : float
        Thickness over conductivity of an oxide or tribofilm on the disk [m² K/W].

    Examples
    --------
    >>> falling = Corrections(friction=((1.0, 1.03), (4.0, 0.94)))
    >>> falling.friction_factor(np.array([0.5, 2.0, 9.0])).round(3).tolist()
    [1.03, 0.985, 0.94]
    """

    friction: tuple[tuple[float, float], ...] = ()
    track: Track | None = None
    stem: Stem | None = None
    film_resistance: float = 0.0

    def __post_init__(self) -> None:
        velocities = [velocity for velocity, _ in self.friction]
        if sorted(set(velocities)) != velocities or (velocities and velocities[0] <= 0):
            raise InputError(
                f"velocities of friction are {velocities}; they must be above 0 and ascending"
            )
        if not all(0 <= factor < math.inf for _, factor in self.friction):
            raise InputError(f"friction is {self.friction!r}; each must be finite and ≥ 0")
        if not 0 <= self.film_resistance < math.inf:
            raise InputError(
                f"film_resistance is {self.film_resistance!r} m² K/W; it must be finite and ≥ 0"
            )

    @classmethod
    def of_plain(cls, plain: Mapping[str, Any]) -> Self:
        """Corrections from the plain data that `as_dict` gives."""
        track, stem = plain.get("track"), plain.get("stem")
        return cls(
            friction=tuple((v, factor) for v, factor in plain.get("friction", ())),
            track=Track(**track) if track else None,
            stem=Stem(**stem) if stem else None,
            film_resistance=plain.get("film_resistance", 0.0),
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the corrections that are present as plain data."""
        plain = asdict(self) | {"friction": [list(pair) for pair in self.friction]}
        return {name: value for name, value in plain.items() if value}

    @property
    def worded(self) -> str:
        """The corrections in words."""
        parts = (
            (self.friction, "friction by velocity"),
            (self.track, f"earlier passes, {self.track.length:.3g} m" if self.track else ""),
            (self.stem, f"stem of the pin, {self.stem.resistance:.3g} K/W" if self.stem else ""),
            (self.film_resistance, f"film on the disk, {self.film_resistance:.3g} m² K/W"),
        )
        return "; ".join(words for part, words in parts if part)

    def friction_factor(self, velocity: Array) -> Array:
        """Friction at sliding velocities [m/s] over the coefficient of friction."""
        if not self.friction:
            return np.ones(np.shape(velocity))
        velocities, factors = np.array(self.friction).T
        # Smooth also at the ends, since a boundary is interpolated between points on both sides.
        nodes = np.concatenate([[velocities[0] / 2], velocities, [2 * velocities[-1]]])
        curve = scipy.interpolate.PchipInterpolator(
            np.log(nodes), factors[[0, *range(len(factors)), -1]]
        )
        within = np.clip(velocity, nodes[0], nodes[-1])
        factor: Array = curve(np.log(within))
        return factor

    def added_rise(self, columns: Mapping[str, Any]) -> Array:
        """Additional rise of the contact at friction 1 by film, stem and earlier passes [K].

        The columns are those of `NEEDED`, the steps last, in their order in time. NaN where the
        temperature was not asked for.
        """
        rise, load, time = (columns[name] for name in ("mean_rise", "normal_load", "time"))
        heats = np.isfinite(rise) & (rise > 0)
        if not (self.track or self.stem or self.film_resistance) or not heats.any():
            return np.zeros_like(rise)
        theta, F, t = rise[heats], load[heats], time[heats]
        share, V = columns["pin_heat_share"][heats], columns["sliding_distance"][heats] / t
        area = F / columns["mean_pressure"][heats]
        warming = (1 - share) * _warming(self.track, columns, heats) if self.track else 0.0
        added: Array = rise * 0.0
        added[heats] = (
            circuit_rise(
                theta,
                share,
                F * V,
                self.stem.resistance_after(t) if self.stem else 0.0,
                self.film_resistance / area,
                warming,
            )
            - theta
        )
        return added

    def applied(self, columns: Mapping[str, Any]) -> dict[str, Any]:
        """Columns whose rises at friction 1 have the corrections, at all bulk ratios [K].

        Needed are those of `NEEDED`, and the rises by step as far as they are asked for.
        """
        added, slid = self.added_rise(columns), columns["sliding_distance"]
        factor = self.friction_factor(slid / np.where(slid > 0, columns["time"], 1.0))
        rises = {
            name: (columns[name] + added[after]) * factor[after]
            for name, after in _RISES.items()
            if name in columns
        }
        return {**columns, **rises}


_RISES: dict[str, Any] = {
    "max_rise": ...,
    "mean_rise": ...,
    "rise_quantile": (..., None),
    "bulk_rise_quantile": (..., None, None),
}
"""Columns of rises, and the axes that follow that of the steps."""


def moment_of(scene: Scene, state: State, corrections: Corrections | None) -> Mapping[str, Any]:
    """Rises of a state as columns of one moment, with corrections.

    The state has to have a temperature. Before, the load is taken to have grown evenly.
    """
    if state.heat is None:
        raise InputError("a point ended without a temperature")
    columns = columns_of(state.heat)
    if corrections is None:
        return columns
    record = {**measures(scene, state), **columns}
    steps = corrections.applied({name: np.array([value]) for name, value in record.items()})
    return {name: value[0] for name, value in steps.items()}


def _warming(track: Track, columns: Mapping[str, Any], heats: Mask) -> Array:
    """Warming of the track at some steps, for each unit of heat that enters the disk [K]."""
    terms = []
    for place in map(tuple, np.argwhere(heats).tolist()):
        before, now = place[:-1], place[-1]
        time, load = (columns[name][before][: now + 1] for name in ("time", "normal_load"))
        velocity = columns["sliding_distance"][place] / time[now]
        terms.append(
            track_warming(
                time[now],
                track.length / velocity,
                (time, load),
                track.width or track.aspect * columns["contact_width"][place],
                track.thermal_diffusivity,
                track.heat_capacity,
            )
        )
    return np.array(terms)
