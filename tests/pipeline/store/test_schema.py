"""The page of the dataset is what its variables say."""

from pipeline.scene.shipped import WORKFLOWS
from pipeline.store import schema
from pipeline.store.schema import page


def test_the_page_of_the_dataset_is_what_the_variables_say():
    text = (WORKFLOWS / "DATASET.md").read_text(encoding="utf-8")
    assert text.endswith(f"\n\n{page()}"), "write it anew with: make reference"


def test_a_new_variable_of_a_point_stands_on_the_page(monkeypatch):
    new = schema.Variable(("load", "velocity"), "m", "something new")
    monkeypatch.setitem(schema.VARIABLES, "novelty", new)
    before, _, after = page().partition("| `novelty` | load, velocity | m | something new |")
    assert after
    assert before.rstrip().rpartition("## ")[2].startswith(("Coordinates", "Variables of each"))
