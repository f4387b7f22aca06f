"""A scene, the points to simulate it at, and the conditions of severe wear."""

from __future__ import annotations

import functools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

from pipeline.sweep.about import (
    About,
    FromLibrary,
    Measurement,
    condition_rows,
    plane_rows,
    scene_rows,
)
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.digest import digest
from pipeline.sweep.remarks import Remark
from pipeline.sweep.selection import Selection
from pipeline.sweep.shown import shown
from pipeline.sweep.stations import Stations, Steps
from pipeline.sweep.tables import (
    CURVES,
    FRICTION,
    Entries,
    changes,
    entry_at,
    replace_value,
    replace_values,
)
from pipeline.sweep.variants import Row, Variant, Variants, surfaces
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

    def __post_init__(self) -> None:
        if not (self.loads and self.velocities):
            raise InputError("the sweep has no load or no velocity; give at least one of each")


@dataclass(frozen=True, slots=True)
class Record:
    """What is kept of each point; see `pipeline.sweep.stations`."""

    fields: bool = False  # those at the end of each point
    steps: Steps | None = None  # None for what is usual


@dataclass(frozen=True, slots=True)
class Parts:
    """What the entries of a scene read as."""

    declared: Any  # the file as it is declared
    scene: Scene
    plane: Plane
    conditions: Conditions
    record: Record
    about: About


