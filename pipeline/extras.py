"""Extras: optional parts of the program. If the folder of one is missing, the rest works."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

EXTRAS: dict[str, tuple[str, ...]] = {
    "laboratory": ("surface_statistics",),
    "page": ("explore",),
}
"""Extras by the names of their folders in `pipeline`, with the public names of each."""
STUDIES = "pipeline.workflows", "workflows"
"""Package of shipped scenes, which has a command: its names when installed and in a checkout."""


@cache
def present() -> tuple[str, ...]:
    """Names of the optional parts that are installed, from their folders."""
    return tuple(name for name in EXTRAS if _is_there(f"pipeline.{name}"))


def _is_there(package: str) -> bool:
    spec = find_spec(package)
    # A folder that was emptied, but for caches, has a spec without an origin.
    return spec is not None and bool(spec.origin)


def absent() -> frozenset[str]:
    """Public names of `pipeline` whose optional parts are not installed."""
    return frozenset(one for name in EXTRAS.keys() - present() for one in EXTRAS[name])


def modules(name: str) -> Iterator[ModuleType]:
    """Import and yield each module called `name`, such as ``commands``.

    They belong to the optional parts of the program, and to the package of its shipped scenes.
    """
    studies = next((one for one in STUDIES if _is_there(one)), "pipeline")
    for part in (*(f"pipeline.{one}" for one in present()), studies):
        if find_spec(f"{part}.{name}"):
            yield import_module(f"{part}.{name}")


def module(name: str) -> ModuleType:
    """Import the module `name`, such as ``fields``, of the first optional part that has one.

    Raises an `InputError` if no installed part has a module of this name.
    """
    for one in modules(name):
        return one
    from tribo import InputError  # with NumPy, which importing the package does not need

    lacking = " or ".join(f"pipeline/{name}" for name in EXTRAS if name not in present())
    raise InputError(
        f"this needs an extra that is not there; put back its folder, {lacking}, or install the "
        "package again"
    )
