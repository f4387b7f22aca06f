"""A scene, the points to simulate it at, and the conditions of severe wear."""

from __future__ import annotations

import functools
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple, Self

from pipeline.sweep.about import About, condition_rows, plane_rows, scene_rows
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.shown import shown
from pipeline.sweep.stations import Stations, Steps
from pipeline.sweep.variants import Part, Variant, Variants
from tribo import InputError, Ramp, Scene, SelfAffineRoughness
from tribo.simulation import inseparable, mechanics, wear_number

_DIGITS = 12  # digits of a wear number: two that ought to be the same differ by rounding


class Lead(NamedTuple):
    """The variant whose ramp of contacts another one shares, and at which velocity."""

    variant: Variant
    ratio: float = 1.0  # its velocity over that of the other, with the same wear number
    places: tuple[float, float] | None = None  # velocities of both, if they have one each [m/s]

    def leading_velocity(self, velocity: float) -> float | None:
        """The lead's velocity with the same contacts [m/s]; None where the variant has no point."""
        if self.places:
            own, leading = self.places
            return leading if velocity == own else None
        return velocity if self.ratio == 1 else drop_last_digits(velocity * self.ratio)


def drop_last_digits(number: float) -> float:
    """A number without the rounding of the last digits."""
    return float(f"{number:.{_DIGITS}g}")


def leads_of(
    scenes: Iterable[tuple[Variant, Scene]],
    places: Sequence[float | None],
    velocities: Sequence[float],
) -> Mapping[Variant, Lead]:
    """For each variant the first one with its contacts, at velocities of a plane or its own."""
    first: dict[tuple[Scene, float | None], tuple[Variant, Scene, float | None]] = {}
    leads = {}
    for (name, scene), place in zip(scenes, places, strict=True):
        number_there = None if place is None else drop_last_digits(wear_number(scene, place))
        key = mechanics(scene), number_there
        leader, leading, its_place = first.setdefault(key, (name, scene, place))
        slides: list[Sequence[float]]
        if place is not None and its_place is not None:
            lead, slides = Lead(leader, places=(place, its_place)), [(place, its_place)]
        else:
            wears = scene.wear and leading.wear and scene.wears and leading.wears
            ratio = wear_number(scene, 1.0) / wear_number(leading, 1.0) if wears else 1.0
            lead, slides = Lead(leader, ratio), [velocities, [ratio * v for v in velocities]]
        # Contacts may depend on more than their key.
        is_shared = leader != name and not any(inseparable(scene, some) for some in slides)
        leads[name] = lead if is_shared else Lead(name)
    return leads


class Point(NamedTuple):
    """One place in the diagram, and in which variant of the scene."""

    load: float  # on the whole pin [N]
    velocity: float  # [m/s]
    variant: Variant = ()

    def __str__(self) -> str:
        return ", ".join([f"{self.load:g} N, {self.velocity:g} m/s", *named(self.variant)])


def named(variant: Variant) -> list[str]:
    """Words for each value of a variant."""
    return [
        f"{'surface' if name == 'realization' else name} "
        + (f"{value:g}" if isinstance(value, float) else f"{value}")
        for name, value in variant
    ]


@dataclass(frozen=True, slots=True)
class Plane:
    """Loads and velocities at which to simulate a scene, each ascending and once."""

    loads: tuple[float, ...]  # on the whole pin [N]
    velocities: tuple[float, ...]  # [m/s]
    chosen: Collection[Point] | None = None  # the points to simulate, if not all of them

    def __post_init__(self) -> None:
        if not (self.loads and self.velocities):
            raise InputError("the sweep has no load or no velocity; give at least one of each")


@dataclass(frozen=True, slots=True)
class Record:
    """What is kept of each point; see `pipeline.sweep.stations`."""

    fields: bool = False  # those at the end of each point
    steps: Steps | None = None  # None for what is usual
    stations: Stations | None = None  # that a store has


