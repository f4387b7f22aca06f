"""Tables of variants: which rows they have, and where each is simulated."""

import pytest

from pipeline.sweep.model import differing_inputs
from pipeline.sweep.variants import Variants, rows, surfaces
from tests.helpers import tiny
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
    assert table.has_plane is (plane == (LOADS, VELOCITIES))


def test_what_is_not_drawn_is_given_and_each_combination_once():
    assert surfaces((3, 4)).given == {(): ()}
    assert OILS.given == dict(zip(OILS.names, OILS.parts, strict=True))
    both = OILS * surfaces((3, 4))
    assert both.given == OILS.given
    assert len(both) == 4
    a, b = OILS.names
    assert both.part(a) == (("disk.density", 7800.0),)
    assert both.part((*b, ("realization", 4))) == (("disk.density", 7900.0), ("roughness.seed", 4))
    assert both.drawn_fields == ("roughness.seed",)
    assert both.below(a).axes == {"realization": (3, 4)}
    assert OILS.below(a) == Variants()
    with pytest.raises(InputError, match=r"realization is 5, which the sweep .* it has 3, 4"):
        both.part((*a, ("realization", 5)))
    with pytest.raises(InputError, match="two tables of variants have oil; give one"):
        _ = OILS * OILS


def test_rows_of_some_labels_are_taken_and_those_of_two_tables_put_together():
    both = OILS * surfaces((3, 4))
    few = both.within({"oil": ("b",), "realization": (3, 4, 9)})
    assert few.axes == {"oil": ("b",), "realization": (3, 4)}
    assert [*few.given.values()] == [(("disk.density", 7900.0),)]
    with pytest.raises(InputError, match="combinations of values, such as oil a, realization 3"):
        few.union(OILS * surfaces((2,)))
    united = both.union(OILS * surfaces((2,)))
    assert united.axes == {"oil": ("a", "b"), "realization": (2, 3, 4)}
    assert united.parts[0] == (("disk.density", 7800.0), ("roughness.seed", 2))
    assert len(united) == 6


def test_inputs_in_which_a_sweep_differs_are_those_of_its_parts_but_for_words():
    sweep = tiny.sweep()
    other = sweep.changed(loads=(100.0,), title="Another", notes=("new",), wear=None)
    assert dict(differing_inputs(sweep, other)) == {"wear": None, "loads": (100.0,)}
    assert dict(differing_inputs(sweep, tiny.sweep())) == {}
