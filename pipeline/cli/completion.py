"""What a shell offers for some arguments, with argcomplete: names, beside its own files."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def _scenes(**_: Any) -> list[str]:
    from pipeline.scene.shipped import shipped_scenes

    return [*shipped_scenes(), *map(str, Path().glob("*.toml"))]


def _presets(**_: Any) -> list[str]:
    from tribo import PRESETS

    return [*PRESETS]


def _pages(**_: Any) -> list[str]:
    from pipeline.scene.shipped import shipped_pages

    return [*shipped_pages()]


def _entries(**_: Any) -> list[str]:
    from pipeline.scene.reference import sections

    listed = (section for section in sections() if not section.is_list)
    return [f"{section.path_of(key)}=" for section in listed for key in [*section.keys()]]


OFFERED = {"scene": _scenes, "preset": _presets, "topic": _pages, "set": _entries, "at": _entries}
"""What argcomplete asks for the names offered for an argument, by its destination."""
