"""Variants that share contacts: each follows the first one with the same contact key."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from pipeline.sweep.variants import Row, Variant
from tribo import Scene
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
    first: dict[tuple[Scene, float | None], tuple[Variant, Scene, Any]] = {}
    leads = {}
    for (name, scene), place in zip(scenes, places, strict=True):
        number_there = None if place is None else drop_last_digits(wear_number(scene, place))
        key = mechanics(scene), number_there
        leader, leading, its_place = first.setdefault(key, (name, scene, place))
        slides: list[Sequence[float]]
        if place is None:
            wears = scene.wear and leading.wear and scene.wears and leading.wears
            ratio = wear_number(scene, 1.0) / wear_number(leading, 1.0) if wears else 1.0
            lead, slides = Lead(leader, ratio), [velocities, [ratio * v for v in velocities]]
        else:
            lead, slides = Lead(leader, places=(place, its_place)), [(place, its_place)]
        # Contacts may depend on more than their key.
        is_shared = leader != name and not any(inseparable(scene, some) for some in slides)
        leads[name] = lead if is_shared else Lead(name)
    return leads


def leads_of_samples(
    samples: Iterable[tuple[Variant, Variant, Row]], scenes: Mapping[Variant, Scene], size: int
) -> Mapping[Variant, Lead]:
    """For each sample the first one of its contact, of which each has `size` samples.

    Samples come with the names of the scenes that they are drawn for. No sample is read.
    """
    same: dict[Scene, Variant] = {}
    alike = {name: same.setdefault(mechanics(scene), name) for name, scene in scenes.items()}
    first: dict[tuple[Variant, int], tuple[Variant, float]] = {}
    leads = {}
    for name, base, row in samples:
        place: Any = row.labels["velocity"]
        key = alike[base], int(row.labels["sample"]) // size
        leader, its_place = first.setdefault(key, (name, place))
        leads[name] = Lead(leader, places=(place, its_place))
    return leads
