"""How a command starts, tells its progress, and ends."""

import argparse
import io
import pkgutil
import re
import shlex
import signal
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import pipeline
from pipeline.cli import exit_code_of, main, output
from pipeline.cli.output import Result
from pipeline.cli.parser import parse, whole_parser
from pipeline.interrupts import keyboard_interrupts
from pipeline.progress import Progress
from tests.helpers.processes import python
from tests.helpers.scenes import MEASURED, SCENE
from tribo import InputError


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
    assert not streams.err  # without the progress
    assert main(["boundary", str(tmp_path / "none.zarr"), "-q"]) == 2
    assert "no store at" in capsys.readouterr().err


@pytest.mark.parametrize("command", whole_parser().get_default("commands"))
def test_the_example_in_a_commands_help_can_be_typed_as_it_stands(command, irg):
    *_, heading, example = irg(command, "--help").splitlines()
    assert heading == "example:"
    program, *words = shlex.split(example)
    assert program == "irg"
    options = parse(words)
    assert callable(pkgutil.resolve_name(options.function))
    assert parse([*words, "--json"]).json
    assert not options.json


def test_the_version_is_printed_before_any_command(irg):
    assert re.fullmatch(r"irg \d+\.\d+\.\S+\n", irg("--version"))


_LOADED = """
import sys
from pipeline.cli import main
for words in sys.argv[1:]:
    try:
        assert main(words.split()) == 0
    except SystemExit as ended:
        assert ended.code == 0
    print("loaded", *sys.modules)
"""


def loaded_by(*commands):
    """Modules that are loaded after each command, all run in one process."""
    done = python("-c", _LOADED, *commands)
    assert done.returncode == 0, done.stderr
    lines = (line.split() for line in done.stdout.splitlines() if line.startswith("loaded "))
    return [{*modules} for _, *modules in lines]


def test_an_answer_on_a_store_imports_no_scheduler_and_no_reader_of_scenes(tiny_store):
    point = "--load=400N --velocity=1.2m/s"
    commands = (
        f"status {tiny_store}",
        f"boundary {tiny_store}",
        f"margin {tiny_store} {point}",
        f"verify {tiny_store}",
    )
    *_, loaded = loaded_by(*commands)
    slow = {"distributed", "matplotlib", "scipy.interpolate", "scipy.optimize"}
    assert slow & loaded == set()
    assert [name for name in loaded if name.startswith("pipeline.scene")] == []


def test_the_help_and_a_check_import_no_library_of_arrays_and_of_stores():
    by_help, by_check = loaded_by("--help", "check first_try")
    slow = {"dask", "pint", "distributed", "xarray", "zarr", "scipy.ndimage"}
    assert {"matplotlib", "pandas", "scipy.interpolate", *slow} & by_help == set()
    assert (slow - {"dask"}) & by_check == set()  # the number of cores is Dask's


# Progress on stderr, and faults that are found before the work begins.


def test_progress_names_what_its_points_are_for():
    progress = Progress("", 13, 28, 0, parts="24 of the plane, 4 for tests")
    assert str(progress) == "13 of 28 points (24 of the plane, 4 for tests) done, 0 failed"


def test_without_a_terminal_progress_comes_in_plain_lines(capsys, monkeypatch):
    monkeypatch.setattr(output.time, "monotonic", iter(range(0, 1000, 4)).__next__)
    with output.run_line() as show:
        for done in range(8):
            show(Progress("", done, 8, 0, 4.0 * done, 4.0 * (8 - done)))
            show(Progress(f"note {done}"))
        show(Progress("", 8, 8, 0, 32.0, 0.0))
    printed = capsys.readouterr().err
    assert "\r" not in printed
    notes, states = (re.findall(rf"irg: {kind}.*", printed) for kind in ("note", r"\d"))
    assert notes == [f"irg: note {done}" for done in range(8)]  # each note, without delay
    assert states[0] == "irg: 0 of 8 points done, 0 failed, 0 s so far, 32 s to go"
    assert states[-1] == "irg: 8 of 8 points done, 0 failed, 32 s so far"
    assert 3 <= len(states) <= 6


def fail(*_, **__):
    raise AssertionError("work was begun that cannot succeed")


def test_a_figure_that_cannot_be_written_is_refused_first(tmp_path, irg, monkeypatch):
    (tmp_path / "small.toml").write_text(SCENE + MEASURED)
    monkeypatch.setattr("tribo.simulation.contact_ramp.advance", fail)
    out = tmp_path / "nowhere" / "figure.png"
    assert f"cannot write {out}" in irg("trade", tmp_path / "small.toml", "-o", out, code=2)
    (folder := tmp_path / "figure.png").mkdir()
    words = f"cannot write {folder}: it is a folder, or it or its folder is not writable"
    assert words in irg("trade", tmp_path / "small.toml", "-o", folder, code=2)


