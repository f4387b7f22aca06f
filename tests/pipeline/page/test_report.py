"""The report: what stands in it is what the answers say, escaped, without scripts."""

import re
from html.parser import HTMLParser

import pytest

import pipeline
from pipeline.answers.frames import boundary_frame
from pipeline.answers.tables import cells_of
from pipeline.answers.words import percent
from pipeline.figures.rows import deciding_row
from pipeline.page.report import HEADLINES
from tests.helpers import synthetic
from tests.helpers.entries import bare_test
from tribo import InputError

HOSTILE = "\"><script>alert(1)</script><img src=x onerror=alert(2)> & 'a'"
TESTS = (
    bare_test(250.0, 1.5, outcome="mild"),
    bare_test(500.0, 3.0, outcome="severe"),
)


class Page(HTMLParser):
    """Tags of a page with their attributes, and its text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words = [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_data(self, data):
        self.words += data

    def of(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep(measured=(), tested=TESTS)


@pytest.fixture(scope="module")
def page(sweep):
    return pipeline.report(sweep, 400.0, "1.9 m/s", title=HOSTILE, author=HOSTILE, command=HOSTILE)


def test_the_verdict_stands_first_and_is_that_of_margin(sweep, page):
    here, found = pipeline.margin(sweep, 400.0, 1.9), Page(page)
    (box,) = (one for one in found.of("section") if one.get("id") == "verdict")
    verdict = here["verdict"].item()
    assert box["class"] == verdict
    first = found.words[found.words.index(f"{HEADLINES[verdict]} at 400 N and 1.9 m/s") :]
    assert f"severe wear is {percent(here['probability'].item())} likely" in first
    assert first.index("severe wear is") < first.index("Transition diagram")


def test_the_tables_are_those_of_the_answers(sweep, page):
    cells = re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", page)
    for row in cells_of(boundary_frame(pipeline.boundary(sweep)).iloc[:, 1:4], "–", digits=3):
        assert {*row} < {*cells}
    assert {"test", "outcome", "computed"} < {*cells}


def test_nothing_of_a_user_is_read_as_html(page):
    found = Page(page)
    assert not found.of("script")
    assert all(image["src"].startswith("data:image/svg+xml;base64,") for image in found.of("img"))
    assert not any(name.startswith("on") for _, one in found.tags for name in one)
    assert found.words.count("<script>alert(1)</script>") == 4  # two titles, author, command
    policy = found.of("meta")[1]["content"]
    assert policy.startswith("default-src 'none'; img-src data:; style-src 'sha256-")
    assert "http:" not in page.replace("http-equiv", "")
    assert "https:" not in page


def test_a_screen_reader_finds_headings_captions_and_words_for_pictures(page):
    found = Page(page)
    assert found.of("html") == [{"lang": "en"}]
    assert len(found.of("h1")) == 1
    assert len(found.of("caption")) == len(found.of("table")) >= 3
    assert all(one["scope"] in ("col", "row") for one in found.of("th"))
    assert all(len(image["alt"]) > 40 for image in found.of("img"))


def test_rows_are_judged_and_the_deciding_one_is_bold(sweep):
    points = {"case": ["idle", "full"], "load [N]": [200, 700], "velocity [m/s]": [1, 4]}
    table = pipeline.margin(sweep, points)
    assert deciding_row(table) == 1
    page = pipeline.report(sweep, points=points)
    assert "Severe wear (scuffing): decided by full" in page
    assert re.search(r'<tr class="bold"><th scope="row">full</th>', page)


def test_without_a_point_the_boundary_is_told(sweep, tmp_path):
    path = pipeline.report(sweep, out=tmp_path / "a.html")
    text = path.read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>")
    assert "Severe wear is 50 % likely at" in text


def test_refusals(sweep, tmp_path):
    with pytest.raises(InputError, match=r"suffix must be one of .html, .pdf"):
        pipeline.report(sweep, out=tmp_path / "a.docx")
    with pytest.raises(InputError, match="give a load and a velocity"):
        pipeline.report(sweep, 400.0)
    with pytest.raises(InputError, match="the sweep has"):
        pipeline.report(sweep, 4000.0, 1.0)


def test_a_page_prints_on_a4(sweep, tmp_path):
    pytest.importorskip("weasyprint")
    written = pipeline.report(sweep, 400.0, 2.0, tmp_path / "a.pdf").read_bytes()
    assert written.startswith(b"%PDF-1.7")
