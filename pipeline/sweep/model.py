"""A sweep: the scenes to simulate, each with the conditions to judge it by, and its points."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from pipeline.sweep.conditions import Conditions, changed_conditions
from pipeline.sweep.measurement import Case, Measurement
from pipeline.sweep.missing import MissingSurface
from pipeline.sweep.remarks import FromLibrary, Remark
from pipeline.sweep.stations import Stations, Steps
from pipeline.sweep.tables import entry_at, replace_value, replace_values
from pipeline.sweep.variants import SEED, Row, Variant, Variants, surfaces
from tribo import InputError, MeasuredRoughness, Oil, Ramp, Scene, SelfAffineRoughness
from tribo.surface import array_digest


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


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Sweep:
    """Scenes, loads and velocities to simulate, and how to judge the results.

    A sweep is read once, from a scene file or a store; after that it is plain data. Copies by
    `dataclasses.replace` change what is an object here; `changed` reads the scene again with
    another value of an entry.

    Attributes
    ----------
    name, title : str
        Name of the file without its ending, and title.
    loads, velocities : tuple of float
        Ascending loads [N] and velocities [m/s] of the plane.
    variants : Variants
        Table of the labels of the cases, and of the entries that each replaces.
    tests : tuple of Measurement
        Tests of the scene, each with its own case; those that measured a transition come first.
    entries : mapping
        All entries of the scene, for people: completed by defaults, values of the library and
        choices of the preset, in the units of the file.

    Examples
    --------
    >>> import pipeline
    >>> sweep = pipeline.load_scene("workflows/first_try.toml")
    >>> sweep.loads, sweep.scene.pin.radius
    ((200.0, 400.0, 600.0, 750.0), 0.002)
    >>> sweep.changed("pin.radius", "1 mm").scene.pin.radius, sweep.entries["pin"]["radius"]
    (0.001, '2 mm')
    """

    name: str
    title: str
    caveat: str | None  # what readers of answers must know
    base: Case  # the scene itself, without the entries that cases replace
    cases: tuple[Case, ...]  # one for each row of `variants`, in its order
    variants: Variants = field(repr=False)
    loads: tuple[float, ...]
    velocities: tuple[float, ...]
    fields: bool  # True to store fields of the contact
    steps: Steps | None  # to store; None for the default
    tests: tuple[Measurement, ...]
    notes: Sequence[Remark] = ()  # assumptions made on reading the scene
    sources: tuple[FromLibrary, ...] = ()
    stations: Stations | None = None  # times whose results an existing store has
    judged: Mapping[str, Any] = field(default_factory=dict)  # given by `judge`, by name
    entries: Mapping[str, Any] = field(repr=False)
    source: Any = field(repr=False)  # `pipeline.scene.source.Source`, to read again

    def __eq__(self, other: object) -> bool:
        """True if both sweeps have the same meaning, however their entries are written."""
        return isinstance(other, Sweep) and self._meaning == other._meaning

    def __hash__(self) -> int:
        return hash(self._meaning)

    def __repr__(self) -> str:
        return f"{self.name}: {self.title} ({len(self._rows)} rows)"

    @cached_property
    def _meaning(self) -> str:
        labels = self.variants.columns, [row.labels for row in self._rows]
        plane = self.loads, self.velocities, self.fields, self.steps
        words = self.title, self.caveat
        return digest(((self.base, *self.cases), plane, words, self.tests, labels))

    @cached_property
    def doubts(self) -> tuple[Remark, ...]:
        """Warnings of probable mistakes in the scene, of all cases, the gravest first."""
        found: tuple[Remark, ...] = self.source.doubts(self)
        return found

    @property
    def scene(self) -> Scene:
        """The scene itself, to simulate."""
        return self.base.scene

    @property
    def conditions(self) -> Conditions:
        """Friction, temperatures and criterion of the scene itself."""
        return self.base.conditions

    @property
    def friction_band(self) -> tuple[float, float] | None:
        """Lowest and highest friction that the diagram shows; None without `friction.band`."""
        return self.base.friction_band

    @property
    def lubricant(self) -> Oil | None:
        """The oil between the bodies, which does not affect simulations; None without `[oil]`."""
        return self.base.lubricant

    @property
    def preset(self) -> str | None:
        """Name of the preset that has the scene's numerical choices; None if there is none."""
        return self.base.preset

    @property
    def _measured(self) -> tuple[Measurement, ...]:
        """Tests that measured a transition from mild to severe wear."""
        return tuple(test for test in self.tests if not test.outcome)

    @property
    def _rows(self) -> tuple[Row, ...]:
        """Rows of the table of variants: values that identify a row, and entries it replaces."""
        return self.variants.rows

    @cached_property
    def _by_name(self) -> dict[Variant, Case]:
        return {case.name: case for case in self.cases}

    def case(self, name: Variant = ()) -> Case:
        """The case of a variant; by default the scene itself.

        Raises an `InputError` if the sweep has no such variant.
        """
        if not name:
            return self.base
        if name not in self._by_name:
            self.variants.values(name)  # raises, and says what there is
        return self._by_name[name]

    @cached_property
    def _given(self) -> tuple[Case, ...]:
        """Cases that the user chose: of each, the one on the first random surface."""
        if not self.variants.chosen:
            return (self.base,)
        chosen = {one.name for one in self.variants.chosen}
        first: dict[Variant, Case] = {}
        for case in self.cases:
            first.setdefault(tuple(label for label in case.name if label[0] in chosen), case)
        return tuple(first.values())

    def _alone(self, name: Variant = ()) -> Self:
        """The sweep of one case, by default of the scene itself, without variants."""
        return self._taken(name, Variants(), [replace(self.case(name), name=())])

    def _take(self, name: Variant) -> Self:
        """The sweep of the random surfaces of one variant, named without them."""
        table, wanted = self.variants.surfaces_of(name), {*name}
        own = [case for case in self.cases if wanted <= {*case.name}]
        cases = [replace(case, name=label) for case, label in zip(own, table.names, strict=True)]
        return self._taken(name, table, cases)

    def _taken(self, name: Variant, table: Variants, cases: Sequence[Case]) -> Self:
        values = self.variants.values(name) if name else {}
        return replace(
            self,
            base=replace(cases[0], name=()),
            cases=tuple(cases),
            variants=table,
            entries=replace_values(self.entries, values),
            source=replace(self.source, written=replace_values(self.source.written, values)),
        )

    def _hash_scene(self, scene: Scene) -> str:
        """SHA-256 of a scene, computed once for this sweep."""
        if scene not in self._hashes:
            self._hashes[scene] = digest(scene)
        return self._hashes[scene]

    @cached_property
    def _hashes(self) -> dict[Scene, str]:
        return {}

    def changed(self, path: str, value: Any) -> Self:
        """The sweep with another value of an entry, as in a scene file; None removes the entry.

        A preset (``fidelity.preset``) replaces all numerical choices, and a coefficient of friction
        scales the curves of friction. Variants that set the entry keep their own value.

        Raises
        ------
        InputError
            If the scene has a fault with this value.
        """
        written = dict(self.source.written)
        if path == "fidelity.preset":  # the preset replaces all other choices
            written.pop("fidelity", None)
        elif path.startswith("fidelity.") and self.source.reader.is_stored:
            written = replace_value(written, "fidelity.preset", None)  # no longer its choices
        made: Self = self.source.read_again(
            self, replace_values(written, {path: value}), self.variants
        )
        return made

    def _with_patches(self, count: int) -> Self:
        """The sweep on this many random surfaces, counted from its own seed on."""
        first = entry_at(self.entries, SEED)
        written = replace_values(self.source.written, {"sweep.realizations": count})
        variants = self.variants.without_surfaces * surfaces(range(first, first + count))
        made: Self = self.source.read_again(self, written, variants)
        return made

    def judge(self, changes: Mapping[str, Any]) -> Self:
        """The sweep with the conditions of all cases replaced as by `changed_conditions`.

        Tests keep their own: answers take the oil's limit for them too.
        """
        if not changes:
            return self
        base, *cases = (
            replace(case, conditions=changed_conditions(case.conditions, changes))
            for case in (self.base, *self.cases)
        )
        judged = {**self.judged, **changes}
        return replace(self, base=base, cases=tuple(cases), judged=judged)

    def _with_hold(self, duration: float) -> Self:
        """The sweep with another `duration` for which the full load is held after the ramp [s]."""
        if not isinstance(self.scene.loading, Ramp):
            raise InputError(
                f"hold is {duration:g} s, but the load follows a record or stages, which have "
                "their own end; leave out the hold, or give a loading with rate and reference_load"
            )
        return self.changed("loading.hold", f"{duration!r} s")

    def _take_surface(self, seed: int | None) -> Self:
        """The sweep on the random surface of a seed, without variants; itself for None."""
        if seed is None:
            return self
        if not isinstance(self.scene.roughness, SelfAffineRoughness):
            raise InputError(
                f"realization is {seed}, the seed of a random roughness, and that of the scene is "
                "not random; leave it out"
            )
        return self._alone().changed(SEED, seed)


def digest(part: Any) -> str:
    """SHA-256 of a value, or of an object's fields; the numbers 2 and 2.0 are the same."""
    return hashlib.sha256(json.dumps(_plain(part)).encode()).hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, bool | str) or value is None:
        return value
    if isinstance(value, int | float | np.number):
        number = float(value)
        return number if number == value or number != number else str(value)
    if isinstance(value, np.ndarray):
        return array_digest(value)
    if isinstance(value, MeasuredRoughness | MissingSurface):
        return value.digest
    if is_dataclass(value):
        counted = [one.name for one in fields(value) if one.init and one.compare]
        values = [_plain(getattr(value, name)) for name in counted]
        return [type(value).__name__, *values]
    if isinstance(value, Mapping):
        return [[_plain(key), _plain(one)] for key, one in value.items()]
    return [_plain(one) for one in value]
