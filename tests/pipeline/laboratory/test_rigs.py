"""Which rig a log is of, and what its cells say: what must come out of its text."""

import numpy as np
import pytest

import pipeline
from pipeline.laboratory.logs import outcome_of, read_log, read_trace
from tests.pipeline.laboratory.test_machines import rows


def contacts(tmp_path, text, **given):
    return [pytest.approx(row[:2], rel=1e-4) for row in rows(tmp_path, text, **given)]


def faults(tmp_path, text, **given):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    return read_log(path, {"given": given}).faults


RADIUS = "Test,Load [kg],Speed [rpm],Track radius [mm],Result\n1,5,500,20,pass\n"
TRACK = "Test,Load [kg],Speed [rpm],Track diameter [mm],Result\n1,5,500,40,pass\n"
PIN = "Pin on disc\nNormal load (kg),Velocity (m/s),Result\n5,1,pass\n"
SEAM = "Load [N],Speed [m/s],Result,Weld seam\n5,1,ok,none\n"
POND = "Prüflast / kp;Gleitgeschw. / m/s;Ergebnis\n5;1;ok\n"


@pytest.mark.parametrize(
    ("text", "contact"),
    [
        (TRACK, (49.03325, 1.0472)),
        (RADIUS, (49.03325, 1.0472)),
        (f"Rig 2\n{TRACK}", (49.03325, 1.0472)),
        (PIN, (49.03325, 1)),
        (SEAM, (5, 1)),
        (POND, (49.03325, 1)),
    ],
)
def test_a_load_in_kilograms_is_that_of_the_contact(tmp_path, text, contact):
    assert contacts(tmp_path, text) == [contact]


@pytest.mark.parametrize(("text", "which"), [(TRACK, "diameter"), (RADIUS, "radius")])
def test_a_track_without_a_unit_is_asked_for_one(tmp_path, text, which):
    found = faults(tmp_path, text.replace(" [mm]", ""))
    assert f'has no unit; name it like "track {which} [mm]"' in found[-1]


@pytest.mark.parametrize(
    "text",
    [
        "Normalkraft [N];Gleitgeschwindigkeit [m/s];Drehmoment [Nm];Ergebnis\n400;2;1;ok\n",
        "Load [N],Speed [m/s],Torque [N m],Step,Result\n400,2,1,1,ok\n",
        "Rig FZG\nLoad [kN],Speed [m/s],Torque [N m],Result\n0.4,2,1,ok\n",
    ],
)
def test_a_torque_of_friction_makes_no_gears(tmp_path, text):
    assert contacts(tmp_path, text) == [(400, 2)]


@pytest.mark.parametrize(
    "head", ["Ritzelmoment [Nm]", "T1 [N m]", "FZG torque [Nm]", "Step;Torque [Nm]"]
)
def test_a_torque_of_the_pinion_or_beside_a_stage_makes_gears(tmp_path, head):
    cells = ";".join(["239.25"] * (1 + head.count(";")))
    found = contacts(tmp_path, f"{head};Result\n{cells};ok\n", velocity="5 m/s")
    assert found == [(7072.33, 5)]


@pytest.mark.parametrize("units", [";kN;Hz;mm;%;", "-;(kN);[Hz];mm;rel. %;ok/fail"])
def test_a_row_of_units_may_have_one_that_is_unknown(tmp_path, units):
    text = f"SRV\nRun;Load;Frequency;Stroke;Humidity;Result\n{units}\n1;0,1;50;1;40;ok\n"
    assert contacts(tmp_path, text) == [(100, 0.1)]
    assert read_log(tmp_path / "log.csv").left_out == []


def test_a_row_with_a_number_is_none_of_units(tmp_path):
    found = contacts(tmp_path, "oil,load [N],velocity [m/s],outcome\nA,400,2,ok\n")
    assert found == [(400, 2)]


SLIDING = "SRV\nLoad [kgf];Scar [mm];Frequency [Hz];Stroke [mm];Remarks\n63;0,41;50;1;ok\n"


def test_a_number_that_a_form_makes_is_never_doubted_but_those_it_is_made_of_are(tmp_path):
    text = SLIDING + "80;0,9;50;1;weld\n"
    assert contacts(tmp_path, text) == [(617.819, 0.1), (784.532, 0.1)]
    (fault,) = faults(tmp_path, text.replace("80;", "1.250;"))
    assert 'row 4, Load [kgf]: "1.250" beside decimal commas is 1.25 or 1250' in fault


def test_a_rotation_in_radians_is_no_number_of_turns(tmp_path):
    discs = "Load [N],n1 [rad/s],n2 [rad/s],Result\n500,100,80,ok\n"
    assert contacts(tmp_path, discs, diameter="80 mm") == [(500, 0.8)]
    (fault,) = faults(tmp_path, discs)
    assert "does not say diameter" in fault


