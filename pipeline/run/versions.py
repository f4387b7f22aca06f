"""Versions that decide the numbers: of the code of `tribo` and `pipeline`, Python, NumPy and SciPy.

A worker on another machine, or one that was started before the code changed, may run other code
than its driver. Its numbers must not enter the same store.
"""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import scipy

import tribo

Versions = Mapping[str, str]

_FOLDERS = (Path(tribo.__file__).parent, Path(__file__).parents[1])
_PACKAGES = ("python", "numpy", "scipy")


def hash_of_code(folders: Iterable[Path] = _FOLDERS) -> str:
    """Hash of the source files of packages, by their names and contents."""
    digest = hashlib.sha256()
    for folder in folders:
        for file in sorted(folder.rglob("*.py")):
            name = os.fspath(file.relative_to(folder.parent))
            digest.update(f"{name} {file.stat().st_size}\n".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


# Taken as this module is imported, so that a process that runs on after its files have changed
# names the code that it runs, and not the files.
_HERE: Versions = {
    "code": hash_of_code(),
    "numpy": np.__version__,
    "scipy": scipy.__version__,
    "python": platform.python_version(),
    "folder": os.fspath(_FOLDERS[1].parent),
}


def versions() -> Versions:
    """Versions of this process, and the folder that its code was loaded from."""
    return _HERE


def packages_of(theirs: Versions) -> dict[str, str]:
    """Versions of Python, NumPy and SciPy alone."""
    return {name: theirs[name] for name in _PACKAGES}


def other_packages(theirs: Versions) -> str:
    """Differences in Python, NumPy and SciPy between a worker and this process, in words."""
    return ", ".join(
        f"{name} {version} (here {_HERE[name]})"
        for name, version in packages_of(theirs).items()
        if version != _HERE[name]
    )
