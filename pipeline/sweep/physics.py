"""Physics beside the two half-spaces: what a scene counts, what it could, what cannot be sized.

Each effect that can be sized is a scene with it, or without it where the scene counts it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from statistics import median_high
from typing import Any, Literal

import numpy as np

from pipeline.quantities import display
from pipeline.sweep.model import Sweep
from tribo import Bulk, Corrections, Material, Motion, Scene, Stem, Track, contact_modulus
from tribo.types import Array

_TRACK = 0.34  # m, of the paper's disk
_THICKNESS = 10e-3  # m, of a disk or a disc
_FALL = 0.1  # fall of friction from the lowest to the highest velocity, as the paper measured
_FILM = 10e-9, 2.0  # m and W/(m K), of an oxide
# Conductivity and specific heat of a carbon steel about 60 K above room temperature.
_CONDUCTIVITY, _SPECIFIC_HEAT = 42 / 45, 520 / 470
_OF_CARBON_STEEL = {
    "elastic_modulus": (190e9, 220e9),
    "density": (7600.0, 8000.0),
    "thermal_conductivity": (30.0, 60.0),
}
_HOT = 1e9  # K: a rise beside which the warming of earlier turns changes no share


@dataclass(frozen=True, slots=True)
class Effect:
    """One effect beside the two half-spaces."""

    name: str
    state: Literal["counted", "could be counted", "cannot be sized"]
    size: str  # what is assumed, or what the scene says
    certainty: str  # reason to believe the result, or not to
    entry: str = ""  # by which a scene counts it
    scene: Sweep | None = None  # with the effect, or without it if the scene counts it

    @property
    def key(self) -> tuple[str, str]:
        """Name and size of the change that it makes."""
        return f"{'without ' if self.state == 'counted' else ''}{self.name}", self.size


@dataclass(frozen=True, slots=True)
class _Sized:
    """An effect that a scene could include: its size and certainty, its entries, and parts."""

    size: str
    certainty: str
    entries: tuple[str, ...]
    parts: dict[str, Any]  # arguments of `Corrections`


_Find = Callable[[Sweep, Corrections], _Sized | str | None]


def physics_of(sweep: Sweep) -> tuple[Effect, ...]:
    """All effects beside the half-spaces, of any scene.

    But for warm materials, which are simulated, they act afterwards, by `tribo.Corrections`.
    """
    present = sweep.conditions.corrections or Corrections()
    effects, parts, more = [*_counted(sweep, present)], dict[str, Any](), 0
    for name, (entries, _, find) in _EFFECTS.items():
        found = find(sweep, present)
        if isinstance(found, _Sized):
            entry, scene = " and ".join(found.entries), _changed(sweep, present, found.parts)
            said = found.size, found.certainty
            effects.append(Effect(name, "could be counted", *said, entry, scene))
            parts, more = parts | found.parts, more + 1
        elif found:
            effects.append(Effect(name, "cannot be sized", found, "", " and ".join(entries)))
    if more > 1:
        together = "all that could be counted, at once", "no surer than the least sure of them"
        scene = _changed(sweep, present, parts)
        effects.append(Effect("together", "could be counted", *together, scene=scene))
    return (
        *effects,
        _warm_steel(sweep),
        Effect(
            "plastic memory of the track",
            "cannot be sized",
            "summits that were pressed flat stay flat at the next turn: +4 % of the critical "
            "velocity at 750 N and +17 % at 200 N in the paper's system, by a trial of 6 turns",
            "on the safe side; the mean pressure on the summits falls by a quarter, and so does "
            "the effect of a film; no measurement can check it",
        ),
        Effect(
            "kinetics of desorption",
            "cannot be sized",
            "a film that fails in time and not at a temperature",
            "needs an activation energy, which is not known; above about 200 kJ/mol a critical "
            "temperature does as well",
        ),
    )


def _changed(sweep: Sweep, present: Corrections, parts: dict[str, Any]) -> Sweep:
    friction = replace(present.friction, **parts.get("friction", {}))
    corrections = replace(present, **parts | {"friction": friction})
    return replace(sweep, conditions=replace(sweep.conditions, corrections=corrections))


def _counted(sweep: Sweep, present: Corrections) -> Iterator[Effect]:
    """Effects that the scene counts, each with the scene without it."""
    if sweep.conditions.corrections is None:
        return
    said = dict(part.split(", ", 1) for part in present.worded.split("; "))
    for name, (entries, without, _) in _EFFECTS.items():
        if counted := {entry: words for entry, words in entries.items() if words in said}:
            size = ", ".join(f"{words}: {said[words]}" for words in counted.values())
            certainty, entry = "as the scene's own numbers", " and ".join(counted)
            yield Effect(name, "counted", size, certainty, entry, _changed(sweep, present, without))


def _usual_friction(sweep: Sweep, present: Corrections) -> _Sized | str | None:
    """Friction by velocity, as measured at transitions or as is usual."""
    conditions = sweep.conditions
    sliding = [velocity for velocity in sweep.plane.velocities if velocity]
    if present.friction.by_velocity:
        return None
    if conditions.bulk_difference:
        return "the bulk temperatures differ, so that the rise is not proportional to friction"
    if not conditions.friction:
        return "there is no friction"
    if len(sliding) < 2:
        return "the scene has one sliding velocity"
    rows = sweep.about.measured
    measured = sorted({r.velocity: r.friction for r in rows if r.friction is not None}.items())
    if len(measured) > 1:
        factors = [(velocity, friction / conditions.friction) for velocity, friction in measured]
        frictions = [friction for _, friction in measured]
        ends = dict.fromkeys((min(frictions), max(frictions)))
        size = f"{' to '.join(f'{end:g}' for end in ends)}, as measured at the transitions"
        certainty = "as measured; load and velocity changed together in these tests"
    else:
        slow, *_, fast = sliding
        factors = [(slow, 1 + _FALL / 2), (fast, 1 - _FALL / 2)]
        size = f"falling by {_FALL:.0%} from {slow:g} to {fast:g} m/s"
        certainty = "assumed: measure friction at two velocities or more"
    return _Sized(
        size, certainty, ("friction.by_velocity",), {"friction": {"by_velocity": tuple(factors)}}
    )


def _warm_friction(sweep: Sweep, present: Corrections) -> str | None:
    """Friction by temperature; there is no usual value."""
    if present.friction.by_temperature:
        return None
    return "friction at two temperatures of the contact or more would have to be measured"


def _usual_turns(sweep: Sweep, present: Corrections) -> _Sized | str | None:
    """Missing tracks of the bodies that turn: of both if both roll, else of the moving one."""
    scene = sweep.scene
    if not any(sweep.plane.velocities):
        return "nothing moves"
    if cold := cold_bodies(scene.motion, present):
        turns, around = turn_parts(scene, cold)
        return _Sized(
            f"tracks of {around:.3g} m around the {' and the '.join(cold)}",
            "to a tenth, if the tracks are that long: the effect goes as 1/length",
            tuple(f"{body}.track_length" for body in cold),
            turns,
        )
    if present.track or present.pin_track:
        return None
    turns_pin = _pin_turns(sweep)
    body, name = (scene.pin.material, "pin_track") if turns_pin else (scene.disk, "track")
    return _Sized(
        f"a track of {_TRACK:g} m",
        "to a fifth, if the track is that long: the effect goes as 1/√length",
        (f"{'pin' if turns_pin else 'disk'}.track_length",),
        {name: Track.under(scene.pin, body, _TRACK), "motion": scene.motion},
    )


def _pin_turns(sweep: Sweep) -> bool:
    return any(sweep.scene.velocities_at(v).pin for v in sweep.plane.velocities)


def _usual_bulk(sweep: Sweep, present: Corrections) -> _Sized | str | None:
    """Heat capacities of disk and rolling pin, as discs of a usual size, without a loss."""
    scene = sweep.scene
    bodies: dict[str, tuple[float, Material]] = {}
    if any(track and track.disc for track in (present.track, present.pin_track)):
        return "a disc warms as a whole, by the heat of its earlier turns"
    if not present.disk_bulk:
        around = present.track.length if present.track else _TRACK
        bodies["disk"] = around / math.pi, scene.disk
    if not present.pin_bulk and _pin_turns(sweep):
        bodies["pin"] = scene.track_length / math.pi, scene.pin.material
    if not bodies:
        return None
    bulks = {
        f"{body}_bulk": Bulk(
            math.pi / 4 * across**2 * _THICKNESS * material.density * material.specific_heat
        )
        for body, (across, material) in bodies.items()
    }
    sizes = (f"{display(d, 'mm', '.0f')} around the {body}" for body, (d, _) in bodies.items())
    return _Sized(
        f"discs {display(_THICKNESS, 'mm')} thick, {' and '.join(sizes)}, without a loss",
        "as their size: in proportion to the energy of the test over the capacity, less by a loss",
        tuple(f"{body}.capacity" for body in bodies),
        bulks,
    )


def _usual_stem(sweep: Sweep, present: Corrections) -> _Sized | str | None:
    """A rod behind a pin at rest, as long as the pin is wide; a pin that turns has none."""
    pin = sweep.scene.pin
    if present.stem:
        return None
    if _pin_turns(sweep):
        return "the pin turns, so that heat enters all around it"
    length = 2 * pin.radius
    area = math.pi * pin.radius**2 if pin.length is None else 2 * pin.radius * pin.length
    rod = length, area, pin.material.thermal_conductivity, pin.material.thermal_diffusivity
    return _Sized(
        f"a rod {display(length, 'mm', 3)} long, {display(area, 'mm²', 3)} across",
        "to a factor of 2: the holder is not known, and the half-space has part of it already",
        ("pin.stem",),
        {"stem": Stem.rod(*rod)},
    )


def _usual_film(sweep: Sweep, present: Corrections) -> _Sized | None:
    """A thin oxide on the disk."""
    thickness, conductivity = _FILM
    if present.film_resistance:
        return None
    return _Sized(
        f"{display(thickness, 'nm')} of {conductivity:g} W/(m K) on the disk",
        "an order of magnitude: thickness and conductivity are not known; in proportion to "
        "their ratio, and to the pressure on the asperities",
        ("disk.film",),
        {"film_resistance": thickness / conductivity},
    )


_EFFECTS: dict[str, tuple[dict[str, str], dict[str, Any], _Find]] = {
    "friction by velocity": (
        {"friction.by_velocity": "friction by velocity"}, {"friction": {"by_velocity": ()}},
        _usual_friction,
    ),
    "friction by temperature": (
        {"friction.by_temperature": "friction by temperature"},
        {"friction": {"by_temperature": ()}}, _warm_friction,
    ),
    "earlier turns": (
        {
            "pin.track_length": "earlier turns of the pin",
            "disk.track_length": "earlier turns of the disk",
            "pin.diameter": "disc of the pin",
            "disk.diameter": "disc of the disk",
        },
        {"track": None, "pin_track": None}, _usual_turns,
    ),
    "warming bulk": (
        {"pin.capacity": "bulk of the pin", "disk.capacity": "bulk of the disk"},
        {"pin_bulk": None, "disk_bulk": None}, _usual_bulk,
    ),
    "stem and holder of the pin": ({"pin.stem": "stem of the pin"}, {"stem": None}, _usual_stem),
    "oxide or tribofilm": (
        {"disk.film": "film on the disk"}, {"film_resistance": 0.0}, _usual_film
    ),
}  # fmt: skip
"""Effects by corrections: entries as `Corrections.worded` calls them, and what none of it is.

