"""Traces of friction: stages by what was commanded, rises, and lines for scenes, by `irg tests`."""

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


def climb(begin, end, count):
    return np.linspace(begin, end, count)


SECONDS = np.arange(COUNT)
CASES = {
    # By name: load [N], velocity [m/s], and the expected stages, as (start, load, velocity).
    "stages of the load": (SIX, 1.5, [(100 * k, 100 * (k + 1), 1.5) for k in range(6)]),
    "ramps between": (ramps(), 1.5, [(100 * k, 100 * (k + 1), 1.5) for k in range(6)]),
    "stages of the velocity": (
        300.0, steps(0.5, 1, 1.5, 2, 2.5, 3), [(100 * k, 300, (k + 1) / 2) for k in range(6)],
    ),
    "a lower velocity": (
        300.0, steps(2, 1.5, 1, 0.5, each=150), [(150 * k, 300, 2 - k / 2) for k in range(4)],
    ),
    "one stage": (300.0, 2.0, [(0, 300, 2)]),
    "a ramp of the load": (climb(20, 1000, COUNT), 1.5, [(0, (20, 1000), 1.5)]),
    "a short dip of the load": (
        np.where((SECONDS > 200) & (SECONDS < 220), 200, 300.0), 1.5, [(0, 300, 1.5)],
    ),
    "a short overload, which may decide": (
        np.where((SECONDS > 200) & (SECONDS < 220), 450, 300.0), 1.5,
        [(0, 300, 1.5), (201, 450, 1.5), (220, 300, 1.5)],
    ),
    "an overshoot of the speed": (300.0, np.where((SECONDS > 2) & (SECONDS < 9), 0.8, 0.5),
        [(0, 300, 0.5)],
    ),
    "a drift, then a stop": (
        np.concatenate([climb(0, 500, 6), climb(500, 600, 500), np.full(94, 600.0)]),
        np.concatenate([climb(0, 2, 6), np.full(500, 2.0), 2 * np.exp(-np.arange(94) / 20)]),
        [(5, (500, 600), 2)],
    ),
    "a ramp of the speed, then a stop": (
        400.0, np.concatenate([climb(0.1, 4, 500), climb(4, 0.08, 7), climb(0.08, 0, 93)]),
        [(0, 400, (0.1, 4))],
    ),
    "a long run-down": (
        300.0, np.concatenate([np.full(320, 2.0), 2 * np.exp(-np.arange(280) / 60)]), [(0, 300, 2)],
    ),
    "a ramp after running-in": (
        np.concatenate([np.full(400, 100.0), climb(100, 900, 200)]), 1.5,
        [(0, 100, 1.5), (399, (100, 900), 1.5)],
    ),
    "a short last stage": (
        np.concatenate([steps(100, 200, 300, each=195), np.full(15, 400.0)]), 1.5,
        [(0, 100, 1.5), (195, 200, 1.5), (390, 300, 1.5), (585, 400, 1.5)],
    ),
    "spikes of the load": (
        np.where(SECONDS % 250 == 30, 5000, SIX), 1.5,
        [(100 * k, 100 * (k + 1), 1.5) for k in range(6)],
    ),
}  # fmt: skip


def write_held(folder, load, velocity, friction):
    held = {"Load [N]": load, "Speed [m/s]": velocity, "COF": friction}
    return write(folder, **{head: np.broadcast_to(x, COUNT) for head, x in held.items()})


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("noise_of_load", [0.0, 0.01])
def test_a_trace_is_cut_into_stages_of_what_was_commanded(tmp_path, irg, name, noise_of_load):
    load, velocity, right = CASES[name]
    path = write_held(tmp_path, load * (1 + noise(COUNT, noise_of_load, seed=4)), velocity, LEVEL)
    stages = irg("tests", path, "--json")["stages"]
    for found, (start, *place) in zip(stages, right, strict=True):
        assert found["start [s]"] == pytest.approx(start, abs=18)
        for level, wanted in zip((found["load [N]"], found["velocity [m/s]"]), place, strict=True):
            # A line through a tenth of a ramp has more scatter than the median of a hold.
            scatter = 0.03 if isinstance(wanted, tuple) else 0.01
            assert level == pytest.approx(wanted, rel=scatter, abs=2 * noise_of_load * 1000 / 8)


