"""Attributes of a store: what it belongs to, what computed it, and what its scene says now."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib import metadata
from typing import Any

from pipeline.store.identity import describe, scene_hash
from pipeline.store.schema import FORMAT
from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from tribo import BULK_RATIOS, QUANTILES

_OPTIONAL = ("coordinates", "fixed", "lubrication", "samples", "sample_seed", "unknown")
"""Attributes of a scene that a store has only where there are samples, or an oil."""


def attributes_of(sweep: Sweep, before: Mapping[str, Any] | None) -> dict[str, Any]:
    """Attributes of the store of a sweep, which had others before if it is not new.

    The scene and what computed it stay as they were at its creation, with versions that came later
    beside them; what does not decide the numbers follows the scene file.
    """
    kept = {name: value for name, value in (before or {}).items() if name not in _OPTIONAL}
    kept = kept or _lasting(sweep)
    attributes = _with_present_versions(kept) | _present(sweep) | _entries(sweep, kept)
    # As the root gives them back: JSON knows no tuples.
    plain: dict[str, Any] = json.loads(json.dumps(attributes))
    return plain


def _lasting(sweep: Sweep) -> dict[str, Any]:
    description = describe(sweep)
    return {
        "Conventions": "CF-1.11",
        "format": FORMAT,
        "scene": description,
        "scene_hash": scene_hash(description),
        "versions": versions(),
    }


@functools.cache
def versions() -> dict[str, str]:
    """Versions of the packages that compute and store."""
    try:
        tribo = metadata.version("irg-transition")
    except metadata.PackageNotFoundError:  # run from its source
        tribo = "unknown"
    return {"tribo": tribo} | {name: metadata.version(name) for name in ("numpy", "scipy", "zarr")}


def _with_present_versions(attributes: Mapping[str, Any]) -> dict[str, Any]:
    later = attributes.get("later_versions", [])
    last = later[-1]["versions"] if later else attributes["versions"]
    if last == versions():
        return dict(attributes)
    since = datetime.now(UTC).isoformat(timespec="seconds")
    entry = {"since": since, "versions": versions()}
    return {**attributes, "later_versions": [*later, entry]}


def _present(sweep: Sweep) -> dict[str, Any]:
    """Attributes that follow the scene file.

    The reasons for the fidelity are kept from an earlier run, if this one did not pick it.
    """
    picked = {"selection": sweep.about.selection.as_dict()} if sweep.about.selection else {}
    lubrication = Lubrication.of(sweep)
    oiled = {"lubrication": lubrication.as_dict()} if lubrication else {}
    of_scene = {
        "name": sweep.about.name,
        "title": sweep.about.title,
        "arguments": list(sweep.about.arguments),
        "preset": sweep.about.preset,
        "conditions": sweep.conditions.as_dict(),
        "friction_band": list(sweep.about.friction_band) if sweep.about.friction_band else None,
        "measured": [measurement.as_dict() for measurement in sweep.about.measured],
        "tested": [measurement.as_dict() for measurement in sweep.about.tested],
        "library": [entry._asdict() for entry in sweep.about.sources],
        "loads": list(sweep.plane.loads),
        "velocities": list(sweep.plane.velocities),
        "realizations": list(sweep.variants.realizations),
        "boundary_only": sweep.plane.chosen is not None,
    }
    return picked | oiled | _samples_of(sweep) | of_scene


def _samples_of(sweep: Sweep) -> dict[str, Any]:
    """Unknown inputs and how they were drawn; nothing where there are no samples.

    ``coordinates`` is where readers of CF look for coordinates that are not dimensions.
    """
    if not sweep.variants.samples:
        return {}
    samples = sweep.variants.samples
    paths = (*(quantity.path for quantity in samples.design.inputs), "velocity")
    return {
        "coordinates": " ".join(paths),
        "samples": len(samples),
        "sample_seed": samples.design.seed,
        "unknown": [quantity.as_dict() for quantity in samples.unknown],
        "fixed": [one.as_dict() for one in samples.fixed],
    }


def _entries(sweep: Sweep, stored: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes on the scenes that entries with several values make, if there are any.

    For each combination of values: what is not as in the attributes ``scene`` and the others. Those
    of a store stay, besides what a sweep says of them.
    """
    if not sweep.variants.over:
        return {}
    present = _present(sweep)
    combinations = {tuple(entry["values"]): entry for entry in stored.get("scenes", [])}
    for variant in sweep.variants.entries:
        scene = sweep.variant(variant)
        values = tuple(value for _, value in variant)
        combinations[values] = {
            "values": list(values),
            "written": sweep.variants.over.written(variant),
            "scene": _differing(describe(scene), stored["scene"]),
            "attributes": _differing(_present(scene), present),
        }
    return {
        "over": [axis.path for axis in sweep.variants.over.axes],
        "scenes": [*combinations.values()],
    }


def _differing(values: Mapping[str, Any], usual: Mapping[str, Any]) -> dict[str, Any]:
    """Values that differ from the usual ones; None for what is missing."""
    return {
        name: values.get(name)
        for name in {**usual, **values}
        if values.get(name) != usual.get(name)
    }


def grown_axes(axes: Mapping[str, list[Any]], sweep: Sweep) -> dict[str, list[Any]]:
    """Values along each dimension: those of a store, in their order, then what a sweep adds."""
    chosen = sweep.plane.chosen or ()
    scenes = [sweep.variant(variant) for variant in sweep.variants.entries]
    steps = max(step_count(scene.scene, load) for scene in scenes for load in sweep.plane.loads)

    def widened(name: str, wanted: Iterable[Any]) -> list[Any]:
        present = axes.get(name, [])
        return list(dict.fromkeys([*present, *wanted]))

    leading = {name: widened(name, values) for name, values in sweep.variants.axes.items()}
    velocities = (
        sweep.plane.velocities
        if sweep.plane.chosen is None
        else sorted({p.velocity for p in chosen})
    )
    of_samples = (
        sweep.variants.samples.columns(len(leading["sample"])) if sweep.variants.samples else None
    )
    return (
        leading
        | (of_samples or {"velocity": widened("velocity", velocities)})
        | {
            "load": widened("load", sweep.plane.loads),
            "step": list(range(1, max(steps, len(axes.get("step", []))) + 1)),
            "quantile": list(QUANTILES),
            "bulk_ratio": list(BULK_RATIOS),
            "wear_rate": list(sweep.rates),
            "x": scenes[0].scene.grid.coordinates(0).tolist(),
            "y": scenes[0].scene.grid.coordinates(1).tolist(),
        }
    )
