"""Constants of campaigns: each is named in one table, and its command exists."""

import ast
import re
from importlib.util import find_spec

from tests.sources.constants import constants
from tests.sources.measure import ROOT


def test_each_constant_has_a_meaning_and_a_command_that_exists():
    found = [*constants()]
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert {"RISE_SHARE", "PRESET_BOUNDS"} <= {
        name.strip("`").split(" ")[0] for _, name, *_ in found
    }
    for place, _, meaning, way in found:
        command = re.search("`(.*)`", way)[1].split()
        exists = command[1] in targets if command[0] == "make" else bool(find_spec(command[2]))
        exists &= all((ROOT / path).exists() for path in command[3:])
        assert meaning, place
        assert exists, place


def test_each_constant_that_changes_an_answer_of_the_pipeline_names_its_command():
    body = ast.parse((ROOT / "pipeline/constants.py").read_text()).body
    assigned = [one.lineno for one in body if isinstance(one, ast.Assign)]
    lines = [int(place.split(":")[1]) for place, *_ in constants() if "pipeline/constants" in place]
    assert lines == assigned
