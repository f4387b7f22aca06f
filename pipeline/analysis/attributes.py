"""Attributes of a dataset that any format of file can hold: text and numbers alone."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from typing import Any

import xarray as xr

_ENCODED = "json_attributes"
_decoded = functools.lru_cache(maxsize=64)(json.loads)  # each surface has the attributes of all
_INTERNAL = ("axes", "root_hash", "points_per_chunk", "generation")


def portable(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Write a store's attributes so that netCDF holds them, and say what computed the data.

    What is neither text nor a number becomes JSON; `attributes_of` reads it again.
    """
    kept = {k: v for k, v in attributes.items() if v is not None and k not in _INTERNAL}
    plain = (name for name, value in kept.items() if type(value) in (str, int, float))
    encoded = sorted(kept.keys() - set(plain))
    return (
        kept
        | {name: json.dumps(kept[name], ensure_ascii=False) for name in encoded}
        | {_ENCODED: " ".join(encoded)}
        | _provenance(attributes)
    )


def with_changes(attributes: Mapping[Any, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Portable attributes with some in place of others, or without those that are None."""
    new = portable(changes)
    names = {*str(attributes.get(_ENCODED, "")).split(), *new[_ENCODED].split()}
    kept = {name: value for name, value in attributes.items() if name not in changes}
    return kept | new | {_ENCODED: " ".join(sorted(names & {*kept, *new}))}


def attributes_of(ds: xr.Dataset | xr.DataArray) -> dict[Any, Any]:
    """Attributes of a sweep as plain data, those that are JSON text as what they say.

    What they say is kept for the next call, and not to be changed.

    Examples
    --------
    >>> import xarray as xr
    >>> attributes_of(xr.Dataset(attrs=portable({"measured": [{"friction": 0.1}]})))["measured"]
    [{'friction': 0.1}]
    """
    attributes = dict(ds.attrs)
    for name in str(attributes.get(_ENCODED, "")).split():
        if isinstance(attributes.get(name), str):
            attributes[name] = _decoded(attributes[name])
    return attributes


def _provenance(attributes: Mapping[Any, Any]) -> dict[str, str]:
    """Versions that computed a store, and the times at which others went on with it."""
    versions = attributes.get("versions")
    if not versions:
        return {}

    def listed(versions: Mapping[str, str]) -> str:
        others = ", ".join(f"{name} {it}" for name, it in versions.items() if name != "tribo")
        return f"irg-transition {versions['tribo']} with {others}"

    later = attributes.get("later_versions", [])
    lines = [f"computed by {listed(versions)}"]
    lines += [f"{entry['since']}: gone on with by {listed(entry['versions'])}" for entry in later]
    for entry in attributes.get("worker_versions", []):
        others = ", ".join(f"{name} {version}" for name, version in entry["versions"].items())
        lines.append(f"{entry['since']}: some points computed by workers with {others}")
    return {
        "source": f"simulated by irg-transition {versions['tribo']}",
        "history": "\n".join(lines),
        "license": "BSD-3-Clause for the program that computed this; the data are their author's",
    }
