"""The scenes that come with the program: ``workflows/`` of its source, or of the package."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
_INSTALLED = _PACKAGE / "workflows"

WORKFLOWS = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "workflows"
"""Folder of the shipped scenes: within the package if that was installed, else beside it."""


def shipped_scenes() -> dict[str, Path]:
    """File of each shipped scene, by name."""
    return {path.stem: path for path in sorted(WORKFLOWS.glob("*.toml"))}


def name_of(path: Path) -> str:
    """What to call a scene: a shipped one by its name, without the folder of the package."""
    return path.stem if path == WORKFLOWS / path.name and path.suffix == ".toml" else str(path)


def scene_path(scene: str | PathLike[str], folder: Path = Path()) -> Path:
    """File of a scene that is given by its path from a folder, or by its name if it is shipped."""
    path, shipped = folder / scene, shipped_scenes().get(str(scene))
    return path if shipped is None or path.exists() else shipped
