"""Exports of machines, by `irg tests`: what each is taken for, and its right values."""

import re

import numpy as np
import pytest

from pipeline.laboratory.exports import exports
from tests.pipeline.laboratory import samples

TRACES = {
    # name of the sample: its form, what it lacks, and its velocity
    "rtec": ("rtec", {"track_radius": "20 mm"}, samples.SPEED),
    "umt": ("umt", {"velocity": "0.7 m/s"}, 0.7),
    "compend": ("compend", {}, 2 * 25 * 10e-3),
    "trb3": ("trb3", {}, samples.SPEED),
    "sine": ("trb3", {}, 0.6366 * samples.SPEED),
    "t11": ("t11", {"load": "50 N", "track_radius": "20 mm"}, samples.SPEED),
    "mtm": ("mtm", {}, 0.5),
}
LOAD = {"mtm": 0.1}  # load over the load of the other samples' run
NO_OIL = {"umt", "trb3", "sine", "t11"}


def write(folder, name, content):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def options(given):
    return [x for name, value in given.items() for x in ("--given", f"{name}={value}")]


def number(text):
    return float(text.split()[0])


def assert_run(document, name, velocity):
    """Assert the run of all samples: stages of 40 s, and friction that rises in the fourth."""
    stages, share = document["stages"], LOAD.get(name, 1.0)
    # The T-11 does not record the load, which is given.
    loads = [50.0] if name == "t11" else share * np.unique(samples.STAGES)
    assert [one["load [N]"] for one in stages] == pytest.approx([*loads], rel=0.005)
    (rise,) = document["rises"]
    assert rise["time [s]"] == pytest.approx(140, abs=1)
    assert (rise["from"], rise["to"]) == pytest.approx((0.1, 0.3), rel=0.02)
    for stage in stages:
        assert stage["velocity [m/s]"] == pytest.approx(velocity, rel=1e-3)
        warm = stage["temperature [degC]"]
        assert warm == (None if name in NO_OIL else pytest.approx(80, abs=0.1))
    assert stages[0]["friction steady"] == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize("name", TRACES)
def test_a_run_of_a_machine_is_read_with_what_it_lacks(tmp_path, irg, name):
    form, given, velocity = TRACES[name]
    path = write(tmp_path, "run.txt", getattr(samples, name)())
    document = irg("tests", path, *options(given), "--json")
    assert document["form"][0] == exports()[form].title
    assert document["scene"] == exports()[form].scene or document["scene"] is None
    assert_run(document, name, velocity)
    if given:  # without these options the answer or the error says what to give
        code = 2 if name == "t11" else 0
        asked = irg("tests", path, "--outcome", "mild", code=code)
        assert all(re.search(rf'--given "{one}=\.\.\. \w+', asked) for one in given)


VARIANTS = {
    "utf-16": lambda text: text.encode("utf-16"),
    "bom": lambda text: text.encode("utf-8-sig"),
    "cp1252": lambda text: text.encode("cp1252"),
    "crlf": lambda text: text.replace("\r\n", "\n").replace("\n", "\r\n").encode(),
    "blank lines": lambda text: text.replace("\n", "\n\n").encode(),
    "german": lambda text: text.replace(",", ";").replace("\t", ";").replace(".", ",").encode(),
}


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("name", ["rtec", "umt"])
def test_the_encoding_and_the_marks_of_an_export_do_not_matter(tmp_path, irg, name, variant):
    text, given = getattr(samples, name)(), TRACES[name][1]
    if variant == "german":
        text = re.sub(r"(?m)^.*(DAQ|XYZ|Rotary).*$", lambda row: row[0].replace(".", "·"), text)
    content = VARIANTS[variant](text)
    content = content.replace("·".encode(), b".")
    document = irg("tests", write(tmp_path, "run.csv", content), *options(given), "--json")
    assert_run(document, name, TRACES[name][2])


def test_results_of_srv_are_ends_of_a_run_and_a_step_apart(tmp_path, irg):
    pytest.importorskip("openpyxl")
    path = write(tmp_path, "results.xlsx", samples.srv())
    document = irg("tests", path, "--json")
    ends = [(one.get("mild_up_to"), one.get("severe_at")) for one in document["tests"]]
    assert ends == [("700 N", "800 N"), ("2000 N", None), ("500 N", None)]
    for heads, cells, ends in (
        ("O.K. load [N]", "500", ("500 N", "600 N")),
        ("Seizure load [N]", "500", ("400 N", "500 N")),
        ("O.K. load [N]", ">2000", ("2000 N", None)),
    ):
        text = f"SRV {heads};Frequency [Hz];Stroke [mm]\n{cells};50;1\n"
        (one,) = irg("tests", write(tmp_path, "srv.csv", text), "--json")["tests"]
        assert (one["mild_up_to"], one.get("severe_at")) == ends
    assert {number(one["velocity"]) for one in document["tests"]} == {0.1}
    assert [one["oil"] for one in document["tests"]] == ["A", "B", "C"]
    said = irg("tests", path)
    assert 'sheet "Results" (not read: Cover; --sheet names another)' in said
    assert "irg new rig.toml --from srv" in said


def test_a_form_is_named_where_a_file_has_too_few_signs(tmp_path, irg):
    text = samples.trb3().replace("TriboX 4.5\nTribometer\tTRB3\n", "Linear mode\n")
    text = re.sub("Sequence ID|Max linear speed|Nominal load", "speed", text, count=1)
    text = text.replace("Max linear speed", "v").replace("Nominal load", "set")
    path = write(tmp_path, "run.txt", text)
    plain = irg("tests", path, "--json")
    named = irg("tests", path, "--form", "trb3", "--json")
    assert plain["form"][0] != named["form"][0] == "Anton Paar TRB3"
    assert "no form" in irg("tests", path, "--form", "trb", code=2)
    assert 'did you mean "trb3"' in irg("tests", path, "--form", "trb", code=2)


def test_each_export_has_a_sample():
    forms = {form for form, *_ in TRACES.values()}
    assert {*exports()} == forms | {"srv"}  # tested above
