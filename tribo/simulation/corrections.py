"""Effects that the two half-spaces lack, applied to the results of a simulation.

Warming of the tracks by earlier revolutions is a thermal resistance in series with the half-spaces
(`tribo.thermal.circuit_rise`). It follows from the recorded values, without a new simulation.

Earlier turns make a track warmer by w·s. Here w is its warming if all heat went into its body, and
s is the body's share of the heat. That share is taken as constant in time, so that the track is a
thermal resistance: w divided by the heat flow of the contact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np

from tribo.errors import InputError, require_instance, require_positive
from tribo.loading import MeasuredLoad, Ramp, Stages
from tribo.material import Material
from tribo.simulation.motion import Motion
from tribo.simulation.pins import Pin
from tribo.simulation.scene import Scene
from tribo.simulation.state import State, measures
from tribo.thermal import Disc, circuit_rise, track_warming
from tribo.types import Array

NEEDED = (
    "time", "normal_load", "sliding_distance", "contact_width", "pin_heat_share", "mean_rise",
)  # fmt: skip
"""Names of the variables of a step that corrections need."""


@dataclass(frozen=True, slots=True)
class Track:
    """The ring of a body that passes through the contact again and again.

    Attributes
    ----------
    length : float
        Length of the track [m].
    width : float or None
        Width of the track [m]; None for `aspect` times the contact's extent along the track.
    aspect : float
        Extent of the contact across the track divided by that along it, for a ball or a crowned
        pin.
    thermal_diffusivity, heat_capacity : float
        κ [m²/s] and ρc [J/(m³ K)] of the body.
    disc : Disc or None
        Disc whose rim is the track. The disc keeps all heat. None for a half-space, in which heat
        spreads without end.

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
    disc: Disc | None = None

    @classmethod
    def from_pin(cls, pin: Pin, body: Material, around: float | Disc) -> Self:
        """The track of a pin on a body; `around` is its length [m], or the disc whose rim it is.

        Examples
        --------
        >>> from tribo import Crowned
        >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
        >>> Track.from_pin(Crowned(10e-3, 50e-3, steel), steel, 0.34).aspect
        2.8...
        """
        aspect = pin.hertz(1.0, 1e11).aspect if pin.length is None else 1.0
        capacity = body.density * body.specific_heat
        disc = around if isinstance(around, Disc) else None
        length = math.pi * around.diameter if isinstance(around, Disc) else around
        return cls(length, pin.length, aspect, body.thermal_diffusivity, capacity, disc)

    def __post_init__(self) -> None:
        sizes = asdict(self)
        del sizes["disc"]
        if self.width is None:
            del sizes["width"]
        require_positive(**sizes)

    def __str__(self) -> str:
        return str(self.disc or f"{self.length:.3g} m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Corrections:
    """Physical effects that two half-spaces lack; those not given are omitted.

    Attributes
    ----------
    track, pin_track : Track or None
        Tracks of disk and pin, which earlier revolutions have warmed. The track of a body at rest
        stays cold.
    motion : Motion or None
        Motion of both bodies; None where the pin is at rest.
    course : tuple of tuple of float
        A recorded load over time: pairs of time [s] and load divided by the last load. Empty for a
        ramp.
    rate : float or None
        Rate at which a ramp reaches its load [N/s]; the load is then held. If `rate` is None and
        `course` is empty, the load is taken as linear between the simulated steps.

    Examples
    --------
    >>> ring = Track(0.34, 3.4e-3, 1.0, thermal_diffusivity=1.2275e-5, heat_capacity=3.666e6)
    >>> Corrections(track=ring).text
    'earlier revolutions of the disk, 0.34 m'
    """

    track: Track | None = None
    pin_track: Track | None = None
    motion: Motion | None = None
    course: tuple[tuple[float, float], ...] = ()
    rate: float | None = None

    def __post_init__(self) -> None:
        kinds = {"track": Track, "pin_track": Track, "motion": Motion}
        for name, kind in kinds.items():
            if getattr(self, name) is not None:
                require_instance(kind, **{name: getattr(self, name)})

    def with_loading(self, loading: Ramp | Stages | MeasuredLoad) -> Self:
        """Return these corrections with the load course or the load rate of `loading` filled in."""
        if isinstance(loading, Ramp):
            return replace(self, course=(), rate=loading.rate)
        return replace(self, course=loading.course, rate=None)

    @property
    def keeps_heat(self) -> bool:
        """True if a body gets warmer the longer its load is held."""
        return bool(self.track or self.pin_track)

    @property
    def text(self) -> str:
        """The corrections that are set, in words, with their sizes."""
        sizes = {
            f"{'disc of' if track and track.disc else 'earlier revolutions of'} the {body}": track
            for body, track in (("pin", self.pin_track), ("disk", self.track))
        }
        return "; ".join(f"{name}, {size}" for name, size in sizes.items() if size)

    def added_rise(self, columns: Mapping[str, Any]) -> Array:
        """Contact temperature [K] to add to that of two half-spaces, per unit friction coefficient.

        It is due to tracks that earlier revolutions have warmed.

        `columns` has the variables `NEEDED` by name, with the steps on the last axis in order of
        time. The result has their shape. At a step whose ``mean_rise`` is 0 or NaN, it is 0 or NaN.
        """
        rise, load, time = (columns[name] for name in ("mean_rise", "normal_load", "time"))
        has_heat = np.isfinite(rise) & (rise > 0)
        if not self.keeps_heat or not has_heat.any():
            return np.zeros_like(rise)
        theta, F, t = rise[has_heat], load[has_heat], time[has_heat]
        share, V = columns["pin_heat_share"][has_heat], columns["sliding_distance"][has_heat] / t
        course = np.array(self.course).T
        histories = [
            _History.from_columns(columns, index, course, self.rate)
            for index in np.argwhere(has_heat).tolist()
        ]
        speeds = np.array([self._speeds(velocity) for velocity in V.tolist()])
        resistances = (
            _turn_resistance(self.pin_track, histories, speeds[:, 0]),
            _turn_resistance(self.track, histories, speeds[:, 1]),
        )
        added: Array = rise * 0.0
        added[has_heat] = circuit_rise(theta, share, F * V, *resistances) - theta
        return added

    def _speeds(self, sliding: float) -> tuple[float, float]:
        """Speeds of the surfaces of pin and disk past the contact, for a sliding velocity [m/s]."""
        pin, disk = self.motion.velocities(sliding) if self.motion else (0.0, sliding)
        return abs(pin), abs(disk)

    def apply(self, columns: Mapping[str, Any]) -> dict[str, Any]:
        """Return `columns` with corrected rises per unit friction coefficient [K].

        Each rise becomes rise + `added_rise`. `columns` has variables by name: those of `NEEDED`,
        and the rises ``max_rise`` and ``rise_quantile``. All columns but the rises are returned
        unchanged.
        """
        added = self.added_rise(columns)
        rises = {
            name: columns[name] + added[index] for name, index in _RISES.items() if name in columns
        }
        return {**columns, **rises}


_RISES: dict[str, Any] = {
    "max_rise": ...,
    "mean_rise": ...,
    "rise_quantile": (..., None),
}
"""Columns of rises, and the index that broadcasts steps along their further axes."""


def state_rises(scene: Scene, state: State, corrections: Corrections | None) -> Mapping[str, Any]:
    """Temperature rises of a state per unit friction coefficient [K], by name of their variable.

    If `corrections` are given, the rises are corrected, and the result also has the values that
    `measures` returns, such as time and load. Corrections for heat stored in a body depend on
    the loads before the state; these follow from the scene's loading. The state must have a
    temperature.
    """
    if state.heat is None:
        raise InputError("a point ended without a temperature")
    columns = state.heat.columns
    if corrections is None:
        return columns
    step_columns = {
        name: np.array([value]) for name, value in (measures(scene, state) | dict(columns)).items()
    }
    return {
        name: value[0]
        for name, value in corrections.with_loading(scene.loading).apply(step_columns).items()
    }


class _History(NamedTuple):
    """Times and loads of a simulated point up to one of its steps, and its contact width."""

    times: Array  # s, ascending
    loads: Array  # N
    contact_width: float  # m

    @classmethod
    def from_columns(
        cls, columns: Mapping[str, Any], index: Sequence[int], course: Array, rate: float | None
    ) -> Self:
        """Find the history of the load until one step, from the recorded columns of a sweep.

        `columns` has the variables `NEEDED` by name; their last axis is the step. `index` is the
        index of the step along all axes. If a `rate` [N/s] is given, the load grew at this rate and
        was then held. Otherwise the load followed `course`, shape (2, n) with times [s] and loads
        as shares of the last load. If `course` is empty, the load was linear between the recorded
        steps.
        """
        *point, step = index
        times, loads = (columns[name][*point] for name in ("time", "normal_load"))
        width = float(columns["contact_width"][*point][step])
        if rate:
            ramp_time = min(loads[step] / rate, times[step])
            return cls(np.array([ramp_time, times[step]]), np.full(2, loads[step]), width)
        if not course.size:
            is_recorded = np.isfinite(times[: step + 1])
            return cls(times[: step + 1][is_recorded], loads[: step + 1][is_recorded], width)
        course_times, shares = course
        peak = loads[-1] / np.interp(times[-1], course_times, shares)
        is_earlier = course_times < times[step]
        return cls(
            np.append(course_times[is_earlier], times[step]),
            np.append(peak * shares[is_earlier], loads[step]),
            width,
        )


def _turn_resistance(
    track: Track | None, histories: Sequence[_History], speeds: Array
) -> Array | float:
    """Warming of a track by earlier revolutions, divided by the contact's heat flow [K/W]."""
    if track is None:
        return 0.0
    return np.array(
        [
            _turn_warming(track, history, speed) / (history.loads[-1] * speed) if speed else 0.0
            for history, speed in zip(histories, speeds.tolist(), strict=True)
        ]
    )


def _turn_warming(track: Track, history: _History, speed: float) -> float:
    """Warming of a track by earlier revolutions [K], if its body gets all heat at unit friction."""
    width = track.width or track.aspect * history.contact_width
    return track_warming(
        history.times[-1],
        track.length / speed,
        (history.times, history.loads),
        width,
        track.thermal_diffusivity,
        track.heat_capacity,
        track.disc,
    )
