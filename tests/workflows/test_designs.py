"""The tables of the page for designers, against answers computed for the scenes that it names."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest

import pipeline
from tests.pipeline.conftest import commit_all

WORKFLOWS = Path(__file__).parents[2] / "workflows"
PAGE = (WORKFLOWS / "DESIGNERS.md").read_text(encoding="utf-8")
HEADINGS = {
    "safety factor of friction": "friction_safety_factor", "friction": "friction_safety_factor",
    "velocity": "velocity_safety_factor", "load": "load_safety_factor",
    "temperature margin [K]": "temperature_margin",
    "probability of severe wear [%]": "probability",
}  # fmt: skip
ROUGHNESS, WEAR = "disk.roughness.ra", "wear.specific_wear_rate"


@pytest.fixture
def path(tmp_path):
    """Path for a new store."""
    return tmp_path / "designs.zarr"


def table_of(name):
    """Changes of each row of the table below a heading of the page, and cells by heading."""
    section = PAGE.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
    lines = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in section.splitlines()
        if line.startswith("|")
    ]
    rows = {change: dict(zip(lines[0][1:], cells, strict=True)) for change, *cells in lines[2:]}
    everything = {}
    for change in rows:
        everything |= changes_of(change)
    return {
        text: (everything if text == "all four" else changes_of(text), cells)
        for text, cells in rows.items()
    }


def changes_of(text):
    """Conditions and entries that the text of a row states."""
    patterns = {
        "friction": r"friction ([\d.]+)",
        "bulk_temperature": r"bulk temperature (\d+ °C)",
        ROUGHNESS: r"Ra ([\d.]+ µm)",
        WEAR: r"specific wear rate (10⁻⁷)",
    }
    matches = {name: re.match(pattern, text) for name, pattern in patterns.items()}
    return {name: match[1] for name, match in matches.items() if match}


def printed(name, value):
    """A number as the page prints it."""
    if np.isnan(value):
        return "–"
    digits = 2 if name.endswith("factor") else 0
    return f"{100 * value if name == 'probability' else value:.{digits}f}".replace("-", "−")


def answer_at(ds, changes, operating_point):
    """Margin of the case with the changed entries, under the changed conditions."""
    for path in ROUGHNESS, WEAR:
        name = path.replace(".", "_")
        if name in ds.dims:
            ds = ds.isel({name: int(path in changes)})
    conditions = {name: value for name, value in changes.items() if "." not in name}
    if "friction" in conditions:
        conditions["friction"] = float(conditions["friction"])
    return pipeline.margin(ds, *operating_point, **conditions).squeeze()


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


def assert_table_agrees(name, path, scene, roughness, operating_point=(), **overrides):
    """Assert that each row of a table has the numbers computed for its scene."""
    over = {ROUGHNESS: roughness, WEAR: ["1e-8 mm^3/(N m)", "1e-7 mm^3/(N m)"]}
    commit_all(path, pipeline.load_scene(scene, overrides=overrides | {"sweep.over": over}))
    ds, table = pipeline.open_sweep(path), table_of(name)
    assert len(table) == 6
    for text, (changes, cells) in table.items():
        answer = answer_at(ds, changes, operating_point)
        values = {head: answer[HEADINGS[head]].item() for head in cells}
        computed = {head: printed(HEADINGS[head], value) for head, value in values.items()}
        assert computed == cells, text


@pytest.mark.parametrize(
    ("name", "scene", "row", "roughness"),
    [
        ("Cam and flat tappet", "cam_tappet", "nose", ["0.3 um", "0.6 um"]),
        ("Gear mesh", "gear_mesh", "D", ["0.35 um", "0.7 um"]),
    ],
)
def test_a_table_of_rows_has_the_computed_numbers(name, scene, row, roughness, path):
    along = [row_of(scene, row)]
    assert_table_agrees(name, path, scene, roughness, **{"sweep.along": along})


@pytest.mark.slow
def test_the_table_of_the_roller_has_the_computed_numbers(path):
    assert_table_agrees("Crowned roller", path, "roller", ["0.2 um", "0.4 um"], (120.0, 1.5))
