"""Contents of figures."""

import re

import numpy as np
import pytest

import pipeline
from pipeline import plot
from pipeline.answers.readable import error_of, format_value, row_labels
from pipeline.cli.parser import whole_parser
from pipeline.figures import plot as live
from pipeline.figures.rows_figure import draw_rows, most_critical_row
from pipeline.figures.style import GREY
from pipeline.store.schema import FAILED, PENDING
from tests.helpers import synthetic
from tests.helpers.entries import bare_test


@pytest.fixture(scope="module")
def sweep():
    status = {(300.0, 1.5): FAILED, (750.0, 4.0): PENDING, (700.0, 4.0): PENDING}
    return synthetic.sweep(status=status, fields=True)


@pytest.fixture(scope="module")
def drawn(sweep):
    with np.errstate(all="raise", under="ignore"):
        return pipeline.plot(sweep).axes[0]


def lines(axes):
    parts = {}
    for line in axes.lines:
        parts.setdefault(line.get_gid(), []).append(np.column_stack(line.get_data()))
    return {gid: np.concatenate(vertices) for gid, vertices in parts.items()}


def labels(legend):
    return [text.get_text() for text in legend.get_texts()]


def test_diagram_says_its_conditions(drawn):
    (legend,) = drawn.figure.legends
    lines = " ".join(legend.get_title().get_text().split())
    assert re.match(
        r"conditions: friction 0.1 \(tests 0.091 to 0.103\), bulk temperature 25 °C, critical "
        r"temperature 145 °C numerical error \(95 %\): ± .* % of the critical velocity "
        r"model error: .* % of the temperature rise \(90 % range, from 4 tests and the prior\) "
        "dots: simulated points; ×: 3 points are pending or failed",
        lines,
    )
    assert labels(legend) == [
        "undecided: severe wear 5 to 95 % probable",
        "boundary with tests (50 %)",
        "computed boundary, numerical error",
        "computed at friction 0.09 and 0.103",
        "test: transition",
        "the same test at friction 0.1",
    ]


def test_the_command_and_the_docstring_offer_every_kind():
    command = whole_parser().get_default("commands")["plot"].format_help()
    (offered,) = re.findall(r"--kind \{(.*)\}\n", command)
    documented = re.search(r"kind : \{(.*)\}", plot.__doc__)[1]
    assert [*live.KINDS] == offered.split(",") == re.findall(r'"(\w+)"', documented)


def test_ramp_shows_the_course_of_the_point_nearest_to_the_transition():
    sweep = synthetic.sweep(interval=1)
    temperature, contact, wear, fraction, volume = pipeline.plot(sweep, "ramp").axes
    assert [axes.get_ylabel() for axes in (temperature, contact, fraction, wear, volume)] == [
        "contact temperature [°C]",
        "contact width [µm]",
        "real contact area [% of window]",
        "maximum wear depth [µm]",
        "worn volume [mm³]",
    ]
    assert wear.get_xlabel() == "time [s]"
    assert synthetic.critical_velocity(750.0, synthetic.limit()) == pytest.approx(1.23, abs=0.01)
    hottest, deciding, critical = (np.column_stack(line.get_data()) for line in temperature.lines)
    loads = sweep["normal_load"].sel(load=750.0, velocity=1.25).values
    np.testing.assert_allclose(deciding[:, 0], loads / 150.0)
    np.testing.assert_allclose(deciding[:, 1], 25.0 + 0.1 * synthetic.rise(loads, 1.25, 0.9))
    np.testing.assert_allclose(hottest[:, 1], 25.0 + 0.1 * synthetic.rise(loads, 1.25))
    np.testing.assert_allclose(critical[:, 1], 145.0)
    width = contact.lines[0].get_ydata()
    assert np.nanmax(width) == pytest.approx(9.0 * 750**0.5 * 1.25)
    assert np.nanmax(fraction.lines[0].get_ydata()) == pytest.approx(1.2 * 750**0.5)


def test_fields_are_those_of_the_point_nearest_to_the_transition(sweep):
    figure = pipeline.plot(sweep, "fields")
    assert figure.get_suptitle() == (
        "White oil on ground steel\n750 N, 1.25 m/s, friction 0.1, bulk temperature 25 °C\n"
        "at one position of the disk; verdicts use the mean over several positions"
    )
    panels = figure.axes[:3]
    assert panels[0].get_ylabel() == "y [µm]"
    point = sweep.sel(load=750.0, velocity=1.25)
    fields_of_point = {
        "contact pressure [GPa]": point["pressure"] / 1e9,
        "contact temperature [°C]": 25.0 + 0.1 * point["rise"],
        "wear depth of the pin [µm]": 1e6 * point["wear_depth"],
    }
    for axes, (label, expected) in zip(panels, fields_of_point.items(), strict=True):
        assert axes.child_axes[0].get_xlabel() == label
        assert (axes.get_xlabel(), axes.get_aspect()) == ("x, along sliding [µm]", 1.0)
        mesh = axes.collections[0]
        np.testing.assert_allclose(mesh.get_array().filled(0.0), expected.T, atol=1e-12)
        hidden = 0 if "temperature" in label else int((expected == 0).sum())
        assert np.ma.count_masked(mesh.get_array()) == hidden
        edges = mesh.get_coordinates()
        np.testing.assert_allclose(edges[0, 0], [-192.0, -6.0])
        np.testing.assert_allclose(edges[-1, -1], [192.0, 426.0])


def test_each_test_is_drawn_at_the_rise_over_limit_of_the_closed_form():
    tests = (
        bare_test(600.0, 1.5, 0.1),
        bare_test(400.0, 2.25, 0.091, velocity_step=0.25),
        bare_test(900.0, 1.0, 0.07),
    )
    mild = bare_test(200.0, 3.0, outcome="mild")
    axes = plot(synthetic.sweep(tests=(*tests, mild)), "tests").axes[0]

    def ratio(test, velocity):
        rise = synthetic.rise(test.normal_load, velocity, 0.9)
        return rise / synthetic.limit(test.friction or 0.1)

    drawn = [line.get_xdata() for line in axes.lines if line.get_color() == GREY]
    for test, ends in zip((*tests, mild), drawn, strict=True):
        velocities = sorted({velocity for _, velocity in test.points})
        expected = [ratio(test, velocity) for velocity in velocities]
        assert sorted({*ends}) == pytest.approx(expected, rel=1e-3)
    legend_texts = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert {"undecided: severe wear 5 to 95 % probable", "boundary with tests (50 %)"} < {
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
    assert most_critical_row(row_margins) == 2
    weights = [tick.label1.get_fontweight() for tick in axes.yaxis.get_major_ticks()]
    assert weights == ["normal", "normal", "bold", "normal"]
    texts = [text.get_text() for text in axes.texts]
    factors = row_margins["friction_safety_factor"].values
    probabilities = "less than 1 %", "37 %", "more than 99 %"
    errors = error_of(row_margins, "friction_safety_factor").values
    expected = [
        f"{p}, {format_value(*pair)}"
        for p, *pair in zip(probabilities, factors[:3], errors[:3], strict=True)
    ]
    assert texts == [*expected, "unknown"]
