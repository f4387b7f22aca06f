"""What a shell offers for some arguments, with argcomplete: names, beside its own files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any


def _scenes() -> Iterable[str]:
    from pipeline.scene.shipped import shipped_scenes

    return [*shipped_scenes(), *map(str, Path().glob("*.toml"))]


def _presets() -> Iterable[str]:
    from tribo import PRESETS

    return PRESETS


def _pages() -> Iterable[str]:
    from pipeline.scene.shipped import shipped_pages

    return shipped_pages()


def _entries() -> Iterable[str]:
    from pipeline.scene.reference import sections

    listed = (section for section in sections() if not section.is_list)
    return [f"{section.path_of(key)}=" for section in listed for key in [*section.keys()]]


_OFFERED = {"scene": _scenes, "preset": _presets, "topic": _pages, "set": _entries, "at": _entries}
"""Names offered for an argument, by its destination."""


def completer(destination: str) -> Callable[..., Iterable[str]] | None:
    """What argcomplete asks for the values of an argument; None where it offers files."""
    offered = _OFFERED.get(destination)
    if offered is None:
        return None

    def complete(prefix: str, **_: Any) -> Iterable[str]:
        return [name for name in offered() if name.startswith(prefix)]

    return complete
