"""Extras: folders that nothing else imports. Without the folder of one the rest works."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

EXTRAS: dict[str, tuple[str, ...]] = {"gears": (), "page": ("explore",), "report": ("report",)}
"""Folders in `pipeline` that are asked for commands, if they are there; and their public names."""


@cache
def present() -> tuple[str, ...]:
    """Names of the extras whose folders are there."""
    specs = {name: find_spec(f"pipeline.{name}") for name in EXTRAS}
    # A folder that was emptied, but for caches, has a spec without an origin.
    return tuple(name for name, spec in specs.items() if spec is not None and spec.origin)


def absent() -> frozenset[str]:
    """Public names of `pipeline` whose extras are not there."""
    return frozenset(one for name in EXTRAS.keys() - present() for one in EXTRAS[name])


def modules(part: str) -> Iterator[ModuleType]:
    """Modules of one name, such as ``commands``, of all extras that are there."""
    for name in present():
        yield import_module(f"pipeline.{name}.{part}")
