"""Scenes and pages that come with the program: `workflows/` of its source or of the package."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from pipeline.paths import user_path

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
    path, shipped = folder / user_path(scene), shipped_scenes().get(str(scene))
    return path if shipped is None or path.exists() else shipped


_OF_SITE = {"index", "API", "COMMANDS"}  # no text of their own to print
_READING_ORDER = (
    "first-hour", "your-system", "your-gears", "your-tests", "choosing", "model", "physics",
    "scene", "dataset", "own-laws", "cluster", "measured", "paper",
)  # fmt: skip
_NAMES = {"README": "paper"}


def shipped_pages() -> dict[str, Path]:
    """File of each page that can be printed, by its name, in the order of reading."""
    paths = (path for path in sorted(WORKFLOWS.glob("*.md")) if path.stem not in _OF_SITE)
    named = {page_name(path): path for path in paths}
    order = dict.fromkeys((*_READING_ORDER, *sorted(named)))
    return {name: named[name] for name in order if name in named}


def page_name(path: Path) -> str:
    """Name of a page, from its file or from what the user typed."""
    return _NAMES.get(path.stem, path.stem.lower().replace("_", "-"))
