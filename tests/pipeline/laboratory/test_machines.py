"""Forms of the usual machines, as tests of a scene."""

import math

import numpy as np
import pytest

import pipeline
from pipeline.gears.reading import read_pair
from pipeline.laboratory.logs import read_log, read_trace
from pipeline.scene.library import library
from pipeline.sweep.about import Measurement

FZG = """Load stage;Pinion torque [Nm];Oil temp. [°C];Scuffing
8;239.25;90;no scuffing
9;302.0;90;no scuffing
10;372.6;90;scuffing
8;239.25;90;no scuffing
9;302.0;90;scuffing
"""
FZG_RESULTS = "Test;Failure load stage\n1;9\n2;> 12\n3;1\n4;12+\n"
SRV = """Step,Load [N],Frequency [Hz],Stroke [mm],Temperature [°C],COF,Result
1,100,50,1.0,120,0.12,ok
2,200,50,1.0,120,0.12,ok
3,300,50,1.0,120,0.18,seizure
"""
SRV_PASSED = "Sample,O.K. load [N],Frequency [Hz]\na,800,50\nb,>2000,50\n"
TURNING = """Load [N],n1 [rpm],n2 [rpm],Disc diameter [mm],Result
500,1000,800,80,ok
700,1000,800,80,scuffing
"""
SLIP = "Load [N],SRR [%],Rolling speed [m/s],Outcome\n500,20,5,ok\n700,20,5,scuffing\n"


def rows(tmp_path, text, **given):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    log = read_log(path, {"given": given})
    assert log.faults == []
    return [
        (test["load"], test["velocity"], test["outcome"], test.get("run")) for test in log.in_si
    ]


def test_stages_of_gears_are_runs_that_end_where_the_load_falls(tmp_path):
    radius = 0.5 * 4.5e-3 * 16 * math.cos(math.radians(20))
    torques = [239.25, 302.0, 372.6, 239.25, 302.0]
    found = rows(tmp_path, FZG, velocity="5 m/s")
    assert [row[0] for row in found] == pytest.approx([t / radius for t in torques], rel=1e-5)
    assert [row[2:] for row in found] == [
        ("mild", 1), ("mild", 1), ("severe", 1), ("mild", 2), ("severe", 2),
    ]  # fmt: skip
    gears = read_pair("fzg_a").gears
    assert library()["machines"]["FZG"]["base_radius"] == pytest.approx(
        gears.base_radii[0], rel=1e-5
    )


def test_a_failure_stage_is_an_interval_and_one_beyond_the_last_is_a_tail(tmp_path):
    found = rows(tmp_path, FZG_RESULTS, velocity="5 m/s")
    radius, stages = (library()["machines"]["FZG"][name] for name in ("base_radius", "stages"))
    numbers = [stages.index(pytest.approx(row[0] * radius, rel=1e-4)) + 1 for row in found]
    assert [*zip(numbers, (row[2] for row in found), strict=True)] == [
        (8, "mild"), (9, "severe"), (12, "mild"), (1, "severe"), (12, "mild"),
    ]  # fmt: skip
    assert [row[3] for row in found] == [2, 2, 3, 4, 5]


def test_a_reciprocating_rig_slides_at_twice_frequency_times_stroke(tmp_path):
    found = rows(tmp_path, SRV)
    assert found == [(100, 0.1, "mild", 1), (200, 0.1, "mild", 1), (300, 0.1, "severe", 1)]
    again = SRV.replace("3,300", "3,200")  # a load that does not rise begins another specimen
    assert [row[3] for row in rows(tmp_path, again)] == [1, 1, 2]
    seized = "Sample,Seizure load [N],Frequency [Hz]\na,800,50\n"
    found = rows(tmp_path, seized, stroke="2 mm")
    assert found == [(700, 0.2, "mild", 2), (800, 0.2, "severe", 2)]
    named = "SRV\nTest load [N],Sliding speed [m/s],Result\n100,0.1,ok\n200,0.1,ok\n"
    assert rows(tmp_path, named) == [(100, 0.1, "mild", 1), (200, 0.1, "mild", 1)]
    found = rows(tmp_path, SRV_PASSED, stroke="2 mm")
    assert found == [(800, 0.2, "mild", 2), (900, 0.2, "severe", 2), (2000, 0.2, "mild", 3)]


def test_the_name_of_a_machine_before_a_quantity_does_not_hide_it(tmp_path):
    found = rows(tmp_path, "Oil,FZG A/8.3/90 failure load stage\nA,11\nB,>12\n", velocity="5 m/s")
    assert [row[2] for row in found] == ["mild", "severe", "mild"]
    text = "Oil,SRV O.K.-load [N],Frequency [Hz],Stroke [mm]\nA,>2000,50,1\n"
    assert rows(tmp_path, text) == [(2000, 0.1, "mild", 2)]


