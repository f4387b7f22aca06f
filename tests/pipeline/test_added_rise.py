"""What acts beside the model, `[model] rise`, multiplies the rise by friction in every answer."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

import pipeline
from pipeline.answers.results import sweep_of
from tests.helpers import synthetic
from tests.helpers.answer_at import asked
from tests.helpers.sweeps import with_fields
from tests.pipeline.conftest import commit_all
from tribo import Corrections, Friction

RISE, ADDED = {"added_rise_fraction": "+6 %"}, 1.06
LINE = "+6 % is added to the rise for effects outside the model (irg help physics)"
FEW = {
    "fidelity.preset": "standard",
    "sweep.loads": ["400 N", "600 N"],
    "sweep.velocities": ["1 m/s", "4 m/s"],
}


def without_tests(ds):
    """The sweep without tests: a measured friction would not follow another one of the scene."""
    return with_fields(ds, tests=())


def falling():
    """Sweep whose friction depends on velocity."""
    curve = Corrections(friction=Friction(by_velocity=((0.5, 1.2), (4.0, 0.9))))
    ds = synthetic.sweep()
    conditions = replace(sweep_of(ds).conditions, corrections=curve)
    return without_tests(with_fields(ds, conditions=conditions))


KINDS = {
    "one bulk": lambda: without_tests(synthetic.sweep()),
    "friction by velocity": falling,
}


@pytest.mark.parametrize("kind", KINDS)
def test_it_acts_as_more_friction_does(kind):
    ds = KINDS[kind]()
    rubbed = {"friction": ADDED * sweep_of(ds).conditions.friction}
    plain, boundary, like = (pipeline.boundary(ds, **own) for own in ({}, RISE, rubbed))
    for name in ("critical_velocity", "critical_load", "critical_velocity_p50"):
        np.testing.assert_allclose(boundary[name], like[name], rtol=1e-12)
        assert not plain[name].equals(boundary[name])
    margin, same = (asked(ds, 600.0, 1.2, **own) for own in (RISE, rubbed))
    for name in (
        "governing_temperature",
        "temperature_margin",
        "probability",
        "probability_high",
        "critical_velocity",
    ):
        assert getattr(margin, name) == pytest.approx(getattr(same, name), rel=1e-9)
    both = pipeline.temperatures(ds, **RISE), pipeline.temperatures(ds, **rubbed)
    xr.testing.assert_allclose(*(one.drop_attrs() for one in both), rtol=1e-12)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Store of a small sweep whose scene names no rise beside the model."""
    path = tmp_path_factory.mktemp("rise") / "s.zarr"
    commit_all(path, pipeline.load_scene("first_try", overrides=FEW))
    return path


def test_each_answer_names_it_where_it_is_not_zero(irg, store, tmp_path):
    place = "--load=600 N", "--velocity=2 m/s"
    at = "--at", "model.rise=+6 %"
    for command in (("boundary", store), ("margin", store, *place)):
        text = irg(*command, *at)
        assert text.count(LINE) == 1
        assert "outside the model" not in irg(*command)
        assert "outside the model" not in irg(*command, "--at", "model.rise=0")
    assert "25 °C, rise +6 %" in irg("boundary", store, *at)
    assert "rise −5 %" in irg("boundary", store, "--at", "model.rise=-5 %")
    (tmp_path / "own.toml").write_text('extends = "first_try"\n[model]\nrise = "+6 %"\n')
    few = "--preset=standard", "--set=sweep.realizations=1", "--without-tests"
    assert LINE in irg("point", tmp_path / "own.toml", *place, *few)
    figure = pipeline.plot(store, **RISE)
    texts = (text.get_text().replace("\n", " ") for text in figure.findobj(Text))
    assert any("bulk temperature 25 °C, rise +6 %" in text for text in texts)


def test_a_run_with_another_one_computes_nothing_and_is_judged_by_it(irg, tmp_path):
    path = tmp_path / "s.zarr"
    commit_all(path, pipeline.load_scene("first_try", overrides=FEW))
    before = pipeline.boundary(path, friction=0.106)["critical_velocity"]
    (tmp_path / "own.toml").write_text('extends = "first_try"\n[model]\nrise = "+6 %"\n')
    few = [f"--set={name}={value}" for name, value in FEW.items()]
    again = irg("run", tmp_path / "own.toml", *few, "-o", path, "--workers=1", "--json")
    assert (again["computed"], again["done"]) == (0, 4)
    after = pipeline.boundary(path)["critical_velocity"]
    np.testing.assert_allclose(after, before, rtol=1e-12)


def test_a_critical_temperature_from_tests_contains_it(irg, tmp_path):
    ds = synthetic.sweep()
    plain, added = (
        pipeline.infer(ds, **own)["critical_temperature"].item() - 298.15 for own in ({}, RISE)
    )
    assert added == pytest.approx(ADDED * plain, rel=0.01)  # the prior stays where it is
    text = irg("infer", "first_try", "--preset=standard", "--set", "model.rise=+6 %")
    assert LINE in text


def test_check_says_what_is_not_counted_unless_transitions_or_the_entry_count_it(irg, tmp_path):
    said = "heating through pin holder and surface films is not modelled; model.rise adds it"
    assert said not in irg("check", "first_try")
    assert LINE in irg("check", "first_try", "--set", "model.rise=+6 %")
    (tmp_path / "own.toml").write_text('extends = "first_try"\nwithout = ["tests"]\n')
    assert irg("check", tmp_path / "own.toml").count(said) == 1
    added = irg("check", tmp_path / "own.toml", "--set", "model.rise=+6 %")
    assert said not in added
    assert LINE in added


@pytest.mark.parametrize("value", ["-100 %", "-1.5", "much"])
def test_a_rise_that_leaves_nothing_is_refused(irg, store, value):
    assert "model.rise" in irg("check", "first_try", "--set", f"model.rise={value}", code=2)
    assert "give" in irg("boundary", store, "--at", f"model.rise={value}", code=2)
