"""Rises that decide, of samples: at the end of each hold, by the criterion of the conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import worst_rises
from tribo.types import Array, Mask


def columns_until(
    columns: Mapping[str, Array], loads: Array, hold: float, done: Mask
) -> dict[str, Array] | None:
    """Columns without steps after a hold; None if it ends at no step with a temperature."""
    time, normal_load = columns["time"], columns["normal_load"]
    reached = np.where(normal_load >= loads[:, None], time, np.inf).min(axis=-1, keepdims=True)
    since = time - reached
    is_end = np.isclose(since, hold, rtol=1e-6, atol=1e-9) & np.isfinite(columns["mean_rise"])
    if not is_end.any(axis=-1)[done].all():
        return None
    is_later = since > hold * (1 + 1e-6) + 1e-9
    return {**columns, "normal_load": np.where(is_later, np.nan, normal_load)}


def decisive_rises(
    columns: Mapping[str, Array], loads: Array, conditions: Conditions, shares: Array | None
) -> Array:
    """Decisive rise by sample and load [K]."""
    if shares is None:
        return worst_rises(columns, loads[:, None], conditions)
    rows = [
        worst_rises(
            {name: values[i] for name, values in columns.items()},
            loads[:, None],
            replace(conditions, failing_share=share),
        )
        for i, share in enumerate(shares.tolist())
    ]
    return np.array(rows)
