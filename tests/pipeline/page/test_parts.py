"""What a page says of its sweep: words, points, numbers."""

import base64
import json
import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

import pipeline
from pipeline.page.content import content
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic
from tests.helpers.javascript import run

OWN = synthetic.conditions()


def test_a_page_says_what_it_holds(tmp_path):
    page = pipeline.explore(synthetic.sweep(fields=True), tmp_path / "page.html", 6)
    assert str(page).endswith("page.html: 180 points, 6 with fields")
    assert page.as_dict()["path"] == str(tmp_path / "page.html")
    assert "384 × 432 µm; sliding to the right" in page.path.read_text()
    page = pipeline.explore(sweeps.over_surfaces(), tmp_path / "page.html")
    assert str(page).endswith(" points")


def text_of(ds, folder, **options):
    """Text of the page of a sweep, without tags."""
    written = pipeline.explore(ds, folder / "page.html", **options).path.read_text()
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", written)).split())


def test_a_duty_that_cannot_be_judged_is_named_and_the_others_are_shown(tmp_path):
    duties = {"load [N]": [400.0, 5000.0], "velocity [m/s]": [2.0, 1.0], "part": ["a", "b"]}
    text = text_of(synthetic.sweep(), tmp_path, points=duties)
    table = pipeline.margin(synthetic.sweep(), duties)
    assert table["verdict"].to_list() == ["not decided", "not known"]
    assert f"{table['distance [K]'][0]:.4g}" in text
    assert "5000 N at 1 m/s: load is 5000 N; the sweep has 200 to 750 N" in text


def test_without_a_critical_temperature_a_page_says_what_is_not_known(tmp_path):
    ds = synthetic.sweep(conditions=replace(OWN, critical_temperature=None))
    text = text_of(ds, tmp_path)
    assert "Not known: the scene has no critical temperature." in text
    told = run(ds, "return content.loads.map((load) => outcomeText('velocity', load));")
    assert {*told} == {"not known"}
    assert "pin.radius" in text


def test_facts_of_a_page_are_those_of_its_sweep():
    held = content(synthetic.sweep())
    ends = "200 to 750 N, 0.5 to 4 m/s"
    assert held["outside"] == f"Type a load and a velocity within the sweep: {ends}."
    assert held["friction_band"] == (0.09, 0.103)
    assert (held["loads"][-1], held["velocities"][0]) == (750.0, 0.5)
    by_label = {one["label"]: one for one in held["numbers"]}

    def values(label):
        return np.frombuffer(base64.b64decode(by_label[label]["values"]), "<f4").reshape(12, 15)

    # At 750 N and 4 m/s, by the closed forms of the sweep.
    time = 750.0 / synthetic.RATE
    area = 0.416e-3 * 3.4e-3  # of the window along x and the whole pin along y [m²]
    for label, unit, value in (
        ("contact width", "µm", 9.0 * 750**0.5 * 1.8),
        ("contact area", "% of the window", 1.2 * 750**0.5),
        ("mean pressure", "GPa", 1e-9 * 750**0.5 / (0.012 * area)),
        ("highest pressure", "GPa", 6.6),
        ("contact at the hardness", "%", 2.0 + 0.01 * 750),
        ("wear depth", "µm", 2e-3 * 4.0 * 750**0.9),
        ("worn volume", "mm³", 1.2e-6 * 0.5 * synthetic.RATE * time**2 * 4.0),
        ("pin’s share of the heat", "%", 40.0),
        ("sliding distance", "m", 4.0 * time),
        ("duration", "s", time),
    ):
        assert by_label[label]["unit"] == unit
        assert values(label)[-1, -1] == pytest.approx(value, rel=1e-6), label
    marked = synthetic.sweep(status={(200.0, 0.5): 2, (250.0, 1.0): 0})
    marked["message"][3, 2] = "careful"
    held = content(marked)
    assert held["messages"] == {"0": "out of memory", str(3 * 15 + 2): "careful"}
    assert json.dumps(held, allow_nan=False)