RISES = {
    # By name: friction, and the expected rises, as (time, from, to).
    "none": (LEVEL, []),
    "within a stage": (risen(430), [(430, 0.1, 0.3)]),
    "in the first tenth": (risen(40), [(40, 0.1, 0.3)]),
    "at the very beginning": (risen(4), [(4, 0.1, 0.3)]),
    "a trip in the last rows": (risen(594), [(594, 0.1, 0.3)]),
    "under much noise": (risen(550, base=0.1 + noise(COUNT, 0.015)), [(550, 0.1, 0.3)]),
    "small and slow under noise": (
        climb(0.1, 0.13, COUNT) + noise(COUNT, 0.012), [(300, 0.105, 0.125)],
    ),
    "one that falls back": (risen(230, end=240), [(230, 0.1, 0.3)]),
    "slow": (climb(0.08, 0.22, COUNT) + noise(COUNT), [(300, 0.09, 0.21)]),
    "of friction that falls by stages": (
        risen(530, to=0.2, base=np.repeat(climb(0.12, 0.04, 6), 100)), [(530, 0.04, 0.2)],
    ),
    "the three largest of four": (
        0.1 + 0.1 * (SECONDS > 100) - 0.08 * (SECONDS > 150) + 0.2 * (SECONDS > 200)
        - 0.2 * (SECONDS > 250) + 0.3 * (SECONDS > 300) - 0.3 * (SECONDS > 350)
        + 0.4 * (SECONDS > 400),
        [(401, 0.12, 0.52), (301, 0.12, 0.42), (201, 0.12, 0.32)],
    ),
    "not a lone reading": (np.where(SECONDS == 200, 0.9, LEVEL), []),
}  # fmt: skip


@pytest.mark.parametrize("name", RISES)
def test_the_largest_lasting_rises_are_told_with_time_and_levels(tmp_path, irg, name):
    friction, right = RISES[name]
    rises = irg("tests", write_held(tmp_path, SIX, 1.5, friction), "--json")["rises"]
    # The middle of a slow rise, and its ends, are as uncertain as noise makes them.
    late, off = (80, 0.025) if "slow" in name else (1.5, 0.012)
    for found, (time, low, high) in zip(rises, right, strict=True):
        assert found["time [s]"] == pytest.approx(time, abs=late)
        assert (found["from"], found["to"]) == (
            pytest.approx(low, abs=off), pytest.approx(high, abs=off),
        )  # fmt: skip


def test_friction_is_that_of_the_first_seconds_steady_highest_and_at_the_end(tmp_path, irg):
    friction = np.select([SECONDS < 10, SECONDS < 590, SECONDS < 595], [0.05, 0.1, 0.4], 0.2)
    (stage,) = irg("tests", write_held(tmp_path, 300.0, 2.0, friction), "--json")["stages"]
    found = [stage[f"friction {name}"] for name in ("begin", "steady", "highest", "end")]
    assert found == [0.05, 0.1, 0.4, 0.2]
    assert stage["duration [s]"] == COUNT
    assert stage["temperature [degC]"] is None


def toml_of(irg, path, *options):
    """Tables that `irg tests` prints for a trace, by `tested`; its lines alone are checked."""
    document = irg("tests", path, *options, "--json")
    return tomllib.loads(document["toml"])["tested"]


