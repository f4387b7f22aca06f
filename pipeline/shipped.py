"""Scenes and pages that come with the program: `workflows/` of its source or of the package."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from pipeline.paths import user_path

_PACKAGE = Path(__file__).parent
_INSTALLED = _PACKAGE / "workflows"

WORKFLOWS = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "workflows"
"""Folder of the shipped scenes: in the package if it is installed, else next to its source."""


def shipped_scenes() -> dict[str, Path]:
    """File of each shipped scene, by name."""
    return {path.stem: path for path in sorted(WORKFLOWS.glob("*.toml"))}


def name_of(path: Path) -> str:
    """Name of a scene in messages: its name if it is shipped, else its path."""
    return path.stem if path == WORKFLOWS / path.name and path.suffix == ".toml" else str(path)


def scene_path(scene: str | PathLike[str], folder: Path = Path()) -> Path:
    """File of a scene, given by its path from a folder, or by its name if it is shipped."""
    path, shipped = folder / user_path(scene), shipped_scenes().get(str(scene))
    return path if shipped is None or path.exists() else shipped


PAGES_BY_TASK = {
    "begin": ("install", "first-hour"),
    "compute your own contact": (
        "scenes",
        "your-system",
        "designers",
        "scene",
        "own-laws",
        "cluster",
    ),
    "use tests of a laboratory": ("your-tests",),
    "know how accurate answers are, and how long they take": ("choosing", "measured"),
    "understand the model": ("model", "physics", "reproducing", "paper"),
    "look up": ("library", "glossary", "commands", "api", "dataset"),
}
"""Names of the pages that ``irg help`` prints, by what a reader wants to do."""


def shipped_pages() -> dict[str, Path]:
    """File of each page that ``irg help`` prints, by name, in the order of `PAGES_BY_TASK`."""
    pages = {page_name(path): path for path in WORKFLOWS.glob("*.md")}
    ordered = (name for names in PAGES_BY_TASK.values() for name in names)
    return {name: pages[name] for name in ordered if name in pages}


def page_name(path: Path) -> str:
    """Convert the path of a Markdown file to the name of its page in ``irg help``.

    ``FIRST_HOUR.md`` becomes "first-hour". A path made of typed text is converted likewise.
    """
    return "paper" if path.stem == "README" else path.stem.lower().replace("_", "-")


def typed_name(scene: str) -> str:
    """Scene of this name as typed in a command: a shipped one, or a file of the same name."""
    return scene if scene in shipped_scenes() else f"{scene}.toml"
