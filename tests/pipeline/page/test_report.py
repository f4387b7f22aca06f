"""The report states the answers, escapes all texts, and has no scripts."""

import calendar
import re
from base64 import b64decode
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest

import pipeline
import tribo
from pipeline.answers.answer_frames import boundary_frame
from pipeline.answers.headline import to_decide
from pipeline.answers.value_text import format_limit, probability_text, verdict_text
from pipeline.figures.rows_figure import most_critical_row
from pipeline.frames import cells_of
from pipeline.page.report import HEADLINES
from pipeline.store.schema import PENDING
from tests.helpers import synthetic
from tests.helpers.entries import bare_test
from tests.helpers.kept import assert_as_kept
from tests.pipeline.conftest import leave_out_pictures
from tests.pipeline.figures.test_planes import VELOCITIES, two_pins
from tests.pipeline.figures.test_planes import sweep as plane
from tribo import InputError

HOSTILE = "\"><script>alert(1)</script><img src=x onerror=alert(2)> & 'a'"
VOID = {"meta", "img", "source", "br", "link"}
TESTS = (bare_test(250.0, 1.5, outcome="mild"), bare_test(500.0, 3.0, outcome="severe"))
RULING = (
    *synthetic.MEASURED,
    bare_test(300.0, 1.0, outcome="severe", bulk_temperature=280.0),
    *(bare_test(200.0, 3.0, outcome="mild", number=f"m{k}") for k in range(12)),
)