Last what finds the size of each, the reason why it has none, or None if the scene includes it.
"""


def _warm_steel(sweep: Sweep) -> Effect:
    name = "conductivity and specific heat when warm"
    bodies = {"pin": sweep.scene.pin.material, "disk": sweep.scene.disk}
    warm = {
        body: replace(
            material,
            thermal_conductivity=_CONDUCTIVITY * material.thermal_conductivity,
            specific_heat=_SPECIFIC_HEAT * material.specific_heat,
        )
        for body, material in bodies.items()
        if all(low <= getattr(material, k) <= high for k, (low, high) in _OF_CARBON_STEEL.items())
    }
    if not warm:
        reason = "neither body has the constants of a carbon steel, whose change is known"
        return Effect(name, "cannot be sized", reason, "")
    alone = f", of the {next(iter(warm))} alone" if len(warm) == 1 else ""
    both = bodies | warm
    return Effect(
        name,
        "could be counted",
        f"{_CONDUCTIVITY - 1:+.0%} and {_SPECIFIC_HEAT - 1:+.0%}, a carbon steel at 85 °C{alone}",
        "to a few percent: two effects of opposite sign",
        scene=sweep.changed(pin=replace(sweep.scene.pin, material=both["pin"]), disk=both["disk"]),
    )


def cold_bodies(motion: Motion | None, corrections: Corrections | None) -> tuple[str, ...]:
    """Bodies that roll as if each turn met a cold track; none unless both bodies roll."""
    if motion is None or motion.slide_roll_ratio in (-2.0, 2.0):
        return ()
    present = corrections or Corrections()
    tracks = {"pin": present.pin_track, "disk": present.track}
    return tuple(body for body, track in tracks.items() if track is None)


def turn_parts(scene: Scene, cold: Iterable[str]) -> tuple[dict[str, Any], float]:
    """Arguments of `Corrections` for earlier turns of cold bodies, and their tracks' length [m]."""
    pin, motion = scene.pin, scene.motion
    around = (motion and motion.track_length) or 2 * math.pi * pin.radius
    bodies = {"pin": ("pin_track", pin.material), "disk": ("track", scene.disk)}
    pairs = (bodies[body] for body in cold)
    tracks = {name: Track.under(pin, material, around) for name, material in pairs}
    return {"motion": motion, **tracks}, around


