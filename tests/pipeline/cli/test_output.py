"""Output of commands."""

import argparse

from pipeline.cli.output import Result, show


def test_a_long_table_is_shown_whole_and_a_long_line_cut(capsys):
    table = "\n".join(["a row of the table"] * 1000)
    show(argparse.Namespace(json=False), Result({}, [table, "x" * 10_000]))
    *rows, line = capsys.readouterr().out.splitlines()
    assert "\n".join(rows) == table
    assert len(line) < 3000
