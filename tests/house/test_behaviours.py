"""The table of behaviours accounts for the code of `pipeline`, and stays short."""

import ast
import re
from pathlib import Path

import pytest

from tests.house.measure import ROOT, code_lines

_TABLE = Path(__file__).with_name("BEHAVIOURS.md")
_MOST = 60  # most rows of the table
_NEAR = 0.1  # relative error allowed in numbers of lines, so that few changes touch the table


def _rows():
    """Behaviour, lines, code files and test files of each row of BEHAVIOURS.md."""
    lines = _TABLE.read_text(encoding="utf-8").splitlines()
    for line in [line for line in lines if line.startswith("| ")][1:]:
        behaviour, size, _, code, tests, _ = line.strip("|").split(" | ")
        names = [re.findall("`([^`]+)`", cell) for cell in (code, tests)]
        files = [ROOT / "pipeline" / f"{name}.py" for name in names[0]]
        yield behaviour.strip(), int(size), files, [ROOT / "tests/pipeline" / n for n in names[1]]


def _size(file):
    source = file.read_text(encoding="utf-8")
    return code_lines(source, ast.parse(source))


ROWS = [*_rows()]


def test_a_behaviour_has_a_price_and_there_are_few():
    assert len(ROWS) <= _MOST


def test_each_file_with_code_belongs_to_one_behaviour():
    named = sorted(file for _, _, files, _ in ROWS for file in files)
    assert named == sorted(file for file in (ROOT / "pipeline").rglob("*.py") if _size(file))


@pytest.mark.parametrize(
    ("size", "files", "tests"), [row[1:] for row in ROWS], ids=[r[0] for r in ROWS]
)
def test_a_behaviour_has_its_lines_and_its_tests(size, files, tests):
    assert size == pytest.approx(sum(map(_size, files)), rel=_NEAR)
    assert tests
    assert all(test.exists() for test in tests)
