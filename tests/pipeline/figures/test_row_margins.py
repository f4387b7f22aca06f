"""The diagram of rows: each margin and its error at the numbers of the frame."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from pipeline.figures import row_margins
from pipeline.figures.row_margins import _axis, _draw_margins
from pipeline.figures.style import TINTS
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


def test_legends_of_rows_name_what_is_marked():
    axes = margins(FRAME)
    legend = axes.legend()
    assert set(labels(legend)) == {
        "error of the margin", "mild wear", "severe wear", "not decided",
        "not known: not computed", "critical temperature",
    }  # fmt: skip
