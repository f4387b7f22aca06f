"""What tests say of the critical temperature of the lubricant."""

from __future__ import annotations

import math
from typing import Unpack

import numpy as np
import xarray as xr
from scipy.special import logsumexp

from pipeline.answers.conditions import ConditionValues, judged
from pipeline.answers.judge import JudgedCase
from pipeline.answers.results import cases_of
from pipeline.answers.tests import outcome_of
from pipeline.constants import WORTH
from pipeline.store.place import PathLike
from tribo import InputError

_USUAL = 120.0  # K above the bulk, about which the search goes without a critical temperature
_TAILS = math.sqrt(2)  # standard deviation of Student's t with 4 degrees, over its scale


@np.errstate(under="ignore")
def infer(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Find the critical temperature of the lubricant from the tests of a scene.

    Nothing is known before the tests of ln(critical − bulk temperature) but a scale of 1. The
    likelihood is that of `margin`, with another critical temperature in place of the bias.

    Returns
    -------
    Dataset
        ``critical_temperature``; ``spread_another_rig``, its standard deviation on another rig,
        with the model's bias in it, and ``spread_this_rig`` on this one; ``at_least`` and
        ``at_most``, where only mild or only severe tests bound it: its 5 or 95 % quantile.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.infer("results/first_try.zarr")
    >>> (found["critical_temperature"] - 273.15).round(1).item()
    139.8
    """
    case = cases_of(ds)[0]
    stored = case.sweep.conditions
    own = judged(stored, conditions)
    bulk = own.bulk_temperature
    if own.critical_temperature is None:
        own = judged(stored, {**conditions, "critical_temperature": own.bulk_temperature + _USUAL})
    judge = JudgedCase(case).under(own)
    specimens = [outcome_of(rows) for rows in judge.evidence.specimens]
    if not specimens:
        raise InputError(f"the scene {case.sweep.name} has no test with a result; give it some")
    shifts = np.linspace(-4, 4, 1601)  # of ln(critical − bulk)
    above = (own.critical_temperature or 0) - bulk
    v = np.linspace(math.log(0.05 * judge.evidence.prior.scatter), math.log(50), 200)
    scale = judge.evidence.prior.scatter
    log_scatter = -WORTH * v - WORTH * scale**2 / (2 * np.exp(2 * v))
    logs = log_scatter - (WORTH + 1) / 2 * np.log1p(shifts[:, None] ** 2 / WORTH)
    for one in specimens:
        logs = logs + one.log_likelihood(-shifts[:, None], np.exp(v))
    share = np.exp(logsumexp(logs, axis=1))
    share /= share.sum()
    mean = float(share @ shifts)
    spread = math.sqrt(float(share @ (shifts - mean) ** 2))
    below = np.cumsum(share)
    ends = [above * math.exp(shifts[np.searchsorted(below, one)]) + bulk for one in (0.05, 0.95)]
    is_mild, is_severe = (
        any(math.isfinite(getattr(one, side)) for one in specimens) for side in ("mild", "severe")
    )
    centre = above * math.exp(mean)
    values = {
        "critical_temperature": bulk + centre,
        "spread_another_rig": centre * math.hypot(spread, _TAILS * judge.evidence.prior.bias),
        "spread_this_rig": centre * spread,
        "at_least": math.nan if is_severe else ends[0],
        "at_most": math.nan if is_mild else ends[1],
    }
    return xr.Dataset({name: ((), value, {"units": "K"}) for name, value in values.items()})
