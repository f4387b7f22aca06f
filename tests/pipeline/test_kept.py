"""What commands print, draw and report reads as it is kept, word by word."""

import re
import shlex
from functools import partial
from itertools import product

import xarray as xr

import pipeline
import tribo
from pipeline.answers.answer_frames import boundary_frame, margin_frame
from pipeline.answers.facts import NOTES, fact_lines, facts, point_lines
from pipeline.cli import main
from pipeline.figures.rows_figure import draw_rows
from pipeline.figures.style import texts_of
from pipeline.frames import lines_of
from pipeline.store.schema import DONE, FAILED, PENDING
from tests.helpers import synthetic
from tests.helpers.entries import bare_test, rows
from tests.helpers.kept import assert_as_kept, relative, variables
from tests.helpers.scenes import SCENE
from tests.pipeline.answers.test_load_factors import rows_of
from tests.pipeline.figures.test_planes import NOT_DONE, TESTED, surfaces, two_pins
from tests.pipeline.figures.test_planes import sweep as plane
from tests.pipeline.figures.test_plot import POINTS
from tests.pipeline.test_film import filmed

UNCERTAIN_AND_TESTED = """
[uncertainty]
"pin.radius" = "5 %"
"temperature.bulk" = "3 K"

[[tests]]
load = "200 N"
velocity = "1 m/s"
outcome = "mild"

[[tests]]
velocity = "2 m/s"
mild_up_to = "200 N"
severe_at = "400 N"
"""
DUTY = "load [N],velocity [m/s]\n" + "".join(
    f"{load},{load / 200}\n" for load in range(200, 420, 9)
)
ROWS = """
extends = "small.toml"
without = ["sweep.loads", "sweep.velocities", "uncertainty", "tests"]
[[sweep.along]]
place = "A"
load = "200 N"
velocity = "1 m/s"
[[sweep.along]]
place = "B"
load = "300 N"
velocity = "2 m/s"
"""
POINT = '--load "300 N" --velocity "1.5 m/s"'
IN_TURN = [
    "new mine.toml",
    "new --list",
    "help",
    "run small.toml -n -o a.zarr",
    "run small.toml -o a.zarr -j 1",
    "status a.zarr",
    "verify a.zarr",
    "boundary a.zarr",
    "boundary a.zarr --by velocity",
    "boundary a.zarr --by test",
    "boundary a.zarr --friction 0.12 --friction 0.2",
    "boundary a.zarr --critical-temperature 200degC -o boundary.csv",
    "boundary a.zarr --without-tests",
    f"margin a.zarr {POINT}",
    f"margin a.zarr {POINT} --friction 0.05 --friction 0.5",
    f"margin a.zarr {POINT} --critical-temperature 300degC",
    "margin a.zarr --points duty.csv",
    "margin a.zarr --points duty.csv --all --friction 0.07 -o duty.md",
    f"point small.toml {POINT} --friction 0.4",
    f"sensitivity small.toml {POINT}",
    "infer small.toml",
    f'infer small.toml {POINT} --contact-width "0.2 mm"',
    "plot a.zarr",
    "run rows.toml -o b.zarr -j 1",
    f"point rows.toml {POINT}",
    'run small.toml --set without=\'["temperature.critical", "tests", "uncertainty"]\' '
    "--set sweep.loads='[\"200 N\"]' --set sweep.velocities='[\"1 m/s\"]' -o c.zarr -j 1",
    "boundary c.zarr",
    "plot c.zarr",
    "boundary b.zarr",
    "plot b.zarr",
    f"report a.zarr {POINT} -o a.html",
]
"""Commands that are typed one after the other in a folder."""

CHECKS = [
    *("cam_tappet", "designs", "fig4", "gear_mesh", "ground_ring", "mtm", "pin_on_disk", "scan"),
    "whole_pin",
    "first_try --set sweep.loads='[\"900 N\"]' --set wear.pattern=local",
    "first_try --set without=wear --set disk.roughness.correlation_length='200 um'",
    "first_try --set friction.coefficient=1.5 --set without=friction.band",
    "first_try --set friction.coefficient=0 --set without=friction.band",
    "first_try --set materials.steel.hardness='50 GPa' --set pin.radius='2 m'",
    "first_try --set loading.rate='0.01 N/s'",
    "first_try --set motion.slide_roll_ratio=0.5 --set uncertainty.\\\"pin.radius\\\"='30 %'",
    "first_try --set window.pixels=[64,64] --set fidelity.increments=3",
    "first_try --set temperature.bulk='300 degC' --set temperature.critical='800 degC'",
]
"""Scenes, some of them with unusual entries."""


