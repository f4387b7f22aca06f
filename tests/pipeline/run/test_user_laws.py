"""Sweeps with a wear law or surface of a user's class (pipeline/sweep/user_laws.py)."""

import contextlib
import importlib
import sys
from dataclasses import replace
from pathlib import Path

import cloudpickle
import numpy as np
import pytest

import pipeline
from pipeline import StoreMismatchError, run_sweep
from pipeline.store.create import find_sweep, writing
from pipeline.sweep.plan import points
from tests.helpers import laws, tiny

SWEEP = tiny.sweep(velocities=(0.5, 1.5))


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A user's module, as a file in a folder from which Python imports."""
    monkeypatch.syspath_prepend(tmp_path)
    source = Path(laws.__file__).read_text(encoding="utf-8")
    (tmp_path / "laws_of_a_user.py").write_text(source, encoding="utf-8")
    monkeypatch.delitem(sys.modules, "laws_of_a_user", raising=False)
    module = importlib.import_module("laws_of_a_user")
    with contextlib.suppress(ValueError):  # tasks of an earlier test may carry its code
        cloudpickle.unregister_pickle_by_value(module)
    return module


def with_class_of(module, name):
    """The tiny sweep with an object of a user's class."""
    parts = {
        "pressure": {"wear": module.ByPressure()},
        "table": {"wear": module.Tabled()},
        "surface": {"roughness": module.Grooves()},
    }
    return SWEEP.with_scene(**parts[name])


@pytest.mark.parametrize("name", ["pressure", "table", "surface"])
def test_workers_and_answers_need_no_module_of_a_user_s_class(path, module, name):
    sweep = with_class_of(module, name)
    expected = [pipeline.run_point(sweep, *point[:2]) for point in points(sweep)]
    Path(module.__file__).unlink()  # a worker would import it otherwise
    assert run_sweep(sweep, path, workers=1).done == 6
    del sys.modules[module.__name__]
    with pipeline.open_sweep(path) as ds:
        for result in expected:
            load, velocity, _ = result.point
            stored = ds["max_rise"].sel(load=load, velocity=velocity, step=0)
            assert stored == result.columns["max_rise"][-1]
    assert pipeline.verify_store(path).is_clean
    assert np.isfinite(pipeline.margin(path, 300.0, 1.0)["governing_temperature"])
    assert find_sweep(path) == sweep
    assert find_sweep(path).scene.wear.pattern == sweep.scene.wear.pattern
    assert module.__name__ not in sys.modules


def test_the_roughness_of_a_user_s_surface_is_stored(path, module):
    with writing(path, with_class_of(module, "surface")):
        surface = find_sweep(path).scene.roughness.summary
    assert surface.rq == pytest.approx(0.5e-6 / 2**0.5, rel=1e-2)
    assert surface.lay == pytest.approx(90.0)


def test_a_run_continues_and_grows_the_store_of_the_same_law(path, module):
    sweep = with_class_of(module, "table")
    run_sweep(replace(sweep, loads=(150.0, 600.0)), path, workers=1)
    again = with_class_of(importlib.reload(module), "table")
    assert run_sweep(again, path, workers=1).computed == 2
    assert run_sweep(again, path, workers=1).computed == 0


def test_a_run_with_another_law_is_refused_in_a_line(path, module):
    with writing(path, with_class_of(module, "table")):
        pass
    other_values = module.Tabled(module.Table(rates=(4e-15, 2e-15, 2e-15)))
    others = (SWEEP.with_scene(wear=law) for law in (other_values, module.ByPressure()))
    for other in (SWEEP, *others):
        with pytest.raises(StoreMismatchError) as error:
            run_sweep(other, path, workers=1)
        heading, line = str(error.value).splitlines()
        assert "belongs to another scene" in heading
        assert "wear: Tabled(table=Table(distances=(0.0" in line


def test_a_changed_entry_keeps_the_law(module):
    scene = pipeline.load_scene("first_try").with_scene(wear=module.ByPressure())
    wider = scene.changed("pin.radius", "3 mm")
    assert (wider.scene.pin.radius, wider.scene.wear) == (3e-3, scene.scene.wear)
    assert wider.text.startswith("# wear is replaced by ByPressure(rate=2e-24, pattern='local') of")
