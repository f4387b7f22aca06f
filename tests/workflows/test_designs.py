"""The table of the page for designers, against answers computed for the scenes that it names."""

import csv
from pathlib import Path

import pytest

import pipeline
from pipeline.answers.value_text import variable_texts
from tests.helpers.stores import commit_all

WORKFLOWS = Path(__file__).parents[2] / "workflows"
PAGE = (WORKFLOWS / "DESIGNERS.md").read_text(encoding="utf-8")
ROUGHNESS, WEAR = "disk.roughness.ra", "wear.specific_wear_rate"
CHANGES = {
    "friction": "friction + 0.02",
    "bulk_temperature": "bulk temperature + 20 K",
    ROUGHNESS: "twice the Ra",
    WEAR: "ten times the wear rate",
}
"""Condition or entry that each row of the table changes."""


@pytest.fixture
def path(tmp_path):
    """Path for a new store."""
    return tmp_path / "designs.zarr"


def column_of(design, table="change"):
    """Cells of a design in the table of the page whose first heading is `table`, by their row."""
    lines = PAGE.partition(f"\n| {table} |")[2].partition("\n\n")[0].splitlines()
    head, _, *rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in [f"| {table} |{lines[0]}", *lines[1:]]
    ]
    return {change: dict(zip(head[1:], cells, strict=True))[design] for change, *cells in rows}


def answer_at(ds, changed, conditions, operating_point):
    """Margin of the case with the changed entries, under the changed conditions."""
    for path in ROUGHNESS, WEAR:
        name = path.replace(".", "_")
        if name in ds.dims:
            ds = ds.isel({name: int(path in changed)})
    options = {
        "friction": conditions.friction + 0.02 * ("friction" in changed),
        "bulk_temperature": conditions.bulk_temperature + 20 * ("bulk_temperature" in changed),
    }
    return pipeline.margin(ds, *operating_point, **options).squeeze()


def printed(answer):
    """Safety factor of friction, temperature margin and probability as the page prints them."""
    factor, margin, probability = (
        answer[name].item()
        for name in ("friction_safety_factor", "temperature_margin", "probability")
    )
    return f"{factor:.2f}; {margin:.0f} K; {100 * probability:.0f} %".replace("-", "−")


def row_of(scene, name):
    """The row of a table of cases, as entries."""
    rows = csv.DictReader((WORKFLOWS / f"{scene}.csv").read_text(encoding="utf-8").splitlines())
    (row,) = (row for row in rows if row["place"] == name)
    quantities = (
        (head.partition(" [")[0], head.partition(" [")[2].rstrip("]"), value)
        for head, value in row.items()
    )
    return {
        path: f"{value} {unit}" if unit else float(value)
        for path, unit, value in quantities
        if path != "place"
    }


def assert_column_agrees(design, path, scene, roughness, operating_point=(), **overrides):
    """Assert that each row of the table has the numbers computed for the scene of a design."""
    over = {ROUGHNESS: roughness, WEAR: ["1e-8 mm^3/(N m)", "1e-7 mm^3/(N m)"]}
    sweep = pipeline.load_scene(scene, overrides=overrides | {"sweep.over": over})
    commit_all(path, sweep)
    ds, cells = pipeline.open_sweep(path), column_of(design)
    expected = {"none": (), "all four": CHANGES} | {CHANGES[name]: (name,) for name in CHANGES}
    assert cells.keys() == expected.keys()
    for change, changed in expected.items():
        answer = answer_at(ds, changed, sweep.conditions, operating_point)
        assert printed(answer) == cells[change], change


@pytest.mark.parametrize(
    ("design", "scene", "row", "roughness"),
    [
        pytest.param("cam", "cam_tappet", "nose", ["0.3 um", "0.6 um"], marks=pytest.mark.slow),
        ("gear", "gear_mesh", "D", ["0.35 um", "0.7 um"]),
    ],
)
def test_a_row_of_a_scene_has_the_computed_numbers(design, scene, row, roughness, path):
    along = [row_of(scene, row)]
    entries = {"sweep.along": along, "sweep.load_factors": [1.0]}
    assert_column_agrees(design, path, scene, roughness, **entries)


@pytest.mark.parametrize(
    ("heading", "scene", "row"),
    [
        pytest.param("`cam_tappet`, nose", "cam_tappet", "nose", marks=pytest.mark.slow),
        ("`gear_mesh`, D", "gear_mesh", "D"),
    ],
)
def test_the_mild_load_factor_of_a_row_is_the_computed_one(heading, scene, row, path):
    sweep = pipeline.load_scene(scene, overrides={"sweep.along": [row_of(scene, row)]})
    commit_all(path, sweep)
    ds = pipeline.open_sweep(path)
    cells = column_of(heading, "friction")
    assert len(cells) == 4
    for friction, cell in cells.items():
        conditions = {} if friction == "of the scene" else {"friction": float(friction)}
        (text,) = variable_texts(pipeline.margin(ds, **conditions), "mild_load_factor").values
        assert text == cell, friction


@pytest.mark.slow
def test_the_roller_has_the_computed_numbers(path):
    assert_column_agrees("roller", path, "roller", ["0.2 um", "0.4 um"], (120.0, 1.5))
