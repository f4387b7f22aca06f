"""Figure of the laboratory's tests: rise over limit at each, beside what all of them say."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from pipeline.analysis.dataset import require_one_scene
from pipeline.analysis.judge import judge_of
from pipeline.analysis.results import Results
from pipeline.analysis.tested import ComparedTest
from pipeline.figures import style
from pipeline.figures.overlays import mark_test
from pipeline.figures.style import BLACK, GREEN, GREY
from tribo import InputError

_ROOM = 0.3  # above and below the rows of tests
_BESIDE = 1.15  # factor between the outermost values and the axis' ends


@style.house_style
def draw_tests(data: Results) -> Figure:
    """Draw rise over limit of each test, at its own conditions, and the band that they leave.

    A bar joins the mild and the severe end of a transition with a step. The legend counts tests
    without a result.
    """
    require_one_scene(data.entry_dims)
    judge = judge_of(data)
    rows = judge.evidence.rows
    if not rows:
        raise InputError(
            "the scene has no tests to draw; give [[measured]] or [[tested]] in the scene, or a "
            "log file; irg tests LOG prints its lines"
        )
    known = [row for row in rows if not row.reason]
    if not known:
        raise InputError(f"no test of the scene has a result: {rows[0].name} {rows[0].reason}")
    figure, axes = style.canvas((8.0, 1.8 + 0.35 * len(known)))
    low, middle, high = map(math.exp, judge.levels)
    axes.axvspan(low, high, label="next run not decided (5 to 95 %)", **style.BAND)
    axes.axvline(middle, color=GREEN, label="50 % severe, with tests")
    axes.axvline(1.0, color=BLACK, label="as computed: mild below, severe above")
    for place, row in enumerate(known):
        ends = np.exp([end for end in (row.mild, row.severe) if not math.isnan(end)])
        axes.plot(ends, [place] * len(ends), color=GREY)
        mark_test(axes, str(row.test.number), row.test, (float(ends.mean()), place))
    values = np.exp([e for row in known for e in (row.mild, row.severe) if not math.isnan(e)])
    ends = np.array([min(low, *values) / _BESIDE, max(high, *values) * _BESIDE])
    axes.set(xscale="log", xlim=ends, ylim=(len(known) - 1 + _ROOM, -_ROOM))
    axes.set_yticks(range(len(known)), [_label(row) for row in known])
    style.plain_numbers(axes)
    if missing := len(rows) - len(known):
        axes.plot([], [], ls="none", label=f"{missing} of {len(rows)} tests: no result")
    axes.set(xlabel="rise of the deciding temperature over its limit, computed for the test")
    style.write_title(axes, f"{style.title_of(data)}\ntests at their own conditions")
    caption = f"the model's own error: {judge.evidence.text}"
    style.legend_below(figure, ncols=2, caption=caption)
    return figure


def _label(row: ComparedTest) -> str:
    return f"{row.test.normal_load:g} N, {row.test.velocity:g} m/s"
