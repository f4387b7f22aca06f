"""The two sums of the code only fall."""

import ast

import pytest

from tests.house.measure import allowed, code_lines, sums


@pytest.mark.parametrize("name", ["core", "extras"])
def test_no_sum_exceeds_that_of_the_last_issue(name):
    """`python -m tests.house` prints the rooms."""
    assert sums()[name] <= allowed()[name]


def test_a_line_of_code_is_neither_text_nor_comment_nor_import():
    source = '"""Text."""\nimport os\n\n# why\ndef f():\n  """Text."""\n  return (\n    1)\n'
    assert code_lines(source, ast.parse(source)) == 3
