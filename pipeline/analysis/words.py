"""Sentences on answers, made from their records, for terminal, page and captions."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.boundary import ERRORS
from pipeline.analysis.judge import judge_of
from pipeline.analysis.margin import AT_EDGE, PASSED, Margin, percent
from pipeline.analysis.margin_frame import forbidding_words
from pipeline.analysis.outcomes import outcomes
from pipeline.analysis.results import Results
from pipeline.analysis.scenes import attribute_values
from pipeline.analysis.tested import APART
from pipeline.quantities import UNITS, display
from pipeline.words import remarks, split_notes
from tribo.types import Array


def condition_lines(conditions: Iterable[str]) -> list[str]:
    """Line of text with the conditions of verdicts: the first, and how many others there are."""
    first, *others = dict.fromkeys(conditions) or [""]
    more = f"; {len(others)} more in the column conditions (-o, --json)"
    return [f"judged at {first}{more * bool(others)}"] * bool(first)


def in_words(table: pd.DataFrame) -> pd.DataFrame:
    """Copy of a table of margins for reading: probabilities are no finer than they are known."""
    told = [None if pd.isna(one) else percent(one) for one in table["probability"]]
    return table.assign(probability=told)


def model_error_line(errors: Iterable[str]) -> str:
    """Line of text on how far the model may be off, from the texts of all scenes.

    It states the first, and the number of different others.
    """
    first, *others = dict.fromkeys(errors)
    return f"the model's own error: {first}" + f", and {len(others)} more" * bool(others)


def error_words(errors: Array, surface: Array) -> str:
    """Relative numerical errors of critical velocities in words, and their part by the surface."""
    if not np.isfinite(errors).any():
        return "not known"
    part = f", surface {_percents(surface)}" if np.nanmax(surface) > 0 else ""
    return f"± {_percents(errors)} of the critical velocity (95 %){part}"


def _percents(values: Array) -> str:
    """Range of relative values in words, such as "1.2 to 3.4 %"."""
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"


def missing_lines(missing: int) -> list[str]:
    """Line of text with the number of points that are `missing`; empty list if all are done."""
    return [f"{missing} points are pending or failed and were left out"] * bool(missing)


def boundary_lines(boundaries: xr.Dataset) -> list[str]:
    """Lines to print below a boundary: how far the model may be off, tests, missing points."""
    return [
        f"numerical error: {error_words(*(boundaries[name].values for name in ERRORS))}",
        model_error_line(attribute_values(boundaries, "model_error")),
        *tests_apart(boundaries),
        *test_lines(*(attribute_values(boundaries, name) for name in ("misfits", "waiting"))),
        *missing_lines(boundaries.attrs["missing_points"]),
    ]


def test_lines(misfits: Iterable[str], waiting: Iterable[str]) -> list[str]:
    """Lines of text on tests that do not fit the others, and on those without a result."""
    lines = [*split_notes(filter(None, misfits))]
    for why in dict.fromkeys(filter(None, waiting)):
        lines.append(f"not every verdict is given: {why}")
    return lines


def case_lines(data: Results) -> list[str]:
    """Lines of text on the tests of all scenes of a sweep, for answers on single places."""
    misfits, waiting = list[str](), list[str]()
    for judge in map(judge_of, data.scenes):
        misfits += judge.evidence.misfits
        waiting += forbidding_words(judge)
    return test_lines(misfits, waiting)


def tests_apart(boundaries: xr.Dataset) -> list[str]:
    """Line of text on how far the boundary with tests is from the computed one; none if near."""
    pairs = boundaries["tested_velocity"] / boundaries["critical_velocity"]
    ratios = pairs.values[np.isfinite(pairs.values)]
    apart = float(np.median(ratios)) - 1 if ratios.size else 0.0
    if abs(apart) <= APART:
        return []
    side = "higher" if apart > 0 else "lower"
    return [f"the tests lie {100 * abs(apart):.0f} % {side} than computed, in velocity"]


def next_run_line(boundary: xr.Dataset) -> str:
    """Sentence on the velocities at which a further run is 5, 50 and 95 % likely to be severe.

    They are stated at the lowest and the highest load. Those beyond the sweep are stated where 50 %
    are within it.
    """
    said, (lowest, highest) = [], np.sort(boundary["velocity"].values)[[0, -1]].tolist()
    for load in dict.fromkeys(boundary["load"].values[[0, -1]].tolist()):
        here = boundary.sel(load=load)
        names = "tested_velocity_low", "tested_velocity", "tested_velocity_high"
        low, middle, high = (here[name].item() for name in names)
        is_inside, ends = lowest <= middle <= highest, {"5 %": low, "95 %": high}
        if is_inside:
            centre = f"at {middle:.3g} m/s"
        elif math.isnan(middle):
            centre = "at no velocity of the sweep"
        else:
            centre = f"below {lowest:.3g} m/s" if middle < lowest else f"above {highest:.3g} m/s"
        known = {k: x for k, x in ends.items() if lowest <= x <= highest or is_inside}
        told = ", ".join(f"{k}: {x:.3g} m/s" for k, x in known.items() if math.isfinite(x))
        said.append(f"{centre} at {load:g} N" + f" ({told})" * bool(told))
    return f"severe wear is 50 % likely {'; '.join(said)}"


def margin_lines(here: Margin, axes: Collection[str] = ("velocity", "load")) -> Iterator[str]:
    """Yield lines on an operating point: verdict, then temperatures, errors and factors.

    `axes` are those along which critical values are told.
    """
    yield here.sentence
    yield f"  judged at           {here.conditions}"
    origin = "interpolated between computed points"
    if here.is_computed:
        origin = "computed there"
    elif here.is_continued:
        origin = "extrapolated beyond the computed points, as a power of the velocity"
    yield f"  temperature         {display(here.deciding_temperature, '°C', 4)}, {origin}"
    yield f"  numerical error     {here.error.text}"
    yield f"  model's own error   {here.model_error}"
    for axis in axes:
        value, outcome = getattr(here, f"critical_{axis}"), getattr(here, f"{axis}_outcome")
        said = f"{value:.4g} {UNITS[axis]}, {getattr(here, f'{axis}_factor'):.3g} times the {axis}"
        if outcome not in outcomes(axis).values() or math.isnan(value):
            said = outcome if math.isnan(value) else f"{said}; {outcome}"
        yield f"  critical {axis:9}  {said}"
        if axis == "velocity" and not math.isnan(here.tested_velocity):
            yield f"  with tests          {here.tested_velocity:.4g} m/s, where 50 % are severe"
    if here.against:
        yield f"  no verdict          {here.against}"
    if here.decided_by:
        yield f"  would decide it     {here.decided_by}"
    yield from remarks("warning", *(one for one in (PASSED, AT_EDGE) if one in here.caveats))
