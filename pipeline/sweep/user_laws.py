"""Wear laws and surfaces of a user's class in a sweep, and what a store keeps of them.

A store keeps the import name of the class, the text of the object (its ``repr``), a digest of the
class's source, and what answers need. So a run that continues the store can compare the law with
that of its own sweep, and reading a store imports nothing.
"""

from __future__ import annotations

import hashlib
import inspect
import re
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.sweep.codec import NOT_STORED
from tribo import InputError, MeasuredRoughness, Scene, Surface, Wear, WearLaw
from tribo.numerics import Grid
from tribo.simulation.lubrication import SurfaceSummary, summarize_surface
from tribo.surface import UnknownHeights, surface_heights
from tribo.types import Array
from tribo.wear import WearPattern, evaluate_wear, require_wear

_UNCLEAR = re.compile(r"at 0x[0-9a-fA-F]+|\.\.\.")  # parts of a text that do not state values


@dataclass(frozen=True, repr=False, kw_only=True)
class UserObject:
    """An object of a user's class, by what a store keeps of it."""

    name: str  # import name of the class
    text: str  # of the object
    source: str  # SHA-256 of the source of the class
    original: Any = field(default=None, compare=False, metadata=NOT_STORED)  # None from a store

    def __repr__(self) -> str:
        return f"{self.text:.300} of class {self.name} (source {self.source[:8]})"

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
    user_law = UserLaw(**_identify("wear law", law), pattern=law.pattern)
    evaluate_wear(law, 0.0, 1e-3, 1e8, 1.0)
    if (text := _identify("wear law", law)["text"]) != user_law.text:
        raise InputError(
            f"the wear law {user_law.text} becomes {text} when it is used; points are simulated in "
            "any order, so write a law without a state that changes"
        )
    return user_law


def user_surface(scene: Scene, surface: Surface) -> UserSurface:
    """A surface for a scene; `InputError` if it fails, or a store cannot keep what it is."""
    if not hasattr(surface, "heights"):
        raise InputError(f"the surface {surface!r:.200} has no heights; see tribo.Surface")
    identity = _identify("surface", surface)
    heights = MeasuredRoughness(surface_heights(surface, scene.pixels))
    summary = summarize_surface(replace(scene, roughness=heights))
    return UserSurface(**identity, summary=summary)


def _identify(role: str, original: object) -> dict[str, Any]:
    """Import name, text and digest of the source of an object, and the object itself."""
    cls, text = type(original), " ".join(repr(original).split())
    if isinstance(original, type):
        raise InputError(f"the {role} {text:.200} is a class; give an object of it")
    package = cls.__module__.partition(".")[0]
    if package == "__main__":
        raise InputError(
            f"the {role} {text:.200} is of class {cls.__qualname__} of a script or notebook, which "
            "a store cannot name; save the class in a module, such as laws.py, and import it"
        )
    if package in ("tribo", "pipeline"):
        raise InputError(f"the {role} {text:.200} is not your class; set it in the scene file")
    if match := _UNCLEAR.search(text):
        raise InputError(
            f"the {role} {text:.200} does not print its values, but has {match[0]!r}; give class "
            f"{cls.__qualname__} a __repr__ with all values, such as that of a dataclass"
        )
    # A change of a base class in the same package changes the law, too.
    classes = [base for base in cls.__mro__ if base.__module__.partition(".")[0] == package]
    try:
        source = "".join(map(inspect.getsource, classes))
    except (OSError, TypeError):
        raise InputError(
            f"the {role} {text:.200} is of class {cls.__qualname__}, whose source cannot be found; "
            "save the class in a module, such as laws.py, and import it"
        ) from None
    digest = hashlib.sha256(source.encode()).hexdigest()
    name = f"{cls.__module__}.{cls.__qualname__}"
    return {"name": name, "text": text, "source": digest, "original": original}
