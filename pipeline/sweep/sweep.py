"""A sweep: the scenes to simulate, each with the conditions to judge it by, and its points."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

from pipeline.limits import MAX_POINTS
from pipeline.sweep.case import LARGEST, Case, Conditions, SpecimenTest, Variant
from pipeline.sweep.case_table import AREAS_ENTRY, CaseName, CaseTable, in_order, surface_table
from pipeline.sweep.codec import NOT_STORED, digest
from pipeline.sweep.notes import FromLibrary, SceneNote, SceneWarning
from pipeline.sweep.stored_steps import Fields, Steps, StoredSteps
from pipeline.sweep.user_laws import user_law, user_surface
from tribo import (
    Corrections,
    Fidelity,
    InputError,
    Oil,
    Scene,
    SelfAffineRoughness,
    Surface,
    Track,
    WearLaw,
)

TABLE_OF_PART = {"wear": "wear", "roughness": "disk.roughness"}
"""Tables of the scene file that `Sweep.with_scene` replaces, by its arguments."""
BODIES = {"pin_track": "pin", "track": "disk"}
"""Bodies by the names of their tracks in `Corrections`."""
_WRAP_PART: dict[str, Callable[[Scene, Any], Any]] = {"wear": user_law, "roughness": user_surface}
"""Functions that check a law or surface of a user, and add what a store keeps of it."""


class Point(NamedTuple):
    """A point of the diagram: a load and a velocity, in one case of the sweep."""

    load: float  # on the whole pin [N]
    velocity: float  # [m/s]
    case: CaseName = ()

    def __str__(self) -> str:
        return ", ".join([f"{self.load:g} N, {self.velocity:g} m/s", *case_words(self.case)])


def case_words(case: CaseName) -> list[str]:
    """Describe the labels that name a case, each as text such as "surface 3"."""
    return [
        f"{'surface' if name == 'realization' else name} "
        + (f"{value:g}" if isinstance(value, float) else f"{value}")
        for name, value in case
    ]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Sweep:
    """Cases, loads and velocities to simulate, and the conditions of their verdicts.

    What `pipeline.load_scene` returns; it is immutable, and ``changed`` and ``with_scene`` return
    copies.

    Attributes
    ----------
    name, title : str
        Name of the file without its ending, and title.
    base : Case
        The scene itself, without the entries that cases replace.
    cases : tuple of Case
        One for each row of `case_table`, in its order.
    loads, velocities : tuple of float
        Ascending loads [N] and velocities [m/s] of the plane.
    case_table : CaseTable
        Table of the labels of the cases.
    tests : tuple of SpecimenTest
        Tests of the scene, each with its own case.
    text : str
        The scene file for people, with the scenes that it extends and values of the library.

    Examples
    --------
    >>> import pipeline
    >>> sweep = pipeline.load_scene("workflows/first_try.toml")
    >>> sweep.loads, sweep.scene.pin.radius
    ((200.0, 400.0, 600.0, 750.0), 0.002)
    >>> sweep.changed("pin.radius", "1 mm").scene.pin.radius
    0.001
    """

    name: str
    title: str
    note: str | None  # what readers of answers must know
    base: Case
    cases: tuple[Case, ...]
    case_table: CaseTable = field(repr=False)
    loads: tuple[float, ...]
    velocities: tuple[float, ...]
    fields: Fields  # of the contact, to store
    steps: Steps | None  # to store; None for the default
    tests: tuple[SpecimenTest, ...]
    variants: tuple[Variant, ...] = ()  # for sensitivities, chosen by a run
    warnings: tuple[SceneWarning, ...] = ()  # found on reading; from a store, all warnings
    sources: tuple[FromLibrary, ...] = ()
    stored_steps: StoredSteps | None = None  # of an existing store; None to choose them
    text: str = field(default="", repr=False, metadata=NOT_STORED)
    # How entries were read.
    notes: tuple[SceneNote, ...] = field(default=(), metadata=NOT_STORED)
    # The scene file, with what `with_scene` and `judge` replaced; None from a store.
    source: Any = field(default=None, repr=False, metadata=NOT_STORED)

    def __post_init__(self) -> None:
        for name in ("loads", "velocities"):
            values = getattr(self, name)
            if not values or [*values] != sorted({*values}) or max(map(abs, values)) > LARGEST:
                raise InputError(f"{name} are {values}; give numbers that ascend")

    def __eq__(self, other: object) -> bool:
        """True if both sweeps have the same meaning, however their entries are written."""
        return isinstance(other, Sweep) and self.meaning_digest == other.meaning_digest

    def __hash__(self) -> int:
        return hash(self.meaning_digest)

    def __repr__(self) -> str:
        return f"{self.name}: {self.title} ({len(self.case_table)} cases)"

    @cached_property
    def meaning_digest(self) -> str:
        """Digest of what the sweep means, whatever way its entries are written."""
        plane = self.loads, self.velocities, self.fields, self.steps
        texts = self.title, self.note
        return digest(((self.base, *self.cases), plane, texts, self.tests, self.case_table))

    def require_few_points(self) -> None:
        """Raise an `InputError` if the sweep has too many points, before they are listed."""
        table = self.case_table
        loads = len(table.loads_of(table.rows[0]) or self.loads)
        velocities = len(self.velocities) if table.column("velocity") is None else 1
        if (count := len(table) * loads * velocities) > MAX_POINTS:
            raise InputError(
                f"sweep: {count:.4g} points are too many; give {MAX_POINTS:.0e} at most, by "
                "fewer loads, velocities or cases"
            )

    @cached_property
    def all_warnings(self) -> tuple[SceneWarning, ...]:
        """Warnings of probable mistakes in the scene, of all cases, the gravest first."""
        if self.source is None:  # read from a store, with all warnings
            return self.warnings
        warnings: tuple[SceneWarning, ...] = self.source.warnings(self)
        return warnings

    @property
    def scene(self) -> Scene:
        """The scene itself, to simulate."""
        return self.base.scene

    @property
    def conditions(self) -> Conditions:
        """Friction and temperatures of the scene itself."""
        return self.base.conditions

    @property
    def lubricant(self) -> Oil | None:
        """The oil between the bodies, which does not affect simulations; None without `[oil]`."""
        return self.base.lubricant

    @property
    def preset(self) -> str | None:
        """Name of the preset that has the scene's numerical choices; None if there is none."""
        return self.base.preset

    @property
    def tests_and_variants(self) -> tuple[SpecimenTest | Variant, ...]:
        """All whose points are beside the plane: tests, then variants."""
        return (*self.tests, *self.variants)

    @cached_property
    def _by_name(self) -> dict[CaseName, Case]:
        return {case.name: case for case in self.cases}

    def case(self, name: CaseName = ()) -> Case:
        """The case of a name, by default the scene itself; `InputError` if there is none."""
        if not name:
            return self.base
        if name not in self._by_name:
            raise self.case_table.unknown_case(name)
        return self._by_name[name]

    @cached_property
    def on_first_surface(self) -> tuple[Case, ...]:
        """Cases that the user chose, each on its first surface."""
        if not self.case_table.chosen_columns:
            return (self.base,)
        chosen = {column.name for column in self.case_table.chosen_columns}
        first_cases: dict[CaseName, Case] = {}
        for case in self.cases:
            name = tuple((dim, label) for dim, label in case.name if dim in chosen)
            first_cases.setdefault(name, case)
        return tuple(first_cases.values())

    @cached_property
    def surface_with_fields(self) -> CaseName:
        """The one surface realization of each case whose fields are stored: dimension and label.

        It is the first; empty if cases have no realizations.
        """
        return tuple(
            (column.name, in_order(self.case_table.axes[column.name])[0])
            for column in self.case_table.columns
            if column.is_seed
        )

    def fields_of(self, name: CaseName) -> Fields:
        """Which fields of the points of a case are stored."""
        return self.fields if {*self.surface_with_fields} <= {*name} else False

    def single_case(self) -> Self:
        """The sweep of the scene itself, without its cases."""
        case = replace(self.base, name=())
        return replace(self, base=case, cases=(case,), case_table=CaseTable())

    def select_case(self, name: CaseName) -> Self:
        """The sweep of the random surfaces of one case, named without them."""
        table, labels = self.case_table.surfaces_of(name), {*name}
        selected = [case for case in self.cases if labels <= {*case.name}]
        if not selected:
            raise self.case_table.unknown_case(name)
        cases = [
            replace(case, name=label) for case, label in zip(selected, table.names, strict=True)
        ]
        return replace(self, base=replace(cases[0], name=()), cases=tuple(cases), case_table=table)

    @cached_property
    def scene_hashes(self) -> dict[CaseName, str]:
        """SHA-256 of the scene of each case, by the name of the case."""
        hashes = {scene: digest(scene) for scene in {case.scene for case in self.cases}}
        return {case.name: hashes[case.scene] for case in self.cases}

    def changed(self, path: str, value: Any) -> Self:
        """The sweep with another value of an entry, as in a scene file; None removes the entry.

        The scene is read again. A preset (``fidelity.preset``) replaces all numerical choices.
        Cases that set the entry keep their own value.

        Raises
        ------
        InputError
            If the scene has a fault with this value, or the sweep is that of a store.
        """
        if not isinstance(path, str):
            raise InputError(f"path is {f'{path!r}':.80}; give the path of an entry as text")
        if self.source is None:
            raise InputError(
                f"{path} cannot be changed in the sweep of a store, which has no scene file; read "
                "the scene with another value: pipeline.load_scene(..., overrides={...})"
            )
        sweep: Self = self.source.changed(path, value)
        return sweep

    def with_scene(self, *, wear: WearLaw | None = None, roughness: Surface | None = None) -> Self:
        """The sweep with a wear law or a surface of your own class, in all cases and tests.

        The class must be in a module that can be imported, and its objects can be pickled. The
        surface has no realizations: it is the same in all cases.

        Parameters
        ----------
        wear : WearLaw, optional
            Wear law, see `tribo.WearLaw`, in place of ``[wear]``.
        roughness : Surface, optional
            Surface of the disk, see `tribo.Surface`, in place of ``[disk.roughness]``.

        Raises
        ------
        InputError
            If the law or surface fails, a store cannot keep what it is, or cases and tests of the
            scene differ in the part that it replaces.
        """
        arguments = {"wear": wear, "roughness": roughness}
        parts: dict[str, Any] = {name: part for name, part in arguments.items() if part is not None}
        scenes = [case.scene for case in (*self.cases, *(test.case for test in self.tests))]
        for name in parts:
            if any(getattr(scene, name) != getattr(self.scene, name) for scene in scenes):
                raise InputError(
                    f"{name} cannot be replaced: {TABLE_OF_PART[name]} differs between cases or "
                    "tests of the scene; leave out what changes it in sweep and tests"
                )
        stored = {name: _WRAP_PART[name](self.scene, part) for name, part in parts.items()}
        notes = [
            f"# {TABLE_OF_PART[name]} is replaced by {part!r}\n" for name, part in stored.items()
        ]
        sweep = self.map_cases(lambda case: replace(case, scene=replace(case.scene, **stored)))
        if source := self.source:
            source = replace(source, user_parts={**source.user_parts, **parts})
        return replace(sweep, text="".join([*notes, self.text]), source=source)

    def with_fidelity(self, fidelity: Fidelity, preset: str | None = None) -> Self:
        """The sweep with other numerical choices of all cases; `preset` is their name, or None."""
        return self.map_cases(lambda case: case.with_fidelity(fidelity, preset))

    def map_cases(self, change: Callable[[Case], Case]) -> Self:
        """The sweep with each case changed, also those of tests."""
        base, *cases = map(change, (self.base, *self.cases))
        tests = tuple(replace(test, case=change(test.case)) for test in self.tests)
        return replace(self, base=base, cases=tuple(cases), tests=tests)

    def with_realizations(self, count: int) -> Self:
        """The sweep on `count` random surfaces, with ascending seeds from that of the scene on."""
        roughness = self.scene.roughness
        assert isinstance(roughness, SelfAffineRoughness)
        chosen = self.case_table.without_surfaces
        table = chosen * surface_table(range(roughness.seed, roughness.seed + count))
        first_cases = dict(zip(chosen.names, self.on_first_surface, strict=True))
        cases = tuple(
            replace(first_cases[(*labels,)].on_surface(int(seed)), name=(*labels, (dim, seed)))
            for *labels, (dim, seed) in table.names
        )
        return replace(self, cases=cases, case_table=table)

    def judge(self, changes: Mapping[str, Any]) -> Self:
        """The sweep with the conditions of all cases replaced by `changes`, values by name.

        Tests keep their conditions; answers apply the oil's critical temperature to them, too.
        """
        if not changes:
            return self
        base, *cases = (
            replace(case, conditions=replace(case.conditions, **changes))
            for case in (self.base, *self.cases)
        )
        if source := self.source:
            source = replace(source, conditions={**source.conditions, **changes})
        return replace(self, base=base, cases=tuple(cases), source=source)

    def take_surface(self, seed: int | None) -> Self:
        """The sweep without cases, on the random surface of a seed; unchanged for None."""
        if seed is None:
            return self
        if self.scene.roughness is None:
            raise InputError(
                f"realization {seed} has no effect: the disk of the scene is smooth; leave it out"
            )
        if not isinstance(self.scene.roughness, SelfAffineRoughness):  # an area of a scan
            return self.changed(AREAS_ENTRY, [seed]).single_case()
        base = replace(self.base.on_surface(seed), name=())
        tests = tuple(replace(test, case=test.case.on_surface(seed)) for test in self.tests)
        return replace(self, base=base, cases=(base,), case_table=CaseTable(), tests=tests)


def cold_tracks(sweep: Sweep) -> dict[str, Track | None]:
    """Tracks of rolling bodies that the scene treats as cold, although they have been warmed.

    A value is None if the length of the body's track is unknown; keys are those of `BODIES`. The
    result is empty if no body rolls, all velocities are 0, or the heat of earlier revolutions is
    included.
    """
    if sweep.base.includes_earlier_revolutions:
        return {}
    motion, pin = sweep.scene.motion, sweep.scene.pin
    is_rolling = motion is not None and motion.slide_roll_ratio not in (-2.0, 2.0)
    if motion is None or not (is_rolling and any(sweep.velocities)):
        return {}
    corrections = sweep.conditions.corrections or Corrections()
    bodies = {
        "pin_track": (pin.material, motion.pin_track_length),
        "track": (sweep.scene.disk, motion.disk_track_length),
    }
    return {
        name: Track.from_pin(pin, material, length) if length else None
        for name, (material, length) in bodies.items()
        if getattr(corrections, name) is None
    }
