"""Contacts that several variants share: the key of a contact, and which variant leads it.

A contact depends on what `mechanics` keeps of a scene and on the product of wear rate and
velocity. Variants that agree in both have the same contacts, whoever made them; one ramp leads them
all, and heat is computed for each.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from pipeline.sweep.variants import Variant
from tribo import Scene
from tribo.simulation import inseparable, mechanics, wear_number

_DIGITS = 12  # of a wear number: two that ought to be the same differ by rounding


class Lead(NamedTuple):
    """The variant whose ramp of contacts another one shares, and at which velocity.

    Examples
    --------
    >>> Lead((), ratio=2.0).velocity_for(0.5)
    1.0
    """

    variant: Variant
    ratio: float = 1.0  # of its velocity to that of the other, with the same wear number
    places: tuple[float, float] | None = None  # velocities of both, if they have one each [m/s]

    def velocity_for(self, velocity: float) -> float | None:
        """Velocity of the leading variant with the contacts of another at its velocity [m/s].

        None for a variant that has a place of its own, at another velocity.
        """
        if self.places:
            own, leading = self.places
            return leading if velocity == own else None
        return velocity if self.ratio == 1 else rounded(velocity * self.ratio)


def rounded(number: float) -> float:
    """A number without the rounding of the last digits."""
    return float(f"{number:.{_DIGITS}g}")


def leads_of(
    scenes: Iterable[tuple[Variant, Scene]],
    places: Sequence[float] | None,
    velocities: Sequence[float],
) -> Mapping[Variant, Lead]:
    """For each variant the first one with its contacts, by the key of its contacts.

    Variants share the velocities of a plane, or each has a place of its own [m/s].
    """
    first: dict[tuple[Scene, float | None], tuple[Variant, Scene, float | None]] = {}
    leads = {}
    for number, (name, scene) in enumerate(scenes):
        place = places[number] if places is not None else None
        key = mechanics(scene), None if place is None else rounded(wear_number(scene, place))
        leader, leading, its_place = first.setdefault(key, (name, scene, place))
        if leader == name:
            leads[name] = Lead(name)
        elif place is not None and its_place is not None:
            is_shared = inseparable(scene, (place, its_place)) is None
            leads[name] = Lead(leader, places=(place, its_place)) if is_shared else Lead(name)
        else:
            leads[name] = _on_plane(name, scene, leader, leading, velocities)
    return leads


def _on_plane(
    name: Variant, scene: Scene, leader: Variant, leading: Scene, velocities: Sequence[float]
) -> Lead:
    """Lead of a variant by another one that has the same plane."""
    if inseparable(scene, velocities) is not None:
        return Lead(name)  # contacts depend on more than their key
    wears = scene.wear and leading.wear and scene.wears and leading.wears
    ratio = wear_number(scene, 1.0) / wear_number(leading, 1.0) if wears else 1.0
    is_shared = inseparable(scene, [ratio * velocity for velocity in velocities]) is None
    return Lead(leader, ratio) if is_shared else Lead(name)
