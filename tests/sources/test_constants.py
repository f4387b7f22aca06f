"""Constants of campaigns: each is named in one table, and its command exists."""

import ast
import re
from importlib.util import find_spec

from tests.sources.constants import constants
from tests.sources.measure import ROOT


def test_each_constant_has_a_meaning_and_a_command_that_exists():
    rows = [*constants()]
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    page = (ROOT / "workflows/COMMANDS.md").read_text()
    assert {"RISE_EXPONENT", "PRESET_BOUNDS"} <= {
        name.strip("`").split(" ")[0] for _, name, *_ in rows
    }
    for position, _, meaning, words in rows:
        program, *command = re.search("`(.*)`", words)[1].split()
        exists = {
            "make": lambda command: command[0] in targets,
            "irg": lambda command: f"## `irg {command[0]}`" in page,
            "python": lambda command: (
                bool(find_spec(command[1])) and all((ROOT / path).exists() for path in command[2:])
            ),
        }
        assert meaning, position
        assert exists[program](command), position


def test_each_constant_that_changes_an_answer_of_the_pipeline_names_its_command():
    body = ast.parse((ROOT / "pipeline/constants.py").read_text()).body
    assigned = [node.lineno for node in body if isinstance(node, ast.Assign)]
    lines = [
        int(position.split(":")[1])
        for position, *_ in constants()
        if "pipeline/constants" in position
    ]
    assert lines == assigned
