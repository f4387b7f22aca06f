"""Wear laws and surfaces of a user's class in a sweep, and what a store keeps of them.

A store keeps the import name of the class, digests of the object's values and code, what answers
need, and the object's ``repr`` for people. So a run that continues the store can compare the law
with that of its own sweep, and reading a store imports nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from pipeline.sweep.codec import NOT_IDENTITY, NOT_STORED
from pipeline.sweep.object_identity import identify
from tribo import InputError, MeasuredRoughness, Scene, Surface, Wear, WearLaw
from tribo.numerics import Grid
from tribo.simulation.lubrication import SurfaceSummary, summarize_surface
from tribo.surface import UnknownHeights, array_digest, surface_heights
from tribo.types import Array
from tribo.wear import WearPattern, evaluate_wear, require_wear

_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


@dataclass(frozen=True, repr=False, kw_only=True)
class UserObject:
    """An object of a user's class, by what a store keeps of it."""

    name: str  # import name of the class
    values: str  # SHA-256, see `object_identity.Identity`
    code: str
    text: str = field(compare=False, metadata=NOT_IDENTITY)  # of the object, for people
    original: Any = field(default=None, compare=False, metadata=NOT_STORED)  # None from a store
    # Packages of its code, which workers get with the object.
    packages: tuple[str, ...] = field(default=(), compare=False, metadata=NOT_STORED)

    def __repr__(self) -> str:
        digests = f"values {self.values[:8]}, code {self.code[:8]}"
        return f"{self.text:.300} of class {self.name} ({digests})"

    def require_original(self) -> Any:
        """The object itself; `InputError` if the sweep was read from a store, which lacks it."""
        if self.original is None:
            raise InputError(f"the store has no code of {self}; run the sweep of its script")
        return self.original


@dataclass(frozen=True, repr=False, kw_only=True)
class UserLaw(UserObject):
    """A wear law of a user's class."""

    pattern: WearPattern

    def mean_wear(self, begin: float, end: float, pressure: float, velocity: float) -> Wear:
        """The wear of the law in a step, see `tribo.WearLaw.mean_wear`."""
        wear: Wear = self.require_original().mean_wear(begin, end, pressure, velocity)
        return wear


@dataclass(frozen=True, repr=False, kw_only=True)
class UserSurface(UserObject, UnknownHeights):
    """A surface of a user's class."""

    summary: SurfaceSummary | None

    def heights(self, pixels: Grid) -> Array:
        """Heights of the surface [m], see `tribo.Surface.heights`."""
        heights: Array = self.require_original().heights(pixels)
        return heights


def user_law(_scene: Scene, law: WearLaw) -> UserLaw:
    """A wear law for a sweep; `InputError` if it fails, or a store cannot keep what it is."""
    require_wear(law)

    def evaluate() -> object:
        return evaluate_wear(law, 0.0, 1e-3, 1e8, 1.0)

    return UserLaw(**_identify_constant("wear law", law, evaluate), pattern=law.pattern)


def user_surface(scene: Scene, surface: Surface) -> UserSurface:
    """A surface for a scene; `InputError` if it fails, or a store cannot keep what it is."""
    if not hasattr(surface, "heights"):
        raise InputError(f"the surface {surface!r:.200} has no heights; see tribo.Surface")

    def evaluate() -> object:
        return array_digest(surface_heights(surface, scene.pixels))

    identity = _identify_constant("surface", surface, evaluate)
    heights = MeasuredRoughness(surface_heights(surface, scene.pixels))
    summary = summarize_surface(replace(scene, roughness=heights))
    return UserSurface(**identity, summary=summary)


def _identify_constant(
    role: str, original: object, evaluate: Callable[[], object]
) -> dict[str, Any]:
    """What a store keeps of an object, whose equal calls must have equal results."""
    _require_module(role, original)
    # The first call may fill what the object computes once, such as a cached property.
    results = [(evaluate(), _identify(role, original)) for _ in range(2)]
    (result, identity), second = results
    if (result, identity) != second:
        raise InputError(
            f"the {role} {identity['text']:.200} changes when it is used; points are simulated in "
            "any order, so write it without random numbers and without values that change"
        )
    return identity


def _require_module(role: str, original: object) -> None:
    """Raise an `InputError` if an object's class is not one of a user's module."""
    cls, text = type(original), _describe(original)
    package = cls.__module__.partition(".")[0]
    if isinstance(original, type):
        raise InputError(f"the {role} {text:.200} is a class; give an object of it")
    if package == "__main__":
        raise InputError(
            f"the {role} {text:.200} is of class {cls.__qualname__} of a script or notebook, which "
            "a store cannot name; save the class in a module, such as laws.py, and import it"
        )
    if package in ("tribo", "pipeline"):
        raise InputError(f"the {role} {text:.200} is not your class; set it in the scene file")


def _describe(original: object) -> str:
    return _ADDRESS.sub("", " ".join(repr(original).split()))


def _identify(role: str, original: object) -> dict[str, Any]:
    """Import name, digests and text of an object, and the object itself."""
    text = _describe(original)
    return {
        "name": f"{type(original).__module__}.{type(original).__qualname__}",
        "text": text,
        **asdict(identify(original, f"the {role} {text:.200}")),
        "original": original,
    }
