"""Sentences on answers, made from their records, for terminal, page and captions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
import xarray as xr

from pipeline.analysis.margin import PASSED, Margin
from pipeline.analysis.scenes import attribute_values
from pipeline.analysis.transition import outcomes
from pipeline.quantities import UNITS, display, shown_in
from pipeline.sweep.remarks import remarks

ONSET = "the median is not the onset: the hottest patch under the pin scuffs first"
"""Caveat on the median over surfaces."""


def model_error_line(errors: Iterable[str]) -> str:
    """Line of text on the model's own error, from the errors of all scenes.

    It states the first, and the number of different others.
    """
    first, *others = dict.fromkeys(errors)
    return f"the model's own error: {first}" + f", and {len(others)} more" * bool(others)


def missing_lines(missing: int) -> list[str]:
    """Line of text with the number of points that are `missing`; empty list if all are done."""
    return [f"{missing} points are pending or failed and were left out"] * bool(missing)


def boundary_lines(boundaries: xr.Dataset) -> list[str]:
    """Lines of text to print below a boundary: model's own error, median, missing points."""
    return [
        model_error_line(attribute_values(boundaries, "model_error")),
        *([ONSET] if "realization" in boundaries.dims else []),
        *missing_lines(boundaries.attrs["missing_points"]),
    ]


def next_run_line(boundary: xr.Dataset) -> str:
    """Sentence on the velocities below which a further run is mild, and above which severe.

    They are stated at the lowest and the highest load.
    """
    said = []
    for load in dict.fromkeys(boundary["load"].values[[0, -1]].tolist()):
        here = boundary.sel(load=load)
        low, high = here["mild_below"].item(), here["severe_above"].item()
        ends = [
            f"{kind} {f'{side} {end:.3g} m/s' if 0 < end < np.inf else 'nowhere that is known'}"
            for kind, side, end in (("mild", "below", low), ("severe", "above", high))
        ]
        if low == np.inf or high == 0:
            ends = ["mild throughout" if low == np.inf else "severe throughout"]
        said.append(f"{' and '.join(ends)} at {load:g} N")
    return f"the next run is {'; '.join(said)}"


def margin_lines(here: Margin) -> Iterator[str]:
    """Yield lines on an operating point: verdict, then temperatures, errors and factors."""
    yield here.sentence
    origin = "interpolated between computed points"
    if here.is_computed:
        origin = "computed there"
    elif here.is_continued:
        origin = "extrapolated beyond the computed points, as a power of the velocity"
    elif here.members > 1:
        origin = f"that of {here.members} surfaces"
    yield f"  temperature         {display(here.decisive_temperature, '°C', 4)}, {origin}"
    yield f"  numerical error     {here.error.text}"
    if interval := here.intervals.get("decisive_temperature"):
        low, high = (shown_in(value, "°C") for value in interval)
        yield f"  surfaces            {low:.4g} to {high:.4g} °C (90 %)"
    yield f"  model's own error   {here.model_error}"
    for axis in ("velocity", "load"):
        value, outcome = getattr(here, f"critical_{axis}"), getattr(here, f"{axis}_outcome")
        said = f"{value:.4g} {UNITS[axis]}, {getattr(here, f'{axis}_factor'):.3g} times the {axis}"
        if outcome not in outcomes(axis).values() or math.isnan(value):
            said = outcome if math.isnan(value) else f"{said}; {outcome}"
        yield f"  critical {axis:9}  {said}"
    if here.decided_by:
        yield f"  would decide it     {here.decided_by}"
    yield from remarks("warning", PASSED if PASSED in here.caveats else "")
