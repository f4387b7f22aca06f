"""Sweeps of the load–velocity plane: scene files, cluster, store, boundary and figures.

Names are loaded when first used, so that importing the package costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipeline.accuracy import at_accuracy, choose_fidelity, stored_selection
    from pipeline.boundaries import boundary, decisive_temperature
    from pipeline.compact import compact_store
    from pipeline.cost import estimate
    from pipeline.dataset import end_of_point, open_sweep
    from pipeline.execute import run_sweep
    from pipeline.figures import plot
    from pipeline.follow import follow_boundary
    from pipeline.inference import CriticalTemperatures, critical_temperatures
    from pipeline.paper import RESULTS, reproduce, write_gallery
    from pipeline.plan import run_point
    from pipeline.scenefile import SceneFileError, load_scene
    from pipeline.store import StoreError, StoreMismatchError
    from pipeline.style import figure_path, save_figure
    from pipeline.summaries import summary
    from pipeline.sweep import Conditions, Measurement, Sweep
    from pipeline.tradeoff import trade
    from pipeline.tradeoff_figure import draw_trade
    from pipeline.units import display, to_si
    from pipeline.verify import verify_store

_HOMES = {
    "RESULTS": "paper",
    "Conditions": "sweep",
    "CriticalTemperatures": "inference",
    "Measurement": "sweep",
    "SceneFileError": "scenefile",
    "StoreError": "store",
    "StoreMismatchError": "store",
    "Sweep": "sweep",
    "at_accuracy": "accuracy",
    "boundary": "boundaries",
    "choose_fidelity": "accuracy",
    "compact_store": "compact",
    "critical_temperatures": "inference",
    "decisive_temperature": "boundaries",
    "display": "units",
    "draw_trade": "tradeoff_figure",
    "end_of_point": "dataset",
    "estimate": "cost",
    "figure_path": "style",
    "follow_boundary": "follow",
    "load_scene": "scenefile",
    "open_sweep": "dataset",
    "plot": "figures",
    "reproduce": "paper",
    "run_point": "plan",
    "run_sweep": "execute",
    "save_figure": "style",
    "stored_selection": "accuracy",
    "summary": "summaries",
    "to_si": "units",
    "trade": "tradeoff",
    "verify_store": "verify",
    "write_gallery": "paper",
}

__all__ = [
    "RESULTS",
    "Conditions",
    "CriticalTemperatures",
    "Measurement",
    "SceneFileError",
    "StoreError",
    "StoreMismatchError",
    "Sweep",
    "at_accuracy",
    "boundary",
    "choose_fidelity",
    "compact_store",
    "critical_temperatures",
    "decisive_temperature",
    "display",
    "draw_trade",
    "end_of_point",
    "estimate",
    "figure_path",
    "follow_boundary",
    "load_scene",
    "open_sweep",
    "plot",
    "reproduce",
    "run_point",
    "run_sweep",
    "save_figure",
    "stored_selection",
    "summary",
    "to_si",
    "trade",
    "verify_store",
    "write_gallery",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'pipeline' has no attribute {name!r}")
    return getattr(importlib.import_module(f"pipeline.{_HOMES[name]}"), name)
