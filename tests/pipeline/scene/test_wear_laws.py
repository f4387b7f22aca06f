"""Wear laws that ship have names in a scene, as pins and criteria do."""

from dataclasses import dataclass, field

import pytest

import pipeline
import tribo
from pipeline.scene import format as scene_format
from pipeline.scene.doubts import doubts
from pipeline.scene.facts import facts_of
from pipeline.sweep.codec import sweep_text, text_sweep
from pipeline.sweep.own_laws import own_laws
from pipeline.sweep.remarks import Remark
from pipeline.sweep.wear_rates import note_on_wear
from tests.pipeline.conftest import commit_all

RUNNING_IN = {
    "law": "running-in",
    "initial_rate": "6e-6 mm^3/(N m)",
    "final_rate": "1e-6 mm^3/(N m)",
    "distance": "2 m",
}
WITHOUT = ["wear.specific_wear_rate", "wear.pattern"]


def named(**changes):
    return pipeline.load_scene(
        "first_try", overrides={"without": WITHOUT, "wear": RUNNING_IN | changes}
    )


def test_a_law_that_ships_is_named_and_no_code_of_the_user_s():
    sweep = named(pattern="local")
    assert sweep.scene.wear == tribo.RunningIn(6e-15, 1e-15, 2.0, "local")
    assert own_laws(sweep.scene) == {}
    assert text_sweep(sweep_text(sweep, arrays := {}), arrays) == sweep


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"distance": None}, "wear.distance"),
        ({"initial_rate": "2 m"}, "wear.initial_rate"),
        ({"specific_wear_rate": "1e-6 mm^3/(N m)"}, "wear.specific_wear_rate: unknown key"),
        ({"law": "walking-in"}, "wear.initial_rate: unknown key"),
    ],
)
def test_a_law_is_told_what_it_needs(changes, said):
    entries = {k: v for k, v in (RUNNING_IN | changes).items() if v is not None}
    with pytest.raises(pipeline.SceneFileError) as error:
        pipeline.load_scene("first_try", overrides={"without": WITHOUT, "wear": entries})
    assert said in str(error.value)


def test_a_further_law_is_an_entry_of_the_table_and_nothing_else(monkeypatch):
    @dataclass(frozen=True, slots=True)
    class Steady:
        """Wear at one rate.

        Parameters
        ----------
        rate : float
            Specific wear rate [m²/N].
        pattern : str
            Pattern of the wear.
        """

        rate: float = field(metadata={"unit": "m^2/N"})
        pattern: tribo.wear.WearPattern = "swept"

        def over(self, begin, end):
            return tribo.Wear(self.rate, self.pattern)

    monkeypatch.setitem(tribo.LAWS, "steady", Steady)
    form = scene_format._law_form("steady")
    assert [*form.keys] == ["law", "rate", "pattern"]
    assert form.needed == ["law", "rate"]
    assert scene_format._wear_form({"law": "steady"}) == 3


BY_TEMPERATURE = {
    "wear.by_temperature": [
        {"temperature": "25 degC", "specific_wear_rate": "0.37e-6 mm^3/(N m)"},
        {"temperature": "100 degC", "specific_wear_rate": "0.88e-6 mm^3/(N m)"},
    ],
    "wear.specific_wear_rate": "0.37e-6 mm^3/(N m)",
}


def test_a_wear_rate_of_another_bulk_temperature_is_told():
    sweep = pipeline.load_scene("first_try", overrides=BY_TEMPERATURE)
    assert sweep.scene.wear == tribo.Wear(0.37e-15)
    assert note_on_wear(sweep) is None
    warm = pipeline.load_scene(
        "first_try", overrides=BY_TEMPERATURE | {"temperature.bulk": "62.5 degC"}
    )
    assert "is 5.71e-07 mm³/(N m)" in note_on_wear(warm)  # √(0.37 · 0.88)
    warned = Remark("wear.specific_wear_rate", "warning", note_on_wear(warm))
    assert warned in doubts(warm, facts_of(warm))
    right = {"wear.specific_wear_rate": "0.57e-6 mm^3/(N m)", "temperature.bulk": "62.5 degC"}
    assert note_on_wear(pipeline.load_scene("first_try", overrides=BY_TEMPERATURE | right)) is None


