"""What campaigns conclude, and which figures on the page are older than the code."""

import ast
import json
import re
import subprocess

import numpy as np
import pytest

from pipeline.constants import PRESET_BOUNDS
from tests.helpers.campaigns import PAGE, ROOT, older
from tests.mutants.changes import changes
from tests.promises import front, laboratories, patches, truth
from tests.promises.families import FAMILIES, cases
from tribo import PRESETS


def test_figures_are_older_than_later_changes_of_their_rooms_alone(tmp_path):
    def git(*words):
        name = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
        command = ["git", "-C", tmp_path, *name, *words]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    git("init", "-q")
    names = []
    for room in ("store", "run", "store"):
        (tmp_path / room).write_text(str(len(names)))
        git("add", "-A")
        git("commit", "-qm", room)
        names.append(git("rev-parse", "--short=7", "HEAD"))
    page = "# Page\n## {}\n\nRooms: `{}`.\n\n| figure | 11-20, {} |\n"
    sections = ("One", "run", names[1]), ("Two", "store", names[1]), ("Three", "run", "0123456")
    assert list(older("".join(page.format(*section) for section in sections), tmp_path)) == [
        f"Two: 11-20, {names[1]}: 1 changes of store since",
        "Three: 11-20, 0123456: an unknown number of changes of run since",
    ]


def test_each_section_with_a_figure_names_rooms_that_there_are():
    sections = PAGE.read_text(encoding="utf-8").split("\n## ")[1:]
    dated = [section for section in sections if re.search(r"\d\d-\d\d, [0-9a-f]{7}", section)]
    assert len(dated) > 3
    for section in dated:
        rooms = re.findall("`(.*?)`", re.search("^Rooms: (.*)", section, re.MULTILINE)[1])
        assert rooms
        assert all((ROOT / room).is_dir() for room in rooms)


def test_a_mutant_differs_at_one_place_of_what_runs():
    source = "def f(a: int = 1):\n    if a < 2 and b:\n        raise E(a)\n    return min(a, -c)\n"
    mutants = []
    for number in range(len(list(changes(ast.parse(source))))):
        tree = ast.parse(source)
        list(changes(tree))[number].make()
        compile(tree, "", "exec")
        mutants.append(ast.unparse(tree))
    assert len(set(mutants)) == len(mutants)
    assert source.rstrip() not in mutants
    for text in ("a: int=2", "if not (a < 2 and b)", "a < 2 or b", "a <= 2", "a < 3"):
        assert sum(text in mutant for mutant in mutants) == 1, text
    for text in ("pass", "max(a, -c)", "min(a, c)"):
        assert sum(text in mutant for mutant in mutants) == 1, text


# The front of the presets


def test_the_truth_is_that_of_the_scenes_of_all_families_and_of_no_other():
    scenes = cases(range(front.NUMBERS))
    assert len(FAMILIES) == 10
    known = {case.digest: truth.known(case) for case in scenes}
    assert known == json.loads(truth.TRUTH.read_text())
    for case in scenes:
        rises = known[case.digest]
        assert [float(one) for one in rises] == [float(v.split()[0]) for v in case.velocities]
        assert {len(row) for row in rises.values()} == {len(case.loads)}
    judged = {case.digest: case for case in scenes if case.number % 2}
    assert sum(len(case.loads) * len(case.velocities) for case in judged.values()) >= 300


@pytest.mark.parametrize("name", front.PROMISED)
def test_presets_keep_their_promises_on_a_scene_on_which_none_was_chosen(name):
    case = next(case for case in cases([1]) if case.family == "lay")
    found = front.errors(case, PRESETS[name])
    errors, warned = (np.array(found[key]) for key in ("errors", "warned"))
    assert np.abs(errors[~warned]).max() <= PRESET_BOUNDS[name]
    assert warned.mean() < 0.5


def test_two_halves_of_eight_patches_are_as_near_as_they_state():
    small = {"sweep.loads": ["400 N", "600 N"], "fidelity.preset": "standard"}
    for _, apart, ratio in patches.rows_of("line", patches=8, **small):
        assert apart <= 1
        assert patches.LEAST <= ratio <= patches.MOST


# Uncertain inputs


@pytest.mark.parametrize("kind", laboratories.KINDS)
def test_intervals_of_the_shift_hold_it_and_verdicts_are_wrong_as_often_as_they_say(kind):
    held, mild, severe = laboratories.judged(kind, 4, 100)
    assert 0.82 <= held <= 0.97  # 100 laboratories: ± 3 points for one standard deviation
    assert max(mild, severe) <= 0.07
