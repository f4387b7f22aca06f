"""The page of the dataset is what its variables say."""

import pytest

from pipeline.scene.shipped import WORKFLOWS
from pipeline.store import schema
from pipeline.store.layout import block_of
from tests.house import reference


def test_the_page_of_the_dataset_is_what_the_variables_say():
    text = (WORKFLOWS / "DATASET.md").read_text(encoding="utf-8")
    assert text.endswith(f"\n\n{reference.dataset()}"), "write it anew with: make reference"


def test_a_new_variable_of_a_point_stands_on_the_page(monkeypatch):
    new = schema.Variable(("load", "velocity"), "m", "something new")
    monkeypatch.setitem(schema.RECORDS, "novelty", new)
    before, _, after = reference.dataset().partition(
        "| `novelty` | load, velocity | m | something new |"
    )
    assert after
    assert before.rstrip().rpartition("## ")[2].startswith("Variables of each")


@pytest.mark.parametrize(
    ("sizes", "bytes_of_a_point", "block"),
    [
        ({"load": 12, "velocity": 30}, 6000, {"load": 12, "velocity": 30}),
        ({"load": 12, "velocity": 8334}, 2880, {"load": 12, "velocity": 85}),
        ({"variant": 1000, "load": 4}, 1200, {"variant": 256, "load": 4}),
    ],
)
def test_a_chunk_holds_some_hundred_points_all_loads_first(sizes, bytes_of_a_point, block):
    assert block_of(sizes, bytes_of_a_point) == block
