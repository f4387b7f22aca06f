"""Parts above the core that add commands, forms of entries and readers of files to it."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

_PARTS = "laboratory", "workflows"


def modules(name: str) -> Iterator[ModuleType]:
    """Import and yield each module called `name`, such as ``commands``, of the parts."""
    for part in _PARTS:
        # The package of the shipped scenes lies beside `pipeline` in a checkout.
        for package in (f"pipeline.{part}", part):
            if find_spec(package) and find_spec(f"{package}.{name}"):
                yield import_module(f"{package}.{name}")
                break


def module(name: str) -> ModuleType:
    """The first module of this name."""
    return next(modules(name))
