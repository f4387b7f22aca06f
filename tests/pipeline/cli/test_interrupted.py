"""A command that is interrupted promises only what is kept."""

import pytest

import pipeline
from pipeline.cli import main

PLACE = ["--load", "200 N", "--velocity", "1 m/s"]


@pytest.mark.parametrize(
    ("name", "arguments", "is_safe"),
    [
        ("run_point", ["point", "first_try", *PLACE], False),
        ("run_sweep", ["run", "first_try", "-o"], True),
    ],
)
def test_only_a_run_says_that_finished_points_are_safe(
    tmp_path, monkeypatch, capsys, name, arguments, is_safe
):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(pipeline, name, stopped)
    assert main([*arguments, *[str(tmp_path / "out.zarr")] * is_safe]) == 130
    said = capsys.readouterr().err
    assert "irg: interrupted" in said
    assert ("finished points are safe: run the same command again" in said) == is_safe
