"""What campaigns conclude, and which figures on the page are older than the code."""

import ast
import json
import re
import subprocess

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from pipeline.sweep.selection import PRESET_BOUNDS
from tests.helpers.campaigns import PAGE, ROOT, older
from tests.mutants.changes import changes
from tests.promises import front, truth
from tests.promises.errors import are_covered, covered, places
from tests.promises.families import FAMILIES, cases
from tests.promises.report import are_right, kept
from tests.promises.runs import SAID, comes_true, reported, true_probabilities
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
    assert len(dated) > 5
    for section in dated:
        rooms = re.findall("`(.*?)`", re.search("^Rooms: (.*)", section, re.MULTILINE)[1])
        assert rooms
        assert all((ROOT / room).is_dir() for room in rooms)


@pytest.mark.parametrize(
    ("errors", "excuses", "is_right"),
    [
        ([0.01] * 98 + [0.2] * 2, [""] * 100, True),
        ([0.01] * 96 + [0.2] * 4, ["warned"] * 100, True),
        ([0.01] * 95 + [0.2] * 5, ["warned"] * 100, False),
        ([0.01] * 99 + [0.2], [""] * 100, True),
    ],
)
def test_a_campaign_fails_where_too_few_scenes_keep_a_promise(errors, excuses, is_right):
    assert are_right([kept("draft", 0.08, errors, excuses)], "cylinders") == is_right
    assert not are_right([], "cylinders")


def test_many_broken_in_silence_fail_a_campaign_that_warnings_would_excuse():
    errors = [0.01] * 95 + [0.2] * 5
    for excuse, is_right in (("warned", True), ("", False)):
        assert are_right([kept("draft", 0.08, errors, [excuse] * 100)], "wide") == is_right


def test_stated_errors_are_judged_at_points_and_between_them():
    loads, velocities = [100.0, 200.0, 300.0, 400.0], [1.0, 2.0, 3.0, 4.0, 5.0]
    row = {"family": "wide", "number": 1, "pixels": [64, 64]}
    row |= {"loads": loads, "velocities": velocities}
    row |= {"all_loads": [*loads, 250.0], "all_velocities": [*velocities, 2.5]}

    def plane(loads, velocities, factor=1.0):
        rise = factor * np.outer(loads, np.sqrt(velocities))
        zeros = {name: np.zeros(rise.shape) for name in ("flags", "durations", "fractions")}
        return {"0.1": rise, **zeros}

    row["draft"] = plane(loads, velocities, factor=1.02)
    row["fine"] = plane(row["all_loads"], row["all_velocities"])
    found = pd.DataFrame(places(row, "draft", 0.1))
    assert (len(found), found["is_point"].sum(), found["half"].min()) == (30, 20, 1)
    assert found["error"].to_numpy() == pytest.approx(0.02)
    assert found["between"].to_numpy() == pytest.approx(0.0, abs=1e-9)
    for stated, over, held, is_right in (
        (0.03, "1.5", "100.0%", True),
        (0.01, "0.5", "0.0%", False),
    ):
        line = covered("draft", found.assign(stated=stated))
        assert line == ("draft", 1, 30, "2.00%", "2.00%", f"{stated:.2%}", over, held)
        assert are_covered([line]) == is_right
    assert not are_covered([covered("draft", found.assign(stated=0.1))])  # too wide


class KnownRig:
    """A field that knows its rig: lines of severe wear at 400 N from 2 m/s on, with 10 %."""

    ensemble, scatter = type("Ends", (), {"velocities": (0.5, 8.0)}), None

    def probability(self, load, velocities, scatter):
        return stats.norm.cdf(np.log(velocities * load / 800.0) / 0.1)

    def transition(self, load, bulk):
        return np.log(800.0 / load)


def test_what_is_said_of_the_next_run_comes_true_where_all_is_known():
    rig, rows = KnownRig(), []
    for number in range(10):
        same = [true_probabilities(rig, rig, load, 298.15, 0.1) for load in (400.0, 700.0)]
        assert np.ravel(same) == pytest.approx([*SAID, *SAID], rel=0.02)
        # A rig that scatters by 5 % where 10 % are taken is severe less often than said.
        less = [true_probabilities(rig, rig, 400.0, 298.15, 0.05)]
        assert less[0][0] == pytest.approx(stats.norm.cdf(2 * stats.norm.ppf(0.01)), rel=0.2)
        rows += [{"truth": number, "law": law, "true": true}
                 for law, true in (("drawn", same), ("5 %", less))]  # fmt: skip
    assert true_probabilities(rig, rig, 10_000.0, 298.15, 0.1) is None
    found = dict(reported(rows))
    assert comes_true("drawn", found["drawn"], 8)
    assert comes_true("5 %", found["5 %"], 24)  # the safe side
    assert not comes_true("drawn", found["5 %"], 8)


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


def test_scenes_of_a_search_are_drawn_from_all_families_and_each_is_drawn_once():
    every = front.drawn(range(0, front.NUMBERS, 2), None)
    assert len({case.digest for case in every}) == len(every) > 70
    assert {case.family for case in every} == FAMILIES.keys()
    some = front.drawn(range(0, front.NUMBERS, 2), 5)
    assert [case.name for case in some] == [case.name for case in every[:5]]
    assert len({case.family for case in some}) > 1


@pytest.mark.parametrize("name", front.PROMISED)
@pytest.mark.parametrize("family", ["lay", "coarse pixels", "wide summits"])
def test_presets_keep_their_promises_on_scenes_on_which_none_was_chosen(family, name):
    case = next(case for case in cases([1]) if case.family == family)
    found = front.errors(case, PRESETS[name])
    errors, warned = (np.array(found[key]) for key in ("errors", "warned"))
    assert np.abs(errors[~warned]).max() <= PRESET_BOUNDS[name]
    assert warned.mean() < 0.5


def test_a_preset_is_beaten_by_a_choice_a_tenth_cheaper_at_no_larger_quantile():
    def row(name, quantile, seconds, warned=0.0):
        return name, 100, warned, 0.001, quantile, quantile, seconds

    rows = [row("draft", 0.04, 10.0), row("a", 0.04, 8.9), row("b", 0.04, 9.1), row("c", 0.05, 1.0)]
    assert list(front.beaten(rows)) == [("draft", "a")]
    assert front.are_kept([row("draft", PRESET_BOUNDS["draft"], 1.0)])
    assert not front.are_kept([row("draft", 1.01 * PRESET_BOUNDS["draft"], 1.0)])
    assert not front.are_kept([row("draft", 0.01, 1.0, warned=0.06)])
