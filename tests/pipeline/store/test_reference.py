"""The page of the dataset is what its variables say."""

from pipeline.scene.shipped import WORKFLOWS
from pipeline.store.reference import page


def test_the_page_of_the_dataset_is_what_the_variables_say():
    text = (WORKFLOWS / "DATASET.md").read_text(encoding="utf-8")
    assert text == page(), "write it anew with: make reference"