def note_on_turns(
    sweep: Sweep, load: float | None = None, velocity: float | None = None
) -> str | None:
    """Say that earlier turns of bodies that roll are not counted; None where all are.

    By how much they warm the contact at a load and velocity, by default in the middle of the sweep,
    follows in closed form: bodies share the heat as their effusivities times the roots of their
    speeds.
    """
    scene, conditions, plane = sweep.scene, sweep.conditions, sweep.plane
    load = median_high(plane.loads) if load is None else load
    velocity = median_high(plane.velocities) if velocity is None else velocity
    cold = cold_bodies(scene.motion, conditions.corrections)
    if not cold or not velocity:
        return None
    turns, around = turn_parts(scene, cold)
    columns = columns_in_closed_form(sweep, load, velocity, _HOT)
    rise = float(Corrections(**turns).added_rise(columns)[-1])
    warming = conditions.friction_at(velocity) * rise
    return describe_cold_bodies(
        cold,
        around,
        f"warm the contact by about {warming:.2g} K more at {load:g} N and {velocity:g} m/s",
    )


def note_on_ends(sweep: Sweep) -> str | None:
    """Say how much hotter the ends of a pin are where they are sharp; None of other pins."""
    if sweep.scene.pin.length is None or _pin_turns(sweep):
        return None
    return (
        "the pin is computed in its middle: if its ends are sharp, the rise within 0.1 mm of them "
        "is 4 to 11 % higher where wear has doubled the contact's width (a smooth cylinder of 2 mm "
        "at 750 to 200 N), and severe wear begins there at velocities 9 to 23 % lower; it is up to "
        "64 % higher where the pin has hardly worn, and not higher once the width has tripled"
    )


