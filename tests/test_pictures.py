"""Shipped pictures are those of today's scenes and code, by what stands in their metadata."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from PIL import Image

import pipeline
from pipeline.figures import style
from pipeline.shipped import WORKFLOWS, shipped_scenes
from tests.helpers import synthetic

ROOT = Path(__file__).parents[1]
PICTURES = sorted(WORKFLOWS.glob("*.png"))
_RUN = re.compile(r"[^\W\d_]+(?: [^\W\d_]+)*")
"""Words between numbers and signs, of which a text of a figure is made."""
_TICK = r"\mathdefault"
"""How Matplotlib writes the number of a tick."""


def carried(path):
    """Metadata of a picture by keyword."""
    with Image.open(path) as picture:
        return dict(picture.text)


@cache
def phrases_of_today():
    """Runs of words in the texts that code, scenes and their tables have today, as one text."""
    texts = [
        path.read_text(encoding="utf-8")
        for pattern in ("*.toml", "*.csv", "paper/*.toml")
        for path in WORKFLOWS.glob(pattern)
    ]
    texts.append((ROOT / "pipeline/scene/library.toml").read_text(encoding="utf-8"))
    for package in ("pipeline", "workflows/paper", "tribo"):
        for path in (ROOT / package).rglob("*.py"):
            nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            texts += [
                n.value for n in nodes if isinstance(n, ast.Constant) and type(n.value) is str
            ]
    words = (" ".join(text.split()).replace("_", " ") for text in texts)
    phrases = {phrase for text in words for phrase in _RUN.findall(text)}
    return f" {' | '.join(phrases)} "


@cache
def is_of_today(run):
    """True if a run of words stands in a text of today, or is two such runs side by side."""
    if f" {run} " in phrases_of_today():
        return True
    words = run.split()
    halves = ((" ".join(words[:k]), " ".join(words[k:])) for k in range(1, len(words)))
    return any(is_of_today(first) and is_of_today(second) for first, second in halves)


def strange_phrases(description):
    """Runs of words of a picture's texts that nothing of today writes."""
    lines = description.replace(_TICK, "").splitlines()
    runs = {run for line in lines for run in _RUN.findall(line)}
    return sorted(run for run in runs if not is_of_today(run))


@pytest.mark.parametrize("path", PICTURES, ids=lambda path: path.stem)
def test_a_picture_has_the_texts_and_the_scene_of_today(path):
    metadata = carried(path)
    assert strange_phrases(metadata["Description"]) == [], (
        "draw it again: make gallery, make scenes"
    )
    if scene := metadata.get("Source"):
        sweep = pipeline.load_scene(shipped_scenes()[path.stem])
        assert scene == sweep.meaning_digest, "draw it again: make scenes"


def test_a_picture_carries_its_texts_and_its_scene(tmp_path):
    ds = synthetic.sweep((200.0, 400.0, 750.0), (1.0, 2.0, 4.0))
    metadata = carried(pipeline.plot(ds, out=tmp_path / "a.png"))
    assert "sliding velocity [m/s]" in metadata["Description"].splitlines()
    assert metadata["Source"] == synthetic.scene().meaning_digest or len(metadata["Source"]) == 64
    other = carried(pipeline.plot(ds, out=tmp_path / "b.png", friction=0.12))
    assert other["Description"] != metadata["Description"]


def test_a_text_that_nothing_writes_any_more_is_noticed():
    assert strange_phrases("sliding velocity [m/s]\ncomputed boundary, numerical error") == []
    assert strange_phrases("the wear turned nastier here") != []


def test_a_smaller_picture_keeps_its_metadata(tmp_path):
    from workflows.paper import _make_smaller

    figure, axes = style.canvas((2, 1))
    axes.set_xlabel("Θ₁₀ [°C]")
    path = style.save_figure(figure, tmp_path / "a.png")
    before = carried(path)
    _make_smaller(path)
    assert carried(path)["Description"] == before["Description"]
    assert "Θ₁₀ [°C]" in before["Description"]