@pytest.mark.parametrize(("ratios", "velocities"), [("1.5 20", (0.075, 1)), ("0.2 1.5", (1, 7.5))])
def test_a_column_of_slip_is_all_in_percent_or_none_of_it(tmp_path, ratios, velocities):
    lines = "".join(f"500,{ratio},5,ok\n" for ratio in ratios.split())
    found = contacts(tmp_path, f"Load [N],SRR,Rolling speed [m/s],Result\n{lines}")
    assert found == [(500, velocity) for velocity in velocities]


REPEATS = "load [N],velocity [m/s],outcome,rig\n" + "400,2,mild,A\n" * 3


@pytest.mark.parametrize(
    ("text", "twice"),
    [
        (REPEATS, []),
        (REPEATS.replace("outcome,rig", "outcome,friction").replace("A", "0.1"), [3, 4]),
        (REPEATS.replace("rig", "date") + "400,2,mild,B\n", [3, 4]),
        ("SRV ok load [N],Frequency [Hz],Stroke [mm]\n" + ">800,50,1\n" * 3, []),
    ],
)
def test_equal_rows_are_copies_only_where_one_tells_a_test(tmp_path, text, twice):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    log = read_log(path)
    assert (log.twice, log.faults) == (twice, [])
    assert len(log.tests) + len(twice) == 3 + ("B" in text)


def traced(tmp_path, load, velocity, friction):
    columns = zip(range(len(friction)), load, velocity, friction, strict=True)
    text = "\n".join(";".join(f"{cell:.4f}" for cell in cells) for cells in columns)
    path = tmp_path / "trace.csv"
    path.write_text(f"time [s];load [N];velocity [m/s];COF\n{text}\n", encoding="utf-8")
    return read_trace(path)


def test_a_trace_of_strokes_counts_by_its_magnitude(tmp_path):
    turning = np.resize([1, -1], 200)
    friction = np.where(np.arange(200) < 120, 0.1, 0.2) * turning
    trace = traced(tmp_path, [400] * 200, 0.1 * turning, friction)
    assert trace.row == 120
    assert [*trace.toml()][1:4] == ['load = "400 N"', 'velocity = "0.1 m/s"', "friction = 0.1"]


@pytest.mark.parametrize("rises", [True, False])
def test_a_trace_by_steps_of_the_velocity_is_a_run(tmp_path, rises):
    velocity = np.repeat([0.5, 1, 1.5, 2], 50)
    friction = np.where(rises & (velocity > 1.5), 0.2, 0.1)
    toml = "\n".join(traced(tmp_path, [400] * 200, velocity, friction).toml())
    stages = 'mild_up_to = "1.5 m/s"\nsevere_at = "2 m/s"' if rises else 'mild_up_to = "2 m/s"'
    assert toml == f'[[tested]]\n{stages}\nload = "400 N"\nfriction = 0.1'
    (tmp_path / "lab.toml").write_text(f'extends = "first_try"\nwithout = ["measured"]\n{toml}\n')
    tested = pipeline.load_scene(tmp_path / "lab.toml").about.tested
    assert [test.velocity for test in tested] == ([1.5, 2] if rises else [2])


@pytest.mark.parametrize("fails", [True, False])
def test_rows_at_rest_after_a_trace_do_not_count(tmp_path, fails):
    """The load runs down to 0 in ten rows, and the record goes on for 200."""
    load = np.concatenate([np.full(100, 400), np.linspace(360, 0, 10), np.full(200, 1)])
    friction = np.where(np.arange(310) < (80 if fails else 100), 0.1, np.where(load > 9, 0.3, 0))
    friction = friction if fails else np.minimum(friction, 0.1)
    trace = traced(tmp_path, load, np.full(310, 2), friction)
    assert (trace.row, len(trace.time)) == (80 if fails else None, 109)
    assert [*trace.toml()][1:4] == ['load = "400 N"', 'velocity = "2 m/s"', "friction = 0.1"]


def test_a_log_of_tests_with_their_times_is_no_trace(tmp_path):
    rows = [f"60,{load},2,0.1,{'Fresser' if load > 500 else 'ok'}" for load in range(200, 700, 20)]
    text = "\n".join(["time [s],load [N],velocity [m/s],COF,result", *rows])
    (tmp_path / "log.csv").write_text(text)
    assert read_trace(tmp_path / "log.csv") is None
    (tmp_path / "log.csv").write_text(text.replace("Fresser", "run").replace("ok", "run"))
    assert len(read_trace(tmp_path / "log.csv").time) == len(rows)


def test_a_trace_takes_the_columns_and_rows_that_are_named(tmp_path):
    rows = [f"{k},{0.1 + k // 60 / 10},{'AB'[k % 2]}" for k in range(100)]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],x,run", *rows]))
    entries = {"columns": {"friction": "x"}, "where": {"run": "B"}}
    trace = read_trace(tmp_path / "log.csv", entries)
    assert (trace.time[trace.row], len(trace.time)) == (61.0, 50)


