"""Figures for a journal: their width, words, titles, scales and colours."""

import itertools

import pytest
from matplotlib import pyplot as plt
from matplotlib.legend import Legend
from matplotlib.text import Text

from pipeline import plot
from pipeline.figures.plot import KINDS
from tests.helpers import synthetic
from tests.helpers.sweeps import with_fields


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep(loads=(200.0, 400.0, 750.0), velocities=(1.0, 2.0, 4.0), fields=True)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "rows"])
def test_all_words_and_legends_are_inside_and_readable_in_any_style(sweep, kind):
    titled = with_fields(sweep, title=r"worn by $\frac$" + chr(27) + 100 * "words ")
    with plt.rc_context(plt.style.library["dark_background"]):
        figure = plot(titled, kind, width="8.5 cm")
        figure.draw_without_rendering()
    assert figure.get_facecolor() == (1, 1, 1, 1)
    assert figure.get_size_inches()[0] == pytest.approx(8.5 / 2.54)
    room = figure.bbox.padded(1.0)
    parts = [*figure.findobj(Legend), *(axes.title for axes in figure.axes)]
    parts += [figure._suptitle] if figure._suptitle else []
    for part in parts:
        box = part.get_window_extent()
        assert room.x0 <= box.x0 <= box.x1 <= room.x1
        assert room.y0 <= box.y0 <= box.y1 <= room.y1
    texts = (text for text in figure.findobj(Text) if text.get_text() and text.get_visible())
    assert all(float(text.get_fontsize()) >= 4.9 for text in texts)
    labels = [axes.yaxis.label.get_window_extent() for axes in figure.axes if kind == "ramp"]
    for one, other in itertools.combinations(labels, 2):
        assert not one.padded(4).overlaps(other)  # a visible gap [px]