# What depends on the speed of the machine: lines of progress, and how long it takes.
_PROGRESS = re.compile(r"^irg: \d+ of \d+ .*(done|so far).*\n", re.MULTILINE)
_DURATION = re.compile(r"\b(in|about) [\d.]+ (s|min|h)\b")


def printed(capsys, folder, command):
    """All that a command prints, with its exit code."""
    capsys.readouterr()
    try:
        code = main(shlex.split(command))
    except SystemExit as error:
        code = error.code
    texts = capsys.readouterr()
    return relative(f"{texts.out}\n{_PROGRESS.sub('', texts.err)}exit code {code}", folder)


def test_commands_read_as_they_are_kept(tmp_path, monkeypatch, capsys, undrawn):
    monkeypatch.chdir(tmp_path)
    scene = SCENE.replace("pixels_per_element = 1\nincrements = 10", 'preset = "standard"')
    (tmp_path / "small.toml").write_text(scene + UNCERTAIN_AND_TESTED, encoding="utf-8")
    (tmp_path / "duty.csv").write_text(f"{DUTY}5000,1\n")
    (tmp_path / "rows.toml").write_text(ROWS)
    texts = {
        command: _DURATION.sub(r"\1 (time)", printed(capsys, tmp_path, command))
        for command in IN_TURN
    }
    assert_as_kept("commands", texts)


def test_checks_read_as_they_are_kept(tmp_path, monkeypatch, capsys):
    times = 2.0, 0.7  # of a contact and of a heat solution [s]
    monkeypatch.setattr("pipeline.run.estimate._time_steps", lambda sweep: times)
    monkeypatch.setattr("dask.system.cpu_count", lambda: 2)
    texts = {scene: printed(capsys, tmp_path, f"check {scene}") for scene in CHECKS}
    assert_as_kept("checks", texts)


FIGURES = {
    "diagram": partial(synthetic.sweep, status={(300.0, 1.5): FAILED, (750.0, 4.0): PENDING}),
    "diagram with tests": partial(plane, tests=TESTED, friction_band=(0.08, 0.12), status=NOT_DONE),
    "diagram of two pins": two_pins,
    "diagram of two surfaces": partial(surfaces, 1.0, 1.1),
    "diagram without a preset": partial(plane, preset=None),
    "diagram of a rolling pin": partial(plane, motion=tribo.Motion(slide_roll_ratio=0.5)),
}


def test_figures_read_as_they_are_kept():
    drawn = {name: pipeline.plot(make()) for name, make in FIGURES.items()}
    tested = plane(tests=TESTED, status=NOT_DONE)
    drawn["log diagram"] = pipeline.plot(plane(), log=True, load=300.0, velocity=1.5)
    drawn["tests"] = pipeline.plot(tested, "tests")
    drawn["rows"] = draw_rows(pipeline.margin(plane(), POINTS), "duty")
    film = pipeline.margin(filmed(**SMALL), [400.0, 400.0], [1.0, 2.1])
    drawn["rows with a film"] = draw_rows(film, "film")
    drawn["rows with load factors"] = pipeline.plot(rows_of(((180.0, 2.5), (250.0, 1.5))))
    drawn["tests that wait"] = pipeline.plot(waiting(), "tests")
    texts = {name: "\n".join(texts_of(figure)) for name, figure in drawn.items()}
    assert_as_kept("figures", texts)


def test_variables_of_answers_read_as_they_are_kept():
    ds, tested = synthetic.sweep(), plane(tests=TESTED, status=NOT_DONE)
    answers = {
        "boundary": pipeline.boundary(ds),
        "margin": pipeline.margin(tested, POINTS),
        "tests": pipeline.compare_tests(tested),
        "temperatures": pipeline.temperatures(ds),
        "critical temperature": pipeline.infer(tested),
        "boundary with a film": pipeline.boundary(filmed(**SMALL)),
        "rows with load factors": pipeline.margin(rows_of(((180.0, 2.5), (250.0, 1.5)))),
    }
    texts = {name: variables(answer) for name, answer in answers.items()}
    assert_as_kept("variables_of_answers", texts)


AT_400 = [bare_test(400.0, 2.0, outcome=outcome) for outcome in ("mild", "severe", "transition")]
FROM_TESTS = {
    "conditions": synthetic.CONDITIONS | {"critical_temperature": None},
    "critical_from_tests": True,
}
ROLLED = {"motion": tribo.Motion(slide_roll_ratio=0.5, pin_track_length=0.3, disk_track_length=0.4)}
SMALL = {"loads": (200.0, 400.0, 600.0), "velocities": (1.0, 2.0, 4.0)}
FIRST_DONE = {(200.0, 1.0): DONE}
STAGES = {"loading": tribo.Stages(SMALL["loads"], (5.0,) * 3, 150.0)}


