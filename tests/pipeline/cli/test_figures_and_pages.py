"""Options of figures, and how pages are printed."""

import pytest
import xarray as xr

import pipeline
from pipeline.answers.simulated_points import WarnedPoints
from pipeline.shipped import shipped_pages


@pytest.fixture
def drawn(monkeypatch):
    """List to which each call of `pipeline.plot` by a command adds its arguments."""
    calls, opened = [], xr.Dataset()

    def draw(ds, kind, out, **options):
        assert ds is opened
        calls.append((kind, str(out), options))
        return out

    monkeypatch.setattr(pipeline, "open_sweep", lambda store: opened)
    monkeypatch.setattr(pipeline, "plot", draw)
    monkeypatch.setattr(pipeline, "points_with_warnings", lambda ds: WarnedPoints())
    return calls


@pytest.mark.parametrize(
    ("words", "kind", "out", "look"),
    [
        ([], None, "a/out_diagram.png", {}),
        (["--log", "--width", "8.5 cm", "--plain", "-o", "x.pdf"], None, "x.pdf",
         {"log": True, "width": 0.085, "plain": True}),
        (["--kind", "tests", "--friction", "0.1"], "tests", "a/out_tests.png", {"friction": "0.1"}),
        (["--load", "400 N", "--velocity", "2 m/s", "--dpi", "100"], None, "a/out_diagram.png",
         {"load": [400.0], "velocity": [2.0], "dpi": 100}),
    ],
)  # fmt: skip
def test_a_figure_is_drawn_as_its_options_say(irg, drawn, words, kind, out, look):
    assert irg("plot", "a/out.zarr", *words) == f"{out}\n"
    assert drawn == [(kind, out, look)]
    assert irg("plot", "a/out.zarr", *words, "--json") == {"kind": kind, "file": out}


def test_pages_are_listed_with_their_titles_and_printed_as_they_are(irg):
    pages = shipped_pages()
    titles = irg("help", "--json")
    assert {*titles} == {*pages, "library"}
    assert all(f"# {titles[name]}\n" in pages[name].read_text("utf-8") for name in pages)
    first, *lines, last = irg("help").splitlines()
    assert first == "To begin:"
    assert last == "Help on a command: irg COMMAND --help"
    assert {line.split()[2] for line in lines if line.startswith("  ")} == {*titles}
    text = pages["first-hour"].read_text("utf-8")
    assert irg("help", "first-hour") == f"{text.removesuffix(chr(10))}\n"
    assert irg("help", "first-hour", "--json") == {"page": "first-hour", "text": text}
    assert irg("help", "run") == irg("run", "--help")


def test_the_library_is_a_page_with_the_source_of_each_number(irg):
    page = irg("help", "library")
    assert '[materials."42CrMo4"]' in page or "[materials.42CrMo4]" in page
    assert "42.6 W/(m K)" in page
    assert 'meusburger = "Meusburger, data sheet of 1.7225"' in page
