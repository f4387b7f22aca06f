"""A report holds what a reader without the tool asks for, in one file."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline.report.report import citation, sections_of_samples
from pipeline.scene.along import OperatingPoints
from pipeline.sweep.about import FromLibrary
from tests.helpers import page_sweeps as sweeps
from tests.helpers import samples, synthetic
from tests.helpers.scenes import STEEL

POINTS = {"load": ["300 N", "500 N"], "velocity": ["1.5 m/s", "2 m/s"], "gear": ["first", "second"]}
HEADINGS = (
    "Question and answer", "Transition diagram", "Boundary in numbers", "Tests",
    "Operating points", "Warnings", "Inputs", "Numerical choices", "Model",
    "Versions", "Citation",
)  # fmt: skip


@pytest.fixture
def sweep():
    velocities = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
    return synthetic.sweep(
        (200.0, 400.0, 600.0, 750.0),
        velocities,
        pin=tribo.Cylinder(5e-3, 3.4e-3, STEEL),
        fidelity=tribo.Fidelity(pixels_per_element=1, increments=5),
        preset="draft",
        sources=(FromLibrary("disk.density", "7800 kg/m^3", "a <handbook>"),),
    )


def test_a_report_has_everything_and_asks_for_no_other_file(sweep, tmp_path):
    page = pipeline.report(sweep, tmp_path / "report.html", POINTS).read_text(encoding="utf-8")
    assert re.findall("<h2>(.*)</h2>", page) == list(HEADINGS)
    margin = pipeline.margin(sweep, 300.0, 1.5)
    for words in ("pin.radius", "5 mm", "a &lt;handbook&gt;", "first", f"{margin.distance:.4g}"):
        assert f"<td>{words}</td>" in page
    crossing = pipeline.boundary(sweep)["critical_velocity"].sel(load=600).item()
    assert f"<td>{crossing:.4g}</td>" in page
    assert "may err by up to 5 %" in page
    assert re.search(r"developers: irg-transition \(version .*\)\. BSD-3-Clause\.", page)
    assert not re.search(r'(src|href)="(?!data:|#)', page)


def test_a_report_of_surfaces_answers_by_the_median_of_those_that_are_done(tmp_path):
    parts = [sweeps.one(status={}, rise=sweeps.uneven(seed)) for seed in range(3)]
    ds = xr.concat(parts, xr.Variable("realization", range(3)), combine_attrs="override")
    page = pipeline.report(ds, tmp_path / "report.html").read_text(encoding="utf-8")
    velocities = pipeline.boundary(ds)["critical_velocity"].dropna("load", how="any")
    median = velocities.median("realization")[-1].item()
    assert f"{median:.3g} m/s on at {velocities['load'][-1].item():g} N" in page
    assert "on half of 3 surfaces" in page


def test_a_report_cites_what_the_citation_file_has():
    file = (Path(__file__).parents[3] / "CITATION.cff").read_text(encoding="utf-8")
    entries = re.findall(r"^\s*(?:title|version|license|- family-names): (.+)$", file, re.MULTILINE)
    cited = "\n".join(citation())
    assert len(entries) == 6
    assert [entry for entry in entries if entry.strip('"') not in cited] == []


def test_a_report_says_what_it_lacks(tmp_path):
    status = {(load, 3.0): 0 for load in (200.0, 400.0)}
    conditions = synthetic.CONDITIONS | {"critical_temperature": None}
    ds = synthetic.sweep((200.0, 400.0), (1.0, 3.0), status=status, conditions=conditions)
    page = pipeline.report(ds, tmp_path / "report.html")
    assert "The sweep is not finished" in page.read_text()
    assert "Not in this report" in page.read_text()


def test_a_sweep_of_samples_is_answered_by_probabilities():
    ensemble = samples.ensemble()
    points = OperatingPoints.read({"load [N]": [400.0, 5000.0], "velocity [m/s]": [2.2, 1.0]})
    ds = samples.dataset(ensemble, measured=(), tested=(), model_scatter=0.0)
    written = sections_of_samples(ds, points)
    headings = "Question and answer", "Boundary in numbers", "Operating points"
    (_, question), (_, table, *_), (risks, *notes) = (list(written[name]) for name in headings)
    (critical,) = samples.critical_velocity(np.array([[418.15, 1.2e-15, 0.1, 4.5e-6]]), 200.0)
    middle = float(re.search(r"from ([\d.]+) m/s on at 200 N", question)[1])
    assert middle == pytest.approx(critical, rel=0.03)
    assert len(table) == len(ensemble.loads)
    chance = pipeline.margin(ds, 400.0, 2.2)
    here, beyond = risks.to_dict("records")
    assert (here["load [N]"], beyond["load [N]"]) == (400.0, 5000.0)
    assert (here["probability"], here["verdict"]) == (chance.probability, chance.verdict)
    assert np.isnan(beyond["probability"])
    assert "load is 5000 N; the samples have 200 to 750 N" in " ".join(notes)


def test_a_report_of_samples_weighs_them_by_the_tests_if_asked_to(tmp_path, monkeypatch):
    samples.fewer_draws(monkeypatch)
    test = {"normal_load": 400.0, "velocity": 2.2, "friction": 0.1}
    tested = samples.dataset(samples.ensemble(tests=[test]))
    tested["warning_flags"] = tested["status"] * 0
    out = pipeline.report(pipeline.at(tested, given_measured=True), tmp_path / "weighed.html")
    weighed = out.read_text()
    assert "Not known exactly, given 1 measured transition" in weighed
    assert "before the tests" in weighed
    assert "inferred from the tests" in weighed
    plain = pipeline.report(tested, tmp_path / "plain.html")
    assert "Not known exactly, before any test" in plain.read_text()
