"""Output of commands."""

import argparse

from pipeline.cli.output import Result, counted, show, state_of_task


def test_a_long_table_is_shown_whole_and_a_long_line_cut(capsys):
    table = "\n".join(["a row of the table"] * 1000)
    show(argparse.Namespace(json=False), Result({}, [table, "x" * 10_000]))
    *rows, line = capsys.readouterr().out.splitlines()
    assert "\n".join(rows) == table
    assert len(line) < 3000


def test_numbers_and_progress_are_told_in_words():
    assert [counted(n, "load", "loads") for n in (1, 4)] == ["1 load", "4 loads"]
    assert state_of_task("reading", 12.0, 0, 0) == "reading, 12 s so far"
    assert state_of_task("reading", 12.0, 3, 9) == "reading: 3 of 9 done, 12 s so far, 24 s to go"
