"""Figure of the laboratory's tests: measured over computed velocity."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.dataset import Layout, require_kind, require_one_scene
from pipeline.analysis.field import point_field
from pipeline.analysis.laboratory import (
    USUAL_SCATTER,
    comparison,
    model_error,
    own_conditions,
)
from pipeline.analysis.margin import DECIDED
from pipeline.analysis.model_error import ModelError
from pipeline.analysis.results import Results
from pipeline.figures import style
from pipeline.figures.overlays import mark_test, number_tests
from pipeline.figures.style import BLACK, GREY
from tribo import InputError

_ROOM = 1.25  # factor on velocity between the outermost tests and the axes' ends


@style.house_style
def measured_over_computed(data: Results) -> Figure:
    """Draw the velocity of each test against the critical velocity computed for it.

    The legend counts the tests for which none is computed.
    """
    require_kind(data.kind, Layout.PLANE)
    require_one_scene(data.entry_dims)
    tests = number_tests(data.sweep.tests)
    if not tests:
        raise InputError(
            "the scene has no tests to draw; give [[measured]] or [[tested]] in the scene, or a "
            "log file; irg tests LOG prints its lines"
        )
    field, found = point_field(data), []
    for number, test in tests.items():
        with suppress(InputError):  # if its bulk temperature is above the critical one
            one = comparison(field.under(own_conditions(data, test)), test)
            if one.is_known and 0 < one.critical < np.inf:
                found.append((number, test, one))
    if not found:
        raise InputError("no test of the scene can be compared; go on with irg run, or add points")
    figure, axes = style.canvas((8.0, 5.6))
    places = np.array([(one.critical, test.velocity) for _, test, one in found])
    ends = places.min() / _ROOM, places.max() * _ROOM
    scatter = model_error(data, field)
    _draw_band(axes, np.array(ends), scatter)
    for number, test, one in found:
        error = 0.0 if test.outcome else USUAL_SCATTER * test.velocity
        axes.errorbar(one.critical, test.velocity, error, fmt="none", ecolor=GREY)
        beside = ", outside the computed points" * (one.critical != one.turn)
        mark_test(axes, number, test, (one.critical, test.velocity), beside)
    if unknown := len(tests) - len(found):
        axes.plot([], [], ls="none", label=f"{unknown} of {len(tests)} tests: not known")
    axes.set(xscale="log", yscale="log", xlim=ends, ylim=ends, aspect="equal")
    style.plain_numbers(axes)
    axes.set(xlabel="critical velocity computed at the test's own conditions [m/s]")
    axes.set_ylabel("velocity of the test [m/s]")
    style.write_title(axes, f"{style.title_of(data)}\ncomputed against measured")
    style.legend_below(figure, ncols=2, caption=f"the model's own error: {scatter.text}")
    return figure


def _draw_band(axes: Axes, line: np.ndarray, scatter: ModelError) -> None:
    """Draw the line measured = computed, and around it the band of the model's own error.

    In this band a new test is severe with a probability from 5 to 95 %. `line` has the velocities
    [m/s] at both ends of the line. `scatter` is the distribution of the model's own error.
    """
    ratios = np.geomspace(line[0] / line[1], line[1] / line[0], 801)
    shares = 1 - scatter.below(-np.log(ratios))
    low, high = np.interp([DECIDED[0], DECIDED[-1]], shares, ratios)
    axes.fill_between(line, low * line, high * line, label="next run not decided", **style.BAND)
    axes.plot(line, line, color=BLACK, label="measured as computed; mild wear below, severe above")
