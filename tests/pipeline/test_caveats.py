"""What a reader of a verdict must know is said by every door, each line once."""

import pandas as pd
import pytest

import pipeline
from tests.helpers import synthetic
from tests.helpers.answer_at import asked
from tests.pipeline.conftest import commit_all

OWN = "Not validated: no test of this steel."


@pytest.fixture
def store(tmp_path):
    """Store of a small sweep whose scene has its own caveat."""
    few = {"sweep.loads": ["300 N", "500 N"], "sweep.velocities": ["1 m/s", "3 m/s"]}
    own = {"note": OWN}
    scene = pipeline.load_scene("first_try", overrides=few | own)
    commit_all(tmp_path / "out.zarr", scene)
    return tmp_path / "out.zarr"


def doors(irg, store, tmp_path):
    """Yield, for each command and page, the caveats to expect, those told as data, and its text."""
    answer = asked(store, 400.0, 2.0)
    lines = [*answer.notes, answer.not_included]
    place = "--load=400 N", "--velocity=2 m/s"
    for command in (("margin", store, *place), ("boundary", store)):
        out = tmp_path / f"{command[0]}.csv"
        text = irg(*command, "-o", out)
        for record in irg(*command, "--json"):
            yield lines, told_in(record), text
        for _, row in pd.read_csv(out).iterrows():
            yield lines, told_in(row), text


def told_in(row):
    """The caveats in a row of a table."""
    return [*row["notes"].split(" | "), row["not_included"]]


def test_every_door_says_the_same_caveats_each_once(irg, store, tmp_path):
    expected = asked(store, 400.0, 2.0)
    assert expected.notes[0] == OWN
    for part in ("sharp pin ends", "uncertain inputs"):
        assert expected.not_included.count(part) == 1
    for lines, told, text in doors(irg, store, tmp_path):
        assert told == lines
        said = " ".join(text.split())
        assert [said.count(line) for line in lines] == [1] * len(lines)


def test_numerical_choices_are_a_caveat_where_their_error_is_not_known():
    said = {
        preset: any("numerical settings" in one for one in asked(ds, 400.0, 2.0).notes)
        for preset in ("standard", None)
        for ds in [synthetic.sweep(preset=preset)]
    }
    assert said == {"standard": False, None: True}


def test_a_caveat_of_ours_is_a_line_of_at_most_100_columns():
    for preset in ("standard", None):
        for line in asked(synthetic.sweep(preset=preset), 400.0, 2.0).notes:
            assert len(line) <= 100
