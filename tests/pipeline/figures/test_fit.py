"""Figures for a journal: their width, words, titles, scales and colours."""

import itertools

import numpy as np
import pytest
from matplotlib.legend import Legend
from matplotlib.text import Text

import pipeline
from pipeline import plot
from pipeline.figures.plot import KINDS
from tests.helpers import synthetic
from tests.helpers.sweeps import with_fields
from tests.pipeline.figures.test_plot import contour


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep(loads=(200.0, 400.0, 750.0), velocities=(1.0, 2.0, 4.0), fields=True)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "rows"])
def test_all_words_and_legends_are_inside_and_readable(sweep, kind):
    figure = plot(
        with_fields(sweep, title=r"worn by $\frac$" + chr(27) + 100 * "words "),
        kind,
        width="8.5 cm",
    )
    figure.draw_without_rendering()
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


def test_a_logarithmic_diagram_has_the_same_boundary(sweep):
    sweep = with_fields(sweep, friction_band=None)
    plain, log = pipeline.plot(sweep).axes[0], pipeline.plot(sweep, log=True).axes[0]
    assert (log.get_xscale(), log.get_yscale()) == ("log", "log")
    np.testing.assert_allclose(contour(log, "boundary")[0], contour(plain, "boundary")[0])
    low, high = log.get_xlim()
    labels = [
        text.get_text() for text in log.get_xticklabels() if low <= text.get_position()[0] <= high
    ]
    assert labels == ["1", "2", "3", "4"]
    names = {text.get_text() for text in log.texts if text.get_gid() == "region"}
    assert names == {"mild wear\n(I and II)", "severe adhesive wear\n(III* and III)"}
