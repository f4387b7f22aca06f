"""The command's words about itself, and its silence."""

import errno
import os
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import pipeline
from pipeline.cli import main
from pipeline.cli.parser import commands, function_of, parse
from tests.helpers.scenes import SCENE


def test_the_version_is_that_of_the_package(irg):
    assert irg("--version") == f"irg {version('irg-transition')}\n"
    said = irg(code=2)
    assert said.endswith("irg: give a command\n")
    assert "\nwhat everybody needs:\n" in said


def test_files_beside_a_scene_are_not_taken_for_packages(tmp_path):
    """Workers, too, import what the command does, not what lies in the folder of a user."""
    (tmp_path / "scene.toml").write_text(SCENE)
    for name in ("pipeline", "tribo", "numpy"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('not this one')")
    done = subprocess.run(
        [
            Path(sys.executable).with_name("irg"),
            *("run", "scene.toml", "-o", "out.zarr", "--set", 'sweep.loads=["200 N"]'),
            *("--preset", "draft", "--set", 'sweep.velocities=["1 m/s"]'),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "not this one" not in done.stdout + done.stderr


def test_quiet_leaves_results_and_errors_alone(tmp_path, capsys):
    (tmp_path / "small.toml").write_text(SCENE)
    arguments = [str(tmp_path / "small.toml"), "--set", "increments=2", "--workers", "1"]
    arguments += ["-o", str(tmp_path / "small.zarr"), "--set", 'sweep.loads=["200 N"]']
    assert main(["run", *arguments, "--quiet"]) == 0
    streams = capsys.readouterr()
    assert "3 of 3 points done" in streams.out
    assert streams.err == ""
    assert main(["boundary", str(tmp_path / "small.zarr"), "-q", "--share", "3"]) == 2
    assert "share is 3" in capsys.readouterr().err
    assert main(["run", *arguments]) == 0
    assert "3 of 3 points done" in capsys.readouterr().err


@pytest.mark.parametrize("command", commands(), ids=[command.name for command in commands()])
def test_the_example_in_a_commands_help_can_be_typed_as_it_stands(command, irg):
    program, *words = shlex.split(irg(command.name, "--help").splitlines()[-1])
    assert program == "irg"
    options = parse(words)
    assert callable(function_of(options))
    assert parse([*words, "--json"]).json
    assert not options.json


@pytest.mark.parametrize("error", [MemoryError(), OSError(errno.ENOMEM, "fork")])
def test_a_lack_of_memory_is_said_in_a_line(error, monkeypatch, capsys):
    def fails(_):
        raise error

    monkeypatch.setattr(pipeline, "summary", fails)
    assert main(["status", "any.zarr"]) == 2
    assert "out of memory, or of the threads" in capsys.readouterr().err


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


@pytest.mark.parametrize(
    ("setting", "content", "arguments", "said"),
    [
        (
            "MPLBACKEND",
            None,
            ["plot", "done.zarr", "-o", "a.png"],
            "MPLBACKEND (irg needs no backend) is wrong",
        ),
        ("DASK_CONFIG", "a: [b", ["run", "first_try"], "is wrong: A dask config file at"),
        ("DASK_CONFIG", "- a", ["run", "first_try"], "is wrong: A dask config file at"),
        (
            "DASK_CONFIG",
            "distributed: {comm: {timeouts: {connect: soon}}}",
            ["run", "first_try"],
            "is wrong: Invalid time unit: soon",
        ),
    ],
    ids=["backend", "no YAML", "a list", "no time"],
)
def test_a_setting_of_others_that_is_wrong_is_named_in_a_line(
    tmp_path, alone, setting, content, arguments, said
):
    (tmp_path / "done.zarr").symlink_to(alone)
    value = "nosuch" if content is None else str(tmp_path / "dask.yaml")
    (tmp_path / "dask.yaml").write_text(content or "")
    done = subprocess.run(
        [Path(sys.executable).with_name("irg"), *arguments, "-q"],
        env=os.environ | {setting: value},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert said in line