def test_remarks_are_outcomes_where_one_is_severe(tmp_path):
    remarked = SRV.replace("Result", "Remarks")
    assert [row[2] for row in rows(tmp_path, remarked)] == ["mild", "mild", "severe"]
    path = tmp_path / "log.csv"
    path.write_text(remarked.replace("seizure", "ok"), encoding="utf-8")
    assert "outcome" not in read_log(path).sheet.places


def test_columns_named_as_in_a_scene_are_those_of_the_contact(tmp_path):
    path = tmp_path / "srv.csv"
    path.write_text("load [N],velocity [m/s],outcome\n400,2,mild\n", encoding="utf-8")
    assert read_log(path).in_si[0]["load"] == 400.0


def test_discs_slide_at_the_difference_of_their_speeds(tmp_path):
    sliding = math.pi * 0.08 * 200 / 60
    assert rows(tmp_path, TURNING) == [
        (500, pytest.approx(sliding, rel=1e-5), "mild", 1),
        (700, pytest.approx(sliding, rel=1e-5), "severe", 1),
    ]
    assert rows(tmp_path, SLIP) == [(500, 1.0, "mild", 1), (700, 1.0, "severe", 1)]


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        (FZG, 'does not say velocity; give --given "velocity=... m/s"'),
        ("Kraftstufe;Result\n9;ok\n", "does not say velocity; give"),
        (SRV_PASSED, 'does not say stroke; give --given "stroke=... mm"'),
        (SRV.replace("Frequency [Hz],", "Speed,"), "does not say frequency; give"),
        (TURNING.replace("Disc diameter", "Room"), '--given "diameter=... mm"'),
    ],
)
def test_what_a_form_does_not_say_is_asked_in_a_line(tmp_path, irg, text, asked):
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    said = irg("tests", tmp_path / "log.csv", code=2)
    assert "1 fault:" in said
    assert asked in said


def test_a_scene_reads_a_form_with_what_is_given(tmp_path, irg):
    (tmp_path / "fzg.csv").write_text(FZG_RESULTS, encoding="utf-8")
    said = irg("tests", tmp_path / "fzg.csv", "--given", "velocity=5 m/s")
    assert "5 tests of 4 runs: 3 mild, 2 severe" in said
    toml = said[said.index("[[tested]]") :]
    assert 'given = { velocity = "5 m/s" }' in toml
    lines = [line for line in toml.splitlines() if " = " in line and "form" not in line]
    text = 'extends = "first_try"\nwithout = ["measured"]\n[[tested]]\n'
    (tmp_path / "lab.toml").write_text(text + "\n".join(lines), encoding="utf-8")
    first, second, *_ = pipeline.load_scene(tmp_path / "lab.toml").about.tested
    assert isinstance(first, Measurement)
    assert first.run == second.run
    assert (first.outcome, second.outcome) == ("mild", "severe")
    assert first.normal_load < second.normal_load
    said = irg("tests", tmp_path / "fzg.csv", "--given", "warmth=5 m/s", code=2)
    assert "given.warmth: no such quantity; give one of load" in said


@pytest.mark.parametrize(("fails", "stages"), [(150, (700, 800)), (None, (1000, None))])
def test_a_trace_by_steps_is_a_run(tmp_path, fails, stages):
    chance = np.random.default_rng(1)
    times = np.arange(200)
    loads = 100 * (1 + times // 20) + chance.standard_normal(200)
    friction = 0.1 + 0.002 * chance.standard_normal(200)
    friction[fails or 200 :] += 0.08
    columns = zip(times.tolist(), loads.tolist(), friction.tolist(), strict=True)
    text = "\n".join(f"{a},{b:.1f},{c:.4f}" for a, b, c in columns)
    path = tmp_path / "trace.csv"
    path.write_text(f"Time [s],Load [N],Friction\n{text}\n", encoding="utf-8")
    told = dict(
        line.split(" = ")
        for line in read_trace(path, {"given": {"velocity": "2 m/s"}}).toml()
        if "=" in line
    )
    mild, severe = stages
    assert float(told["mild_up_to"].strip('"').split()[0]) == pytest.approx(mild, rel=0.005)
    assert told["velocity"] == '"2 m/s"'
    assert "load" not in told
    if severe:
        assert float(told["severe_at"].strip('"').split()[0]) == pytest.approx(severe, rel=0.005)
    assert ("severe_at" in told) == bool(severe)
