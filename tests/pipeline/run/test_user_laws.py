"""Sweeps with a wear law or surface of a user's class (pipeline/sweep/user_laws.py)."""

import importlib
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pipeline
from pipeline import StoreMismatchError, run_sweep
from pipeline.store.create import find_sweep
from pipeline.sweep.plan import points
from tests.helpers import laws, tiny

OIL = tiny.tribo.Oil((32e-6, 5e-6), 866.0, 20e-9)


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A user's module, as a file in a folder from which Python imports."""
    monkeypatch.syspath_prepend(tmp_path)
    source = Path(laws.__file__).read_text(encoding="utf-8")
    (tmp_path / "laws_of_a_user.py").write_text(source, encoding="utf-8")
    monkeypatch.delitem(sys.modules, "laws_of_a_user", raising=False)
    return importlib.import_module("laws_of_a_user")


def parts_of(module):
    return {
        "pressure": {"wear": module.ByPressure()},
        "table": {"wear": module.Tabled()},
        "surface": {"roughness": module.Grooves()},
    }


SWEEP = tiny.sweep(velocities=(0.5, 1.5))


def forget(module):
    """Delete a module's file and the module, so that nothing can import it."""
    Path(module.__file__).unlink()
    del sys.modules[module.__name__]


@pytest.mark.parametrize("name", ["pressure", "table", "surface"])
def test_a_sweep_with_a_user_s_class_is_computed_and_answered_without_its_module(
    path, module, name
):
    sweep = SWEEP.with_scene(**parts_of(module)[name])
    expected = [pipeline.run_point(sweep, *point[:2]) for point in points(sweep)]
    Path(module.__file__).unlink()  # from which workers would import it
    assert run_sweep(sweep, path, workers=1).done == 6
    forget_only = sys.modules.pop(module.__name__)
    with pipeline.open_sweep(path) as ds:
        for point in expected:
            load, velocity, _ = point.point
            stored = ds["max_rise"].sel(load=load, velocity=velocity, step=0)
            assert stored == point.columns["max_rise"][-1]
    assert pipeline.verify_store(path).is_clean
    assert np.isfinite(pipeline.margin(path, 300.0, 1.0)["governing_temperature"])
    assert forget_only.__name__ not in sys.modules
    known = find_sweep(path)
    assert known == sweep
    assert known.scene.wear.pattern == sweep.scene.wear.pattern


def test_answers_read_the_roughness_of_a_user_s_surface(path, module):
    sweep = SWEEP.with_scene(roughness=module.Grooves())
    summary = find_summary(sweep)
    assert summary.rq == pytest.approx(0.5e-6, rel=1e-6)
    assert summary.lay == pytest.approx(90.0)
