"""Texts of a scene reach each output escaped, or are refused when the scene is read."""

import csv
import json
import re
from xml.etree import ElementTree

import pytest
import xarray as xr

import pipeline
from tests.helpers.stores import commit_all
from tests.pipeline.page.test_report import checked
from tribo import TriboError

ACCEPTED = {
    "mathtext": r"$\frac{1}{$", "dollars": "a$b$c", "script": "<script>alert(1)</script>",
    "attribute": '"><img src=x onerror=alert(2)>', "entity": "&amp; &lt;", "comment": "<!-- -->",
    "closing": "</style></table>", "right to left": "\u05d0\u200fb", "arabic": "\u0627\u0644",
    "emoji": "\U0001f525 hot", "accents": "e\u0301\u0302", "long": "x" * 5000, "braces": "{}",
    "field": "{0.__class__}", "template": "{{ 7*7 }}{% x %}", "percent": "%s%n",
    "backslash": "a\\b\\n", "end": "a\\", "quotes": "\"'`", "pipe": "a|b \\| c",
    "formula": "=A1+1", "function": "@SUM(A1)", "path": "../x", "hash": "#a, b",
}  # fmt: skip
REFUSED = {
    "newline": "a\nb", "return": "a\rb", "tab": "a\tb", "bell": "a\x07b", "delete": "a\x7fb",
    "escape": "\x1b[31mred\x1b[0m", "window title": "\x1b]0;x\x07", "c1": "a\x9b31mb",
    "separator": "a\u2028b", "override": "a\u202eb", "isolate": "a\u2066b", "null": "a\0b",
    "surrogate": "a\udcffb",
}  # fmt: skip
SCENE = """
extends = "ball_on_disk"
without = ["disk.roughness", "wear", "oil", "sweep.loads", "sweep.velocities", "sweep.fields"]
title = {title}
note = {note}
{materials}
[pin]
material = {material}
[window]
pixels = [8, 8]
pixel_size = ["10 um", "10 um"]
[loading]
reference_load = "75 N"
[fidelity]
fewest_elements = 0
pixels_per_element = 1
increments = 2
[sweep]
"""
PLACES = {
    "title": {"title": "{}"},
    "note": {"note": "{}"},
    "material": {"material": "{}"},
    "number": {"end": '[[tests]]\nload="4 N"\nvelocity="2 m/s"\noutcome="mild"\nnumber={}'},
    "case": {"sweep": 'along=[{{number={}, load="4 N", velocity="2 m/s"}}]'},
}
PLANE = 'loads = ["2 N", "8 N"]\nvelocities = ["1 m/s", "4 m/s"]'


def toml(text):
    """The text as a string of TOML, in which all that is not plain is escaped."""
    is_plain = re.compile(r"[ -~]").fullmatch
    letters = (c if is_plain(c) and c not in '"\\' else f"\\U{ord(c):08x}" for c in text)
    return f'"{"".join(letters)}"'


