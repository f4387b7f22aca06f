"""A scene, the points to simulate it at, and the conditions of severe wear."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.digest import digest
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.remarks import Remark
from pipeline.sweep.shown import shown
from pipeline.sweep.sources import FromLibrary
from pipeline.sweep.stations import Stations
from pipeline.sweep.tables import Entries, replace_value, replace_values
from pipeline.sweep.variants import SEED, Row, Variant, Variants
from tribo import InputError, Oil, Ramp, Scene, SelfAffineRoughness


class Point(NamedTuple):
    """A point of the diagram: a load and a velocity, in one variant of the scene."""

    load: float  # on the whole pin [N]
    velocity: float  # [m/s]
    variant: Variant = ()

    def __str__(self) -> str:
        return ", ".join([f"{self.load:g} N, {self.velocity:g} m/s", *variant_words(self.variant)])


def variant_words(variant: Variant) -> list[str]:
    """Describe the values that identify a variant, each as text such as "surface 3"."""
    return [
        f"{'surface' if name == 'realization' else name} "
        + (f"{value:g}" if isinstance(value, float) else f"{value}")
        for name, value in variant
    ]


@dataclass(frozen=True, slots=True)
class Parts:
    """Scene, conditions, tests and oil, made from the entries of a scene file."""

    declared: Any  # the file, read into its declared classes
    scene: Scene
    conditions: Conditions
    tests: tuple[Measurement, ...]  # transitions first
    oil: Oil | None  # tells the regime of lubrication; enters no simulation
    preset: str | None  # preset that the fidelity equals
    contents: Mapping[str, str]  # digests of the contents of files, by the paths of their entries
    sources: tuple[FromLibrary, ...]  # numbers from the library


@shown
@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """A scene, its loads, velocities and variants to simulate, and how to judge the results.

    It has the entries of a scene file, and variants, which replace some entries. Objects such as
    `scene` are made from the entries when they are first needed, and cached.

    Attributes
    ----------
    name : str
        Name of the file, without its ending.
    written : mapping
        Entries as in the file, in tables.
    reader : SceneReader
        Reader of the entries, `pipeline.scene.reading.SceneReader`.
    variants : Variants
        Table of variants, each with the entries that it replaces.
    notes : sequence of Remark
        Assumptions made on reading the scene.
    sources : tuple of FromLibrary
        Values that were taken from the library of materials and oils.
    stations : Stations or None
        Times of the loading whose results an existing store has; None without a store.
    judged : mapping
        Conditions that replace the conditions of all variants, by field of `Conditions`.

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
    notes: Sequence[Remark] = ()
    sources: tuple[FromLibrary, ...] = ()
    stations: Stations | None = None
    judged: Mapping[str, Any] = field(default_factory=dict)

    def __getstate__(self) -> dict[str, Any]:
        """State to pickle: only the fields; another process reads the entries again."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def __eq__(self, other: object) -> bool:
        """True if the entries of both sweeps have the same meaning, in each variant.

        Conditions that were chosen must be the same, too.
        """
        return isinstance(other, Sweep) and self._meaning == other._meaning

    def __hash__(self) -> int:
        return hash(self._meaning)

    @cached_property
    def _meaning(self) -> str:
        rows = [(row.scene, row.conditions) for row in map(self.variant, self.variants.names)]
        labels = self.variants.columns, [row.labels for row in self.rows]
        plane = self.plane.loads, self.plane.velocities, self.plane.fields, self.plane.steps
        own = self.scene, self.conditions, *plane
        words = self.declared.title, self.declared.caveat
        return digest((own, words, self.verdict_inputs, labels, rows))

    @cached_property
    def parts(self) -> Parts:
        """Scene, conditions, tests and oil, made from the entries."""
        parts: Parts = self.reader.read(self.written)
        return parts

    @cached_property
    def conditions(self) -> Conditions:
        """Friction, temperatures and criterion by which the simulated points are judged."""
        parts = self.parts
        return replace(parts.conditions, **self.judged).under(parts.scene.loading)

    @cached_property
    def scene(self) -> Scene:
        """The scene to simulate, with its numerical choices."""
        return self.parts.scene

    @property
    def plane(self) -> Any:
        """Table `[sweep]`: loads [N] and velocities [m/s], and what is stored of each point."""
        return self.parts.declared.sweep

    @property
    def declared(self) -> Any:
        """Tables of the scene file as objects, with values in SI."""
        return self.parts.declared

    @property
    def title(self) -> str:
        """Title of the scene, or the name of its file if it has no title."""
        return str(self.declared.title or self.name)

    @property
    def tests(self) -> tuple[Measurement, ...]:
        """Tests of the scene; those that measured a transition come first."""
        return self.parts.tests

    @property
    def measured(self) -> tuple[Measurement, ...]:
        """Tests that measured a transition from mild to severe wear."""
        return tuple(test for test in self.tests if not test.outcome)

    @property
    def tested(self) -> tuple[Measurement, ...]:
        """Tests with an outcome, mild or severe."""
        return tuple(test for test in self.tests if test.outcome)

    @property
    def lubricant(self) -> Oil | None:
        """The oil between the bodies, which does not affect simulations; None without `[oil]`."""
        return self.parts.oil

    @property
    def preset(self) -> str | None:
        """Name of the preset that has the scene's numerical choices; None if there is none."""
        return self.parts.preset

    @property
    def verdict_inputs(self) -> tuple[Any, ...]:
        """Data, besides simulation and conditions, that affect verdicts.

        They are tests, measured friction, the stated model error, oil and preset.
        """
        friction, own = self.declared.friction, (self.lubricant, self.preset)
        return (self.tests, friction.band, self.declared.model, *own)

    @cached_property
    def entries(self) -> dict[str, Any]:
        """All entries, completed by defaults, values of the library and choices of the preset."""
        entries: dict[str, Any] = self.reader.complete(self.written, self.parts)
        return entries

    @property
    def rows(self) -> tuple[Row, ...]:
        """Rows of the table of variants: values that identify a row, and entries it replaces."""
        return self.variants.rows

    def changed(self, path: str, value: Any) -> Self:
        """The sweep with another value of an entry, as in a scene file; None removes the entry.

        A preset (``fidelity.preset``) replaces all numerical choices, and a coefficient of friction
        scales the curves of friction. Variants that set the entry keep their own value.

        Raises
        ------
        InputError
            If the scene has a fault with this value.
        """
        written = dict(self.written)
        if path == "fidelity.preset":  # the preset replaces all other choices
            written.pop("fidelity", None)
        elif path.startswith("fidelity.") and self.reader.is_stored:
            written = replace_value(written, "fidelity.preset", None)  # no longer its choices
        changed = replace(self, written=replace_values(written, {path: value}))
        _ = changed.parts  # reads the entries: an `InputError` for a fault
        return changed

    def description(self) -> tuple[str, dict[str, Any]]:
        """Title, and a dictionary of the entries and the number of variants, for printing."""
        return f"{self.name}: {self.title}", self.entries | {"rows": str(len(self.rows))}

    @cached_property
    def _alone(self) -> dict[Variant, Self]:
        return {}

    def variant(self, name: Variant = ()) -> Self:
        """The sweep of one variant alone; by default of the scene itself, without variants."""
        if not name and not self.variants.columns:
            return self
        if name not in self._alone:
            values = self.variants.values(name) if name else {}
            written = replace_values(self.written, values)
            self._alone[name] = replace(self, written=written, variants=Variants())
        return self._alone[name]

    def cache_parts(self, parts: Iterable[Parts]) -> None:
        """Cache `parts` that were already made, so that variants do not read their entries again.

        There is one `Parts` (scene, conditions, tests and oil) for each variant, in their order.
        """
        for name, one in zip(self.variants.names, parts, strict=True):
            vars(self.variant(name))["parts"] = one

    @cached_property
    def _scene_hash(self) -> str:
        return digest(self.scene)

    def scene_hash(self, point: Point) -> str:
        """SHA-256 of the scene that is simulated at a point."""
        return self.variant(point.variant)._scene_hash

    def surfaces_of(self, name: Variant) -> Self:
        """The sweep of the random surfaces of one variant."""
        return replace(self.variant(name), variants=self.variants.surfaces_of(name))

    def with_hold(self, duration: float) -> Self:
        """The sweep with another `duration` for which the full load is held after the ramp [s].

        Raises an `InputError` if the load follows a record instead of a ramp.
        """
        if not isinstance(self.scene.loading, Ramp):
            raise InputError(
                f"hold is {duration:g} s, but the load follows a record, which has its own end; "
                "leave out the hold, or give a loading with rate and reference_load"
            )
        return self.changed("loading.hold", f"{duration!r} s")

    def take_surface(self, seed: int | None) -> Self:
        """The sweep on the random surface of a seed, without variants; itself if the seed is None.

        Raises an `InputError` if the scene's surface is not random.
        """
        if seed is None:
            return self
        if not isinstance(self.scene.roughness, SelfAffineRoughness):
            raise InputError(
                f"realization is {seed}, the seed of a random roughness, and that of the scene is "
                "not random; leave it out"
            )
        return replace(self.changed(SEED, seed), variants=Variants())

    def take_place(self, load: float, velocity: float, alone: bool = False) -> Self:
        """The sweep at one load [N] and velocity [m/s], without variants.

        Unless `alone`, the points of the scene's laboratory tests are also simulated. A model error
        inferred from the tests then counts in the verdict at this load and velocity.
        """
        tests = () if alone else self.tests
        loads = sorted({load, *(test.normal_load for test in tests)})
        velocities = sorted({velocity, *(test.velocity for test in tests)})
        at = self.variant().changed("sweep.loads", [f"{one!r} N" for one in loads])
        return at.changed("sweep.velocities", [f"{one!r} m/s" for one in velocities])
