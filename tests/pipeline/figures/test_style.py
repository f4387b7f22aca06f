"""One style sheet for all figures, which a user's figures can take, too."""

import errno
import io
import os

import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text

import pipeline
from pipeline.figures import style
from pipeline.figures.plot import KINDS
from tests.helpers import synthetic
from tests.helpers.sweeps import with_fields
from tribo import InputError

SMALL = (200.0, 400.0, 750.0), (1.0, 2.0, 4.0)


def test_a_user_can_take_the_style_by_its_name():
    with plt.style.context("pipeline.figures.irg"):
        assert plt.rcParams["axes.prop_cycle"].by_key()["color"][0] == style.BLUE
        assert plt.rcParams["legend.frameon"] is False


def test_a_figure_is_the_same_in_any_style_of_its_caller_which_stays():
    def drawn():
        pipeline.plot(store).savefig(written := io.BytesIO(), format="png", dpi=40)
        return written.getvalue()

    store = synthetic.sweep(*SMALL)
    usual, before = drawn(), dict(plt.rcParams)
    with plt.rc_context(plt.style.library["dark_background"] | {"text.usetex": True}):
        assert drawn() == usual
    assert dict(plt.rcParams) == before


def test_a_notebook_shows_a_figure_as_a_file_has_it():
    figure = pipeline.plot(synthetic.sweep(*SMALL))
    figure.savefig(written := io.BytesIO(), format="png")
    assert figure._repr_png_() == written.getvalue()


def test_a_full_disk_leaves_the_figure_that_was_there(tmp_path, monkeypatch):
    def fail(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    out, link = tmp_path / "a.svg", tmp_path / "b.svg"
    link.symlink_to(out)
    style.save_figure(Figure(figsize=(1, 1)), link)
    before = out.read_bytes()
    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(InputError, match=r"cannot write .*b\.svg: No space left on device"):
        style.save_figure(Figure(figsize=(2, 1)), link)
    assert out.read_bytes() == before
    assert {*tmp_path.iterdir()} == {out, link}


def test_a_figure_has_the_resolution_that_a_user_gives(tmp_path):
    out = tmp_path / "a.png"
    pipeline.plot(synthetic.sweep(*SMALL), out=out, dpi=60)
    with out.open("rb") as file:
        head = file.read(24)
    assert int.from_bytes(head[16:20]) == 8 * 60  # a diagram is 8 inches wide


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "rows"])
def test_all_words_and_legends_are_inside_and_readable_in_any_style(kind):
    titled = with_fields(
        synthetic.sweep(*SMALL, fields=True), title=r"worn by $\frac$" + chr(27) + 100 * "words "
    )
    with plt.rc_context(plt.style.library["dark_background"]):
        figure = pipeline.plot(titled, kind, width="8.5 cm")
        figure.draw_without_rendering()
    assert figure.get_facecolor() == (1, 1, 1, 1)
    assert figure.get_size_inches()[0] == pytest.approx(8.5 / 2.54)
    frame = figure.bbox.padded(1.0)
    parts = [*figure.findobj(Legend), *(axes.title for axes in figure.axes)]
    parts += [figure._suptitle] if figure._suptitle else []
    for part in parts:
        box = part.get_window_extent()
        assert frame.x0 <= box.x0 <= box.x1 <= frame.x1
        assert frame.y0 <= box.y0 <= box.y1 <= frame.y1
    texts = (text for text in figure.findobj(Text) if text.get_text() and text.get_visible())
    assert all(float(text.get_fontsize()) >= 4.9 for text in texts)


@pytest.mark.parametrize(("lines", "end"), [(8, "line 8"), (9, "line 8 …")])
def test_a_caption_below_a_figure_has_at_most_eight_lines(lines, end):
    caption = "\n".join(f"line {number}" for number in range(1, lines + 1))
    with plt.style.context("pipeline.figures.irg"):
        figure = Figure(figsize=(8.0, 4.0))
        figure.add_subplot().plot([0.0], [0.0], label="points")
        style.legend_below(figure, caption=caption)
    assert figure.legends[0].get_title().get_text().splitlines()[-1] == end
