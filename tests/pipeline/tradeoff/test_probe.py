"""Where a probe looks for the boundary, and on which elements."""

import math
from dataclasses import replace

import pytest

from pipeline.sweep.model import Point
from pipeline.tradeoff.probe import (
    Target,
    critical_velocity,
    dividing_pixels,
    near_the_boundary,
    probe,
    some_places,
    velocity_errors,
)
from tests.helpers import tiny
from tests.helpers.entries import changed
from tribo import PRESETS, Fidelity

SWEEP = tiny.sweep(velocities=(-2.0, 0.0, 0.5, 8.0))
STANDARD = dividing_pixels(SWEEP, PRESETS["standard"])


@pytest.mark.parametrize(
    ("shape", "asked", "taken"),
    [((90, 60), 4, 3), ((90, 60), 3, 3), ((90, 64), 4, 2), ((91, 64), 4, 1), ((64, 90), 4, 2)],
)
def test_elements_divide_the_pixels_along_both_axes(shape, asked, taken):
    sweep = changed(SWEEP, pixels=replace(SWEEP.scene.pixels, shape=shape))
    fidelity = dividing_pixels(sweep, Fidelity(pixels_per_element=asked))
    assert fidelity.pixels_per_element == taken


@pytest.mark.parametrize(("number", "chosen"), [(1, (0,)), (4, (0, 1, 3, 4)), (9, range(5))])
def test_loads_are_some_of_the_sweep_s_with_both_ends(number, chosen):
    sweep = changed(SWEEP, loads=(200.0, 300.0, 400.0, 500.0, 600.0))
    assert [place.load for place in some_places(sweep, number)] == [
        sweep.plane.loads[k] for k in chosen
    ]


@pytest.mark.parametrize(("exponent", "root"), [(0.05, 3.0), (1.0, 0.11), (8.0, 9.5)])
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


def test_a_jump_is_enclosed():
    jump = critical_velocity(lambda v: 100.0 if v < 0.7 else 300.0, 200.0, 0.1, 10.0)
    assert jump == pytest.approx(0.7, rel=1e-4)


def test_errors_of_the_rise_are_made_those_of_the_velocity_by_its_exponent_there():
    (point,), (exponent,) = near_the_boundary(SWEEP, [Target(300.0)])
    places = [Point(300.0, factor * point.velocity) for factor in (0.95, 1.0, 1.05)]
    below, here, above = (r.rise for r in probe(SWEEP, STANDARD, places).readings)
    assert here == pytest.approx(1200.0, rel=0.01)
    assert exponent == pytest.approx(math.log(above / below) / math.log(1.05 / 0.95), rel=0.02)
    coarse, exact = (probe(SWEEP, PRESETS[name], [point]).readings for name in ("draft", "fine"))
    (error,) = velocity_errors(coarse, exact, [exponent])
    assert error == pytest.approx((exact[0].rise / coarse[0].rise) ** (1 / exponent) - 1)
