"""The figure of rows: a mark for each at its temperature margin, and the most critical one bold."""

import pytest

import pipeline
from pipeline.answers.words import row_labels
from pipeline.figures.rows import deciding_row, draw_rows
from tests.helpers import synthetic
from tribo import InputError

POINTS = {
    "case": ["idle", "part", "full", "gone"],
    "load [N]": [200.0, 400.0, 700.0, 9000.0],
    "velocity [m/s]": [1.0, 1.9, 4.0, 1.0],
}


@pytest.fixture(scope="module")
def found():
    return pipeline.margin(synthetic.sweep(tests=()), POINTS)


def test_each_row_is_at_its_margin_and_the_most_critical_one_is_bold(found):
    (row,) = found.sizes
    assert row_labels(found, row) == ["idle", "part", "full", "gone"]
    assert row_labels(found.drop_vars("case"), row)[0] == "200 N, 1 m/s"
    turned = {"angle [deg]": [0, 30], "load [N]": [200, 300], "velocity [m/s]": [1, 2]}
    named = row_labels(pipeline.margin(synthetic.sweep(tests=()), turned), row)
    assert named == ["angle 0 deg", "angle 30 deg"]
    axes = draw_rows(found, "duty").axes[0]
    places = {
        float(y): float(x)
        for line in axes.lines
        if line.get_label() in ("mild", "undecided", "severe")
        for x, y in zip(*line.get_data(), strict=True)
    }
    assert places == pytest.approx(dict(enumerate(found["temperature_margin"].values[:3])))
    assert deciding_row(found) == 2
    weights = [tick.label1.get_fontweight() for tick in axes.yaxis.get_major_ticks()]
    assert weights == ["normal", "normal", "bold", "normal"]
    told = [one.get_text() for one in axes.texts]
    assert told[3:] == ["more than 99 %", "unknown"]


def test_many_rows_have_some_labels_and_rows_without_a_verdict_are_refused():
    many = {"load [N]": [400.0] * 100, "velocity [m/s]": [1.0 + k / 50 for k in range(100)]}
    found = pipeline.margin(synthetic.sweep(tests=()), many)
    assert len(draw_rows(found, "").axes[0].get_yticks()) <= 41
    with pytest.raises(InputError, match="no row has a verdict: load 9000 N is outside"):
        draw_rows(pipeline.margin(synthetic.sweep(), {k: v[3:] for k, v in POINTS.items()}), "")
