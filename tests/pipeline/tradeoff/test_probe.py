"""Where a probe looks for the boundary, and on which elements."""

import math
from dataclasses import replace

import pytest

from pipeline.tradeoff.probe import (
    Target,
    critical_velocity,
    fitted,
    near_the_boundary,
    some_places,
)
from tests.helpers import tiny
from tribo import Fidelity, InputError

SWEEP = tiny.sweep(velocities=(-2.0, 0.0, 0.5, 8.0))


@pytest.mark.parametrize(
    ("shape", "asked", "taken"),
    [((90, 60), 4, 3), ((90, 60), 3, 3), ((90, 64), 4, 2), ((91, 64), 4, 1), ((64, 90), 4, 2)],
)
def test_elements_divide_the_pixels_along_both_axes(shape, asked, taken):
    sweep = SWEEP.changed(pixels=replace(SWEEP.scene.pixels, shape=shape))
    fidelity = fitted(sweep, Fidelity(pixels_per_element=asked, heat_kernel="endless"))
    assert (fidelity.pixels_per_element, fidelity.heat_kernel) == (taken, "pin")


@pytest.mark.parametrize(
    ("number", "chosen"), [(1, (0,)), (2, (0, 4)), (3, (0, 2, 4)), (4, (0, 1, 3, 4)), (9, range(5))]
)
def test_loads_are_some_of_the_sweep_s_with_both_ends(number, chosen):
    sweep = SWEEP.changed(loads=(200.0, 300.0, 400.0, 500.0, 600.0))
    assert [place.load for place in some_places(sweep, number)] == [
        sweep.plane.loads[k] for k in chosen
    ]


def test_without_a_velocity_there_is_no_boundary():
    with pytest.raises(InputError, match="no velocity but 0"):
        near_the_boundary(SWEEP.changed(velocities=(0.0,)), [Target(300.0)])


@pytest.mark.parametrize("exponent", [0.05, 1.0, 8.0])
@pytest.mark.parametrize("root", [0.11, 3.0, 9.5])
def test_a_crossing_of_any_power_is_found_within_its_tolerance(exponent, root):
    asked = []

    def rise(velocity):
        asked.append(velocity)
        return 200.0 * (velocity / root) ** exponent

    critical = critical_velocity(rise, 200.0, 0.1, 10.0)
    assert abs(exponent * math.log(critical / root)) <= 0.01
    assert len(asked) <= 20
    assert len(set(asked)) == len(asked)
    assert all(0.1 * (1 - 1e-9) <= v <= 10.0 * (1 + 1e-9) for v in asked)


def test_a_crossing_is_enclosed_where_the_rise_jumps():
    asked = []

    def rise(velocity):
        asked.append(velocity)
        return 100.0 if velocity < 0.7 else 300.0

    assert critical_velocity(rise, 200.0, 0.1, 10.0) == pytest.approx(0.7, rel=1e-4)
    assert len(set(asked)) == len(asked)


def test_without_a_limit_the_middle_is_taken():
    assert critical_velocity(lambda v: math.nan, math.inf, 0.1, 10.0) == pytest.approx(1.0)