def two_days():
    """Plane of two cases, which differ in their bulk temperature."""
    warm = pipeline.Conditions(**synthetic.CONDITIONS | {"bulk_temperature": 320.0})
    table = rows("day", {"cold": {}, "warm": {"conditions": warm}})
    days = xr.DataArray(["cold", "warm"], dims="day", name="day")
    part = synthetic.sweep(case_table=table, tests=(), **SMALL)
    return xr.concat([part, part], days, combine_attrs="override")


def waiting():
    return synthetic.with_tests(plane(tests=AT_400, **SMALL), status=(DONE, PENDING, FAILED))


ANSWERS = {
    "a film at the boundary": lambda: pipeline.boundary(filmed(**SMALL)),
    "a film at a point": lambda: pipeline.margin(filmed(**SMALL), 400.0, 2.1),
    "no boundary": lambda: pipeline.boundary(plane(**SMALL), critical_temperature=900.0),
    "tests that wait": lambda: pipeline.margin(waiting(), 300.0, 1.5),
    "a test that failed": lambda: pipeline.margin(
        synthetic.with_tests(plane(tests=AT_400[:1], **SMALL), status=FAILED), 300.0, 1.5
    ),
    "places outside": lambda: pipeline.margin(
        plane(**SMALL), [900.0, 1000.0, 300.0, 300.0], [1.0, 1.0, 9.0, 2.0]
    ),
    "points that are not done": lambda: pipeline.margin(
        plane(**SMALL, status=dict.fromkeys([(400.0, 2.0), (400.0, 4.0)], PENDING)),
        [300.0, 400.0],
        [1.0, 4.0],
    ),
    "too few points": lambda: pipeline.margin(
        plane(**SMALL, status=dict.fromkeys(product(*SMALL.values()), PENDING) | FIRST_DONE),
        [200.0, 300.0],
        [1.0, 1.5],
    ),
    "a critical temperature of tests, and another": lambda: pipeline.margin(
        plane(tests=AT_400, **FROM_TESTS, **SMALL), 300.0, 1.5, critical_temperature=420.0
    ),
    "only mild tests": lambda: pipeline.margin(
        plane(tests=AT_400[:1], **FROM_TESTS, **SMALL), 200.0, 1.0
    ),
    "a test too hot": lambda: pipeline.margin(
        plane(tests=[bare_test(400.0, 2.0, bulk_temperature=430.0)], **SMALL), 200.0, 1.0
    ),
    "heat of earlier revolutions": lambda: pipeline.boundary(two_pins(**ROLLED, **SMALL)),
    "such heat everywhere": lambda: pipeline.margin(
        plane(**ROLLED, **SMALL), 600.0, 1.0, critical_temperature=330.0
    ),
    "such heat in rows": lambda: pipeline.margin(
        rows_of(((180.0, 2.5), (415.0, 2.0)), tests=(), **ROLLED)
    ),
    "a load beyond stages, at an unusual friction": lambda: pipeline.margin(
        plane(**SMALL, **STAGES), [300.0, 900.0], [1.0, 1.0], friction=2.0
    ),
    "conditions that differ": lambda: pipeline.boundary(two_days()),
    "other conditions": lambda: pipeline.margin(
        plane(preset="standard", **SMALL), 300.0, 1.2, critical_area_fraction=0.02
    ),
}


def said(answer):
    """Sentences on a point; else the table of an answer and its facts."""
    if not answer.sizes:
        return "\n".join([*point_lines(answer), *fact_lines(answer, *NOTES)])
    frames = [margin_frame(answer)] if "verdict" in answer else map(
        partial(boundary_frame, answer), ("load", "velocity")
    )  # fmt: skip
    lines = [line for frame in frames for line in lines_of(frame)]
    return "\n".join([*lines, *map(str, facts(answer))])


def test_answers_read_as_they_are_kept():
    ds = plane(**SMALL)
    flags = xr.where((ds["load"] == 400) & (ds["velocity"] == 2), 3, 0)
    warned = pipeline.points_with_warnings(ds.assign(warning_flags=flags)).lines()
    texts = {name: said(make()) for name, make in ANSWERS.items()}
    outside = point_lines(pipeline.margin(ds, 900.0, 1.5))
    further = {"a point with warnings": "\n".join(warned), "a place outside": "\n".join(outside)}
    assert_as_kept("answers", texts | further)
