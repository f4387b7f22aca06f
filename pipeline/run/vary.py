"""One input at a time: the boundary of a scene, and of others that differ from it in one entry."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

import numpy as np

from pipeline.analysis.transition import Transition, outcomes
from pipeline.run.boundary_search import BoundarySearch
from pipeline.run.physics import Effect, physics_of
from pipeline.run.sharing import SharedContacts, SharedPoint
from pipeline.scene.over import note_of
from pipeline.scene.scenefile import load_scene
from pipeline.scene.variants import absolute
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import decisive_rises
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.stages import staged
from pipeline.sweep.variants import Variants
from pipeline.sweep.warned import NO_WARNING, Warned
from tribo import Criterion, Scene, wear_number
from tribo.types import Array


@dataclass(frozen=True, slots=True)
class Variation:
    """The boundary with one entry changed.

    Attributes
    ----------
    key, value : str
        Path of the entry, and what it is given, as it would stand in the scene; both empty for the
        scene as it is.
    critical_velocities : tuple of float
        Critical velocity at each load [m/s]; NaN where there is no transition within the sweep.
    outcomes : tuple of str
        At each load ``"crosses"``, or where there is no transition, ``"mild throughout"`` or
        ``"severe throughout"``.

    Examples
    --------
    >>> Variation("friction.coefficient", "0.12", (1.63,), ("crosses",)).value
    '0.12'
    """

    key: str
    value: str
    critical_velocities: tuple[float, ...]
    outcomes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Variations:
    """The boundary of a scene, and with single entries changed.

    Attributes
    ----------
    title : str
        Title of the scene.
    loads : tuple of float
        Normal loads on the whole pin [N].
    base : Variation
        The scene as it is.
    others : tuple of Variation
        The changes, in the order in which they were asked for.
    points, contacts : int
        Points of all scenes, and the points whose contacts were computed for them.
    warned : Warned
        Points that carry a warning, over all scenes.
    physics : tuple of Effect
        Physics beside the half-spaces; where it can be sized its name is the key of a change, with
        "without" before it where the scene counts it.

    Examples
    --------
    >>> import pipeline
    >>> base = pipeline.Variation("", "", (2.17,), ("crosses",))
    >>> other = pipeline.Variation("friction.coefficient", "0.12", (1.63,), ("crosses",))
    >>> variations = pipeline.Variations("A scene", (400.0,), base, (other,), points=8, contacts=8)
    >>> variations.base.critical_velocities
    (2.17,)
    """

    title: str
    loads: tuple[float, ...]
    base: Variation
    others: tuple[Variation, ...]
    points: int
    contacts: int
    warned: Warned = NO_WARNING
    physics: tuple[Effect, ...] = ()

    def changes(self, variation: Variation) -> Array:
        """Relative change of the critical velocity at each load; NaN where there is none."""
        changed: Array = np.array(variation.critical_velocities) / self.base.critical_velocities - 1
        return changed

    def by_key(self) -> dict[str, list[Variation]]:
        """Changes by entry; first the entry that moves the boundary most."""
        groups: dict[str, list[Variation]] = {}
        for variation in self.others:
            groups.setdefault(variation.key, []).append(variation)
        return dict(sorted(groups.items(), key=lambda item: -self._swing(item[1])))

    def _swing(self, variations: list[Variation]) -> float:
        moved = np.abs([self.changes(variation) for variation in variations])
        return float(np.nanmax(moved)) if np.isfinite(moved).any() else 0.0

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        return {
            "loads": list(self.loads),
            "critical_velocity": list(self.base.critical_velocities),
            "critical_velocity_outcome": list(self.base.outcomes),
            "variations": [
                {
                    "key": variation.key,
                    "value": variation.value,
                    "critical_velocity": list(variation.critical_velocities),
                    "critical_velocity_outcome": list(variation.outcomes),
                    "change": self.changes(variation).tolist(),
                }
                for variation in self.others
            ],
            "points": self.points,
            "contacts": self.contacts,
            "warnings": self.warned.as_dict(),
            "physics": [
                {
                    "key": effect.key[0],
                    "state": effect.state,
                    "size": effect.size,
                    "certainty": effect.certainty,
                    "entry": effect.entry,
                }
                for effect in self.physics
            ],
        }


def vary(
    scene: str | PathLike[str],
    over: Mapping[str, Iterable[Any]],
    preset: str | None = None,
    overrides: Mapping[str, Any] | None = None,
    tolerance: float = 0.01,
    tell: Callable[[str], None] | None = None,
    physics: bool = False,
    own_laws: bool = False,
) -> Variations:
    """Find the boundary of a scene, and of the same with single entries changed.

    Scenes that differ in friction and temperatures alone are simulated once. Those that differ in
    wear rate and thermal constants share the contacts of one product of wear rate and velocity.

    Parameters
    ----------
    scene : path-like
        Scene file, or name of a shipped scene; between its lowest and highest velocity the
        boundary is searched at its loads.
    over : mapping
        Values by the key path of the entry that takes them, one entry at a time: as a scene file
        has them, or such as ``"+20%"`` of the scene's own.
    preset, overrides, own_laws : optional
        See `pipeline.load_scene`.
    tolerance : float
        Relative error of the critical velocity, besides that of the scene's fidelity.
    tell : callable, optional
        Called with a line before each scene: which, of how many, and the time to go; and with
        a note, if the scene has several values of an entry.
    physics : bool
        Add the physics beside the half-spaces: each effect that the scene counts left out, each
        other one with a usual size.

    Raises
    ------
    SceneFileError
        If a scene is faulty with one of the values.
    InputError
        If there is no boundary to look for: no friction, or one velocity alone; or if there is
        nothing to take a percentage of.

    Examples
    --------
    >>> import pipeline
    >>> over = {"pin.radius": ["1 mm", "+20%"], "temperature.bulk": ["40 degC"]}
    >>> variations = pipeline.vary("first_try", over)  # doctest: +SKIP
    """
    overrides = overrides or {}
    sweep = load_scene(scene, preset, overrides, own_laws)
    if sweep.variants.chosen and tell:
        tell(f"note: {note_of(sweep.variants)}")
    others = {
        (key, str(value)): load_scene(scene, preset, {**overrides, key: value}, own_laws)
        for key, values in over.items()
        for value in absolute(scene, key, values, overrides)
    }
    effects = physics_of(sweep) if physics else ()
    others |= {effect.key: effect.scene for effect in effects if effect.scene}
    planes: dict[Scene, _Plane] = {}
    contacts = SharedContacts()

    def scale(variant: Sweep) -> float:
        if not (
            sweep.scene.wear and variant.scene.wear and sweep.scene.wears and variant.scene.wears
        ):
            return 1.0
        return wear_number(variant.scene, 1.0) / wear_number(sweep.scene, 1.0)

    def boundary(key: str, value: str, variant: Sweep) -> Variation:
        plain = variant.changed(variants=Variants())
        plane = planes.setdefault(plain.scene, _Plane(plain, contacts, scale(variant)))
        return Variation(key, value, *plane.boundary(sweep, variant.conditions, tolerance))

    def named(variant: tuple[str, str, Sweep]) -> str:
        return f"{variant[0]} = {variant[1]}" if variant[0] else "the scene as it is"

    scenes = [("", "", sweep), *((*name, scene) for name, scene in others.items())]
    unvaried, *varied = (boundary(*variant) for variant in staged(scenes, tell, named))
    count = sum(len(plane.results) for plane in planes.values())
    warned = _warned(planes.values())
    counts = count, contacts.computed
    return Variations(
        sweep.about.title, sweep.plane.loads, unvaried, tuple(varied), *counts, warned, effects
    )


class _Plane:
    """Points of one scene that were computed; its wear rate is in that of the first scene."""

    def __init__(self, sweep: Sweep, contacts: SharedContacts, scale: float = 1.0) -> None:
        self._sweep, self._contacts, self._scale = sweep, contacts, scale
        self.results: dict[Point, SharedPoint] = {}
        self.beside: set[Point] = set()  # a boundary that was asked for

    def boundary(
        self, asked: Sweep, conditions: Conditions, tolerance: float
    ) -> tuple[tuple[float, ...], tuple[str, ...]]:
        """Critical velocity and outcome at each load under some conditions, by simulation."""
        search = BoundarySearch.of(replace(asked, conditions=conditions), tolerance, self._scale)
        limit, ends = search.limit, (search.lowest, search.highest)
        while wanted := search.wanted(rises := self._rises(conditions)):
            self.results |= self._contacts.points(self._sweep, wanted)
        self.beside.update(_beside(rises, limit))
        velocities, outcomes = zip(
            *(_crossing(rises, load, limit, ends) for load in asked.plane.loads), strict=True
        )
        return velocities, outcomes

    def _rises(self, conditions: Conditions) -> dict[Point, float]:
        return {
            point: float(decisive_rises(result.columns, point.load, conditions))
            for point, result in self.results.items()
        }


def _beside(rises: Mapping[Point, float], limit: float) -> Iterator[Point]:
    """Points with a neighbour in velocity that has the other kind of wear."""
    for one, other in itertools.pairwise(sorted(rises)):
        kinds = {bool(Criterion.is_severe(rises[point], limit)) for point in (one, other)}
        if one.load == other.load and len(kinds) > 1:
            yield from (one, other)


def _warned(planes: Iterable[_Plane]) -> Warned:
    """Count the points that carry a warning, and show one, beside a boundary if there is any."""
    rows = [
        (point not in plane.beside, point, result.warnings)
        for plane in planes
        for point, result in plane.results.items()
        if result.warnings
    ]
    warned = NO_WARNING
    for away, point, warnings in sorted(rows, key=lambda row: row[:2]):
        kinds = {warning.kind.label: 1 for warning in warnings}
        warned += Warned(1, kinds, int(not away), f"{point}: {warnings[0]}")
    return warned


def _crossing(
    rises: Mapping[Point, float], load: float, limit: float, ends: tuple[float, float]
) -> tuple[float, str]:
    """Critical velocity at a load, and the outcome in words."""
    row = sorted((point.velocity, rise) for point, rise in rises.items() if point.load == load)
    velocities, values = np.array(row).T
    crossing = Transition.along(velocities, values, limit, ends)
    return crossing.place, outcomes("velocity")[crossing.outcome]
