"""Scenes, points and figures as a notebook shows them."""

import re
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

import pipeline
from pipeline.run.sweep import Outcome
from pipeline.run.tally import shown_progress
from pipeline.store.progress import FailedPoint
from pipeline.sweep.stages import Progress, silent
from tests.helpers import samples, synthetic, tiny
from tribo import MeasuredRoughness

ROOT = Path(__file__).parents[2]


def test_a_scene_shows_itself_in_a_few_lines():
    heights = np.zeros((32, 16))
    for scene in (tiny.sweep(), tiny.sweep(roughness=MeasuredRoughness(heights))):
        lines = repr(scene).splitlines()
        assert lines[0] == "tiny: A tiny sweep"
        assert len(lines) < 16
        assert max(map(len, lines)) < 100
        assert any(line.startswith("  window") and "pixels: 32, 16" in line for line in lines)


def answer_of_samples():
    return pipeline.margin(samples.dataset(samples.ensemble(), model_scatter=0.0), "400 N", "2 m/s")


def outcome():
    failed = tuple(FailedPoint(100.0 + k, 1.0, "no contact <here>") for k in range(500))
    return Outcome(600, 100, 0, failed, 3.0)


ANSWERS = {
    "margin": lambda: pipeline.margin(synthetic.sweep(), "400 N", "2 m/s"),
    "margin of samples": answer_of_samples,
    "diff": lambda: pipeline.diff(synthetic.sweep(), pipeline.at(synthetic.sweep(), friction=0.12)),
    "warned": lambda: pipeline.warned(synthetic.sweep()),
    "ensemble": samples.ensemble,
    "sensitivity": lambda: pipeline.sensitivity(samples.ensemble()),
    "outcome": outcome,
    "sweep": tiny.sweep,
}


@pytest.mark.parametrize("made", ANSWERS.values(), ids=ANSWERS)
def test_an_answer_shows_itself_on_one_screen_and_as_a_table(made):
    answer = made()
    title, *lines = repr(answer).splitlines()
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 110
    table, *_ = ElementTree.fromstring(f"<div>{answer._repr_html_()}</div>")
    assert table.find("caption").text == title
    rows = [" ".join(cell.text for cell in row) for row in table.findall("tr")]
    assert rows == [" ".join(line.split()) for line in lines]


def test_every_answer_that_the_page_of_functions_lists_has_a_table():
    page = (ROOT / "workflows" / "API.md").read_text(encoding="utf-8")
    listed = re.findall(r"autoclass:: (pipeline\.\S+)", page)
    assert len(listed) > 15
    for path in listed:
        module, _, name = path.rpartition(".")
        # `Progress` is printed as one line of many; `Results` is input of the answers.
        if name not in ("Progress", "Results"):
            assert hasattr(getattr(import_module(module), name), "_repr_html_"), path


def test_a_notebook_shows_one_line_of_progress(monkeypatch):
    assert shown_progress(None) is silent
    monkeypatch.setattr("IPython.get_ipython", lambda: SimpleNamespace(kernel=None))
    assert shown_progress(print) is print
    texts = []
    line = SimpleNamespace(update=lambda data, raw: texts.append(data["text/plain"]))
    monkeypatch.setattr("IPython.display.display", lambda *data, **options: line)
    report = shown_progress(None)
    report(Progress(done=3, failed=1, total=9, elapsed=65.0, time_to_go=130.0))
    report(Progress(done=9, failed=0, total=9, elapsed=65.0, time_to_go=0.0))
    assert texts[0].startswith("3 of 9 points done, 1 failed, ")
    assert texts[0].endswith("2 min to go")
    assert re.fullmatch("9 of 9 points done, 0 failed, (65 s|1 min) so far", texts[1])