LINES = {
    # By name: load, velocity, what was said, and the lines beside friction.
    "mild": (SIX, 1.5, "mild", {"mild_up_to": "600 N", "velocity": "1.5 m/s"}),
    "severe": (SIX, 1.5, 430, {"mild_up_to": "400 N", "severe_at": "500 N", "velocity": "1.5 m/s"}),
    "severe at a step": (
        SIX, 1.5, 500, {"mild_up_to": "500 N", "severe_at": "600 N", "velocity": "1.5 m/s"},
    ),
    "severe by velocity": (
        300.0, steps(0.5, 1, 1.5, 2, 2.5, 3), 350,
        {"mild_up_to": "1.5 m/s", "severe_at": "2 m/s", "load": "300 N"},
    ),
    "severe in the first stage": (
        SIX, 1.5, 50, {"load": "100 N", "velocity": "1.5 m/s", "outcome": "severe"},
    ),
    "one mild stage": (
        300.0, 2.0, "mild", {"load": "300 N", "velocity": "2 m/s", "outcome": "mild"},
    ),
    "one severe stage": (
        300.0, 2.0, 9, {"load": "300 N", "velocity": "2 m/s", "outcome": "severe"},
    ),
    "a mild ramp": (
        climb(20, 1000, COUNT), 1.5, "mild",
        {"load": "1000 N", "velocity": "1.5 m/s", "outcome": "mild"},
    ),
    "a severe ramp": (
        climb(20, 1000, COUNT), 1.5, 400,
        {"load": "674.4 N", "velocity": "1.5 m/s", "outcome": "severe"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LINES)
def test_lines_follow_from_what_the_person_says(tmp_path, irg, name):
    load, velocity, told, right = LINES[name]
    path = write_held(tmp_path, load, velocity, LEVEL)
    said = ("--outcome", "mild") if told == "mild" else ("--scuffed-at", f"{told} s")
    (test,) = toml_of(irg, path, *said)
    assert test.pop("friction") == pytest.approx(0.1, rel=0.02)
    stages = test.pop("stages", [])
    assert test == right
    if stages:
        held, unit = (load, "N") if "velocity" in right else (velocity, "m/s")
        last = right.get("severe_at") or right["mild_up_to"]
        every = [f"{level:g} {unit}" for level in np.unique(held)]
        assert stages == [[level, "100 s"] for level in every[: every.index(last) + 1]]


def test_nothing_is_said_of_the_outcome_unless_the_person_does(tmp_path, irg):
    path = write_held(tmp_path, SIX, 1.5, risen(430))
    assert irg("tests", path, "--json")["toml"] == ""
    said = irg("tests", path)
    place = "at 430 s, in stage 5, at 500 N and 1.5 m/s"
    assert re.search(rf"friction rises from 0\.\d+ to 0\.[23]\d* {place}", said)
    assert "--outcome mild" in said
    assert '--scuffed-at "430 s"' in said
    assert "[[" not in said
    late = irg("tests", path, "--scuffed-at", "700 s", code=2)
    assert "--scuffed-at is 700 s, and the record ends at 599 s" in late


def test_levels_that_fall_or_both_change_make_a_run_of_tests(tmp_path, irg):
    velocity, load = steps(1, 1.5, 2, each=200), steps(100, 200, 300, each=200)
    path = write_held(tmp_path, load, velocity, risen(450))
    found = toml_of(irg, path, "--scuffed-at", "450 s")
    assert [(x["load"], x["velocity"], x["outcome"], x["run"]) for x in found] == [
        ("100 N", "1 m/s", "mild", 1),
        ("200 N", "1.5 m/s", "mild", 1),
        ("300 N", "2 m/s", "severe", 1),
    ]
    (tmp_path / "lab.toml").write_text(
        'extends = "first_try"\nwithout = ["measured"]\n'
        + irg("tests", path, "--scuffed-at", "450 s", "--json")["toml"]
    )
    tested = pipeline.load_scene(tmp_path / "lab.toml").tests
    assert [(one.normal_load, one.outcome) for one in tested] == [
        (100.0, "mild"), (200.0, "mild"), (300.0, "severe"),
    ]  # fmt: skip
    falling = write_held(tmp_path, 300.0, steps(2, 1.5, 1, 0.5, each=150), LEVEL)
    found = toml_of(irg, falling, "--outcome", "mild")
    assert [one["velocity"] for one in found] == ["2 m/s", "1.5 m/s", "1 m/s", "0.5 m/s"]


@pytest.mark.parametrize("sign", [1, -1])
def test_a_load_cell_that_idles_beside_zero_is_told(tmp_path, irg, sign):
    """For most rows the load cell shows −3 N; 300 N were held for 100 s of 600."""
    load = np.where((SECONDS >= 250) & (SECONDS < 350), 300.0, -3.0) + noise(COUNT, 0.5)
    force = 0.1 * load
    path = write(
        tmp_path, **{"Load [N]": sign * load, "v [m/s]": 2 + 0 * load, "Friction force [N]": force}
    )
    document = irg("tests", path, "--json")
    (stage,) = document["stages"]
    assert stage["load [N]"] == pytest.approx(300, rel=0.002)
    assert (stage["start [s]"], stage["duration [s]"]) == (250, 100)
    assert stage["friction steady"] == pytest.approx(0.1, rel=0.02)
    assert re.search(r"idle load -(3|2\.9\d|3\.0\d) N, not taken off", document["form"][-1])
    assert len(document["left_out"]) == 500


def test_a_pause_counts_in_no_duration(tmp_path, irg):
    velocity = np.where((SECONDS > 200) & (SECONDS < 301), 0.0, 2.0)
    (stage,) = irg("tests", write_held(tmp_path, 300.0, velocity, LEVEL), "--json")["stages"]
    assert stage["duration [s]"] == 500


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
    document = irg("tests", path, "--json")
    places = [(one["load [N]"], one["velocity [m/s]"]) for one in document["stages"]]
    assert places == [(50, pytest.approx(0.04, rel=0.01)), (100, pytest.approx(0.04, rel=0.01))]
    (rise,) = document["rises"]
    assert rise == {
        "time [s]": pytest.approx(16, abs=0.5), "from": pytest.approx(0.12, rel=0.01),
        "to": pytest.approx(0.35, rel=0.01),
    }  # fmt: skip


def test_rows_at_rest_do_not_count_and_are_told(tmp_path, irg):
    """The load falls to zero after 100 rows, and the record continues for 200."""
    count = np.arange(310)
    load = np.concatenate([np.full(100, 400), np.linspace(360, 0, 10), np.full(200, 1)])
    friction = np.where(count < 80, 0.1, np.where(load > 9, 0.3, 0)) + noise(310)
    path = write(tmp_path, **{"Load [N]": load, "v [m/s]": load * 0 + 2, "COF": friction})
    document = irg("tests", path, "--json")
    (stage,) = document["stages"]
    assert stage["load [N]"] == 400
    assert {*document["left_out"].values()} == {"is at rest"}
    assert "310 rows: 109 used, 201 left out: rows 111, 112" in irg("tests", path)


def test_the_temperature_of_the_oil_is_that_before_the_scuff(tmp_path, irg):
    oil = np.where(np.arange(COUNT) < 430, 90.0, 140.0)
    columns = {"Load [N]": SIX, "v [m/s]": SIX * 0 + 1.5, "COF": risen(430), "Oil temp (C)": oil}
    path = write(tmp_path, **columns)
    (test,) = toml_of(irg, path, "--scuffed-at", "480 s")
    assert test["bulk_temperature"] == "90 degC"
    assert test["friction"] == pytest.approx(0.1, rel=0.02)  # before the rise, too
    assert irg("tests", path, "--json")["stages"][5]["temperature [degC]"] == 140


def test_friction_follows_from_a_force_or_a_torque(tmp_path, irg):
    friction = risen(430)
    columns = {"Load [N]": SIX, "v [m/s]": SIX * 0 + 1.5, "Friction force [N]": friction * SIX}
    right = irg("tests", write(tmp_path, **columns), "--json")["stages"]
    assert right[0]["friction steady"] == pytest.approx(0.1, rel=0.02)
    torque = columns | {"Friction torque [N mm]": 20 * friction * SIX}
    del torque["Friction force [N]"]
    path = write(tmp_path, **torque)
    assert 'give --given "track_radius=... m"' in irg("tests", path, code=2)
    found = irg("tests", path, "--given", "track_radius=20 mm", "--json")["stages"]
    assert [*found[0].values()][:-1] == pytest.approx([*right[0].values()][:-1], rel=1e-4)


def test_units_that_a_trace_lacks_are_asked_for_once_with_their_options(tmp_path, irg):
    columns = {"Load": SIX, "v [m/s]": SIX * 0 + 1.5, "Friction force": risen(430) * SIX}
    path = write(tmp_path, **columns)
    asked = irg("tests", path, code=2)
    assert asked.count('"100" has no unit') == 1
    named = re.findall(r'--column "([^"]+)"', asked)
    assert named == ["friction_force=Friction force [N]", "load=Load [N]"]
    chosen = [word for name in named for word in ("--column", name)]
    stages = irg("tests", path, *chosen, "--json")["stages"]
    assert [one["load [N]"] for one in stages] == [100, 200, 300, 400, 500, 600]


def test_columns_and_rows_of_a_trace_are_chosen(tmp_path, irg):
    columns = {"t": np.arange(COUNT) / 60, "F": SIX / 9.80665, "v": SIX * 0 + 1500, "x": risen(430)}
    path = write(tmp_path, **columns, flag=np.arange(COUNT) % 2)
    names = ["time=t [min]", "load=F [kgf]", "velocity=v [mm/s]", "friction=x"]
    chosen = [word for name in names for word in ("--column", name)]
    document = irg("tests", path, *chosen, "--where", "flag=0", "--json")
    stage = document["stages"][4]
    assert (stage["load [N]"], stage["velocity [m/s]"]) == (pytest.approx(500, rel=1e-3), 1.5)
    assert document["rises"][0]["time [s]"] == pytest.approx(430, abs=2)
    skipped = irg("tests", path, *chosen, "--skip", "flag=1", "--json")
    assert skipped["stages"] == document["stages"]


def test_a_status_in_each_row_of_one_run_makes_no_tests_of_its_rows(tmp_path, irg):
    path = write(tmp_path, **{"Load [N]": SIX, "Speed [m/s]": SIX * 0 + 1.5, "COF": risen(430)})
    right = irg("tests", path, "--json")["stages"]
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([f"{head},Status", *(f"{row},OK" for row in rows)]) + "\n")
    assert irg("tests", path, "--json")["stages"] == right
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
    stages = irg("tests", tmp_path / "clock.csv", "--json")["stages"]
    assert [one["load [N]"] for one in stages] == [100, 120, 140, 160, 180, 200]
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
    from pipeline.laboratory.reading import OF_TRACE, read_table
    from pipeline.laboratory.records import read_trace
    from pipeline.scene.choices import NO_CHOICES

    trace = read_trace(read_table(path, NO_CHOICES, wanted=OF_TRACE))
    friction, commands, speeds = draw_trace(trace, "trace.csv").axes
    numbers = [text.get_text() for text in friction.texts if text.get_text().isdigit()]
    assert numbers == ["1", "2", "3", "4", "5", "6"]
    assert "430 s" in [text.get_text() for text in friction.texts]
    assert (commands.get_ylabel(), speeds.get_ylabel()) == ("load [N]", "velocity [m/s]")
    (tmp_path / "log.csv").write_text("load [N],velocity [m/s],outcome\n400,2,mild\n")
    for option, value in (
        ("-o", tmp_path / "log.png"),
        ("--scuffed-at", "9 s"),
        ("--outcome", "mild"),
    ):
        said = irg("tests", tmp_path / "log.csv", option, value, code=2)
        assert f"is no record of friction over time, which {option} needs; leave it out" in said


def test_the_lines_of_a_trace_ask_for_what_was_not_recorded(tmp_path, irg):
    path = write(tmp_path, **{"Load [N]": SIX, "COF": risen(430)})
    said = irg("tests", path, "--scuffed-at", "440 s")
    assert 'velocity = "... m/s"  # in no column; give --given "velocity=... m/s"' in said
    (test,) = toml_of(irg, path, "--scuffed-at", "440 s", "--given", "velocity=1.5 m/s")
    stages = [[f"{load} N", "100 s"] for load in (100, 200, 300, 400, 500)]
    assert test == {
        "stages": stages, "mild_up_to": "400 N", "severe_at": "500 N", "velocity": "1.5 m/s",
        "friction": pytest.approx(0.1, rel=0.02),
    }  # fmt: skip
