"""Constants of campaigns: each is named in one table, and its command exists."""

import re
from importlib.util import find_spec

from tests.house.constants import constants
from tests.house.measure import ROOT


def test_each_constant_has_a_meaning_and_a_command_that_exists():
    found = [*constants()]
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert {"BETWEEN", "PRESET_BOUNDS", "_OF_REFERENCE"} <= {
        name.strip("`").split(" ")[0] for _, name, *_ in found
    }
    for place, _, meaning, way in found:
        command = re.search("`(.*)`", way)[1].split()
        exists = command[1] in targets if command[0] == "make" else bool(find_spec(command[2]))
        assert meaning, place
        assert exists, place
