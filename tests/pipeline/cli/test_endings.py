"""How a command ends: its exit code, its words on an error, and what it does not begin."""

import argparse
import errno
import io
import os
import sys
import warnings
from pathlib import Path

import pytest

import pipeline
from pipeline.cli import exit_code_of, output
from pipeline.cli.output import Result
from tribo import InputError


def carry_out(result=None, command="stores:status", **options):
    """Exit code of a command whose function returns a result, raises it, or warns of it."""

    def function(_):
        if isinstance(result, BaseException):
            raise result
        if isinstance(result, str):
            warnings.warn(result, stacklevel=1)
        return result if isinstance(result, Result) else Result({}, ["a line"])

    usual = {"quiet": False, "json": False, "output": None, "command": command}
    return exit_code_of(argparse.Namespace(**usual | options), function)


def error_of(module):
    """A `ValueError` raised in a module of this name."""
    with pytest.raises(ValueError, match="qt9") as caught:
        exec("raise ValueError('qt9 is unknown')", {"__name__": module})
    return caught.value


SAFE = "; finished points are saved"


@pytest.mark.parametrize(
    ("result", "command", "code", "said"),
    [
        (Result({}, ["a line"]), "stores:status", 0, ""),
        (Result({}, ["a line"], code=1), "stores:status", 1, ""),
        ("few nodes", "stores:status", 0, "irg: note: few nodes\n"),
        (InputError("no such scene"), "stores:status", 2, "irg: no such scene\n"),
        (pipeline.StoreMismatchError("another"), "sweeps:run", 3, "irg: another\n"),
        (KeyboardInterrupt(), "stores:status", 130, "irg: interrupted\n"),
        (KeyboardInterrupt(), "sweeps:run", 130,
         f"irg: interrupted{SAFE}: run the same command again to go on\n"),
        (MemoryError(), "sweeps:run", 2,
         "irg: out of memory, or at the limit of threads and processes for this user (ulimit -a)"
         f"{SAFE}: use fewer workers or a coarser grid\n"),
        (RuntimeError("can't start new thread"), "stores:status", 2,
         "irg: out of memory, or at the limit of threads and processes for this user (ulimit -a)"
         ": use fewer workers or a coarser grid\n"),
        (error_of("matplotlib"), "stores:status", 2,
         "irg: the variable MPLBACKEND (irg needs no backend) is wrong: qt9 is unknown\n"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("always")
def test_a_command_ends_with_its_code_and_a_line_on_what_ended_it(
    capsys, result, command, code, said
):
    assert carry_out(result, command) == code
    assert capsys.readouterr().err == said


def test_what_no_user_can_put_right_is_shown_with_its_place_in_the_code():
    with pytest.raises(RuntimeError, match="a fault"):
        carry_out(RuntimeError("a fault"))


def test_results_that_cannot_be_printed_end_a_command_and_python_does_not_try_again(
    tmp_path, monkeypatch, capsys
):
    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(output, "show", fail)
    with (tmp_path / "full").open("w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert carry_out(command="sweeps:run") == 2
        assert os.path.samestat(os.fstat(out.fileno()), Path(os.devnull).stat())
    no_space = f"[Errno {errno.ENOSPC}] No space left on device"
    assert capsys.readouterr().err == f"irg: cannot continue: {no_space}{SAFE}\n"


def test_a_reader_that_wants_no_more_is_no_error(monkeypatch):
    closed = io.StringIO()
    monkeypatch.setattr(sys, "stderr", closed)
    assert carry_out(BrokenPipeError()) == 0
    assert closed.closed
