"""The page of the dataset is what its variables say, and rows differ in what they have to."""

import ast
import re

import numpy as np
import pytest

import tribo
from pipeline.shipped import WORKFLOWS
from pipeline.store import schema
from pipeline.store.layout import chunk_sizes
from pipeline.sweep.case_table import CaseTable, surfaces
from tests.helpers import tiny
from tests.helpers.entries import placed_rows, rows
from tests.sources import reference


def test_the_page_of_the_dataset_is_what_the_variables_say():
    text = (WORKFLOWS / "DATASET.md").read_text(encoding="utf-8")
    assert text.endswith(f"\n\n{reference.dataset()}"), "write it anew with: make reference"


def test_the_lines_of_the_page_run_and_find_numbers(folder_with_results, monkeypatch):
    monkeypatch.chdir(folder_with_results)
    text, names = (WORKFLOWS / "DATASET.md").read_text(encoding="utf-8"), {}
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    for line in ast.parse("".join(blocks)).body:
        if not isinstance(line, ast.Expr):
            exec(ast.unparse(line), names)
            continue
        found = eval(ast.unparse(line), names)
        values = found[0].get_ydata() if "plot" in ast.unparse(line) else found
        assert np.isfinite(values).any(), ast.unparse(line)


@pytest.mark.parametrize(
    ("sizes", "bytes_of_a_point", "block"),
    [
        ({"load": 12, "velocity": 30}, 6000, {"load": 12, "velocity": 30}),
        ({"load": 12, "velocity": 8334}, 2880, {"load": 12, "velocity": 85}),
        ({"case": 1000, "load": 4}, 1200, {"case": 256, "load": 4}),
    ],
)
def test_a_chunk_holds_some_hundred_points_all_loads_first(sizes, bytes_of_a_point, block):
    assert chunk_sizes(sizes, bytes_of_a_point) == block


RAMPS = rows("ramp", {"slow": {"loading": tribo.Ramp(50.0, 750.0)}, "fast": {}})
TESTS = {"a": {}, "b": {}}


@pytest.mark.parametrize(
    ("case_table", "time", "distance", "status"),
    [
        (CaseTable(), "load", "load velocity", "load velocity"),
        (surfaces((1, 2)) * RAMPS, "ramp load", "ramp load velocity",
         "realization ramp load velocity"),
        (rows("test", TESTS, velocities=(0.5, 1.0)), "load", "test load", "test load"),
        (rows("test", TESTS, (0.5, 1.0), (200.0, 300.0)), "test", "test", "test"),
        (placed_rows((200.0, 0.5), (300.0, 1.0)), "case", "case", "case"),
    ],
    ids=["plane", "surfaces and ramps", "velocities", "places", "rows"],
)  # fmt: skip
def test_time_and_distance_differ_between_rows_whose_ramps_or_velocities_do(
    case_table, time, distance, status
):
    """Otherwise a sweep of many surfaces would store the same times for each."""
    wanted = schema.variables_of(tiny.full(case_table=case_table))
    assert wanted["status"].dims == tuple(status.split())
    assert wanted["mean_rise"].dims == (*status.split(), "step")
    for name, dims in (("time", time), ("normal_load", time), ("sliding_distance", distance)):
        assert wanted[name].dims == (*dims.split(), "step")
