"""The command's words about itself, and its silence."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.cli import main
from pipeline.cli.parser import commands, function_of, parse
from tests.helpers.processes import python
from tests.helpers.scenes import SCENE


def test_a_store_is_answered_without_the_reader_of_scenes(alone):
    code = """
import sys
from pipeline.cli import main
store, place = sys.argv[1], ["--load", "400 N", "--velocity", "1 m/s"]
codes = [main([name, store]) for name in ("status", "boundary", "verify")]
print(*codes, main(["margin", store, *place]))
print([name for name in sys.modules if name.startswith("pipeline.scene")])
"""
    words = [sys.executable, "-c", code, str(alone)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-2:] == ["0 0 0 0", "[]"]


def test_files_beside_a_scene_are_not_taken_for_packages(tmp_path):
    """Workers, too, import the installed packages, not files in the user's folder."""
    (tmp_path / "scene.toml").write_text(SCENE)
    for name in ("pipeline", "tribo", "numpy"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('not this one')")
    done = subprocess.run(
        [
            Path(sys.executable).with_name("irg"),
            *("run", "scene.toml", "-o", "out.zarr", "--set", 'sweep.loads=["200 N"]'),
            *("--workers", "1", "--preset", "standard", "--set", 'sweep.velocities=["1 m/s"]'),
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
    doubts = streams.err.splitlines()  # without the progress
    assert len(doubts) == 1
    assert doubts[0].startswith("irg: warning: pin.length: the pin's sharp ends are not modelled")
    assert (
        main(["boundary", str(tmp_path / "small.zarr"), "-q", "--critical-area-fraction", "3"]) == 2
    )
    assert "critical area fraction is 3" in capsys.readouterr().err
    assert main(["run", *arguments]) == 0
    assert "3 of 3 points done" in capsys.readouterr().err


@pytest.mark.parametrize("command", commands(), ids=[command.name for command in commands()])
def test_the_example_in_a_commands_help_can_be_typed_as_it_stands(command, irg):
    said = irg(command.name, "--help")
    assert f"{command.purpose[0].upper()}{command.purpose[1:]}." in " ".join(said.split())
    program, *words = shlex.split(said.splitlines()[-1])
    assert program == "irg"
    options = parse(words)
    assert callable(function_of(options))
    assert parse([*words, "--json"]).json
    assert not options.json


def test_the_version_is_printed_before_any_command(irg):
    assert re.fullmatch(r"irg \d+\.\d+\.\S+\n", irg("--version"))


_LOADED = """
import sys
from pipeline.cli import main
assert main(sys.argv[2:]) == 0
print("loaded:", *sorted({*sys.argv[1].split(",")} & sys.modules.keys()))
"""


@pytest.mark.parametrize(
    ("words", "slow"),
    [
        ("margin STORE --load 400N --velocity 1.2m/s", "dask,pint,distributed,matplotlib"),
        ("boundary STORE", "dask,pint,distributed,matplotlib"),
        ("status STORE", "dask,pint,distributed,matplotlib"),
        ("check first_try", "dask,pint,distributed,xarray,zarr,scipy.ndimage"),
    ],
)
def test_an_answer_waits_for_no_library_that_it_does_without(alone, words, slow):
    words = words.replace("STORE", str(alone)).split()
    done = python("-c", _LOADED, slow, *words)
    assert done.stdout.endswith("loaded:\n"), done.stdout[-200:] + done.stderr
