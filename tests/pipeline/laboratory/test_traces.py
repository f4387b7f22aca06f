"""Traces of friction: stages by what was commanded, and where scuffing begins, by `irg tests`."""

import re
import tomllib

import numpy as np
import pytest

import pipeline


def noise(count, size=0.002, seed=3):
    return size * np.random.default_rng(seed).standard_normal(count)


def write(folder, **columns):
    """Write a trace with these columns, by heading, and time steps of 1 s; return its path."""
    count = len(next(iter(columns.values())))
    columns = {"Time [s]": np.arange(count), **columns}
    rows = zip(*columns.values(), strict=True)
    text = "\n".join([",".join(columns), *(",".join(f"{x:.6g}" for x in row) for row in rows)])
    (folder / "trace.csv").write_text(text + "\n", encoding="utf-8")
    return folder / "trace.csv"


def steps(*levels, each=100):
    return np.repeat(np.array(levels, float), each)


SIX = steps(100, 200, 300, 400, 500, 600)
COUNT = len(SIX)
LEVEL = 0.1 + noise(COUNT)


def risen(row, to=0.3, end=COUNT, base=LEVEL):
    return np.where((np.arange(COUNT) >= row) & (np.arange(COUNT) < end), to, base) + noise(COUNT)


def ramps(each=100, rise=12):
    """Load of each row of six stages with `each` rows; it rises during the first `rise` of them."""
    parts = [np.full(each, 100.0)]
    for level in range(200, 700, 100):
        climb = np.linspace(level - 100, level, rise + 1)[1:]
        parts.append(np.concatenate([climb, np.full(each - rise, level)]))
    return np.concatenate(parts)