@shown
@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A scene, where to simulate it and in which variants, and how to judge the results.

    Attributes
    ----------
    scene : Scene
        What is simulated, with its numerical choices.
    plane : Plane
        Loads and velocities at which.
    conditions : Conditions
        Friction, temperatures and criterion, which act after the simulation.
    variants : Variants
        Variants of the scene to simulate in its place.
    record : Record
        What is kept of each point.
    about : About
        Names, tests, oil and sources.

    Raises
    ------
    InputError
        If a variant changes what the scene does not have, such as the seed of a smooth surface.

    Examples
    --------
    >>> import pipeline
    >>> sweep = pipeline.load_scene("workflows/first_try.toml")
    >>> sweep.plane.loads, sweep.scene.pin.radius
    ((200.0, 400.0, 600.0, 750.0), 0.002)
    >>> sweep.changed(loads=(600.0,)).plane.loads
    (600.0,)
    """

    scene: Scene
    plane: Plane
    conditions: Conditions
    variants: Variants = field(default_factory=Variants)
    record: Record = field(default_factory=Record)
    about: About = field(default_factory=lambda: About(name="scene", title="A scene"))

    def __post_init__(self) -> None:
        object.__setattr__(self, "conditions", self.conditions.under(self.scene.loading))
        solved = self.conditions.solved_friction
        if solved != self.scene.solved_friction:
            object.__setattr__(self, "scene", replace(self.scene, solved_friction=solved))
        if self.variants.columns:
            self.variant(self.variants.names[0])  # refuses what the scene does not have

    def description(self) -> tuple[str, list[tuple[str, str]]]:
        """Title, and a row for each subject of the scene."""
        several = [(f"{name}s", str(len(values))) for name, values in self.variants.axes.items()]
        return f"{self.about.name}: {self.about.title}", [
            *scene_rows(self.scene),
            plane_rows(self.plane.loads, self.plane.velocities),
            *several,
            ("fidelity", self.about.preset or "of its own"),
            *condition_rows(self.conditions, [one.path for one in self.variants.unknown]),
        ]

    @property
    def ramps(self) -> int:
        """Number of simulated ramps; a ramp passes all loads at one velocity."""
        own = self.variants.velocities
        return len(own) if own else len(self.plane.velocities) * len(self.variants)

    def variant(self, variant: Variant = ()) -> Self:
        """The sweep of one row of its table alone; of the scene itself if none is given."""
        alone = self.changed(variants=Variants()) if self.variants.columns else self
        return alone.replace_part(self.variants.part(variant)) if variant else alone

    def replace_part(self, part: Part) -> Self:
        """The sweep with what a row of a table changes."""
        values: dict[str, Any] = {}
        for path, value in part:
            name, *inner = path.split(".")
            present = values.get(name, self.get(name))
            values[name] = _replaced_inner(present, inner, value, path)
        return self.changed(**values)

    def below(self, name: Variant) -> Self:
        """The sweep at labels that are not drawn, on the rows that are drawn for them."""
        return self.variant(name).changed(variants=self.variants.below(name))

    @functools.cached_property
    def leads(self) -> Mapping[Variant, Lead]:
        """For each row of the table, the first with the same contacts; see `Lead`."""
        table = self.variants
        scenes = ((name, self.variant(name).scene) for name in table.names)
        places = table.velocities or (None,) * len(table)
        return leads_of(scenes, places, self.plane.velocities)

    def contact_of(self, point: Point) -> tuple[float, Variant]:
        """Velocity and variant whose ramp of contacts leads through a point."""
        lead = self.leads.get(point.variant)
        velocity = lead and lead.leading_velocity(point.velocity)
        return point[1:] if lead is None or velocity is None else (velocity, lead.variant)

    def require_search(self) -> None:
        """Raise an `InputError` where no boundary can be looked for along velocities."""
        if not self.variants.has_plane:
            raise InputError(
                "each row has its own velocity, as samples have, and answers need all rows; leave "
                "out --boundary-only"
            )

    def held(self, duration: float) -> Self:
        """The sweep with another duration at the full load [s]; not if the load is a record."""
        if not isinstance(self.scene.loading, Ramp):
            raise InputError(
                f"hold is {duration:g} s, but the load follows a record, which has its own end; "
                "leave out the hold, or give a loading with rate and reference_load"
            )
        return self.changed(loading=replace(self.scene.loading, hold=duration, stops=()))

    def take_surface(self, seed: int | None) -> Self:
        """The sweep on the random surface of a seed alone; itself if None."""
        if seed is None:
            return self
        if not isinstance(self.scene.roughness, SelfAffineRoughness):
            raise InputError(
                f"realization is {seed}, the seed of a random roughness, and that of the scene is "
                "not random; leave it out"
            )
        return self.changed(variants=Variants()).replace_part((("roughness.seed", seed),))

    def changed(self, **values: Any) -> Self:
        """The sweep with other values of some fields of its parts, by the names of the fields."""
        if unknown := values.keys() - PART_OF.keys():
            raise TypeError(f"a sweep has no {', '.join(sorted(unknown))}")
        parts: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            parts.setdefault(PART_OF[name], {})[name] = value
        whole = parts.pop("", {})
        whole |= {name: replace(getattr(self, name), **new) for name, new in parts.items()}
        return replace(self, **whole)

    def get(self, name: str) -> Any:
        """Value of a field of one of the parts."""
        part = PART_OF[name]
        return getattr(getattr(self, part) if part else self, name)


_PARTS = {"scene": Scene, "plane": Plane, "record": Record, "about": About}
PART_OF = {
    "conditions": "",
    "variants": "",
    **{entry.name: part for part, kind in _PARTS.items() for entry in fields(kind)},
}
"""Part of a sweep that has a field; empty for the sweep itself."""
_EVERYWHERE = {"name", "title", "notes", "variants", "solved_friction"}
"""Fields in which no variant differs, or that follow from the conditions."""


def _replaced_inner(present: Any, inner: Sequence[str], value: Any, path: str) -> Any:
    """A part of a scene with another value of an inner field."""
    if not inner:
        return value
    name, *deeper = inner
    if not hasattr(present, name):
        kind = type(present).__name__ if present is not None else "none"
        raise InputError(
            f"{path} is {value!r}, but that part of the scene is {kind}, without {name}; "
            "leave it out"
        )
    return replace(present, **{name: _replaced_inner(getattr(present, name), deeper, value, path)})


def differing_inputs(sweep: Sweep, other: Sweep) -> Iterator[tuple[str, Any]]:
    """Fields, and their values, in which another sweep differs from one."""
    for name in PART_OF:
        old, new = sweep.get(name), other.get(name)
        if name not in _EVERYWHERE and old is not new and old != new:
            yield name, new
