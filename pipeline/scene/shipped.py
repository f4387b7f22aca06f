"""The scenes that come with the program: ``workflows/`` of its source, or of the package."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
_INSTALLED = _PACKAGE / "workflows"

WORKFLOWS = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "workflows"
"""Folder of the shipped scenes: within the package if that was installed, else beside it."""


def shipped_scenes() -> dict[str, Path]:
    """File of each shipped scene, by name.

    Examples
    --------
    >>> "first_try" in shipped_scenes()
    True
    """
    return {path.stem: path for path in sorted(WORKFLOWS.glob("*.toml"))}
