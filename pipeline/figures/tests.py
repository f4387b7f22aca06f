"""Figure of the laboratory's tests: rise ratio of each, beside what all of them say."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple

import pipeline
from pipeline.answers import words
from pipeline.answers.results import refuse_cases, sweep_of
from pipeline.figures import style
from pipeline.figures.diagram import UNDECIDED_LABEL
from pipeline.figures.markers import draw_test_marker, legend_of_tests
from pipeline.figures.style import BLACK, GREY
from tribo import InputError

_ROOM = 0.3  # above and below the rows of tests
_Y = "log_rise_ratio"
_BESIDE = 1.15  # factor between the outermost values and the axis' ends


@style.house_style
def draw_tests(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Figure:
    """Draw rise ratio of each test, at its own conditions, and the band that they leave.

    A bar joins the mild and the severe end of a transition with a step. The caption counts tests
    without a result.
    """
    refuse_cases(ds)
    found = pipeline.compare_tests(ds, **conditions)
    if not found.sizes["test"]:
        raise InputError("the scene has no tests to draw; add [[tests]] to it")
    known = found.isel(test=found["reason"].values == "")
    if not known.sizes["test"]:
        why = found.attrs["tests_without_result"]
        raise InputError(f"no test of the scene has a result yet: {why}")
    low, middle, high = map(math.exp, found.attrs["levels"])
    figure, axes = style.canvas((8.0, 1.8 + 0.35 * known.sizes["test"]))
    legend: dict[str, Any] = {
        UNDECIDED_LABEL: axes.axvspan(low, high, **style.BAND),
        "boundary with tests (50 %)": axes.axvline(middle, **style.BOUNDARY),
        "computed boundary": axes.axvline(1.0, color=BLACK, lw=style.THIN),
    }
    pairs = np.exp(np.stack([known[f"{_Y}_mild"].values, known[f"{_Y}_severe"].values], axis=1))
    outcomes = known["outcome"].values.tolist()
    for place, pair in enumerate(pairs):
        ends = pair[np.isfinite(pair)]
        axes.plot(ends, [place] * len(ends), color=GREY)
        at = float(ends.mean()), place
        draw_test_marker(axes, str(known["test"].values[place]), outcomes[place], at)
    legend |= legend_of_tests(outcomes)
    ends = np.array([min(low, np.nanmin(pairs)) / _BESIDE, max(high, np.nanmax(pairs)) * _BESIDE])
    axes.set(xscale="log", xlim=ends, ylim=(len(pairs) - 1 + _ROOM, -_ROOM))
    places = zip(known["load"].values, known["velocity"].values, strict=True)
    axes.set_yticks(range(len(pairs)), [f"{load:g} N, {speed:g} m/s" for load, speed in places])
    style.plain_numbers(axes)
    axes.set(xlabel="computed rise ratio of the test")
    title = style.as_text(sweep_of(ds).title)
    style.write_title(axes, f"{title}\ntests, each at its own conditions")
    caption = f"model error: {words.attribute_texts(found, 'model_error')[0]}"
    if missing := found.sizes["test"] - len(pairs):
        caption += f"\n{missing} of {found.sizes['test']} tests have no result"
    style.legend_below(
        figure,
        2,
        handles=[*legend.values()],
        labels=[*legend],
        caption=caption,
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )
    return figure
