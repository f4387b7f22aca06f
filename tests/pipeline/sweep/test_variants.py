"""Tables of variants: which rows they have, and where each is simulated."""

import pytest

from pipeline.sweep.variants import Variants, surfaces
from tests.helpers import tiny
from tests.helpers.entries import rows
from tribo import InputError

OILS = rows("oil", {"a": {"disk.density": 7800.0}, "b": {"disk.density": 7900.0}})
LOADS, VELOCITIES = (150.0, 600.0), (0.5, 1.0)
HERE = {"a": {}, "b": {}}


@pytest.mark.parametrize(
    ("table", "plane"),
    [
        (Variants(), (LOADS, VELOCITIES)),
        (rows("test", HERE), (LOADS, VELOCITIES)),
        (rows("test", HERE, loads=(200.0, 300.0)), ((300.0,), VELOCITIES)),
        (rows("test", HERE, velocities=(2.0, 3.0)), (LOADS, (3.0,))),
        (rows("test", HERE, (2.0, 3.0), (200.0, 300.0)), ((300.0,), (3.0,))),
    ],
)
def test_a_row_has_its_own_place_as_far_as_it_is_given(table, plane):
    assert table.plane_of(table.names[-1], LOADS, VELOCITIES) == plane


def test_rows_of_two_tables_are_put_together():
    few = rows("oil", {"b": {"disk.density": 7900.0}}) * surfaces((3, 4))
    with pytest.raises(InputError, match="combinations of values, such as oil a, realization 3"):
        few.union(OILS * surfaces((2,)))
    united = (OILS * surfaces((3, 4))).union(OILS * surfaces((2,)))
    assert united.axes == {"oil": ("a", "b"), "realization": (2, 3, 4)}
    assert united.rows[0].values["disk.roughness.seed"] == 2
    assert len(united) == 6


def test_a_row_reads_what_it_replaces_alone():
    sweep = tiny.sweep(variants=rows("pin", {"a": {}, "b": {"pin.radius": 6e-3}}))
    plain, other = map(sweep.variant, sweep.variants.names)
    assert other.scene.pin.radius == 6e-3
    assert other.parts().declared.disk is plain.parts().declared.disk is sweep.parts().declared.disk
    assert [*sweep.rows[1].values] == ["pin.radius"]
