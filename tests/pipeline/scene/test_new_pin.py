"""A pin of a new shape is a class and a name: nothing asks for a crown."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.scene.facts import facts_of
from pipeline.sweep.surface import find_lubrication
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.scenes import STEEL
from tests.pipeline.conftest import commit_all
from tribo.simulation.pins import sizes_of


@dataclass(frozen=True, slots=True)
class Oblong:
    """A paraboloid twice as blunt across sliding, which borrows all that it tells."""

    radius: float
    bluntness: float
    material: tribo.Material
    length: ClassVar[None] = None

    @property
    def _roller(self):
        return tribo.Crowned(self.radius, self.bluntness * self.radius, self.material)

    words = "oblong"

    def profile(self, grid):
        return self._roller.profile(grid)

    def patches(self, grid):
        return 1.0

    def hertz(self, normal_load, contact_modulus):
        return self._roller.hertz(normal_load, contact_modulus)

    def worn(self, half_width, volume):
        return self._roller.worn(half_width, volume)

    def film_thickness(self, oil, normal_load, contact_modulus):
        return self._roller.film_thickness(oil, normal_load, contact_modulus)


@pytest.fixture
def sweep(monkeypatch):
    monkeypatch.setitem(tribo.PINS, "oblong", Oblong)
    pin = Oblong(5e-3, 2.0, STEEL)
    oil = tribo.Oil((313.15, 373.15), (95e-6, 10.7e-6), 866.0, (20e-9, 20e-9))
    free = tribo.Grid((48, 48), (8e-6, 8e-6), (False, False))
    return tiny.sweep(pin=pin, pixels=free, oil=oil, loads=(5.0, 10.0), velocities=(1.0,))


def test_a_new_pin_is_checked_sized_and_swept_like_any_other(sweep, tmp_path):
    crowned = changed(sweep, pin=tribo.Crowned(5e-3, 10e-3, STEEL))
    facts, expected = facts_of(sweep), facts_of(crowned)
    assert facts.contact_width == expected.contact_width
    assert facts.wear_depth == expected.wear_depth
    assert sizes_of(sweep.scene.pin) == ("radius", "bluntness")
    film = [find_lubrication(one).film_parameter(5.0, 1.0, 298.15) for one in (sweep, crowned)]
    assert film[0] == film[1] > 0
    store = tmp_path / "new.zarr"
    commit_all(store, sweep)
    ds = pipeline.open_sweep(store)
    assert pipeline.warned(ds).points == pipeline.warned(crowned_store(crowned, tmp_path)).points
    assert np.isfinite(ds["max_rise"].isel(step=-1)).all()


def crowned_store(sweep, folder):
    commit_all(folder / "crowned.zarr", sweep)
    return pipeline.open_sweep(folder / "crowned.zarr")
