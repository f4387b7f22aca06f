"""Progress on stderr, and faults that are found before the work begins."""

import re
import sys
import time

import pytest

import pipeline
from pipeline.cli import main, output
from pipeline.progress import Progress
from tests.helpers.scenes import MEASURED, SCENE


@pytest.fixture
def small(tmp_path):
    (tmp_path / "small.toml").write_text(SCENE + MEASURED)
    return tmp_path


def test_without_a_terminal_progress_comes_in_plain_lines(capsys, monkeypatch):
    monkeypatch.setattr(output.time, "monotonic", iter(range(0, 1000, 4)).__next__)
    with output.run_line() as show:
        for done in range(8):
            show(Progress("", done, 8, 0, 4.0 * done, 4.0 * (8 - done)))
            show(Progress(f"note {done}"))
        show(Progress("", 8, 8, 0, 32.0, 0.0))
    said = capsys.readouterr().err
    assert "\r" not in said
    notes, states = (re.findall(rf"irg: {kind}.*", said) for kind in ("note", r"\d"))
    assert notes == [f"irg: note {done}" for done in range(8)]  # each note, without delay
    assert states[0] == "irg: 0 of 8 points done, 0 failed, 0 s so far, 32 s to go"
    assert states[-1] == "irg: 8 of 8 points done, 0 failed, 32 s so far"
    assert 3 <= len(states) <= 6


def test_steps_of_a_point_and_chunks_of_a_store_are_counted(small):
    counted = []

    def count(progress):
        counted.append((progress.done, progress.total))

    scene = pipeline.load_scene(small / "small.toml", overrides={"increments": 4})
    point = pipeline.run_point(scene, 400.0, 2.0, progress=count)
    assert counted == [(step + 1, len(counted)) for step in range(len(counted))]
    assert len(counted) > 1
    assert point.columns["normal_load"][-1] == 400.0
    arguments = [str(small / "small.toml"), "-o", str(small / "a.zarr"), "--workers", "1"]
    assert main(["run", *arguments, "--set", "increments=2", "-q"]) == 0
    counted.clear()
    pipeline.verify_store(small / "a.zarr", progress=count)
    assert counted == [(chunk + 1, len(counted)) for chunk in range(len(counted))] != []


def fail(*_, **__):
    raise AssertionError("work was begun that cannot succeed")


def test_a_figure_that_cannot_be_written_is_refused_first(small, irg, monkeypatch):
    monkeypatch.setattr("tribo.simulation.contact_ramp.advance", fail)
    out = small / "nowhere" / "figure.png"
    assert f"cannot write {out}" in irg("trade", small / "small.toml", "-o", out, code=2)


def test_a_run_on_a_terminal_has_a_bar_that_stays_and_a_stage_without_a_total_none(
    capsys, monkeypatch
):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with output.run_line() as show:
        show(Progress("", 0, 8, 0, 0.0))
        show(Progress("a note"))
        time.sleep(0.11)  # tqdm draws every 0.1 s at most
        show(Progress("", 4, 8, 0, 8.0, 8.0))
    said = capsys.readouterr().err
    assert "irg: a note\n" in said
    assert re.search(r"\r4 of 8 points done, 0 failed, 8 s so far, 8 s to go \|█{10} {10}\|", said)
    assert said.endswith("\n")
    output.QUIET.set()
    try:
        with output.run_line() as show:
            show(Progress("", 0, 8, 0, 0.0))
            show(Progress("a note"))
    finally:
        output.QUIET.clear()
    assert capsys.readouterr().err == ""
