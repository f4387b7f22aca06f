"""The diagram of rows: each margin, its error and its factors at the numbers of the frame."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from pipeline.figures import row_margins
from pipeline.figures.row_margins import _axis, _draw_factors, _draw_margins
from pipeline.figures.style import TINTS
from pipeline.sweep.variants import PLACE
from tests.helpers import synthetic
from tests.pipeline.figures.test_parts import labels, lines

NAN = math.nan
JUDGED = [SimpleNamespace(field=SimpleNamespace(conditions=synthetic.conditions()))]
FRAME = pd.DataFrame(
    {
        "variant": ["a", "b", "c", "d"],
        "pin.radius [mm]": [1.0, 2.0, 3.0, 4.0],
        "load [N]": [200.0, 200.0, 400.0, 400.0],
        "distance [K]": [20.0, -5.0, 0.5, NAN],
        "temperature error [K]": [3.0, 4.0, NAN, NAN],
        "verdict": ["mild", "severe", "not decided", None],
        "velocity factor": [1.3, NAN, NAN, NAN],
        "load factor": [NAN, 0.4, 1.1, NAN],
    }
)
X = np.arange(4)


def colour(patch):
    return "#" + "".join(f"{round(255 * part):02X}" for part in patch.get_facecolor()[:3])


def margins(frame, x=X):
    axes = Figure().add_subplot()
    _draw_margins(axes, x, frame)
    return axes


def test_each_margin_stands_at_its_row_with_its_error():
    axes = margins(FRAME)
    marks = lines(axes)
    assert marks["mild wear"].tolist() == [[0.0, 20.0]]
    assert marks["severe wear"].tolist() == [[1.0, -5.0]]
    assert marks["not decided"].tolist() == [[2.0, 0.5]]
    assert marks["not known: not computed"].tolist() == [[3.0, 0.0]]
    (errors,) = (bars for bars in axes.containers if bars.get_label() == "error of the margin")
    ends = [segment[:, 1].tolist() for segment in errors.lines[2][0].get_segments()[:3]]
    assert ends == [[17.0, 23.0], [-9.0, -1.0], [0.5, 0.5]]
    assert axes.get_ylabel() == "margin to severe wear [K]"
    assert set(marks["boundary"][:, 1]) == {0.0}
    names = [line.get_label() for line in axes.lines]
    assert "critical temperature" in names


@pytest.mark.parametrize(
    ("values", "low", "high"),
    [
        ([20.0, -5.0, 1.0, NAN], -9.0, 23.0),
        ([0.1, 0.2, 0.1, 0.2], -1.0, 1.0),  # at least a kelvin on either side
    ],
)
def test_above_zero_wear_is_mild_and_below_severe(values, low, high):
    frame = FRAME.assign(**{"distance [K]": values})
    if low == -1.0:
        frame["temperature error [K]"] = 0.0
    axes = margins(frame)
    (mild, severe) = axes.patches
    assert max(mild.get_zorder(), severe.get_zorder()) < axes.xaxis.get_zorder()  # of the grid
    assert (colour(mild), colour(severe)) == (TINTS["mild"], TINTS["severe"])
    bottom, top = axes.get_ylim()
    assert (mild.get_y(), mild.get_y() + mild.get_height()) == (0.0, top)
    assert (severe.get_y(), severe.get_y() + severe.get_height()) == pytest.approx((bottom, 0.0))
    if low == -1.0:
        assert (bottom, top) == (low, high)
    else:  # with a little room about the errors
        assert low - 3 < bottom < low
        assert high < top < high + 3


def test_rows_are_joined_only_where_each_has_a_place_of_its_own():
    def joined(x):
        return [line for line in margins(FRAME, x).lines if line.get_ls() == "-"]

    assert len(joined(X)) == 2  # the line of the rows and that of the limit
    assert len(joined(np.array([0, 0, 1, 2]))) == 1


@pytest.mark.parametrize(("count", "size"), [(60, 6.0), (61, 3.0)])
def test_many_rows_have_small_marks_without_caps(count, size):
    frame = pd.concat([FRAME.iloc[:1]] * count)
    axes = margins(frame, np.arange(count))
    (mark,) = (line for line in axes.lines if line.get_gid() == "mild wear")
    assert mark.get_markersize() == size
    (bars,) = axes.containers
    assert bool(bars.lines[1]) == (count == 60)


def test_factors_stand_at_their_rows_and_those_beyond_at_the_end_of_their_side():
    axes = Figure().add_subplot()
    _draw_factors(axes, X, FRAME)
    marks = lines(axes)
    assert marks["velocity"][0].tolist() == [0.0, 1.3]
    assert marks["load"][1:3].tolist() == [[1.0, 0.4], [2.0, 1.1]]
    assert np.isnan(marks["velocity"][1:, 1]).all()
    # A row that is severe turns mild below all factors, and one that is mild severe above them.
    low, high = 0.4 / 1.1**3, 2.0 * 1.1**3
    assert axes.get_ylim() == pytest.approx((low, high))
    np.testing.assert_allclose(
        marks["velocity, beyond"], [[1.0, low * 1.1], [2.0, high / 1.1]], rtol=1e-12
    )
    np.testing.assert_allclose(marks["load, beyond"], [[0.0, high / 1.1**2]], rtol=1e-12)
    names = [line.get_label() for line in axes.lines if line.get_gid()]
    assert names == [
        "factor of velocity",
        "velocity: beyond what was computed",
        "factor of load",
        "load: beyond what was computed",
    ]
    assert axes.get_ylabel() == "factor to severe wear"
    assert axes.get_yscale() == "log"
    figure = axes.figure
    figure.draw_without_rendering()
    assert [text.get_text() for text in axes.get_yticklabels()] == [
        "0.5 ×", "0.7 ×", "1 ×", "1.4 ×", "2 ×"
    ]  # fmt: skip
    # Marks of velocity stand to the left of their row, those of load as far to the right.
    asides = [
        line.get_transform().transform((1.0, 1.0)) - axes.transData.transform((1.0, 1.0))
        for line in axes.lines
        if line.get_gid() in ("velocity", "load")
    ]
    aside = 5 / 72 * figure.dpi
    np.testing.assert_allclose(asides, [(-aside, 0.0), (aside, 0.0)], atol=1e-9)
    assert [line.get_markerfacecolor() == "white" for line in axes.lines if line.get_gid()] == [
        False, True, False, True
    ]  # fmt: skip


def test_factors_within_a_half_and_two_have_the_room_of_these():
    axes = Figure().add_subplot()
    near = FRAME.assign(**{"velocity factor": 1.2, "load factor": 0.9})
    _draw_factors(axes, X, near)
    assert axes.get_ylim() == pytest.approx((0.5 / 1.1**3, 2.0 * 1.1**3))
    assert "velocity, beyond" not in lines(axes)
    names = [line.get_label() for line in axes.lines if line.get_gid()]
    assert names == ["factor of velocity", "factor of load"]
    (even,) = (line for line in axes.lines if not line.get_gid())  # severe at the point itself
    assert set(even.get_ydata()) == {1.0}


def test_rows_are_named_by_their_own_label_or_numbered():
    x, ticks, label = _axis(FRAME, ["variant", "pin.radius [mm]", "load [N]"])
    assert (x.tolist(), ticks, label) == ([0, 1, 2, 3], ["a", "b", "c", "d"], "variant")
    numbered = FRAME.assign(test=[7, 7, 8.5, 8.5])
    x, ticks, label = _axis(numbered, ["test", "load [N]"])
    assert (x.tolist(), ticks, label) == ([0, 0, 1, 1], ["7", "8.5"], "test")
    x, ticks, label = _axis(FRAME, ["pin.radius [mm]", "load [N]", "velocity [m/s]"][:2])
    assert (x.tolist(), ticks, label) == ([0, 1, 2, 3], ["1", "2", "3", "4"], "row")
    unsorted = FRAME.assign(variant=["b", NAN, "a", NAN])
    assert _axis(unsorted, ["variant"])[0].tolist() == [0, 1, 2, 1]  # in their own order
    surfaces = numbered.assign(realization=[1, 2, 1, 2])
    assert _axis(surfaces, ["test", "load [N]", "realization"])[0].tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize(
    ("several", "title"),
    [
        (False, "severe wear: more than 10 % of the contact above 145 °C; friction 0.1, bulk 25"),
        (True, "severe wear: by the conditions of each row"),
    ],
)
def test_conditions_of_rows_are_said_where_all_have_the_same(monkeypatch, several, title):
    own = synthetic.conditions()
    other = replace(own, critical_temperature=438.15) if several else own
    judged = [SimpleNamespace(field=SimpleNamespace(conditions=one)) for one in (own, other, own)]
    frame = FRAME.rename(columns={"variant": "test"})
    monkeypatch.setattr(row_margins, "judged", lambda ds, points: judged)
    monkeypatch.setattr(row_margins, "margin_frame", lambda ds, rows: frame)
    monkeypatch.setattr(row_margins, "row_labels", lambda frame: ["test", "load [N]"])
    figure = row_margins.draw_rows(synthetic.sweep([200.0, 400.0], [1.0, 2.0]))
    (axes,) = figure.axes
    assert figure.legends[0].get_title().get_text().startswith(title)
    assert axes.get_xlabel() == "test"
    assert [text.get_text() for text in axes.get_xticklabels()] == ["a", "b", "c", "d"]
    assert axes.get_title() == "White oil on ground steel"
    assert {text.get_rotation() for text in axes.get_xticklabels()} == {0.0}


@pytest.mark.parametrize(("count", "every"), [(24, 1), (25, 2)])
def test_of_many_rows_every_second_one_is_named_and_their_names_are_turned(
    monkeypatch, count, every
):
    frame = pd.concat([FRAME.iloc[:1]] * count)
    frame = frame.assign(test=[f"test {number}" for number in range(count)])
    monkeypatch.setattr(row_margins, "judged", lambda ds, points: JUDGED)
    monkeypatch.setattr(row_margins, "margin_frame", lambda ds, rows: frame)
    monkeypatch.setattr(row_margins, "row_labels", lambda frame: ["test", "load [N]"])
    axes = row_margins.draw_rows(synthetic.sweep([200.0, 400.0], [1.0, 2.0])).axes[0]
    shown = [*range(0, count, every)]
    assert axes.get_xticks().tolist() == shown
    named = axes.get_xticklabels()
    assert [text.get_text() for text in named] == [f"test {number}" for number in shown]
    assert all(text.get_rotation() > 0 and text.get_ha() == "right" for text in named)


def test_where_places_about_each_row_were_simulated_its_factors_have_a_panel(monkeypatch):
    monkeypatch.setattr(row_margins, "judged", lambda ds, points: JUDGED)
    monkeypatch.setattr(row_margins, "margin_frame", lambda ds, rows: FRAME)
    monkeypatch.setattr(row_margins, "row_labels", lambda frame: ["variant", "load [N]"])
    ds = synthetic.sweep([200.0, 400.0], [1.0, 2.0])
    placed = ds.assign_coords({PLACE: ("load", [0, 1])})
    figure = row_margins.draw_rows(placed)
    upper, lower = figure.axes
    assert upper.get_ylabel() == "margin to severe wear [K]"
    assert lower.get_ylabel() == "factor to severe wear"
    assert (upper.get_title(), lower.get_title()) == ("White oil on ground steel", "")
    assert (upper.get_xlabel(), lower.get_xlabel()) == ("", "variant")
    assert upper.get_xlim() == lower.get_xlim()
    figure.draw_without_rendering()
    assert upper.bbox.height > lower.bbox.height
    said = labels(figure.legends[0])
    assert said[0] == "critical temperature"
    assert {"mild wear", "factor of velocity", "factor of load"} < {*said}
    own = Figure().add_subplot()
    row_margins.draw_rows(placed, own)
    assert own.figure.axes == [own]
    assert row_margins.draw_rows(ds).axes[0].get_ylabel() == "margin to severe wear [K]"


def test_legends_of_rows_name_what_is_marked():
    axes = margins(FRAME)
    legend = axes.legend()
    assert set(labels(legend)) == {
        "error of the margin", "mild wear", "severe wear", "not decided",
        "not known: not computed", "critical temperature",
    }  # fmt: skip
