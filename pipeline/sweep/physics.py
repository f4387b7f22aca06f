"""Physics beside the two half-spaces: what a scene counts, what it could, what cannot be sized.

Each effect that can be sized is a scene with it, or without it where the scene counts it, so that
the boundary shows how much it matters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from pipeline.sweep.model import Sweep
from pipeline.sweep.warned import cold_bodies, with_turns
from tribo import Bulk, Corrections, Material, Stem, Track

_TRACK = 0.34  # m, of the paper's disk
_THICKNESS = 10e-3  # m, of a disk or a disc
_FALL = 0.1  # of friction, from the lowest to the highest velocity, as in the paper's measurements
_FILM = 10e-9, 2.0  # m and W/(m K), of an oxide
# Conductivity and specific heat of a carbon steel about 60 K above room temperature.
_CONDUCTIVITY, _SPECIFIC_HEAT = 42 / 45, 520 / 470
_OF_CARBON_STEEL = {
    "elastic_modulus": (190e9, 220e9),
    "density": (7600.0, 8000.0),
    "thermal_conductivity": (30.0, 60.0),
}

State = Literal["counted", "could be counted", "cannot be sized"]


@dataclass(frozen=True, slots=True)
class Effect:
    """One effect beside the two half-spaces.

    Attributes
    ----------
    name : str
        Its name.
    state : {"counted", "could be counted", "cannot be sized"}
        Whether the scene counts it.
    size : str
        What is assumed of it, or what the scene says, in words.
    certainty : str
        Reason to believe the result, or not to.
    entry : str
        Entry by which a scene counts it; empty if there is none.
    scene : Sweep or None
        The scene with the effect, or without it if the scene counts it; None if it has no size.
    """

    name: str
    state: State
    size: str
    certainty: str
    entry: str = ""
    scene: Sweep | None = None

    @property
    def key(self) -> tuple[str, str]:
        """Name and size of the change that it makes."""
        return f"{'without ' if self.state == 'counted' else ''}{self.name}", self.size


def physics_of(sweep: Sweep) -> tuple[Effect, ...]:
    """All effects beside the half-spaces, of any scene.

    All but the materials' dependence on temperature act after the simulation, by
    `tribo.Corrections`; materials that change with it are simulated with the constants that they
    have 60 K above room temperature, as is usual of a carbon steel.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> [effect.entry for effect in physics_of(scene) if effect.state == "could be counted"]
    ['friction.by_velocity', 'disk.track_length', 'disk.capacity', 'pin.stem', 'disk.film', '', '']
    """
    effects = [*_counted(sweep), *_of_friction(sweep), *_of_turns(sweep), *_of_bulk(sweep)]
    effects += [*_of_stem(sweep), *_of_film(sweep)]
    more = [effect for effect in effects if effect.scene and effect.state == "could be counted"]
    if len(more) > 1:
        effects.append(_together(sweep, more))
    return (*effects, _warm_steel(sweep), *_NOT_SIZED)


_NOT_SIZED = (
    Effect(
        "plastic memory of the track",
        "cannot be sized",
        "summits that were pressed flat stay flat at the next turn: +4 % of the critical velocity "
        "at 750 N and +17 % at 200 N in the paper's system, by a trial of 6 turns",
        "on the safe side; the mean pressure on the summits falls by a quarter, and so does the "
        "effect of a film; no measurement can check it",
    ),
    Effect(
        "kinetics of desorption",
        "cannot be sized",
        "a film that fails in time and not at a temperature",
        "needs an activation energy, which is not known; above about 200 kJ/mol a critical "
        "temperature does as well",
    ),
)


def _together(sweep: Sweep, effects: list[Effect]) -> Effect:
    together = sweep.conditions.corrections or Corrections()
    for effect in effects:
        part = (effect.scene and effect.scene.conditions.corrections) or Corrections()
        present = {entry.name: getattr(part, entry.name) for entry in fields(part)}
        together = replace(together, **{name: value for name, value in present.items() if value})
    return Effect(
        "together",
        "could be counted",
        "all above that could be counted, at once",
        "as the least sure of them",
        scene=_with(sweep, together),
    )


def _counted(sweep: Sweep) -> Iterator[Effect]:
    """Effects that the scene counts, each with the scene without it."""
    present = sweep.conditions.corrections
    if present is None:
        return
    said = dict(part.split(", ", 1) for part in present.worded.split("; "))
    for entries, without in (
        ({"friction by velocity": "friction.by_velocity"}, {"friction": ()}),
        (
            {
                "earlier turns of the pin": "pin.track_length",
                "earlier turns of the disk": "disk.track_length",
            },
            {"track": None, "pin_track": None},
        ),
        (
            {"bulk of the pin": "pin.capacity", "bulk of the disk": "disk.capacity"},
            {"pin_bulk": None, "disk_bulk": None},
        ),
        ({"stem of the pin": "pin.stem"}, {"stem": None}),
        ({"film on the disk": "disk.film"}, {"film_resistance": 0.0}),
    ):
        if counted := [name for name in entries if name in said]:
            plain: Any = without
            yield Effect(
                _NAMES[entries[counted[0]]],  # both bodies' have one name
                "counted",
                ", ".join(f"{name}: {said[name]}" for name in counted),
                "as the scene's own numbers",
                " and ".join(entries[name] for name in counted),
                _with(sweep, replace(present, **plain)),
            )


_NAMES = {
    "friction.by_velocity": "friction by velocity",
    "disk.track_length": "earlier turns",
    "pin.track_length": "earlier turns",
    "disk.capacity": "bulk that follows",
    "pin.capacity": "bulk that follows",
    "pin.stem": "stem and holder of the pin",
    "disk.film": "oxide or tribofilm",
}


def _could_be(sweep: Sweep, entry: str, size: str, certainty: str, **parts: Any) -> Effect:
    corrections = replace(sweep.conditions.corrections or Corrections(), **parts)
    scene = _with(sweep, corrections)
    return Effect(_NAMES[entry.split()[0]], "could be counted", size, certainty, entry, scene)


def _no_size(entry: str, reason: str) -> Effect:
    return Effect(_NAMES[entry], "cannot be sized", reason, "", entry)


def _sliding(sweep: Sweep) -> list[float]:
    """Sliding velocities of a sweep above 0, ascending [m/s]."""
    return [velocity for velocity in sweep.plane.velocities if velocity]


def _of_friction(sweep: Sweep) -> Iterator[Effect]:
    conditions, entry = sweep.conditions, "friction.by_velocity"
    if conditions.corrections and conditions.corrections.friction:
        return
    reason = None
    if conditions.bulk_difference:
        reason = "the bulk temperatures differ, so that the rise is not proportional to friction"
    elif not conditions.friction:
        reason = "there is no friction"
    elif len(_sliding(sweep)) < 2:
        reason = "the scene has one sliding velocity"
    if reason:
        yield _no_size(entry, reason)
        return
    factors, size, certainty = _friction(sweep)
    yield _could_be(sweep, entry, size, certainty, friction=factors)


def _of_turns(sweep: Sweep) -> Iterator[Effect]:
    """Tracks of all bodies that turn and have none; of two that roll, or of the one that moves."""
    present, scene, entry = sweep.conditions.corrections, sweep.scene, "disk.track_length"
    if not _sliding(sweep):
        yield _no_size(entry, "nothing moves")
    elif cold := cold_bodies(scene.motion, present):
        turns, around = with_turns(present, scene.pin, scene.disk, scene.motion)
        yield _could_be(
            sweep,
            " and ".join(f"{body}.track_length" for body in cold),
            f"tracks of {around:.3g} m around the {' and the '.join(cold)}",
            "to a tenth, if the tracks are that long: the effect goes as 1/length",
            track=turns.track,
            pin_track=turns.pin_track,
            motion=turns.motion,
        )
    elif not (present and (present.track or present.pin_track)):
        turns_pin = _pin_turns(sweep)
        body, name = (scene.pin.material, "pin_track") if turns_pin else (scene.disk, "track")
        yield _could_be(
            sweep,
            "pin.track_length" if turns_pin else entry,
            f"a track of {_TRACK:g} m",
            "to a fifth, if the track is that long: the effect goes as 1/√length",
            **{name: Track.under(scene.pin, body, _TRACK)},
            motion=scene.motion,
        )


def _of_bulk(sweep: Sweep) -> Iterator[Effect]:
    """Heat capacities of disk and rolling pin, as discs of a usual size, without a loss."""
    present, scene = sweep.conditions.corrections or Corrections(), sweep.scene
    bodies: list[tuple[str, float, Material]] = []
    if not present.disk_bulk:
        around = present.track.length if present.track else _TRACK
        bodies.append(("disk", around / math.pi, scene.disk))
    if not present.pin_bulk and _pin_turns(sweep):
        bodies.append(("pin", scene.track_length / math.pi, scene.pin.material))
    if not bodies:
        return
    bulks = {
        f"{body}_bulk": Bulk(
            math.pi / 4 * across**2 * _THICKNESS * material.density * material.specific_heat
        )
        for body, across, material in bodies
    }
    sizes = (f"{1e3 * across:.0f} mm around the {body}" for body, across, _ in bodies)
    yield _could_be(
        sweep,
        " and ".join(f"{body}.capacity" for body, _, _ in bodies),
        f"discs {1e3 * _THICKNESS:g} mm thick, {' and '.join(sizes)}, without a loss",
        "as their size: in proportion to the energy of the test over the capacity, less by a loss",
        **bulks,
    )


def _pin_turns(sweep: Sweep) -> bool:
    return any(sweep.scene.velocities_at(v).pin for v in sweep.plane.velocities)


def _of_stem(sweep: Sweep) -> Iterator[Effect]:
    """A rod behind a pin at rest; a pin that turns has none."""
    present, pin = sweep.conditions.corrections, sweep.scene.pin
    if present and present.stem:
        return
    if _pin_turns(sweep):
        yield _no_size("pin.stem", "the pin turns, so that heat enters all around it")
        return
    length, area = _stem_of(sweep)
    rod = length, area, pin.material.thermal_conductivity, pin.material.thermal_diffusivity
    yield _could_be(
        sweep,
        "pin.stem",
        f"a rod {1e3 * length:.3g} mm long, {1e6 * area:.3g} mm² across",
        "to a factor of 2: the holder is not known, and the half-space has part of it already",
        stem=Stem.rod(*rod),
    )


def _of_film(sweep: Sweep) -> Iterator[Effect]:
    present, (thickness, conductivity) = sweep.conditions.corrections, _FILM
    if present and present.film_resistance:
        return
    yield _could_be(
        sweep,
        "disk.film",
        f"{1e9 * thickness:g} nm of {conductivity:g} W/(m K) on the disk",
        "an order of magnitude: thickness and conductivity are not known; in proportion to "
        "their ratio, and to the pressure on the asperities",
        film_resistance=thickness / conductivity,
    )


def _friction(sweep: Sweep) -> tuple[tuple[tuple[float, float], ...], str, str]:
    """Friction by velocity, as measured or as is usual, in words, and how sure."""
    usual = sweep.conditions.friction
    by_velocity = {
        row.velocity: row.friction for row in sweep.about.measured if row.friction is not None
    }
    if len(by_velocity) > 1:
        measured = sorted(by_velocity.items())
        frictions = [friction for _, friction in measured]
        ends = dict.fromkeys((min(frictions), max(frictions)))
        return (
            tuple((velocity, friction / usual) for velocity, friction in measured),
            f"{' to '.join(f'{end:g}' for end in ends)}, as measured at the transitions",
            "as the measured friction, of which load and velocity changed together",
        )
    slow, *_, fast = _sliding(sweep)
    return (
        ((slow, 1 + _FALL / 2), (fast, 1 - _FALL / 2)),
        f"falling by {_FALL:.0%} from {slow:g} to {fast:g} m/s",
        "assumed: measure friction at two velocities or more",
    )


def _stem_of(sweep: Sweep) -> tuple[float, float]:
    """Length [m] and cross section [m²] of a pin that is as long as it is wide."""
    pin = sweep.scene.pin
    across = math.pi * pin.radius**2
    if pin.length is not None:
        across = 2 * pin.radius * pin.length
    return 2 * pin.radius, across


def _warm_steel(sweep: Sweep) -> Effect:
    name, pin, disk = "conductivity and specific heat when warm", sweep.scene.pin, sweep.scene.disk
    bodies = {"pin": pin.material, "disk": disk}
    of_steel = [body for body, material in bodies.items() if _is_carbon_steel(material)]
    if not of_steel:
        reason = "neither body has the constants of a carbon steel, whose change is known"
        return Effect(name, "cannot be sized", reason, "")
    alone = f", of the {of_steel[0]} alone" if len(of_steel) == 1 else ""
    return Effect(
        name,
        "could be counted",
        f"{_CONDUCTIVITY - 1:+.0%} and {_SPECIFIC_HEAT - 1:+.0%}, a carbon steel at 85 °C{alone}",
        "to a few percent: two effects of opposite sign",
        scene=sweep.changed(pin=replace(pin, material=_warm(pin.material)), disk=_warm(disk)),
    )


def _is_carbon_steel(material: Material) -> bool:
    ranges = _OF_CARBON_STEEL.items()
    return all(low <= getattr(material, name) <= high for name, (low, high) in ranges)


def _warm(material: Material) -> Material:
    """A carbon steel when warm; another material as it is."""
    if not _is_carbon_steel(material):
        return material
    return replace(
        material,
        thermal_conductivity=_CONDUCTIVITY * material.thermal_conductivity,
        specific_heat=_SPECIFIC_HEAT * material.specific_heat,
    )


def _with(sweep: Sweep, corrections: Corrections) -> Sweep:
    return replace(sweep, conditions=replace(sweep.conditions, corrections=corrections))