@shown
@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """A scene, where to simulate it and in which variants, and how to judge the results.

    It is the entries of a scene file, and rows that replace some of them. What they read as is
    made when it is asked for, and kept.

    Attributes
    ----------
    name : str
        That of the file, without its ending.
    written : mapping
        Entries as the file has them, in tables.
    reader : SceneReader
        What reads them; it lives with the format.
    variants : Variants
        Rows, each with the entries that it replaces.
    notes : tuple of Remark
        Assumptions made on reading the scene.
    sources : tuple of FromLibrary
        Numbers from the library.
    selection : Selection or None
        Reasons of a fidelity picked for its accuracy.
    chosen : collection of Point or None
        The points to simulate, if not all of the plane.
    stations : Stations or None
        Stations that a store has.
    judged : mapping
        Conditions in place of those of all rows, by the fields of `Conditions`.
    oil : str or None
        Oil whose tests count; the scene's own if None.

    Examples
    --------
    >>> import pipeline
    >>> sweep = pipeline.load_scene("workflows/first_try.toml")
    >>> sweep.plane.loads, sweep.scene.pin.radius
    ((200.0, 400.0, 600.0, 750.0), 0.002)
    >>> sweep.changed("pin.radius", "1 mm").scene.pin.radius, sweep.entries["pin"]["radius"]
    (0.001, '2 mm')
    """

    name: str
    written: Entries = field(repr=False)
    reader: Any = field(repr=False)
    variants: Variants = field(default_factory=Variants)
    notes: tuple[Remark, ...] = ()
    sources: tuple[FromLibrary, ...] = ()
    selection: Selection | None = None
    chosen: Collection[Point] | None = None
    stations: Stations | None = None
    judged: Mapping[str, Any] = field(default_factory=dict)
    oil: str | None = None
    made: dict[Variant, Parts] = field(default_factory=dict, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        """All but what is made of the entries, which another process makes anew."""
        kept = {key: value for key, value in vars(self).items() if key not in _MADE}
        return kept | {"made": {}}

    def __eq__(self, other: object) -> bool:
        """True if the entries of both mean the same, in each row."""
        return isinstance(other, Sweep) and self._meaning == other._meaning

    def __hash__(self) -> int:
        return hash(self._meaning)

    @functools.cached_property
    def _meaning(self) -> str:
        about = replace(self.about, name="", sources=(), notes=(), title=self.parts().about.title)
        rows = [(row.scene, row.conditions) for row in map(self.variant, self.variants.names)]
        own = self.scene, self.conditions, self.plane.loads, self.plane.velocities, self.record
        chosen = None if self.chosen is None else sorted(self.chosen)
        return digest((own, chosen, about, self.variants.columns, self.variants.rule, rows))

    def parts(self, name: Variant = ()) -> Parts:
        """What the entries read as, or those with what a row replaces."""
        if name not in self.made:
            values = self._row(name) if name else {}
            self.made[name] = self.reader.read(replace_values(self.written, values))
        return self.made[name]

    def _row(self, name: Variant) -> Row:
        row = self.variants.row(name)
        if FRICTION not in row:
            return row
        if self.variants.draw:  # its samples have the curves of the scene
            return {path: entry_at(self.written, path) for path in CURVES} | dict(row)
        # Friction that is measured at a place is not one by velocity.
        return dict.fromkeys(CURVES) | dict(row) if "load" in row else row

    @functools.cached_property
    def conditions(self) -> Conditions:
        """Friction, temperatures and criterion, which act after the simulation."""
        parts = self.parts()
        return replace(parts.conditions, **self.judged).under(parts.scene.loading)

    @functools.cached_property
    def scene(self) -> Scene:
        """What is simulated, with its numerical choices."""
        scene, solved = self.parts().scene, self.conditions.solved_friction
        return scene if solved == scene.solved_friction else replace(scene, solved_friction=solved)

    @property
    def plane(self) -> Plane:
        """Loads and velocities at which."""
        return self.parts().plane

    @property
    def record(self) -> Record:
        """What is kept of each point."""
        return self.parts().record

    @functools.cached_property
    def about(self) -> About:
        """Names, tests, oil and sources."""
        about = self.parts().about
        about = replace(
            about,
            name=self.name,
            title=about.title or self.name,
            selection=self.selection,
            sources=self.sources,
            notes=self.notes,
        )
        if self.oil is None:
            return about

        def under(tests: Iterable[Measurement]) -> tuple[Measurement, ...]:
            return tuple(test.under_oil(self.oil or "") for test in tests)

        return replace(
            about,
            title=f"{about.title}, oil {self.oil}",
            tested_oil=self.oil,
            measured=under(about.measured),
            tested=under(about.tested),
        )

    @functools.cached_property
    def entries(self) -> dict[str, Any]:
        """The entries in full: with defaults, values of the library and choices of the preset."""
        entries: dict[str, Any] = self.reader.complete(self.written, self.parts())
        return entries

    @functools.cached_property
    def rows(self) -> tuple[Row, ...]:
        """Labels of each row, and the entries that it replaces, in full."""
        if self.variants.draw:
            return self.variants.rows
        parts, rows = self.parts(), []
        for name, row in zip(self.variants.names, self.variants.rows, strict=True):
            alone = self.variant(name)
            full = self.reader.complete(alone.written, alone.parts(), parts)
            before = {key: self.entries.get(key) for key in full}
            given = {key: one for key, one in row.items() if one is not None}
            added = {key: one for key, one in changes(before, full) if key not in given}
            rows.append(given | added)
        return tuple(rows)

    def changed(self, path: str, value: Any) -> Self:
        """The sweep with another value of an entry, as a scene file has it; None leaves it out.

        Raises
        ------
        InputError
            If the scene is not sound with it.
        """
        written = dict(self.written)
        if path == "fidelity.preset":  # all other choices stand for this one
            written.pop("fidelity", None)
        is_inner = "." in path
        written = (
            replace_values(written, {path: value})
            if is_inner
            else replace_value(written, path, value)
        )
        changed = replace(self, written=written, made={})
        changed.parts()
        return changed

    def description(self) -> tuple[str, list[tuple[str, str]]]:
        """Title, and a row for each subject of the scene."""
        several = [(f"{name}s", str(len(values))) for name, values in self.variants.axes.items()]
        return f"{self.about.name}: {self.about.title}", [
            *scene_rows(self.scene),
            plane_rows(self.plane.loads, self.plane.velocities),
            *several,
            ("fidelity", self.about.preset or "of its own"),
            *condition_rows(self.conditions, self.variants.unknown),
        ]

    @property
    def ramps(self) -> int:
        """Number of simulated ramps; a ramp passes all loads at one velocity."""
        own = self.variants.velocities
        return len(own) if own else len(self.plane.velocities) * len(self.variants)

    @functools.cached_property
    def _alone(self) -> dict[Variant, Self]:
        return {}

    def variant(self, name: Variant = ()) -> Self:
        """The sweep of one row of its table alone; of the scene itself if none is given."""
        if not name and not self.variants.columns:
            return self
        if name not in self._alone:
            made: dict[Variant, Parts] = {(): self.parts(name)}
            written = replace_values(self.written, self._row(name)) if name else self.written
            alone = replace(self, written=written, variants=Variants(), made=made)
            self._alone[name] = alone
        return self._alone[name]

    def below(self, name: Variant) -> Self:
        """The sweep at labels that are not drawn, on the rows that are drawn for them."""
        return replace(self.variant(name), variants=self.variants.below(name), made={})

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
        return self.changed("loading.hold", f"{duration!r} s")

    def take_surface(self, seed: int | None) -> Self:
        """The sweep on the random surface of a seed alone; itself if None."""
        if seed is None:
            return self
        if not isinstance(self.scene.roughness, SelfAffineRoughness):
            raise InputError(
                f"realization is {seed}, the seed of a random roughness, and that of the scene is "
                "not random; leave it out"
            )
        return replace(self, variants=surfaces((seed,))).variant((("realization", seed),))


_MADE = {"_meaning", "conditions", "scene", "about", "entries", "rows", "_alone", "made"}
"""Attributes that are made of the entries."""