def test_a_run_on_a_terminal_has_a_line_that_changes_and_a_stage_without_a_total_none(
    capsys, monkeypatch
):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with output.run_line() as show:
        show(Progress("", 0, 8, 0, 0.0))
        show(Progress("a note"))
        show(Progress("", 4, 8, 0, 8.0, 8.0))
    printed = capsys.readouterr().err
    assert "\x1b[Kirg: a note\n" in printed
    assert printed.endswith("\r\x1b[K4 of 8 points done, 0 failed, 8 s so far, 8 s to go\n")


# How a command ends: its exit code and its error message.


def carry_out(result=None, command="status", **options):
    """Exit code of a command whose function returns a result, raises it, or warns of it."""

    def function(_):
        if isinstance(result, BaseException):
            raise result
        if isinstance(result, str):
            warnings.warn(result, stacklevel=1)
        return result if isinstance(result, Result) else Result({}, ["a line"])

    usual = {"quiet": False, "json": False, "output": None, "command": command}
    return exit_code_of(argparse.Namespace(**usual | options), function)


SAFE = "; finished points are saved"


@pytest.mark.parametrize(
    ("result", "command", "code", "message"),
    [
        (Result({}, ["a line"], code=1), "status", 1, ""),
        ("few nodes", "status", 0, "irg: note: few nodes\n"),
        (InputError("no such scene"), "status", 2, "irg: no such scene\n"),
        (pipeline.StoreMismatchError("another"), "run", 3, "irg: another\n"),
        (KeyboardInterrupt(), "status", 130, "irg: interrupted\n"),
        (KeyboardInterrupt(), "run", 130,
         f"irg: interrupted{SAFE}: run the same command again to continue\n"),
        (MemoryError(), "run", 2,
         "irg: out of memory, or at the limit of threads and processes for this user (ulimit -a)"
         f"{SAFE}: use fewer workers or a coarser grid\n"),
        (RuntimeError("can't start new thread"), "status", 2,
         "irg: out of memory, or at the limit of threads and processes for this user (ulimit -a)"
         ": use fewer workers or a coarser grid\n"),
        (OSError(28, "No space left on device"), "run", 2,
         f"irg: cannot continue: [Errno 28] No space left on device{SAFE}\n"),
        (FileNotFoundError(2, "No such file or directory", "a.csv"), "status", 2,
         "irg: cannot continue: [Errno 2] No such file or directory: 'a.csv'\n"),
        (RuntimeError("error during blosc decompression: -1"), "status", 2,
         "irg: cannot continue: error during blosc decompression: -1\n"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("always")
def test_a_command_ends_with_its_code_and_a_line_on_what_ended_it(
    capsys, result, command, code, message
):
    assert carry_out(result, command) == code
    assert capsys.readouterr().err == message


INTERRUPTED = """
import threading
import pipeline.cli
from pipeline.__main__ import run

def main():
    threading.Thread(target=threading.Event().wait).start()  # as one that waits for a disk
    return 130

pipeline.cli.main = main
run()
"""


def test_an_interrupted_command_waits_for_no_thread():
    assert python("-c", INTERRUPTED, timeout=60).returncode == 130


def test_no_setting_of_matplotlib_keeps_a_figure_from_being_drawn(tmp_path, tiny_store):
    figure = tmp_path / "a.png"
    command = ("-m", "pipeline", "plot", tiny_store, "-o", figure)
    done = python(*command, variables={"MPLBACKEND": "qt9"})
    assert done.returncode == 0, done.stderr
    assert figure.exists()


def test_a_deleted_working_directory_ends_in_a_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert main(["boundary", "results/a.zarr"]) == 2
    expected = "irg: cannot continue: [Errno 2] No such file or directory\n"
    assert capsys.readouterr().err == expected


def test_what_no_user_can_put_right_is_shown_with_its_place_in_the_code():
    with pytest.raises(RuntimeError, match="a fault"):
        carry_out(RuntimeError("a fault"))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_each_signal_ends_a_command_once_and_acts_as_before_afterwards(number):
    before = signal.signal(number, signal.SIG_DFL)
    try:
        with pytest.raises(KeyboardInterrupt), keyboard_interrupts():
            signal.raise_signal(number)
        assert signal.getsignal(number) == signal.SIG_DFL
    finally:
        signal.signal(number, before)


def test_a_terminal_with_few_letters_gets_the_codes_of_others(monkeypatch):
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", terminal)
    assert main(["check", "first_try"]) == 0
    terminal.flush()
    assert rb" \xb5m" in terminal.buffer.getvalue()


def test_a_reader_that_wants_no_more_is_no_error(monkeypatch):
    closed = io.StringIO()
    monkeypatch.setattr(sys, "stderr", closed)
    assert carry_out(BrokenPipeError()) == 0
    assert closed.closed
