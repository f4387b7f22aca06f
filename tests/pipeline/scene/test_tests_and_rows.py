"""Tests and rows of a scene: their entries, loads and velocities, and load stages."""

from dataclasses import replace

import pytest

import pipeline
import tribo
from pipeline.sweep.plan import points
from pipeline.units import exact_si
from tests.helpers.scenes import SCENE
from tests.helpers.stored import parse_sweep, sweep_text
from tribo import Stages

WEAR = 'with = { "wear.specific_wear_rate" = "3.7e-7 mm^3/(N m)" }'


@pytest.fixture
def load(tmp_path):
    def load_tests(*tests, top=""):
        listed = "".join(f"\n[[tests]]\n{entries}\n" for entries in tests)
        scene = f'extends = "first_try"\nwithout = ["tests"]\n{top}{listed}'
        (tmp_path / "lab.toml").write_text(scene, encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml")

    return load_tests


def transition(*entries, outcome="transition"):
    return "\n".join(['load = "400 N"', 'velocity = "2 m/s"', f'outcome = "{outcome}"', *entries])


BY_LOAD = 'velocity = "2 m/s"\nmild_up_to = "400 N"\nsevere_at = "450 N"\nnumber = 7'
BEYOND = 'velocity = "2 m/s"\nmild_up_to = "700 N"\nfriction = 0.1'


def test_a_run_by_stages_is_its_last_mild_test_and_its_severe_one_or_one_of_them(load):
    tests = load(BY_LOAD, BEYOND).tests
    read_tests = [(test.normal_load, test.velocity, test.outcome, test.number) for test in tests]
    assert read_tests == [
        (400.0, 2.0, "mild", "7"),
        (450.0, 2.0, "severe", "7"),
        (700.0, 2.0, "mild", tests[-1].number),
    ]
    assert tests[-1].case.conditions.friction == 0.1


def test_a_test_has_the_scene_with_its_own_entries(load):
    own_entries = transition(WEAR, "friction = 0.12", 'bulk_temperature = "60 degC"')
    changed, plain = load(own_entries, transition()).tests
    scene = pipeline.load_scene("first_try")
    with_wear = scene.changed("wear.specific_wear_rate", "3.7e-7 mm^3/(N m)")
    assert changed.case.scene == with_wear.scene
    conditions = changed.case.conditions
    assert (conditions.friction, conditions.bulk_temperature) == (0.12, 333.15)
    assert plain.case.scene == scene.scene
    assert plain.case.conditions == replace(scene.conditions, critical_temperature=None)


@pytest.mark.parametrize(
    ("step", "before"), [("0.25 m/s", (400.0, 1.75)), ("50 N", (350.0, 2.0)), (None, None)]
)
def test_a_step_leads_from_the_last_mild_place_to_the_transition(load, step, before):
    (test,) = load(transition(*([f'step = "{step}"'] if step else []))).tests
    assert test.points == ((before,) if before else ()) + ((400.0, 2.0),)


def test_a_store_keeps_what_a_test_changes_whatever_the_library_has_later(load):
    own_entries = 'with = { "pin.material" = "100Cr6", "fidelity.preset" = "fine" }'
    sweep = load(
        transition(own_entries, 'step = "0.5 m/s"'),
        f'load = "300 N"\nvelocity = "1 m/s"\noutcome = "mild"\n{WEAR}',
    )
    stored = parse_sweep(sweep_text(sweep), {})
    assert stored == sweep
    assert [test.case for test in stored.tests] == [test.case for test in sweep.tests]
    assert stored.tests[0].case.scene.fidelity == tribo.PRESETS["fine"]
    assert sweep_text(stored) == sweep_text(sweep)


# Stages of one specimen in a scene: how they are written, read, stored and refused.

RAMP = '[loading]\nrate = "150 N/s"\nreference_load = "750 N"'
EVEN = '[loading]\nrate = "150 N/s"\nstages = { first = "200 N", step = "200 N", hold = "5 s" }'
LISTED = (
    '[loading]\nrate = "150 N/s"\nstages = [["200 N", "5 s"], ["400 N", "5 s"], ["600 N", "1 min"]]'
)
WINDOW = "pixels = [48, 16]"


@pytest.fixture
def staged(tmp_path):
    def read(loading=EVEN, *tests, change=("", "")):
        text = SCENE.replace(RAMP, loading).replace(*change)
        text += "".join(f"\n[[tests]]\n{test}\n" for test in tests)
        (tmp_path / "lab.toml").write_text(text, encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml")

    return read


def test_stages_are_read_in_both_forms(staged):
    even, listed = staged(), staged(LISTED)
    loads = 200.0, 400.0, 600.0
    assert even.scene.loading == Stages(loads, (5.0,) * 3, 150.0)
    assert listed.scene.loading == Stages(loads, (5.0, 5.0, 60.0), 150.0)
    # The reference load of a scene that this one extends is not used.
    assert staged(f'{EVEN}\nreference_load = "750 N"') == even


def test_the_window_is_as_wide_as_the_stages_wear_the_pin(staged):
    sweep = staged()  # up to 600 N and 4 m/s
    volume = 1.2e-15 * sweep.scene.loading.worn_impulse(4.0) / 3.4e-3
    chord = (12 * 2e-3 * volume) ** (1 / 3)
    side = sweep.scene.pixels.size[0]
    assert 384e-6 < 1.25 * chord <= side < 1.4 * chord
    wider = staged(change=(WINDOW, "pixels = [300, 16]"))
    assert wider.scene.pixels.shape == (300, 16)


def test_the_stages_of_a_test_are_one_specimen_up_to_its_last_stage_and_are_stored(staged):
    by_load = 'stages = { first = "100 N", step = "100 N", hold = "60 s" }\nvelocity = "2 m/s"\n'
    listed = 'stages = [["100 N", "60 s"], ["250 N", "90 s"], ["400 N", "60 s"]]\n'
    sweep = staged(
        RAMP,
        f'{by_load}mild_up_to = "200 N"\nsevere_at = "300 N"',
        f'{listed}velocity = "2 m/s"\nmild_up_to = "250 N"',
    )
    mild, severe, other = sweep.tests
    assert mild.case.scene == severe.case.scene
    volume = 1.2e-15 * mild.case.scene.loading.worn_impulse(2.0) / 3.4e-3
    chord = (12 * 2e-3 * volume) ** (1 / 3)
    assert sweep.scene.pixels.size[0] < 1.25 * chord <= mild.case.scene.pixels.size[0]
    assert mild.case.scene.loading == Stages((100.0, 200.0, 300.0), (60.0,) * 3, 150.0)
    assert other.case.scene.loading == Stages((100.0, 250.0), (60.0, 90.0), 150.0)
    reread = parse_sweep(sweep_text(sweep), {})
    assert [test.case.scene for test in reread.tests] == [test.case.scene for test in sweep.tests]


def test_a_test_without_stages_of_its_own_has_those_of_the_scene(staged):
    single = 'load = "{} N"\nvelocity = "2 m/s"\noutcome = "mild"'
    inside, above = staged(EVEN, single.format(400), single.format(1000)).tests
    assert inside.case.scene.loading.loads == (200.0, 400.0, 600.0)
    assert above.case.scene.loading.loads == (200.0, 400.0, 600.0, 800.0, 1000.0)


# Rows of a file or of the scene, each with a load, a velocity and entries.

TABLES = """along = [
  { "pin.radius" = "3 mm", "friction.coefficient" = 0.1, load = "300 N", velocity = "1 m/s" },
  { "pin.radius" = "4 mm", "friction.coefficient" = 0.12, load = "600 N", velocity = "2 m/s" },
]"""
FILE = """pin.radius [mm],friction.coefficient,load [N],velocity [m/s],flank
3,0.1,300,1,a
4,0.12,600,2,b
"""


def scene(tmp_path, along='along = "mesh.csv"', rows=FILE):
    (tmp_path / "mesh.csv").write_text(rows)
    (tmp_path / "scene.toml").write_text(SCENE.replace("[sweep]", f"[sweep]\n{along}"))
    return tmp_path / "scene.toml"


@pytest.mark.parametrize("along", [TABLES, 'along = "mesh.csv"'])
def test_each_row_has_its_place_and_its_entries(tmp_path, along):
    sweep = pipeline.load_scene(scene(tmp_path, along))
    assert [(point.load, point.velocity) for point in points(sweep)] == [(300.0, 1.0), (600.0, 2.0)]
    first, second = (sweep.case(name) for name in sweep.case_table.names)
    assert (first.scene.pin.radius, second.scene.pin.radius) == (3e-3, 4e-3)
    assert (first.conditions.friction, second.conditions.friction) == (0.1, 0.12)
    assert sweep.case_table.column("pin_radius") == (3e-3, 4e-3)


def test_the_quantities_read_for_a_row_do_not_depend_on_the_number_of_rows(tmp_path):
    def count_reads(rows):
        cells = [f"{200 + row},{1 + row / 100},{3 + row / 10}" for row in range(rows)]
        table = "\n".join(["load [N],velocity [m/s],pin.radius [mm]", *cells])
        (tmp_path / "rows.csv").write_text(table)
        (tmp_path / "lab.toml").write_text('extends = "first_try"\nsweep.along = "rows.csv"')
        before = exact_si.cache_info()
        assert len(pipeline.load_scene(tmp_path / "lab.toml").cases) == rows
        after = exact_si.cache_info()
        return after.hits + after.misses - before.hits - before.misses

    counts = [count_reads(rows) for rows in (10, 20, 40)]
    assert counts[2] - counts[1] == 2 * (counts[1] - counts[0])


def test_labels_are_words_and_names_stay_as_written(tmp_path):
    rows = "number,flank,load [N],velocity [m/s]\n007,a,300,1\n12E4,b,600,2\n"
    table = pipeline.load_scene(scene(tmp_path, rows=rows)).case_table
    columns = {column.name: (table.column(column.name), column.unit) for column in table.columns}
    assert columns["number"] == (("007", "12E4"), None)
    assert columns["flank"] == (("a", "b"), None)


def test_a_test_with_friction_is_heated_though_its_scene_is_not():
    test = {"load": "400 N", "velocity": "1 m/s", "outcome": "mild", "friction": 0.1}
    entries = {"friction.coefficient": 0, "without": ["friction.band"], "tests": [test]}
    sweep = pipeline.load_scene("first_try", overrides=entries)
    assert not sweep.scene.friction_heat
    assert sweep.tests[0].case.scene.friction_heat
