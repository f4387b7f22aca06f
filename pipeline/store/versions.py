"""Versions of the packages that computed a store, for people and for reproducing it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from importlib import metadata


@functools.cache
def package_versions() -> dict[str, str]:
    """Versions of the packages that compute and store, by name."""
    try:
        own = metadata.version("irg-transition")
    except metadata.PackageNotFoundError:  # run from its source
        own = "unknown"
    names = ("numpy", "scipy", "zarr")
    return {"irg-transition": own} | {name: metadata.version(name) for name in names}


def in_words(versions: Mapping[str, str]) -> str:
    """Write package versions as text, such as "numpy 2.1, scipy 1.15"."""
    return ", ".join(f"{name} {version}" for name, version in versions.items())