def write(path, title='"a"', note='"a"', material='"steel"', materials=(), sweep=PLANE, end=""):
    names = materials or {'"steel"', material}
    tables = (f'[materials.{name}]\nlike = "AISI 52100"\n' for name in names)
    scene = SCENE.format(title=title, note=note, material=material, materials="\n".join(tables))
    path.write_text(f"{scene}{sweep}\n{end}\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("payload", REFUSED)
def test_controls_are_refused_on_a_line_without_them(payload, place, tmp_path):
    entries = {k: text.format(toml(REFUSED[payload])) for k, text in PLACES[place].items()}
    with pytest.raises(TriboError) as refusal:
        pipeline.load_scene(write(tmp_path / "a.toml", **entries))
    assert re.search(r"has a line break or a control|is not valid TOML", str(refusal.value))
    assert str(refusal.value).isprintable()


def test_half_of_a_surrogate_pair_is_refused_from_python(tmp_path):
    path = write(tmp_path / "a.toml")
    with pytest.raises(TriboError, match="has a line break or a control character"):
        pipeline.load_scene(path, overrides={"title": REFUSED["surrogate"]})


TITLE = " ".join(text for text in ACCEPTED.values() if len(text) < 100)


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    """Store of a plane whose tests have the payloads as numbers, with all of them as title."""
    path = tmp_path_factory.mktemp("payloads") / "plane.toml"
    test = '[[tests]]\nload = "4 N"\nvelocity = "2 m/s"\noutcome = "mild"\nnumber = '
    tests = "\n".join(test + toml(text) for text in ACCEPTED.values())
    scene = write(path, title=toml(TITLE), note=toml(TITLE), end=tests)
    commit_all(path.with_suffix(".zarr"), pipeline.load_scene(scene))
    return path.with_suffix(".zarr")


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Store of rows that have the payloads as names and as materials."""
    path, names = tmp_path_factory.mktemp("payloads") / "rows.toml", [*map(toml, ACCEPTED.values())]
    listed = (f'{{number={k}, "pin.material"={k}, load="4 N", velocity="2 m/s"}}' for k in names)
    along = f"along = [{', '.join(listed)}]"
    scene = write(path, materials=('"steel"', *names), sweep=along)
    commit_all(path.with_suffix(".zarr"), pipeline.load_scene(scene))
    return path.with_suffix(".zarr")


@pytest.mark.parametrize("heading", ["test", "number"])
def test_terminal_json_and_tables_have_the_texts(heading, plane, rows, irg, tmp_path):
    commands = {"test": ("boundary", plane, "--by", "test"), "number": ("margin", rows, "--all")}
    command, expected = commands[heading], [*ACCEPTED.values()]
    output = irg(*command, "-o", tmp_path / "a.csv")
    lines = output.splitlines()
    assert all(line.replace("\u200f", "").isprintable() for line in lines)
    tables = [line for line in lines if not line.startswith(("warning", "not included"))]
    assert max(map(len, tables)) < 300
    for text in ACCEPTED.values():
        assert text.split()[0][:99] in output
    printed = irg(*command, "--json", "-o", tmp_path / "a.json")
    assert [row[heading] for row in printed] == expected
    assert json.loads((tmp_path / "a.json").read_text()) == printed
    cells = [*csv.DictReader((tmp_path / "a.csv").read_text().splitlines())]
    texts = [row[heading] for row in cells]
    assert [text.removeprefix("'") for text in texts] == expected
    assert not any(text.startswith(("=", "@", "+", "-")) for text in texts)
    irg(*command, "-o", tmp_path / "a.md")
    lines = (tmp_path / "a.md").read_text().splitlines()
    assert len(lines) == 2 + len(expected)
    assert not any(re.search(r"(?<!\\)<", line) for line in lines)
    table = [[cell.strip() for cell in re.findall(r"(?:\\.|[^\\|])+", line)] for line in lines]
    assert {*map(len, table)} == {len(table[0])}
    cells = [row[table[0].index(heading)] for row in table[2:]]
    assert [re.sub(r"\\(.)", r"\1", cell) for cell in cells] == expected


@pytest.mark.filterwarnings("always:Glyph")
def test_figures_are_drawn_and_name_a_missing_glyph_once(plane, rows, irg, tmp_path):
    for store in (plane, rows):
        output = irg("plot", store, "-o", tmp_path / "a.svg")
        assert output.count("FIRE") == 1
        drawn = ElementTree.parse(tmp_path / "a.svg").getroot()
        assert not [part for part in drawn.iter() if part.tag.endswith("script")]


def test_the_report_shows_the_texts_and_has_no_tag_of_them(plane, rows, tmp_path, irg, undrawn):
    for store in (plane, rows):
        irg("report", store, "-o", tmp_path / "a.html")
        page = checked((tmp_path / "a.html").read_text(encoding="utf-8"))
        words = " ".join(page.words.split())
        for text in ACCEPTED.values():
            assert " ".join(text.split()) in words


def test_netcdf_keeps_the_texts(plane, rows, tmp_path):
    for store in (plane, rows):
        ds = pipeline.open_sweep(store)
        ds.to_netcdf(tmp_path / "a.nc")
        with xr.open_dataset(tmp_path / "a.nc") as copy:
            assert copy.attrs["title"] == ds.attrs["title"]
            assert "number" not in ds or copy["number"].values.tolist() == [*ACCEPTED.values()]
