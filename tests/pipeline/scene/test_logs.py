"""Tests of a laboratory: tables of the scene, or rows of a log in CSV."""

import pytest

import pipeline
from pipeline.sweep.about import Measurement
from tests.helpers import tiny

SCENE = """
extends = "first_try"
without = ["measured"]

[[tested]]
load = "400 N"
velocity = "2 m/s"
outcome = "mild"

[[tested]]
file = "log.csv"
"""


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "lab.toml").write_text(SCENE, encoding="utf-8")

    def load(log):
        (tmp_path / "log.csv").write_text(log, encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml")

    return load


def test_rows_of_a_log_stand_beside_tables(lab):
    head = "date;Normal load [kN];velocity [m/s];friction;bulk temperature [degC];outcome;hold [s]"
    scene = lab(f"{head}\n1 May;0.4;2.5;0.1;60;severe;\n\n2 May;0.6;1.5;;;mild;10\n")
    assert scene.about.tested == (
        Measurement(400.0, 2.0, outcome="mild"),
        Measurement(400.0, 2.5, 0.1, bulk_temperature=333.15, outcome="severe"),
        Measurement(600.0, 1.5, hold=10.0, outcome="mild"),
    )
    assert "tested[1].file: columns not used: date" in scene.about.notes


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("0.4,-2,mild", ["row 2, velocity", "out of range"]),
        ("0.4,2,mlid", ["row 2, outcome", 'did you mean "mild"?']),
        ("0.4,2", ["row 2: 2 cells below 3 headings"]),
        (",2,severe", ["row 2, load", "missing"]),
        ('"0,4",2,severe', ["row 2, load", '"0,4 kN"']),
    ],
)
def test_a_fault_is_named_by_row_and_column(lab, row, words):
    with pytest.raises(pipeline.SceneFileError) as caught:
        lab(f"load [kN],velocity [m/s],outcome\n{row}\n")
    assert all(word in str(caught.value) for word in words)


def test_a_column_without_a_unit_is_told_where_to_have_it(lab):
    with pytest.raises(pipeline.SceneFileError, match=r"unit of the column in its heading"):
        lab("load [kN],velocity,outcome\n0.4,2,mild\n")


def test_all_faults_of_a_log_come_at_once(lab):
    with pytest.raises(pipeline.SceneFileError) as caught:
        lab("load [kN],velocity [m/s],outcome\n0.4,x,mild\n0,2,mild\n0.4,2,no\n")
    assert len(caught.value.faults) == 3


def test_a_log_without_a_sound_row_is_one_fault(tmp_path):
    scene = tmp_path / "lab.toml"
    scene.write_text('extends = "first_try"\n[[tested]]\nfile = "log.csv"\n', encoding="utf-8")
    with pytest.raises(pipeline.SceneFileError, match="cannot be read") as caught:
        pipeline.load_scene(scene)
    assert len(caught.value.faults) == 1


def test_a_transition_counts_with_its_own_bulk_and_hold():
    sweep = tiny.sweep(wear=None)  # so that it gets warmer in the hold
    plain, warm, held = (
        pipeline.critical_temperatures(
            sweep.changed(measured=(Measurement(300.0, 1.0, 0.1, **conditions),))
        ).mean
        for conditions in ({}, {"bulk_temperature": 333.15}, {"hold": 2.0})
    )
    bulk = sweep.conditions.bulk_temperature
    assert warm - 333.15 == pytest.approx(plain - bulk, rel=1e-9)
    assert held == pytest.approx(
        pipeline.critical_temperatures(
            sweep.held(2.0).changed(measured=(Measurement(300.0, 1.0, 0.1),))
        ).mean,
        rel=1e-12,
    )
    assert held > plain
