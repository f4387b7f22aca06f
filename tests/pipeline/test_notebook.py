"""Scenes, points and figures as a notebook shows them."""

import io
import re
from types import SimpleNamespace

import numpy as np
from matplotlib import image

import pipeline
from pipeline.run.sweep import Progress
from pipeline.run.tally import reported
from tests.helpers import synthetic, tiny
from tribo import MeasuredRoughness


def test_a_scene_shows_itself_in_a_few_lines():
    heights = np.zeros((32, 16))
    for scene in (tiny.sweep(), tiny.sweep(roughness=MeasuredRoughness(heights))):
        lines = repr(scene).splitlines()
        assert lines[0] == "tiny: A tiny sweep"
        assert len(lines) < 14
        assert max(map(len, lines)) < 90
        assert "  sweep     3 loads from 150 to 600 N, 3 velocities from 0.5 to 1.5 m/s" in lines


def test_a_figure_shows_itself_as_a_picture():
    figure = pipeline.plot(synthetic.sweep(), "diagram")
    pixels = image.imread(io.BytesIO(figure._repr_png_()))
    assert min(pixels.shape[:2]) > 300
    assert np.unique(pixels[..., :3].reshape(-1, 3), axis=0).shape[0] > 20


def test_a_notebook_shows_one_line_of_progress(monkeypatch):
    with reported(None) as report:
        assert report is None
    monkeypatch.setattr("IPython.get_ipython", lambda: SimpleNamespace(kernel=None))
    with reported(print) as report:
        assert report is print
    texts = []
    line = SimpleNamespace(update=lambda data, raw: texts.append(data["text/plain"]))
    monkeypatch.setattr("IPython.display.display", lambda *data, **options: line)
    with reported(None) as report:
        report(Progress(done=3, failed=1, total=9, elapsed=65.0, time_to_go=130.0))
        report(Progress(done=9, failed=0, total=9, elapsed=65.0, time_to_go=0.0))
    assert texts[0].startswith("3 of 9 points done, 1 failed, ")
    assert texts[0].endswith("2 min to go")
    assert re.fullmatch("9 of 9 points done, 0 failed, (65 s|1 min) so far", texts[1])
