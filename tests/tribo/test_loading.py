import pytest
from hypothesis import given
from hypothesis import strategies as st

from tribo import InputError, Ramp

RAMP = Ramp(rate=150.0, reference_load=750.0)


def test_trunk_is_the_same_for_every_load():
    trunk = [s for s in RAMP.stations(750.0, 100) if s.on_trunk]
    for load in (200.0, 433.3, 600.0):
        stations = list(RAMP.stations(load, 100))
        assert stations[:-1] == trunk[: len(stations) - 1]
        assert stations[-1].normal_load == load
        assert stations[-1].time == load / 150.0


def test_a_load_on_a_station_is_part_of_the_trunk():
    *_, last = RAMP.stations(600.0, 100)
    assert last.on_trunk
    *_, last = RAMP.stations(200.0, 100)
    assert not last.on_trunk


@given(
    load=st.floats(1.0, 2000.0),
    increments=st.integers(1, 300),
    start=st.floats(0.0, 0.999),
)
def test_going_on_from_the_trunk_gives_the_rest_of_the_way(load, increments, start):
    whole = list(RAMP.stations(load, increments))
    assert len(whole) <= load / (750.0 / increments) + 1
    loads = [s.normal_load for s in whole]
    assert loads == sorted(set(loads))
    trunk = [s for s in whole[:-1] if s.on_trunk]
    if trunk:
        from_here = trunk[int(start * len(trunk))]
        rest = list(RAMP.stations(load, increments, after=from_here.normal_load))
        assert rest == whole[whole.index(from_here) + 1 :]


def test_rounding_makes_no_step_of_no_length():
    ramp = Ramp(rate=1.0, reference_load=0.3)
    assert [s.normal_load for s in ramp.stations(0.1 + 0.2, 3)] == pytest.approx([0.1, 0.2, 0.3])


@pytest.mark.parametrize("load", [0.0, -1.0, float("nan"), float("inf")])
def test_loads_that_are_no_loads_are_refused(load):
    with pytest.raises(InputError, match="normal_load"):
        list(RAMP.stations(load, 10))
