"""Contents of figures."""

import re

import numpy as np
import pytest

import pipeline
from pipeline import plot
from pipeline.answers.answer_frames import row_labels
from pipeline.answers.value_text import format_limit
from pipeline.cli.parser import whole_parser
from pipeline.figures import plot as live
from pipeline.figures.rows_figure import draw_rows, most_critical_row
from pipeline.figures.style import GREY, THICK
from tests.helpers import synthetic
from tests.helpers.entries import bare_test


def test_the_command_and_the_docstring_offer_every_kind():
    command = whole_parser().get_default("commands")["plot"].format_help()
    (offered,) = re.findall(r"--kind \{(.*)\}\n", command)
    documented = re.search(r"kind : \{(.*)\}", plot.__doc__)[1]
    assert [*live.KINDS] == offered.split(",") == re.findall(r'"(\w+)"', documented)


def test_each_test_is_drawn_at_the_rise_over_limit_of_the_closed_form():
    tests = (
        bare_test(600.0, 1.5, 0.1),
        bare_test(400.0, 2.25, 0.091, velocity_step=0.25),
        bare_test(900.0, 1.0, 0.07),
    )
    mild = bare_test(200.0, 3.0, outcome="mild")
    ds = synthetic.sweep(tests=(*tests, mild))
    axes = plot(ds, "tests").axes[0]
    low, middle, high = np.exp(pipeline.compare_tests(ds).attrs["levels"])
    band = axes.patches[0].get_extents().transformed(axes.transData.inverted())
    assert (band.x0, band.x1) == pytest.approx((low, high))
    heavy = [line for line in axes.lines if line.get_linewidth() == THICK]
    assert [line.get_xdata()[0] for line in heavy] == pytest.approx([middle])

    def ratio(test, velocity):
        rise = synthetic.rise(test.normal_load, velocity, 0.9)
        return rise / synthetic.limit(test.friction or 0.1)

    drawn = [line.get_xdata() for line in axes.lines if line.get_color() == GREY]
    for test, ends in zip((*tests, mild), drawn, strict=True):
        velocities = sorted({velocity for _, velocity in test.points})
        expected = [ratio(test, velocity) for velocity in velocities]
        assert sorted({*ends}) == pytest.approx(expected, rel=1e-3)
    assert [label.get_text() for label in axes.get_yticklabels()] == [
        "600 N, 1.5 m/s", "400 N, 2.25 m/s", "900 N, 1 m/s", "200 N, 3 m/s",
    ]  # fmt: skip
    legend_texts = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert {"undecided: neither mild nor severe wear is sure", "boundary with tests (50 %)"} < {
        *legend_texts
    }


# Rows: a mark for each at its temperature margin, and the most critical one bold

POINTS = {
    "case": ["idle", "part", "full", "gone"],
    "load [N]": [200.0, 400.0, 700.0, 9000.0],
    "velocity [m/s]": [1.0, 1.9, 4.0, 1.0],
}


@pytest.fixture(scope="module")
def row_margins():
    return pipeline.margin(synthetic.sweep(tests=()), POINTS)


def test_each_row_is_at_its_margin_and_the_most_critical_one_is_bold(row_margins):
    (row,) = row_margins.sizes
    assert row_labels(row_margins, row) == ["idle", "part", "full", "gone"]
    assert row_labels(row_margins.drop_vars("case"), row)[0] == "200 N, 1 m/s"
    axes = draw_rows(row_margins, "duty").axes[0]
    drawn_margins = {
        float(y): float(x)
        for line in axes.lines
        if line.get_label() in ("mild", "undecided", "severe")
        for x, y in zip(*line.get_data(), strict=True)
    }
    assert drawn_margins == pytest.approx(
        dict(enumerate(row_margins["temperature_margin"].values[:3]))
    )
    ((_, _, (error_bars,)),) = axes.containers
    ends = np.array(error_bars.get_segments()[:3])[..., 0]
    assert np.diff(ends)[:, 0] == pytest.approx(2 * row_margins["temperature_error"].values[:3])
    low, high = ends[:, 0].min(), max(drawn_margins.values())
    beyond = np.subtract(axes.get_xlim(), (low, high)) / (high - low)
    assert beyond[0] == pytest.approx(-beyond[1])
    assert 0.05 < beyond[1] < 0.1  # so that no mark or bar is at the edge
    assert most_critical_row(row_margins) == 2
    weights = [tick.label1.get_fontweight() for tick in axes.yaxis.get_major_ticks()]
    assert weights == ["normal", "normal", "bold", "normal"]
    texts = [text.get_text() for text in axes.texts]
    factors = row_margins["friction_safety_factor"].values
    probabilities = "< 1 %", "37 %", "> 99 %"
    assert texts == [
        *("probability\nof severe\nwear", *probabilities, "unknown"),
        *("safety\nfactor of\nfriction", *map(format_limit, factors[:3]), ""),
    ]