@pytest.mark.parametrize(
    ("unknown", "told"),
    [
        ({}, True),
        (
            {"wear.specific_wear_rate": {"from": "0.3e-6 mm^3/(N m)", "to": "1e-6 mm^3/(N m)"}},
            False,
        ),
    ],
)
def test_a_wear_rate_of_one_bulk_temperature_is_told_where_the_bulk_is_unknown(unknown, told):
    warm = {"temperature.bulk": {"from": "25 degC", "to": "62.5 degC"}}
    draft = {"fidelity.preset": "draft", "sweep.samples": 16, "unknown": warm | unknown}
    note = note_on_wear(pipeline.load_scene("first_try", overrides=BY_TEMPERATURE | draft))
    assert bool(note) == told
    if told:  # at 95 % of the range, 60.6 °C
        assert note.startswith("temperature.bulk is unknown, and the wear rate at the bulk")
        assert "60.625 °C" in note
        assert "is 5.58e-07 mm³/(N m)" in note


def test_a_misspelt_law_is_asked_for_by_the_laws_that_ship():
    with pytest.raises(pipeline.SceneFileError) as caught:
        pipeline.load_scene(
            "first_try",
            overrides={
                "wear": {
                    "law": "runing-in",
                    "initial_rate": "6e-6 mm^3/(N m)",
                    "final_rate": "1e-6 mm^3/(N m)",
                    "distance": "2 m",
                }
            },
        )
    assert 'wear.law: "runing-in" is unknown (did you mean "running-in"?)' in str(caught.value)
    for path, near in (("pin.shape", "cylindr"), ("temperature.criterion", "higest")):
        with pytest.raises(pipeline.SceneFileError, match="did you mean"):
            pipeline.load_scene("first_try", overrides={path: near})
    with pytest.raises(pipeline.SceneFileError, match='did you mean "by_temperature"'):
        pipeline.load_scene("first_try", overrides={"friction.by_temprature": []})


def test_an_answer_at_another_bulk_temperature_says_that_its_wear_is_of_the_first(tmp_path, irg):
    store = tmp_path / "worn.zarr"
    draft = {"fidelity.preset": "draft", "sweep.loads": ["400 N"]}
    commit_all(store, pipeline.load_scene("first_try", overrides=BY_TEMPERATURE | draft))
    said, warm = "the wear rate at the bulk temperature, 100 °C", "bulk_temperature=100 degC"
    assert said not in irg("boundary", store)
    assert said in irg("boundary", store, "--at", warm)
    here = "--load", "400 N", "--velocity", "2 m/s"
    assert said not in irg("margin", store, *here)
    assert said in irg("margin", store, *here, "--at", warm)
    assert irg("margin", store, *here, "--json")["not_counted"] is None
    table = tmp_path / "points.csv"
    table.write_text("load [N],velocity [m/s],bulk temperature [°C]\n400,2,25\n400,2,100\n")
    assert f"warning: {said}" in irg("margin", store, "--points", table)


def test_samples_at_a_bulk_temperature_of_another_wear_rate_say_so(tmp_path, irg):
    store = tmp_path / "drawn.zarr"
    unknown = {
        "temperature.bulk": {"from": "25 degC", "to": "62.5 degC"},
        "friction.coefficient": {"mean": 0.1, "sd": 0.005},
    }
    drawn = {"fidelity.preset": "draft", "sweep.loads": ["400 N", "600 N"], "sweep.samples": 16}
    scene = pipeline.load_scene(
        "first_try", overrides=BY_TEMPERATURE | drawn | {"unknown": unknown}
    )
    commit_all(store, scene)
    said = "warning: temperature.bulk is unknown, and the wear rate at the bulk temperature, 60.6"
    assert said in irg("boundary", store)
    assert irg("boundary", store, "--json")["not_counted"].startswith("temperature.bulk is unknown")
    cold = "--at", "bulk_temperature=25 degC"
    assert "the wear rate" not in irg("boundary", store, *cold)
    here = "margin", store, "--load", "400 N", "--velocity", "2 m/s"
    assert said in irg(*here)
    assert "the wear rate" not in irg(*here, *cold)