class Page(HTMLParser):
    """Tags of a page with their attributes, and its text; asserts that elements are nested."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words, self.inside = [], "", []
        self.feed(text)
        self.close()
        assert self.inside == []

    def handle_starttag(self, tag, attributes):
        assert len(dict(attributes)) == len(attributes), "an attribute is given twice"
        self.tags.append((tag, dict(attributes)))
        self.inside += [tag] * (tag not in VOID)

    def handle_endtag(self, tag):
        assert self.inside.pop() == tag
        self.words += " |" * (tag in ("td", "th"))

    def handle_data(self, data):
        self.words += data * ("style" not in self.inside)

    def attributes_of(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


def checked(text):
    """The parsed page, after checks of its HTML, labels for screen readers, and scripts."""
    assert text.startswith("<!DOCTYPE html>")
    page = Page(text)
    names = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len({*names}) == len(names)
    labels = {
        attributes["aria-labelledby"]
        for _, attributes in page.tags
        if "aria-labelledby" in attributes
    }
    assert labels <= {*names}
    levels = [tag for tag, _ in page.tags if re.fullmatch("h[1-6]", tag)]
    assert levels == ["h1", *["h2"] * (len(levels) - 1)]
    assert {tag for tag, _ in page.tags} <= {
        "html", "head", "meta", "title", "style", "body", "header", "h1", "p", "main", "section",
        "h2", "figure", "picture", "source", "img", "figcaption", "div", "table", "thead", "tbody",
        "tr", "th", "td", "ul", "li", "pre",
    }  # fmt: skip
    assert not any(name.startswith("on") for _, attributes in page.tags for name in attributes)
    assert len(page.attributes_of("tbody")) == len(page.attributes_of("table"))
    assert not re.search(r"<(ul|p)>\s*</", text)
    for image in page.attributes_of("img"):
        drawn = ElementTree.fromstring(b64decode(image["src"].partition("base64,")[2]))
        assert not [element for element in drawn.iter() if element.tag.endswith("script")]
    return page


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep((200.0, 400.0, 600.0, 750.0), (0.5, 1.0, 2.0, 4.0), tests=TESTS)


@pytest.fixture(scope="module")
def page(sweep):
    return pipeline.report(
        sweep, 400.0, "1.9 m/s", title=f"{HOSTILE}\udcff", author=HOSTILE, command=HOSTILE
    )


def test_the_verdict_stands_first_and_is_that_of_margin(sweep, page):
    margin, parsed = pipeline.margin(sweep, 400.0, 1.9), Page(page)
    (box,) = (
        section for section in parsed.attributes_of("section") if section.get("id") == "verdict"
    )
    assert box["class"] == verdict_text(margin)
    headline = f"{HEADLINES[margin['verdict'].item()]} at 400 N and 1.9 m/s"
    first = parsed.words[parsed.words.index(headline) :]
    limit = f"Mild up to {format_limit(margin['mild_velocity'].item())} m/s at this load"
    statement = f"Probability of severe wear {probability_text(margin['probability'].item())}"
    advice = f"To decide it, {to_decide(margin)}."
    positions = [first.index(text) for text in (limit, advice, statement, "Transition diagram")]
    assert positions == sorted(positions)


def test_the_tables_are_those_of_the_answers(sweep, page):
    cells = re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", page)
    table = boundary_frame(pipeline.boundary(sweep))
    for row in cells_of(table.iloc[:, 1:4], "–", digits=3):
        assert {*row} < {*cells}
    assert {"test", "outcome"} < {*cells}


def test_a_report_names_its_tables_and_what_each_error_comes_from(sweep, page):
    words = " ".join(Page(page).words.split())
    for text in (
        sweep.attrs["title"],
        "The operating point in numbers",
        "Tests, each at its own conditions, and what is computed for them",
        "The numerical error comes from the elements and load steps, from interpolation between "
        "simulated points, from the positions of the disk at which a pin at rest wears, and from "
        "the small number of simulated surfaces; more computing makes it smaller.",
        "The model error comes from the physics that is left out, and from the inputs; only tests "
        "make it smaller.",
    ):
        assert text in words


def test_nothing_of_a_user_is_read_as_html(page):
    parsed = checked(page)
    assert all(
        image["src"].startswith("data:image/svg+xml;base64,")
        for image in parsed.attributes_of("img")
    )
    assert parsed.words.count("<script>alert(1)</script>") == 4  # two titles, author, command
    policy = parsed.attributes_of("meta")[1]["content"]
    assert policy.startswith("default-src 'none'; img-src data:; style-src 'sha256-")
    assert "http:" not in page.replace("http-equiv", "")
    assert "https:" not in page


def test_a_screen_reader_finds_headings_captions_and_words_for_pictures(page):
    parsed = Page(page)
    assert parsed.attributes_of("html") == [{"lang": "en"}]
    assert len(parsed.attributes_of("table")) >= 3
    assert all("aria-labelledby" in element for element in parsed.attributes_of("table"))
    assert all(element["scope"] in ("col", "row") for element in parsed.attributes_of("th"))
    assert all(len(image["alt"]) > 40 for image in parsed.attributes_of("img"))


def half_done():
    later = {(load, speed): PENDING for load in (500.0, 600.0) for speed in VELOCITIES}
    return plane(status=later)


ONE_ROW = {
    "case": ["wear specific wear rate 1.2e-06 mm³/(N m)"], "load [N]": [300.0],
    "velocity [m/s]": [2.0],
}  # fmt: skip
REPORTS = {
    "boundary": (plane, {}),
    "point": (plane, {"load": 400.0, "velocity": 1.0}),
    "half done": (half_done, {}),
    "two pins": (two_pins, {"load": 300.0, "velocity": 4.0}),
    "a rolling pin": (lambda: plane(motion=tribo.Motion(slide_roll_ratio=0.5)), {}),
    "one load": (lambda: plane(loads=(300.0,)), {"load": 300.0, "velocity": 1.5}),
    "custom settings": (lambda: plane(preset=None), {}),
    "a row": (plane, {"points": ONE_ROW}),
    "tests that rule out": (lambda: plane(velocities=(0.5, 1.0, 2.0, 4.0), tests=RULING), {}),
}


@pytest.fixture(scope="module")
def reports():
    """Texts of the pages of `REPORTS`, without pictures."""
    with pytest.MonkeyPatch.context() as patch:
        leave_out_pictures(patch)
        return {name: pipeline.report(make(), **where) for name, (make, where) in REPORTS.items()}


@pytest.mark.parametrize("name", REPORTS)
def test_a_report_of_any_sweep_is_sound(reports, name):
    captions = [image["alt"] for image in checked(reports[name]).attributes_of("img")]
    # The points of several cases would cover each other, and one load has no diagram.
    has_dots = name not in ("two pins", "one load")
    assert any("Dots: simulated points." in text for text in captions) == has_dots


def test_reports_read_as_they_are_kept(reports):
    texts, date = {}, re.compile(rf"\d\d ({'|'.join(calendar.month_name[1:])}) \d{{4}}")
    for name, text in reports.items():
        assert len(date.findall(text)) == 1
        page = Page(date.sub("(date)", text))
        captions = [image["alt"] for image in page.attributes_of("img")]
        lines = filter(str.strip, page.words.splitlines())
        texts[name] = "\n".join([*lines, "pictures:", *captions])
    assert_as_kept("reports", texts)


def test_an_operating_point_at_the_ends_of_the_sweep_is_marked_in_the_diagram():
    page = Page(pipeline.report(plane(), 600.0, VELOCITIES[-1]))
    diagram = b64decode(page.attributes_of("img")[0]["src"].partition("base64,")[2]).decode()
    assert 'id="operating point"' in diagram


def test_a_report_has_a_point_or_a_table_of_points():
    words = "^give a load and a velocity, or a table of points, or neither$"
    for places in ({"load": 400.0}, {"load": 400.0, "velocity": 1.0, "points": ONE_ROW}):
        with pytest.raises(InputError, match=words):
            pipeline.report(plane(), **places)


def test_a_report_of_rows_under_several_conditions_or_for_several_pins_is_refused():
    for ds, conditions, text in (
        (
            plane(),
            {"friction": [0.1, 0.2]},
            r"^a report has rows along one dimension, not along \['friction', 'place'",
        ),
        (two_pins(), {}, "the sweep has several cases; select one by pin_radius"),
    ):
        with pytest.raises(InputError, match=text):
            pipeline.report(ds, points=ONE_ROW, **conditions)


def test_rows_are_judged_and_the_deciding_one_is_bold(undrawn, sweep):
    points = {"case": ["idle", "full"], "load [N]": [200, 700], "velocity [m/s]": [1, 4]}
    table = pipeline.margin(sweep, points)
    assert most_critical_row(table) == 1
    page = pipeline.report(sweep, points=points)
    assert "Severe wear (scuffing) at the most critical operating point: full" in page
    assert re.search(r'<tr class="bold"><th scope="row">full</th>', page)


def test_rows_without_a_verdict_leave_the_headline_open(undrawn, sweep):
    points = {"case": ["idle", "beyond"], "load [N]": [200, 9000], "velocity [m/s]": [1, 4]}
    page = checked(pipeline.report(sweep, points=points))
    (box,) = (
        section for section in page.attributes_of("section") if section.get("id") == "verdict"
    )
    assert box["class"] == ""
    assert "1 of 2 operating points have a verdict; mild at the most critical" in page.words


def test_a_report_refers_to_no_command(sweep):
    words = Page(pipeline.report(sweep, 400.0, 1.0, added_rise_fraction=0.06)).words
    assert "6 % is added to the rise for effects outside the model" in words
    assert "irg help" not in words


def test_a_report_of_a_point_outside_is_refused(sweep):
    with pytest.raises(InputError, match=r"load 4000 N is outside the sweep \(200 to 750 N\)"):
        pipeline.report(sweep, 4000.0, 1.0)


def test_a_report_has_the_scene_with_all_that_it_extends(undrawn, sweep):
    page = checked(pipeline.report(sweep.assign_attrs(scene=f"a = 1\n{HOSTILE}"), 400.0, 1.9))
    assert f"a = 1\n{HOSTILE}" in page.words


def test_a_report_states_why_a_verdict_is_withheld(undrawn):
    mild = [bare_test(400.0, 1.4, outcome="mild", number=f"m{k}") for k in range(40)]
    severe = bare_test(300.0, 0.9, outcome="severe", number="weak")
    withheld = synthetic.sweep(tests=(*mild, severe))
    page = checked(pipeline.report(withheld, 300.0, 0.95))
    reason = pipeline.margin(withheld, 300.0, 0.95)["reason"].item()
    assert reason.endswith("rules it out")
    assert f"Without a verdict: {reason}" in page.words
