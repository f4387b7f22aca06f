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
from pipeline.cli.parser import COMMANDS, function_of, parse
from tests.helpers.scenes import SCENE


def test_the_version_is_that_of_the_package(irg):
    assert irg("--version") == f"irg {version('irg-transition')}\n"


def test_without_a_command_there_is_help(irg):
    said = irg(code=2)
    assert "write a scene to start from" in said
    assert said.endswith("irg: give a command\n")


def test_files_beside_a_scene_are_not_taken_for_packages(tmp_path):
    """Workers, too, import what the command does, not what lies in the folder of a user."""
    (tmp_path / "scene.toml").write_text(SCENE)
    for name in ("pipeline", "tribo", "numpy"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('not this one')")
    done = subprocess.run(
        [
            Path(sys.executable).with_name("irg"),
            *("run", "scene.toml", "-o", "out.zarr", "--set", 'sweep.loads=["200 N"]'),
            *("--set", "increments=1"),
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


@pytest.mark.parametrize("command", COMMANDS, ids=[command.name for command in COMMANDS])
def test_the_example_in_a_commands_help_can_be_typed_as_it_stands(command, irg):
    program, *words = shlex.split(irg(command.name, "--help").splitlines()[-1])
    assert program == "irg"
    options = parse(words)
    assert callable(function_of(options))
    assert parse([*words, "--json"]).json
    assert not options.json


def test_the_examples_are_of_the_scenes_that_new_writes(tmp_path):
    """Their stores are told by name, as run calls them."""
    (certain, *_), (uncertain, *_) = (
        pipeline.new_scene(tmp_path / f"{name}.toml", like)
        for name, like in (("scene", None), ("uncertain", "uncertain"))
    )
    scene, samples = pipeline.load_scene(certain), pipeline.load_scene(uncertain)
    options = {
        command.name: parse([command.name, *shlex.split(command.example)]) for command in COMMANDS
    }
    assert options["plot"].load in scene.plane.loads
    assert pytest.approx(options["plot"].velocity) in scene.plane.velocities
    for name, of in (("margin", scene), ("point", scene), ("risk", samples)):
        assert of.plane.loads[0] <= options[name].load <= of.plane.loads[-1]
        assert of.plane.velocities[0] <= options[name].velocity <= of.plane.velocities[-1]
    assert samples.variants.draw is not None
    for name in ("risk", "sensitivity"):
        assert str(options[name].store) == "results/uncertain.zarr"


@pytest.mark.parametrize(
    ("line", "offered"), [("irg plo", "plot "), ("irg plot a.zarr --kind f", "fields ")]
)
def test_a_shell_is_told_what_may_follow(line, offered, tmp_path):
    environment = os.environ | {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(tmp_path / "offered"),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    program = "import sys; sys.argv[0] = 'irg'; from pipeline.cli import main; main()"
    subprocess.run([sys.executable, "-c", program], env=environment, check=True)
    assert (tmp_path / "offered").read_text() == offered


@pytest.mark.parametrize(
    "error",
    [MemoryError(), RuntimeError("can't start new thread"), OSError(errno.ENOMEM, "fork")],
)
def test_a_lack_of_memory_is_said_in_a_line(error, monkeypatch, capsys):
    def fails(_):
        raise error

    monkeypatch.setattr(pipeline, "summary", fails)
    assert main(["status", "any.zarr"]) == 2
    assert "out of memory, or of the threads" in capsys.readouterr().err


def test_other_errors_are_not_taken_for_a_lack_of_memory(monkeypatch):
    def fails(_):
        raise RuntimeError("a mistake in this program")

    monkeypatch.setattr(pipeline, "summary", fails)
    with pytest.raises(RuntimeError, match="a mistake"):
        main(["status", "any.zarr"])
