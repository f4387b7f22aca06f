"""Temperature at the hottest end of a pin that is computed with its ends.

Verdicts are of the whole pin. A pin that is mild as a whole may be severe at an end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from pipeline.sweep.case import known_critical_temperature
from tribo.thermal.quantiles import rise_exceeded
from tribo.types import Array

if TYPE_CHECKING:
    from pipeline.answers.condition_values import QueryPoints
    from pipeline.answers.verdict_model import VerdictModel

_RATIO = "end_rise_ratio"


def end_temperatures(
    model: VerdictModel, points: QueryPoints, temperatures: Array | None = None
) -> dict[str, Any]:
    """Variable ``end_temperature`` at points (k,) [K]; none for a pin without free ends.

    `temperatures` are the governing ones of the whole pin [K], by default the critical one.
    """
    case, bulks = model.case, points.bulk_temperature
    if _RATIO not in case.ds:
        return {}
    if temperatures is None:
        temperatures = np.full(bulks.shape, known_critical_temperature(model.conditions))
    share = model.conditions.critical_area_fraction
    ratios = rise_exceeded(case.array(_RATIO), share, case.ds["area_fraction_below"].values)
    is_known = case.done & (ratios > 0)
    count = is_known.sum(axis=0)
    means = np.where(is_known, ratios, 0.0).sum(axis=0) / np.where(count > 0, count, np.nan)
    ratio = model.field.bilinear(means, points.load, points.velocity)
    return {"end_temperature": bulks + ratio * (temperatures - bulks)}


def is_severe_at_end(points: xr.Dataset) -> xr.DataArray:
    """True where an end of the pin is above the critical temperature, but the whole pin is not."""
    margins = points["temperature_margin"]
    end_margins = points["governing_temperature"] + margins - points["end_temperature"]
    return (margins > 0) & (end_margins < 0)
