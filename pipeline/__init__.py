"""Sweeps of the load–velocity plane: scene files, cluster, store, boundary and figures.

Names are loaded when first used, so that importing the package costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipeline.analysis.boundary import boundary, decisive_temperature
    from pipeline.analysis.dataset import end_of_point, open_sweep
    from pipeline.analysis.inference import CriticalTemperatures, critical_temperatures
    from pipeline.analysis.warned import warned
    from pipeline.figures.plot import plot
    from pipeline.figures.style import figure_path, save_figure
    from pipeline.figures.tradeoff import draw_trade
    from pipeline.paper import RESULTS, reproduce, write_gallery
    from pipeline.run.follow import follow_boundary
    from pipeline.run.sweep import run_sweep
    from pipeline.scene.faults import SceneFileError
    from pipeline.scene.scenefile import load_scene
    from pipeline.scene.units import display, to_si
    from pipeline.store.compact import compact_store
    from pipeline.store.points import StoreError, StoreMismatchError
    from pipeline.store.progress import summary
    from pipeline.store.verify import verify_store
    from pipeline.sweep.criterion import Conditions
    from pipeline.sweep.model import Measurement, Sweep
    from pipeline.sweep.plan import run_point
    from pipeline.tradeoff.choose import at_accuracy, choose_fidelity, stored_selection
    from pipeline.tradeoff.forecast import estimate
    from pipeline.tradeoff.trade import trade

_HOMES = {
    "RESULTS": "paper",
    "Conditions": "sweep.criterion",
    "CriticalTemperatures": "analysis.inference",
    "Measurement": "sweep.model",
    "SceneFileError": "scene.faults",
    "StoreError": "store.points",
    "StoreMismatchError": "store.points",
    "Sweep": "sweep.model",
    "at_accuracy": "tradeoff.choose",
    "boundary": "analysis.boundary",
    "choose_fidelity": "tradeoff.choose",
    "compact_store": "store.compact",
    "critical_temperatures": "analysis.inference",
    "decisive_temperature": "analysis.boundary",
    "display": "scene.units",
    "draw_trade": "figures.tradeoff",
    "end_of_point": "analysis.dataset",
    "estimate": "tradeoff.forecast",
    "figure_path": "figures.style",
    "follow_boundary": "run.follow",
    "load_scene": "scene.scenefile",
    "open_sweep": "analysis.dataset",
    "plot": "figures.plot",
    "reproduce": "paper",
    "run_point": "sweep.plan",
    "run_sweep": "run.sweep",
    "save_figure": "figures.style",
    "stored_selection": "tradeoff.choose",
    "summary": "store.progress",
    "to_si": "scene.units",
    "trade": "tradeoff.trade",
    "verify_store": "store.verify",
    "warned": "analysis.warned",
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
    "warned",
    "write_gallery",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'pipeline' has no attribute {name!r}")
    return getattr(importlib.import_module(f"pipeline.{_HOMES[name]}"), name)
