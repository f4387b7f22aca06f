"""What computed a store, for people and for reproducing it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from importlib import metadata


@functools.cache
def package_versions() -> dict[str, str]:
    """Versions of the packages that compute and store."""
    try:
        tribo = metadata.version("irg-transition")
    except metadata.PackageNotFoundError:  # run from its source
        tribo = "unknown"
    return {"tribo": tribo} | {name: metadata.version(name) for name in ("numpy", "scipy", "zarr")}


def provenance(
    versions: Mapping[str, str],
    later: Mapping[str, Mapping[str, str]],
    workers: Mapping[str, Mapping[str, str]],
) -> dict[str, str]:
    """Attributes on the program that computed a store, by versions and the times they came at."""

    def listed(versions: Mapping[str, str]) -> str:
        others = ", ".join(f"{name} {it}" for name, it in versions.items() if name != "tribo")
        return f"irg-transition {versions.get('tribo')} with {others}"

    lines = [f"computed by {listed(versions)}"]
    lines += [f"{since}: gone on with by {listed(others)}" for since, others in later.items()]
    for since, others in workers.items():
        named = ", ".join(f"{name} {version}" for name, version in others.items())
        lines.append(f"{since}: some points computed by workers with {named}")
    return {
        "source": f"simulated by irg-transition {versions.get('tribo')}",
        "history": "\n".join(lines),
        "license": "BSD-3-Clause for the program that computed this; the data are their author's",
    }
