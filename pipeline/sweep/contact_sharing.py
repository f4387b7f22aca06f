"""Variants that share contacts: each reuses the solutions of the first one with these contacts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from pipeline.sweep.variants import Variant
from tribo import Scene
from tribo.simulation import inseparable, mechanics, wear_number

_DIGITS = 12  # digits of a wear number that are compared: equal numbers differ by rounding


class ContactSource(NamedTuple):
    """The variant whose contact solutions another variant reuses, and at which velocities.

    The source's velocity is `ratio` times the variant's velocity. If each has only one velocity,
    `places` is the pair (variant's velocity, source's velocity) [m/s], and `ratio` is not used.
    """

    variant: Variant
    ratio: float = 1.0  # velocity of the source over the variant's, at the same wear number
    places: tuple[float, float] | None = None  # own velocities of variant and source [m/s]

    def velocity_at(self, velocity: float) -> float | None:
        """Convert `velocity` of the variant that reuses contacts to that of their source [m/s].

        At these two velocities both variants have the same contacts. The result is None if each
        variant has only one velocity, and `velocity` is not that of the reusing variant.
        """
        if self.places:
            own, shared = self.places
            return shared if velocity == own else None
        return velocity if self.ratio == 1 else drop_last_digits(velocity * self.ratio)


def drop_last_digits(number: float) -> float:
    """Round a number to 12 digits, so that equal numbers do not differ by rounding errors."""
    return float(f"{number:.{_DIGITS}g}")


def contact_sources(
    scenes: Iterable[tuple[Variant, Scene]],
    places: Sequence[float | None],
    velocities: Sequence[float],
) -> Mapping[Variant, ContactSource]:
    """Find for each variant the first variant with the same contacts, to reuse the solutions.

    `scenes` are pairs (name, scene) of all variants. `places` has the velocity of each variant with
    a single velocity [m/s], else None. `velocities` are the velocities of all other variants.
    """
    first: dict[tuple[Scene, float | None], tuple[Variant, Scene, Any]] = {}
    sources = {}
    for (name, scene), place in zip(scenes, places, strict=True):
        number_there = None if place is None else drop_last_digits(wear_number(scene, place))
        key = mechanics(scene), number_there
        variant, other, its_place = first.setdefault(key, (name, scene, place))
        slides: list[Sequence[float]]
        if place is None:
            wears = scene.wear and other.wear and scene.wears and other.wears
            ratio = wear_number(scene, 1.0) / wear_number(other, 1.0) if wears else 1.0
            source = ContactSource(variant, ratio)
            slides = [velocities, [ratio * v for v in velocities]]
        else:
            source = ContactSource(variant, places=(place, its_place))
            slides = [(place, its_place)]
        # Contacts may depend on more than the key: `inseparable` says when.
        is_shared = variant != name and not any(inseparable(scene, some) for some in slides)
        sources[name] = source if is_shared else ContactSource(name)
    return sources
