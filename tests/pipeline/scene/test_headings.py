"""Words of a laboratory's files: headings with units, outcomes, marks of decimals and thousands."""

import pytest

from pipeline.scene.headings import heading_of
from pipeline.scene.logs import outcome_of
from pipeline.scene.spreadsheet import decoded, may_be_thousands, read_rows


@pytest.mark.parametrize(
    ("text", "title", "unit"),
    [
        *[("F_N / N", "F_N", "N"), ("T_oil (°C)", "T_oil", "°C"), ("v in m/s", "v", "m/s")],
        *[("load [kN]", "load", "kN"), ("pass/fail", "pass/fail", ""), ("mu [-]", "mu", "")],
    ],
)
def test_a_heading_is_a_title_and_a_unit(text, title, unit):
    heading = heading_of(text)
    assert (heading.title, heading.unit) == (title, unit)


@pytest.mark.parametrize(
    ("word", "heading", "outcome"),
    [("ok", "Ergebnis", "mild"), ("n.i.O.", "Ergebnis", "severe"), ("no", "scuffing", "mild")],
)
def test_a_word_means_an_outcome_below_its_heading(word, heading, outcome):
    assert outcome_of(word, heading) == outcome


@pytest.mark.parametrize(
    ("decimal", "cells", "plain"),
    [
        (
            ",",
            ["1,75", "1.250,5 N", "0.4", "04.05.2026"],
            ["1.75", "1250.5 N", "0.4", "04.05.2026"],
        ),
        (".", ["1.75", "1,250.5 N", "1,250", "4"], ["1.75", "1250.5 N", "1,250", "4"]),
    ],
)
def test_cells_have_decimal_points_and_no_thousands(tmp_path, decimal, cells, plain):
    (tmp_path / "log.tsv").write_text("a\tb\tc\td\n" + "\t".join(cells) + "\n")
    (row,) = read_rows(tmp_path / "log.tsv", lambda heads: heads[0] == "a", decimal).rows
    assert row.cells == plain


def test_three_decimals_behind_a_point_may_be_thousands():
    cells = ["1.250", "0.250", "1.25"]
    assert [may_be_thousands(cell) for cell in cells] == [True, False, False]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_text_is_read_in_each_usual_encoding(encoding):
    assert decoded("1,5 µm".encode(encoding)) == ("1,5 µm", encoding == "latin-1")


def test_thousands_before_a_point_make_no_decimal_commas_of_commas(tmp_path):
    (tmp_path / "log.csv").write_text("load;velocity\n1,250.5 N;1.5 m/s\n")
    read = read_rows(tmp_path / "log.csv", lambda heads: heads[0] == "load")
    assert (read.decimal, read.rows[0].cells) == (".", ["1250.5 N", "1.5 m/s"])
