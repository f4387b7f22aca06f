"""Physics that a scene leaves out, each with a usual size, to see how much it would matter."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

from pipeline.sweep.model import Sweep
from tribo import Corrections, Cylinder, Material, Stem, Track

_TRACK = 0.34  # m, of the paper's disk
_FALL = 0.1  # of friction, from the lowest to the highest velocity, as in the paper's measurements
_FILM = 10e-9, 2.0  # m and W/(m K), of an oxide
# Conductivity and specific heat of a carbon steel about 60 K above room temperature.
_CONDUCTIVITY, _SPECIFIC_HEAT = 42 / 45, 520 / 470


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Physics that a scene leaves out."""

    name: str
    size: str  # that is assumed for it, in words
    certainty: str  # reason to believe the result, or not to
    entry: str  # entry by which a scene includes it; empty if there is none
    scene: Sweep  # with the effect


def physics_left_out(sweep: Sweep) -> tuple[LeftOut, ...]:
    """Physics that a scene leaves out, without what its entries include.

    All but the materials' dependence on temperature act after the simulation, by
    `tribo.Corrections`; materials that change with it are simulated with the constants that they
    have 60 K above room temperature, as is usual of a carbon steel.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> [effect.entry for effect in physics_left_out(scene)]
    ['friction.by_velocity', 'disk.track_length', 'pin.stem', 'disk.film', '', '']
    """
    effects = [*_of_corrections(sweep)]
    together = sweep.conditions.corrections or Corrections()
    for effect in effects:
        part = effect.scene.conditions.corrections or Corrections()
        present = {entry.name: getattr(part, entry.name) for entry in fields(part)}
        together = replace(together, **{name: value for name, value in present.items() if value})
    if len(effects) > 1:
        all_entries = "the effects above that are entries, at once"
        effects.append(
            LeftOut(
                "together", all_entries, "as the least sure of them", "", _with(sweep, together)
            )
        )
    return (*effects, _warm_steel(sweep))


def _of_corrections(sweep: Sweep) -> Iterator[LeftOut]:
    present = sweep.conditions.corrections or Corrections()
    pin, disk = sweep.scene.pin, sweep.scene.disk
    if not present.friction and not sweep.conditions.bulk_difference and sweep.conditions.friction:
        factors, size, certainty = _friction(sweep)
        part = replace(present, friction=factors)
        yield LeftOut(
            "friction by velocity", size, certainty, "friction.by_velocity", _with(sweep, part)
        )
    if not present.track and not sweep.scene.motion:
        track = Track.under(pin, disk, _TRACK)
        yield LeftOut(
            "earlier passes in the track",
            f"a track of {_TRACK:g} m",
            "to a fifth, if the track is that long: the effect goes as 1/√length",
            "disk.track_length",
            _with(sweep, replace(present, track=track)),
        )
    turns = any(sweep.scene.velocities_at(v).pin for v in sweep.plane.velocities)
    if not present.stem and not turns:
        length, area = _stem_of(sweep)
        rod = length, area, pin.material.thermal_conductivity, pin.material.thermal_diffusivity
        yield LeftOut(
            "stem and holder of the pin",
            f"a rod {1e3 * length:.3g} mm long, {1e6 * area:.3g} mm² across",
            "to a factor of 2: the holder is not known, and the half-space has part of it already",
            "pin.stem",
            _with(sweep, replace(present, stem=Stem.rod(*rod))),
        )
    if not present.film_resistance:
        thickness, conductivity = _FILM
        yield LeftOut(
            "oxide or tribofilm",
            f"{1e9 * thickness:g} nm of {conductivity:g} W/(m K) on the disk",
            "an order of magnitude: thickness and conductivity are not known; in proportion to "
            "their ratio, and to the pressure on the asperities",
            "disk.film",
            _with(sweep, replace(present, film_resistance=thickness / conductivity)),
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
        return (
            tuple((velocity, friction / usual) for velocity, friction in measured),
            f"{min(frictions):g} to {max(frictions):g}, as measured at the transitions",
            "as the measured friction, of which load and velocity changed together",
        )
    slow, fast = min(v for v in sweep.plane.velocities if v), max(sweep.plane.velocities)
    return (
        ((slow, 1 + _FALL / 2), (fast, 1 - _FALL / 2)),
        f"falling by {_FALL:.0%} from {slow:g} to {fast:g} m/s",
        "assumed: measure friction at two velocities or more",
    )


def _stem_of(sweep: Sweep) -> tuple[float, float]:
    """Length [m] and cross section [m²] of a pin that is as long as it is wide."""
    pin = sweep.scene.pin
    across = math.pi * pin.radius**2
    if isinstance(pin, Cylinder):
        across = 2 * pin.radius * pin.length
    return 2 * pin.radius, across


def _warm_steel(sweep: Sweep) -> LeftOut:
    pin = replace(sweep.scene.pin, material=_warm(sweep.scene.pin.material))
    return LeftOut(
        "conductivity and specific heat when warm",
        f"{_CONDUCTIVITY - 1:+.0%} and {_SPECIFIC_HEAT - 1:+.0%}, a carbon steel at 85 °C",
        "to a few percent: two effects of opposite sign",
        "",
        sweep.changed(pin=pin, disk=_warm(sweep.scene.disk)),
    )


def _warm(material: Material) -> Material:
    return replace(
        material,
        thermal_conductivity=_CONDUCTIVITY * material.thermal_conductivity,
        specific_heat=_SPECIFIC_HEAT * material.specific_heat,
    )


def _with(sweep: Sweep, corrections: Corrections) -> Sweep:
    return replace(sweep, conditions=replace(sweep.conditions, corrections=corrections))