CASES = {
    # By name: load [N], velocity [m/s], friction, and the expected ends of the run or the test.
    "within a stage": (SIX, 1.5, risen(430), {"mild_up_to": 400, "severe_at": 500}),
    "at a step": (SIX, 1.5, risen(500), {"mild_up_to": 500, "severe_at": 600}),
    "no rise": (SIX, 1.5, LEVEL, {"mild_up_to": 600}),
    "noisy friction that rises": (
        SIX, 1.5, risen(550, base=0.1 + noise(COUNT, 0.015)), {"mild_up_to": 500, "severe_at": 600},
    ),
    "a peak of running-in": (
        SIX, 1.5, LEVEL + 0.1 * np.exp(-np.arange(COUNT) / 5), {"mild_up_to": 600},
    ),
    "a slow rise to more than twice": (
        300.0, 1.5, np.linspace(0.08, 0.22, COUNT) + noise(COUNT),
        {"load": 300, "outcome": "severe"},
    ),
    "a rise that falls back": (SIX, 1.5, risen(230, end=240), {"mild_up_to": 600}),
    "the last rows": (SIX, 1.5, risen(590), {"mild_up_to": 500, "severe_at": 600}),
    "ramps between": (ramps(), 1.5, risen(520), {"mild_up_to": 500, "severe_at": 600}),
    "friction that falls by stages": (
        SIX, 1.5, risen(530, to=0.2, base=np.repeat(np.linspace(0.12, 0.04, 6), 100)),
        {"mild_up_to": 500, "severe_at": 600},
    ),
    "steps of the velocity": (
        300.0, steps(0.5, 1, 1.5, 2, 2.5, 3), risen(350, to=0.2),
        {"mild_up_to": 1.5, "severe_at": 2},
    ),
    "a lower velocity": (
        300.0, steps(2, 1.5, 1, 0.5, each=150), np.repeat([0.05, 0.07, 0.1, 0.13], 150),
        {"mild_up_to": 2},
    ),
    "one stage": (300.0, 2.0, risen(400), {"load": 300, "velocity": 2, "outcome": "severe"}),
    "one stage that rises slowly": (
        300.0, 2.0, 0.08 + 0.035 * np.linspace(0, 1, COUNT) + noise(COUNT),
        {"load": 300, "outcome": "mild"},
    ),
    "one stage that doubles by and by": (
        300.0, 2.0, 0.1 + np.clip((np.arange(COUNT) - 400) * 0.002, 0, 0.2) + noise(COUNT),
        {"load": 300, "outcome": "severe"},
    ),
    "a rise at the start": (
        300.0, 0.5, np.where(np.arange(COUNT) < 15, 0.03, LEVEL), {"load": 300, "outcome": "mild"},
    ),
    "a single ramp": (
        np.linspace(20, 1000, COUNT), 1.5, risen(400), {"load": 674, "velocity": 1.5},
    ),
    "a single ramp without a rise": (
        np.linspace(20, 1000, COUNT), 1.5, LEVEL, {"load": 1000, "outcome": "mild"},
    ),
    "an excursion of the load": (
        np.where((np.arange(COUNT) > 200) & (np.arange(COUNT) < 220), 200, 300.0), 1.5, LEVEL,
        {"load": 300, "outcome": "mild"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_trace_counts_by_its_stages(tmp_path, irg, name):
    load, velocity, friction, right = CASES[name]
    held = {"Load [N]": load, "Speed [m/s]": velocity, "COF": friction}
    path = write(tmp_path, **{head: np.broadcast_to(x, COUNT) for head, x in held.items()})
    document = irg("tests", path, "--json")
    (test,) = document["tests"]
    numbers = {
        key: test[key] if key == "outcome" else pytest.approx(float(test[key].split()[0]), rel=0.01)
        for key in right
    }
    assert right == numbers
    ends = {"mild_up_to", "severe_at", "outcome"}
    assert {*test} & ends == {*right} & ends
    is_severe = "severe_at" in right or right.get("outcome") == "severe"
    is_severe |= name == "a single ramp"
    assert (document["transition_time"] is not None) == is_severe


def test_what_is_no_scuff_is_told_with_its_reason(tmp_path, irg):
    reasons = {}
    for name in ("a rise that falls back", "a rise at the start", "a lower velocity",
                 "one stage that rises slowly"):  # fmt: skip
        load, velocity, friction, _ = CASES[name]
        held = {"Load [N]": load, "Speed [m/s]": velocity, "COF": friction}
        path = write(tmp_path, **{head: np.broadcast_to(x, COUNT) for head, x in held.items()})
        document = irg("tests", path, "--json")
        reasons[name] = {one["why_not"] for one in document["candidates"]}
        said = irg("tests", path)
        assert all(f"no scuffing, since it {why}" in said for why in reasons[name])
    assert reasons == {
        "a rise that falls back": {"falls back"},
        "a rise at the start": {"begins the first stage"},
        "a lower velocity": {"begins with a lower speed"},
        "one stage that rises slowly": {"comes slowly"},
    }


def test_a_scuff_is_told_with_time_stage_load_and_levels(tmp_path, irg):
    path = write(tmp_path, **{"Load [N]": SIX, "Speed [m/s]": SIX * 0 + 1.5, "COF": risen(430)})
    said = irg("tests", path)
    assert "6 stages, 100 N to 600 N, 1.5 m/s" in said
    assert re.search(
        r"friction rises from 0.[01]\d+ to 0.3 at 430 s, 500 N, in stage 5: scuff", said
    )
    (one,) = irg("tests", path, "--json")["candidates"]
    assert (one["stage"], one["why_not"]) == (5, "")
    assert (one["low"], one["high"]) == (pytest.approx(0.1, rel=0.03), pytest.approx(0.3, rel=0.01))


def test_both_commands_that_change_make_a_run_of_tests(tmp_path, irg):
    velocity, load = steps(1, 1.5, 2, each=200), steps(100, 200, 300, each=200)
    path = write(tmp_path, **{"Load [N]": load, "Speed [m/s]": velocity, "COF": risen(450)})
    document = irg("tests", path, "--json")
    found = [(x["load"], x["velocity"], x["outcome"], x["run"]) for x in document["tests"]]
    assert found == [
        ("100 N", "1 m/s", "mild", 1),
        ("200 N", "1.5 m/s", "mild", 1),
        ("300 N", "2 m/s", "severe", 1),
    ]
    (tmp_path / "lab.toml").write_text(
        f'extends = "first_try"\nwithout = ["measured"]\n{document["toml"]}\n'
    )
    tested = pipeline.load_scene(tmp_path / "lab.toml").tested
    assert [(one.normal_load, one.outcome) for one in tested] == [
        (100.0, "mild"), (200.0, "mild"), (300.0, "severe"),
    ]  # fmt: skip


@pytest.mark.parametrize("is_signed", [True, False])
def test_strokes_of_many_readings_count_with_their_mean_speed(tmp_path, irg, is_signed):
    """2 Hz with 500 readings a period and a stroke of 10 mm are 2 · 2 Hz · 10 mm = 0.04 m/s."""
    time = np.arange(20_000) / 1000
    phase = np.cos(2 * np.pi * 2 * time)
    load, friction = np.repeat([50.0, 100.0], 10_000), np.where(time < 16, 0.12, 0.35)
    sign = 1 if is_signed else np.sign(phase)
    path = write(tmp_path, **{
        "Time [s]": time, "Load [N]": load, "v [m/s]": 5e-3 * 4 * np.pi * phase * sign,
        "Friction force [N]": friction * load * np.where(np.abs(phase) > 0.05, np.sign(phase), 0),
    })  # fmt: skip
    (test,) = irg("tests", path, "--json")["tests"]
    assert (test["mild_up_to"], test["severe_at"], test["velocity"]) == (
        "50 N", "100 N", "0.04 m/s",
    )  # fmt: skip


def test_rows_at_rest_do_not_count_and_are_told(tmp_path, irg):
    """The load falls to zero after 100 rows, and the record continues for 200."""
    count = np.arange(310)
    load = np.concatenate([np.full(100, 400), np.linspace(360, 0, 10), np.full(200, 1)])
    friction = np.where(count < 80, 0.1, np.where(load > 9, 0.3, 0)) + noise(310)
    path = write(tmp_path, **{"Load [N]": load, "v [m/s]": load * 0 + 2, "COF": friction})
    document = irg("tests", path, "--json")
    (test,) = document["tests"]
    assert (test["load"], test["outcome"]) == ("400 N", "severe")
    assert {*document["left_out"].values()} == {"is at rest"}
    assert "310 rows: 109 used, 201 left out: rows 111, 112" in irg("tests", path)


def test_the_temperature_of_the_oil_is_that_before_the_scuff(tmp_path, irg):
    oil = np.where(np.arange(COUNT) < 430, 90.0, 140.0)
    columns = {"Load [N]": SIX, "v [m/s]": SIX * 0 + 1.5, "COF": risen(430), "Oil temp (C)": oil}
    (test,) = irg("tests", write(tmp_path, **columns), "--json")["tests"]
    assert test["bulk_temperature"] == "90 degC"


def test_friction_follows_from_a_force_or_a_torque(tmp_path, irg):
    friction = risen(430)
    columns = {"Load [N]": SIX, "v [m/s]": SIX * 0 + 1.5, "Friction force [N]": friction * SIX}
    (test,) = irg("tests", write(tmp_path, **columns), "--json")["tests"]
    assert test["friction"] == pytest.approx(0.1, rel=0.02)
    torque = columns | {"Friction torque [N mm]": 20 * friction * SIX}
    del torque["Friction force [N]"]
    path = write(tmp_path, **torque)
    assert 'give --given "track_radius=... m"' in irg("tests", path, code=2)
    (other,) = irg("tests", path, "--given", "track_radius=20 mm", "--json")["tests"]
    assert other == test


def test_units_that_a_trace_lacks_are_asked_for_once_with_their_options(tmp_path, irg):
    columns = {"Load": SIX, "v [m/s]": SIX * 0 + 1.5, "Friction force": risen(430) * SIX}
    path = write(tmp_path, **columns)
    asked = irg("tests", path, code=2)
    assert asked.count('"100" has no unit') == 1
    named = re.findall(r'--column "([^"]+)"', asked)
    assert named == ["friction_force=Friction force [N]", "load=Load [N]"]
    chosen = [word for name in named for word in ("--column", name)]
    (test,) = irg("tests", path, *chosen, "--json")["tests"]
    assert (test["mild_up_to"], test["severe_at"]) == ("400 N", "500 N")


def test_columns_and_rows_of_a_trace_are_chosen(tmp_path, irg):
    columns = {"t": np.arange(COUNT) / 60, "F": SIX / 9.80665, "v": SIX * 0 + 1500, "x": risen(430)}
    path = write(tmp_path, **columns, flag=np.arange(COUNT) % 2)
    names = ["time=t [min]", "load=F [kgf]", "velocity=v [mm/s]", "friction=x"]
    chosen = [word for name in names for word in ("--column", name)]
    document = irg("tests", path, *chosen, "--where", "flag=0", "--json")
    (test,) = document["tests"]
    assert float(test["severe_at"].split()[0]) == pytest.approx(500, rel=1e-3)
    assert test["velocity"] == "1.5 m/s"
    assert document["transition_time"] == pytest.approx(430, abs=2)
    skipped = irg("tests", path, *chosen, "--skip", "flag=1", "--json")
    assert skipped["tests"] == document["tests"]


def test_a_status_in_each_row_of_one_run_makes_no_tests_of_its_rows(tmp_path, irg):
    path = write(tmp_path, **{"Load [N]": SIX, "Speed [m/s]": SIX * 0 + 1.5, "COF": risen(430)})
    (right,) = irg("tests", path, "--json")["tests"]
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([f"{head},Status", *(f"{row},OK" for row in rows)]) + "\n")
    assert irg("tests", path, "--json")["tests"] == [right]
    scene = 'extends = "first_try"\n[[tested]]\nfile = "trace.csv"\n'
    (tmp_path / "scene.toml").write_text(scene)
    with pytest.raises(pipeline.SceneFileError, match="irg tests"):
        pipeline.load_scene(tmp_path / "scene.toml")


def test_many_rows_without_an_outcome_never_become_transitions(tmp_path, irg):
    """A trace with clock times was once read as 239 transitions."""
    rows = [f"2026-03-14 10:{k // 60:02d}:{k % 60:02d},{100 + 20 * (k // 40)},1.5,{0.1:.2f}"
            for k in range(239)]  # fmt: skip
    text = "\n".join(["Timestamp,Load (N),Speed (m/s),COF", *rows])
    (tmp_path / "clock.csv").write_text(text)
    (test,) = irg("tests", tmp_path / "clock.csv", "--json")["tests"]
    assert test["mild_up_to"] == "200 N"
    (tmp_path / "wear.csv").write_text(
        "Sample,Load (N),Speed (m/s),Wear (mm3)\n" + "a,100,1.5,0.3\n" * 9
    )
    said = irg("tests", tmp_path / "wear.csv", code=2)
    assert "no column says whether wear was mild or severe" in said
    assert "[[measured]]" not in said


def test_the_figure_shows_friction_stages_and_rises(tmp_path, irg):
    path = write(tmp_path, **{"Load [N]": SIX, "v [m/s]": SIX * 0 + 1.5, "COF": risen(430)})
    said = irg("tests", path, "-o", tmp_path / "trace.png")
    assert str(tmp_path / "trace.png") in said
    assert (tmp_path / "trace.png").read_bytes().startswith(b"\x89PNG")
    from pipeline.laboratory.picture import draw_trace
    from pipeline.laboratory.reading import OF_TRACE, read_table, read_trace

    trace = read_trace(read_table(path, {}, OF_TRACE))
    friction, commands, speeds = draw_trace(trace, "trace.csv").axes
    numbers = [text.get_text() for text in friction.texts if text.get_text().isdigit()]
    assert numbers == ["1", "2", "3", "4", "5", "6"]
    assert "scuffing" in [text.get_text() for text in friction.texts]
    assert (commands.get_ylabel(), speeds.get_ylabel()) == ("load [N]", "velocity [m/s]")
    (tmp_path / "log.csv").write_text("load [N],velocity [m/s],outcome\n400,2,mild\n")
    said = irg("tests", tmp_path / "log.csv", "-o", tmp_path / "log.png", code=2)
    assert "is no record of friction over time, which -o draws; leave it out" in said


def test_the_lines_of_a_trace_are_a_scene_once_what_is_open_is_given(tmp_path, irg):
    path = write(tmp_path, **{"Load [N]": SIX, "COF": risen(430)})
    said = irg("tests", path)
    assert 'velocity = "... m/s"  # in no column; give --given "velocity=... m/s"' in said
    toml = irg("tests", path, "--given", "velocity=1.5 m/s", "--json")["toml"]
    (test,) = tomllib.loads(toml)["tested"]
    assert test == {
        "mild_up_to": "400 N", "severe_at": "500 N", "velocity": "1.5 m/s",
        "friction": pytest.approx(0.1, rel=0.02),
    }  # fmt: skip
