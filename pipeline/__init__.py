"""Sweeps of the load–velocity plane: scene files, cluster, store, boundary and figures.

Names are loaded when first used, so that importing the package costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipeline.boundaries import boundary, decisive_temperature
    from pipeline.dataset import end_of_point, open_sweep
    from pipeline.cost import estimate
    from pipeline.execute import run_sweep
    from pipeline.figures import plot
    from pipeline.plan import run_point
    from pipeline.scenefile import SceneFileError, load_scene
    from pipeline.store import StoreError, StoreMismatchError, summary
    from pipeline.sweep import Conditions, Measurement, Sweep
    from pipeline.units import display, to_si

_HOMES = {
    "Conditions": "sweep",
    "Measurement": "sweep",
    "SceneFileError": "scenefile",
    "StoreError": "store",
    "StoreMismatchError": "store",
    "Sweep": "sweep",
    "boundary": "boundaries",
    "decisive_temperature": "boundaries",
    "display": "units",
    "end_of_point": "dataset",
    "estimate": "cost",
    "load_scene": "scenefile",
    "open_sweep": "dataset",
    "plot": "figures",
    "run_point": "plan",
    "run_sweep": "execute",
    "summary": "store",
    "to_si": "units",
}

__all__ = [
    "Conditions",
    "Measurement",
    "SceneFileError",
    "StoreError",
    "StoreMismatchError",
    "Sweep",
    "boundary",
    "decisive_temperature",
    "display",
    "end_of_point",
    "estimate",
    "load_scene",
    "open_sweep",
    "plot",
    "run_point",
    "run_sweep",
    "summary",
    "to_si",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'pipeline' has no attribute {name!r}")
    return getattr(importlib.import_module(f"pipeline.{_HOMES[name]}"), name)