def columns_in_closed_form(
    sweep: Sweep, load: float, velocity: float, rise: float
) -> dict[str, Array]:
    """Columns that corrections need, of a smooth contact with a rise at its end [K]."""
    scene, pin = sweep.scene, sweep.scene.pin
    stations = list(scene.loading.stations(load, scene.fidelity.increments))
    times = np.array([station.time for station in stations])
    part_of_pin, part_of_disk = (
        body.thermal_effusivity * math.sqrt(abs(speed))
        for body, speed in zip(
            (pin.material, scene.disk), scene.velocities_at(velocity), strict=True
        )
    )
    hertz = pin.hertz(load, contact_modulus(pin.material, scene.disk))
    return {
        "time": times,
        "normal_load": np.array([station.normal_load for station in stations]),
        "sliding_distance": velocity * times,
        "mean_pressure": np.full_like(times, hertz.peak_pressure),
        "contact_width": np.full_like(times, 2 * hertz.half_width),
        "pin_heat_share": np.full_like(times, part_of_pin / (part_of_pin + part_of_disk)),
        "mean_rise": np.append(np.full(len(times) - 1, np.nan), rise),
    }


def describe_cold_bodies(bodies: tuple[str, ...], around: float, by_how_much: str) -> str:
    """Say that earlier turns of some bodies are not counted, and how much they would matter."""
    entries = " and ".join(f"{body}.diameter" for body in bodies)
    return (
        f"earlier turns of the {' and the '.join(bodies)} are not counted, as if each met a cold "
        f"track: on tracks of {display(around, 'mm', 3)} they would {by_how_much}; give {entries} "
        "and width, or track_length"
    )
