"""Scenes, points and figures as a notebook shows them."""

import re
from pathlib import Path
from types import SimpleNamespace

from pipeline.progress import Progress, silent
from pipeline.run.sweep import Outcome
from pipeline.run.tally import shown_progress
from pipeline.store.status import FailedPoint

ROOT = Path(__file__).parents[2]


def outcome():
    failed = tuple(FailedPoint(100.0 + k, 1.0, "no contact <here>") for k in range(500))
    return Outcome(600, 100, 0, failed, 3.0)


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
