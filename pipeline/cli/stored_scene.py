"""The scene of a store of samples, with other values of its inputs, for direct simulations."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import pipeline
from pipeline.analysis.attributes import attributes_of
from pipeline.cli.values import setting
from pipeline.store.identity import describe, scene_hash
from tribo import InputError

if TYPE_CHECKING:
    import xarray as xr

    from pipeline.uncertain.direct import SceneWith


def scene_with_of(ds: xr.Dataset) -> SceneWith:
    """Reader of the scene of a store with other entries, if its file is still the same."""
    attributes = attributes_of(ds)
    path, *words = attributes.get("arguments") or [""]
    given = [setting(word.removeprefix("--set=")) for word in words if word.startswith("--set=")]
    presets = [word.removeprefix("--preset=") for word in words if word.startswith("--preset=")]
    settings, preset = dict(given), presets[0] if presets else None
    if any("hash" in part for part in attributes["scene"].values() if isinstance(part, dict)):
        raise InputError("it has laws of its own, and no code runs because a store names it")
    read = partial(pipeline.load_scene, path, preset)  # also without the user's own laws
    if not path or scene_hash(describe(read(settings))) != attributes["scene_hash"]:
        raise InputError(f"{path or 'the scene'} is not the scene of the store any more")
    left_out = settings.pop("without", [])
    left_out = [left_out] if isinstance(left_out, str) else left_out
    alone = {"without": [*left_out, "unknown", "sweep.samples"]}
    return lambda entries: read(settings | alone | dict(entries))
