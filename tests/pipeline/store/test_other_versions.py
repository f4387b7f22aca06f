"""Stores of versions of this program whose classes differ, and of other versions of NumPy."""

from dataclasses import field, fields, make_dataclass, replace

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.store.create import find_sweep, writing
from pipeline.sweep import stored
from tests.helpers import tiny
from tests.helpers.stores import commit
from tribo import Fidelity, Wear

LATER = {
    cls: make_dataclass(cls.__name__, [("later", int, field(default=7))], bases=(cls,), frozen=True)
    for cls in (Wear, Fidelity)
}
"""Classes of a version with a field more, by those of this version."""


def of_later_version(part, **values):
    """A part of a scene as an object of the later version."""
    known = {field.name: getattr(part, field.name) for field in fields(part)}
    return LATER[type(part)](**known, **values)


def later_sweep(**values):
    """The tiny sweep of the later version; the field of its wear law has a value in `values`."""
    sweep = tiny.sweep()
    wear = of_later_version(sweep.scene.wear, **values)
    scene = replace(sweep.scene, wear=wear, fidelity=of_later_version(sweep.scene.fidelity))
    case = replace(sweep.base, scene=scene)
    return replace(sweep, base=case, cases=(case,))


def assert_all_intact(path):
    verification = pipeline.verify_store(path)
    assert (verification.done, verification.is_clean) == (9, True)


def test_a_store_remains_readable_if_a_field_with_its_default_is_removed(tmp_path):
    commit(tmp_path / "a.zarr", later_sweep())
    assert find_sweep(tmp_path / "a.zarr") == tiny.sweep()
    commit(tmp_path / "a.zarr", tiny.sweep(), ())  # damaged points would be pending
    assert_all_intact(tmp_path / "a.zarr")


def test_a_store_remains_readable_if_a_field_with_a_default_is_added(tmp_path, monkeypatch):
    commit(tmp_path / "a.zarr", tiny.sweep())
    for cls, later in LATER.items():
        monkeypatch.setitem(stored._CLASSES, cls.__name__, later)
    assert find_sweep(tmp_path / "a.zarr").scene.wear.later == 7
    commit(tmp_path / "a.zarr", later_sweep(), ())
    assert_all_intact(tmp_path / "a.zarr")


def scan(relative_error):
    """Heights of a scan as a library levels them whose rounding errors differ by as much."""
    heights = 3e-9 + tiny.sweep().scene.roughness.heights(tiny.sweep().scene.pixels)
    signs = np.random.default_rng(0).choice([-1, 1], heights.shape)
    return tribo.MeasuredRoughness(heights * (1 + relative_error * signs))


def test_a_sweep_of_a_scan_goes_on_whatever_the_rounding_errors_of_its_heights(tmp_path):
    begun, resumed, another = (tiny.sweep(roughness=scan(error)) for error in (0.0, 1e-15, 1e-4))
    assert (begun.scene.roughness.array != resumed.scene.roughness.array).any()
    assert (begun, hash(begun.scene)) == (resumed, hash(resumed.scene))
    assert begun.meaning_digest == resumed.meaning_digest != another.meaning_digest
    more_loads = replace(resumed, loads=(*resumed.loads, 800.0))
    commit(tmp_path / "a.zarr", begun)
    for sweep, count in ((resumed, 9), (more_loads, 12)):
        with writing(tmp_path / "a.zarr", sweep) as store:
            assert len(store.pending()) == count - 9
    with pytest.raises(pipeline.StoreMismatchError, match=r"disk.roughness.*in the store"):
        commit(tmp_path / "a.zarr", another, ())
