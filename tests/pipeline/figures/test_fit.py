"""Figures for a journal: their width, words, titles, scales and colours."""

import itertools

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.legend import Legend
from matplotlib.text import Text

from pipeline.figures import style
from pipeline.figures.diagram import diagram
from pipeline.figures.plot import plot
from pipeline.store.schema import FAILED, PENDING
from tests.helpers import synthetic
from tests.pipeline.figures.test_plot import contour, lines
from tribo import InputError


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep(loads=(200.0, 400.0, 750.0), velocities=(1.0, 2.0, 4.0), fields=True)


@pytest.mark.parametrize("kind", ["diagram", "ramp", "fields"])
def test_at_the_width_of_a_column_all_words_are_inside_and_readable(sweep, kind):
    figure = plot(sweep, kind, width="8.5 cm")
    figure.draw_without_rendering()
    assert figure.get_size_inches()[0] == pytest.approx(8.5 / 2.54)
    room = figure.bbox.padded(1.0)
    for text in figure.findobj(lambda each: isinstance(each, Text) and each.get_text()):
        if not text.get_visible() or text.get_in_layout() is False:
            continue
        assert float(text.get_fontsize()) >= 4.9, text.get_text()
    for legend in figure.findobj(Legend):
        box = legend.get_window_extent()
        assert room.x0 <= box.x0
        assert box.x1 <= room.x1


def test_a_long_legend_leaves_the_diagram_its_room():
    status = {(400.0, 1.0): FAILED, (200.0, 4.0): PENDING}
    ds = synthetic.sweep((200.0, 400.0, 750.0), (1.0, 2.0, 4.0), status=status)
    shapes = []
    for figure in (plot(ds, "diagram", friction=[0.09, 0.11], width=w) for w in (None, "8.5 cm")):
        figure.draw_without_rendering()
        assert len(figure.legends[0].get_texts()) == 9
        shapes.append(figure.axes[0].bbox.height / figure.axes[0].bbox.width)
    assert shapes[1] > 0.9 * shapes[0]


def test_labels_of_rows_do_not_meet_at_the_width_of_a_column(sweep):
    figure = plot(sweep, "ramp", width=0.085)
    figure.draw_without_rendering()
    boxes = [axes.yaxis.label.get_window_extent() for axes in figure.axes]
    for one, other in itertools.combinations(boxes, 2):
        assert not one.padded(4).overlaps(other)  # [px], a gap that is seen


def test_without_titles_the_caption_has_their_place(sweep):
    bare = plot(sweep, "ramp", with_title=False)
    assert bare.get_suptitle() == ""
    assert diagram(sweep).axes[0].get_title() == "White oil on ground steel"
    assert plot(sweep, "diagram", with_title=False).axes[0].get_title() == ""


@pytest.mark.parametrize(
    ("options", "said"),
    [({"width": 0.01}, "width is 1 cm; it must be from 4"), ({"dpi": 5}, "dpi is 5; it must be")],
)
def test_sizes_that_nobody_can_read_are_refused(sweep, options, said):
    with pytest.raises(InputError, match=said):
        plot(sweep, "diagram", **options)


def test_words_of_an_svg_stay_words(sweep, tmp_path):
    plot(sweep, "diagram", tmp_path / "a.svg")
    assert "sliding velocity [m/s]</text>" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_dots_per_inch_are_those_asked_for(sweep, tmp_path):
    plot(sweep, "diagram", tmp_path / "a.png", width=0.127, dpi=100)
    assert mpl.image.imread(tmp_path / "a.png").shape[1] == 500


def test_a_logarithmic_diagram_has_the_same_boundary(sweep):
    plain, log = diagram(sweep).axes[0], diagram(sweep, log=True).axes[0]
    assert (log.get_xscale(), log.get_yscale()) == ("log", "log")
    np.testing.assert_allclose(contour(log, "boundary")[0], contour(plain, "boundary")[0])
    low, high = log.get_xlim()
    shown = [
        text.get_text() for text in log.get_xticklabels() if low < text.get_position()[0] < high
    ]
    assert shown == ["1", "2", "3", "4"]
    names = {text.get_text().split("\n")[0] for text in log.texts}
    assert names == {"I/II", "III/III*"}


def test_the_users_own_style_goes_before_that_of_the_house(sweep):
    with mpl.rc_context({"font.size": 14.0}):
        assert diagram(sweep).axes[0].xaxis.label.get_fontsize() == 14.0
    assert diagram(sweep).axes[0].xaxis.label.get_fontsize() == 10.0


def test_a_measured_transition_is_joined_with_that_at_its_own_friction(sweep):
    at = {"normal_load": 400.0, "velocity": 2.2, "friction": 0.08}
    found = lines(diagram(sweep.assign_attrs(measured=[at])).axes[0])["at own friction"]
    own = contour(diagram(sweep, friction=0.08).axes[0], "boundary")[0]
    expected = (
        np.interp(-400.0, -own[::-1, 1], own[::-1, 0])
        if own[0, 1] < own[-1, 1]
        else (np.interp(-400.0, -own[:, 1], own[:, 0]))
    )
    assert found[0] == pytest.approx([expected, 400.0], rel=5e-3)
    usual = {"normal_load": 400.0, "velocity": 2.2, "friction": 0.1}
    assert "at own friction" not in lines(diagram(sweep.assign_attrs(measured=[usual])).axes[0])
    beyond = {"normal_load": 900.0, "velocity": 1.2, "friction": 0.08}
    assert "at own friction" not in lines(diagram(sweep.assign_attrs(measured=[beyond])).axes[0])


def test_one_load_alone_has_its_transition_marked_or_says_that_there_is_none():
    one = synthetic.sweep(loads=(400.0,), velocities=(0.5, 1.0, 2.0, 4.0))
    plane = diagram(synthetic.sweep(loads=(399.0, 400.0), velocities=(0.5, 1.0, 2.0, 4.0)))
    (place,) = lines(diagram(one).axes[0])["boundary"]
    top = contour(plane.axes[0], "boundary")[0]
    assert place == pytest.approx(top[top[:, 1].argmax()], rel=1e-3)
    cold = diagram(one, friction=0.001)
    words = [text.get_text() for text in cold.legends[0].get_texts()]
    assert "no transition: mild at every velocity computed (to 4 m/s)" in words


# Machado, Oliveira & Fernandes (2009), severity 1, on linear RGB
BLINDNESS = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}  # fmt: skip


def lab(linear):
    """CIELAB of linear sRGB, white at D65."""
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    ratio = np.array(to_xyz) @ np.clip(linear, 0, 1) / [0.9505, 1.0, 1.089]
    f = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def seen(colour, matrix):
    rgb = np.array(mpl.colors.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return lab(np.array(matrix) @ linear)


@pytest.mark.parametrize("matrix", [np.eye(3), *BLINDNESS.values()], ids=["usual", *BLINDNESS])
def test_colours_are_told_apart_with_any_colour_vision(matrix):
    lines_ = [style.BLACK, style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE]
    for one, other in itertools.combinations([*lines_, style.SKY], 2):
        assert np.linalg.norm(seen(one, matrix) - seen(other, matrix)) > 9, (one, other)
    mild, severe = (seen(style.TINTS[name], matrix) for name in ("mild", "severe"))
    assert np.linalg.norm(mild - severe) > 3
    for marker, tint in ((style.BLUE, mild), (style.VERMILION, severe)):
        assert abs(seen(marker, matrix)[0] - tint[0]) > 25  # of 100 in lightness
