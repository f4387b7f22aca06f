"""A scene that extends another is the scene written in full."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from pipeline import SceneFileError, load_scene
from pipeline.sweep.sweep import digest
from tests.helpers.entries import changed
from tests.pipeline.scene.conftest import MEASURED_SURFACE, ROUGHNESS, TEXT

EXTENDS = 'extends = "base.toml"\n'


@pytest.fixture
def write(tmp_path):
    """Write scenes; return the path of the last one."""
    (tmp_path / "base.toml").write_text(TEXT, encoding="utf-8")

    def write(**texts):
        for name, text in texts.items():
            path = tmp_path / f"{name}.toml"
            path.write_text(text, encoding="utf-8")
        return path

    return write


def faults_of(path, **arguments):
    with pytest.raises(SceneFileError) as caught:
        load_scene(path, **arguments)
    return caught.value.faults


def test_a_scene_that_only_extends_is_the_other_under_its_own_name(write):
    sweep = load_scene(write(own=EXTENDS))
    assert sweep == changed(load_scene(write(base=TEXT)), name="own")


def test_what_an_inherited_entry_excludes_is_replaced_or_named(write):
    counted = EXTENDS + '[sweep]\nvelocities = { to = "4 m/s", count = 3 }'
    assert load_scene(write(own=counted)).velocities == (1.0, 2.5, 4.0)
    fault, *_ = faults_of(write(own=EXTENDS + '[disk.roughness]\nfile = "scan.npy"'))
    assert fault.startswith("disk.roughness.ra (in ")
    assert fault.endswith('leave it out here: without = ["disk.roughness.ra"]')


def test_a_false_entry_of_over_is_not_said_to_be_inherited(write):
    (fault,) = faults_of(write(own=EXTENDS + '[sweep]\nover = { "pin.radus" = ["3 mm"] }'))
    assert fault.startswith("pin.radus")
    assert "without" not in fault


def test_entries_of_its_own_stand_in_place_of_the_others(write):
    entries = """
    extends = "base.toml"
    [pin]
    radius = "4 mm"
    [sweep]
    loads = ["300 N"]
    velocities = { to = "2.2 m/s" }
    [[tests]]
    load = "300 N"
    velocity = "2 m/s"
    outcome = "transition"
    """
    text = TEXT[: TEXT.index("[[tests]]")] + entries[entries.index("[[tests]]") :]
    for old, new in (
        ('"2 mm"', '"4 mm"'),
        ('["200 N", "400 N", "600 N", "750 N"]', '["300 N"]'),
        ('to = "4 m/s"', 'to = "2.2 m/s"'),
    ):
        assert old in text
        text = text.replace(old, new)
    extended, written = load_scene(write(own=entries)), load_scene(write(full=text))
    assert extended == changed(written, name="own")
    assert digest(extended.scene) == digest(written.scene)


def test_entries_may_be_left_out(write):
    keys = '"wear", "friction.band", "tests", "materials.steel.hardness", "disk.roughness.seed"'
    sweep = load_scene(write(own=f"{EXTENDS}without = [{keys}]"))
    assert sweep.scene.wear is sweep.base.friction_band is None
    assert sweep.tests == ()
    assert sweep.scene.hardness == np.inf
    assert sweep.scene.disk.elastic_modulus == 210e9


def test_a_preset_takes_the_place_of_the_others_numerical_choices(write):
    write(base=TEXT.replace('preset = "standard"', "increments = 7"))
    sweep = load_scene(write(own=f'{EXTENDS}[fidelity]\npreset = "fine"'))
    assert sweep.scene.fidelity == tribo.PRESETS["fine"]
    sweep = load_scene(write(own=f"{EXTENDS}[fidelity]\nfewest_elements = 50"))
    own = {"increments": 7, "fewest_elements": 50}
    assert sweep.scene.fidelity == replace(tribo.PRESETS["standard"], **own)


def test_files_are_looked_for_beside_the_scene_that_names_them(write, tmp_path):
    folder = tmp_path / "surfaces"
    folder.mkdir()
    np.save(folder / "surface.npy", np.eye(480))
    measured = TEXT.replace(ROUGHNESS, MEASURED_SURFACE)
    (folder / "base.toml").write_text(measured, encoding="utf-8")
    sweep = load_scene(write(own='extends = "surfaces/base.toml"'))
    np.testing.assert_array_equal(sweep.scene.roughness.array, np.eye(480) * 1e-6)
    fault, *_ = faults_of(
        write(own='extends = "surfaces/base.toml"\n[disk.roughness]\nfile = "surface.npy"')
    )
    assert str(tmp_path / "surface.npy") in fault
    (folder / "record.csv").write_text("time [s], load [N]\n0, 0\n5, 800\n", encoding="utf-8")
    ramp = 'rate = "150 N/s"\nreference_load = "750 N"'
    recorded = TEXT.replace(ramp, 'file = "record.csv"')
    (folder / "base.toml").write_text(recorded, encoding="utf-8")
    assert max(load_scene(write(own='extends = "surfaces/base.toml"')).scene.loading.loads) == 800.0


def test_a_shipped_scene_is_named_wherever_a_scene_is_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shipped = load_scene("first_try")
    (tmp_path / "mine.toml").write_text('extends = "first_try"\n')
    assert load_scene("mine.toml").loads == shipped.loads
    (tmp_path / "first_try").write_text('extends = "twin_disc"\n')  # files precede shipped scenes
    assert load_scene("first_try").scene.motion is not None


def test_settings_reach_whole_entries_and_leave_some_out():
    wear = {"wear.specific_wear_rate": "1e-6 mm^3/(N m)", "wear.pattern": "local"}
    overrides = {"title": "Mine", "without": ["wear"], "oil": "oil A"}
    sweep = load_scene("first_try", overrides=overrides)
    assert (sweep.title, sweep.scene.wear, sweep.lubricant.density) == ("Mine", None, 862.0)
    sweep = load_scene("first_try", overrides=wear | {"without": ["wear", "oil"]})
    assert (sweep.scene.wear.pattern, sweep.lubricant) == ("local", None)


@pytest.mark.parametrize(
    ("path", "written"), [("sweep.loads", "loads = {}"), ("sweep.velocities", "velocities = {}")]
)
def test_an_empty_table_over_another_is_refused_by_name(write, path, written):
    own = write(own=f"{EXTENDS}[sweep]\n{written}\n")
    said = f"{path}: an empty table changes nothing; give its entries, or leave it out"
    assert faults_of(own) == [said]
    assert faults_of(write(base=TEXT), overrides={path: {}}) == [said]
