"""Points chosen of a sweep take a bit for each place, and come back as they were."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.store.variables import chosen_of
from pipeline.sweep.chosen import Chosen
from pipeline.sweep.model import Point

LOADS, VELOCITIES, COUNT = (200.0, 400.0, 750.0), (0.6, 1.5, 2.5, 6.0), 9
SAMPLES = [(None, number) for number in range(COUNT)]
SOME = st.sets(
    st.builds(
        Point,
        st.sampled_from(LOADS),
        st.sampled_from(VELOCITIES),
        st.none(),
        st.integers(0, COUNT - 1),
    )
)


def order(point):
    return point.sample, point.velocity, point.load


@given(SOME)
def test_points_come_back_in_order(points):
    chosen = Chosen.of(points)
    assert list(chosen) == sorted(points, key=order)
    assert len(chosen) == len(points)
    assert chosen == Chosen.of(sorted(points)) == pickle.loads(pickle.dumps(chosen))
    assert all(point in chosen for point in points)
    assert Point(300.0, 1.5, None, 0) not in chosen


@given(SOME)
def test_text_and_list_of_a_store_say_the_same(points):
    text = Chosen.of(points).packed(SAMPLES, LOADS, VELOCITIES)
    packed = {"loads": LOADS, "velocities": VELOCITIES, "samples": COUNT, "chosen": text}
    listed = {"chosen": [list(point) for point in points]}
    for attributes in (packed, listed):
        assert set(chosen_of(attributes)) == points


def test_what_is_along_other_axes_alone_is_not_chosen():
    chosen = Chosen.of([Point(200.0, 1.5, None, 3)])
    found = chosen.over(SAMPLES[2:5], LOADS[::-1], (1.5, 1.6))
    assert np.argwhere(found).tolist() == [[1, 2, 0]]


@pytest.mark.parametrize("count", [1000, 10000])
def test_a_point_takes_few_bits(count):
    points = [Point(load, V, None, n) for n in range(count) for load in LOADS for V in VELOCITIES]
    chosen = Chosen.of(points[::3])
    samples = [(None, number) for number in range(count)]
    assert len(chosen.bits) <= count * 12 / 8 + 1
    assert len(chosen.packed(samples, LOADS, VELOCITIES)) < len(chosen)