def test_a_start_from_rest_is_no_step(tmp_path):
    velocity, friction = np.repeat([0, 2], [20, 180]), np.repeat([0.1, 0.2], [120, 80])
    toml = [*traced(tmp_path, [400] * 200, velocity, friction).toml()]
    assert toml[:3] == ["[[measured]]", 'load = "400 N"', 'velocity = "2 m/s"']


def test_a_run_of_stages_has_one_oil_and_ends_where_a_row_is_severe(tmp_path):
    heads = "Oil,Load [N],Frequency [Hz],Stroke [mm],Result\n"
    text = heads + "A,100,50,1,ok\nA,200,50,1,seizure\nB,300,50,1,ok\n"
    assert [row[3] for row in rows(tmp_path, text)] == [1, 1, 2]
    assert [row[3] for row in rows(tmp_path, text.replace("seizure", "ok"))] == [1, 1, 2]
    stages = ["8;ok", "9;fail", "10;ok", "11;fail"]
    text = "\n".join(["FZG load stage;Result", *stages])
    assert [row[3] for row in rows(tmp_path, text, velocity="5 m/s")] == [1, 1, 2, 2]


@pytest.mark.parametrize(
    ("lines", "row", "problem"),
    [
        ("1,A,400,2,mild\n1,B,500,2,mild\n", 3, "1 has two oils"),
        ("1,A,400,2,severe\n1,A,500,2,mild\n", 2, "1 is severe at 400 N"),
    ],
)
def test_a_run_that_no_specimen_is_is_named_by_file_and_row(tmp_path, irg, lines, row, problem):
    path = tmp_path / "log.csv"
    path.write_text(f"run,oil,load [N],velocity [m/s],outcome\n{lines}", encoding="utf-8")
    assert f"log.csv, row {row}, run: {problem}" in irg("tests", path, code=2)


STROKES = "SRV\nLoad [N],Frequency [Hz],Result\n100,50,ok\n"


@pytest.mark.parametrize("stroke", ["1 mm", "1mm", "0.1cm", "1"])
def test_a_clear_quantity_is_read_as_it_is_given(tmp_path, stroke):
    assert contacts(tmp_path, STROKES, stroke=stroke) == [(100, 0.1)]


@pytest.mark.parametrize("stroke", ["1,5 mm", "abc", "1 N", "10:1", ""])
def test_a_given_quantity_that_cannot_be_read_is_named(tmp_path, stroke):
    said = f'given.stroke: "{stroke}" is no stroke; give one like "1.5 mm"'
    assert faults(tmp_path, STROKES, stroke=stroke) == [said]


def test_all_quantities_that_are_given_wrongly_are_named(tmp_path):
    found = faults(tmp_path, STROKES, warmth="9", stroke="abc", hub="1 mm")
    names = ("given.warmth: no such", 'given.stroke: "abc" is no', "given.hub: no such")
    assert [one.startswith(name) for one, name in zip(found, names, strict=True)] == [True] * 3


def test_two_letters_without_a_unit_are_no_load(tmp_path):
    text = "SRV\nFn,Frequency [Hz],Stroke [mm],Result\n100,50,1,ok\n"
    assert "does not say load; give" in faults(tmp_path, text)[-1]
    assert contacts(tmp_path, text.replace("Fn", "Fn [N]")) == [(100, 0.1)]


def test_a_cell_of_a_form_that_cannot_be_read_is_named_by_row_and_heading(tmp_path):
    (fault,) = faults(tmp_path, STROKES + "n/a,50,ok\nMean,,\n", stroke="1 mm")
    assert fault.startswith('row 4, Load [N]: "n/a" cannot be read; write a number')
    for cell in ("13", "> 13", "0"):
        found = faults(tmp_path, f"Failure load stage\tOil\n9\tA\n{cell}\tA\n", velocity="5 m/s")
        said = f'row 3, Failure load stage: "{cell}" is no load stage; give 1 to 12, or > 12'
        assert found == [said]


@pytest.mark.parametrize("name", ["fzg_stages.csv", "fzg4.txt", "4FZG-b.csv"])
def test_the_name_of_a_machine_in_that_of_a_file_ends_at_a_digit_or_a_line(tmp_path, name):
    path = tmp_path / name
    path.write_text("Stage;Result\n9;ok\n", encoding="utf-8")
    (test,) = read_log(path, {"given": {"velocity": "5 m/s"}}).tests
    assert test["load"].startswith("8927")


def test_usual_words_of_german_logs_are_known(tmp_path):
    for word, outcome in (("Verschweißung", "severe"), ("keine Verschweißung", "mild")):
        assert outcome_of(word, "Befund") == outcome
    text = "Schadenskraftstufe SKS;Öltemp. (°C)\n9;90\n"
    assert [row[2] for row in rows(tmp_path, text, velocity="5 m/s")] == ["mild", "severe"]
    (first, _) = read_log(tmp_path / "log.csv", {"given": {"velocity": "5 m/s"}}).in_si
    assert first["bulk_temperature"] == pytest.approx(363.15)
