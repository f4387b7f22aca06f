"""Heat that stays in the bodies, held against sums and balances by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erf

import tribo

STEEL = tribo.Material(210e9, 0.3, 45.0, 7800.0, 470.0)
DIFFUSIVITY, CAPACITY = 45.0 / (7800.0 * 470.0), 7800.0 * 470.0
WIDTH, AROUND = 10e-3, 0.314
PIN = tribo.Cylinder(25e-3, WIDTH, STEEL)
TRACK = tribo.Track.from_pin(PIN, STEEL, AROUND)
ROLLING = tribo.Motion(slide_roll_ratio=0.5)  # surfaces at 1.5 and 2.5 times the sliding velocity
RISE, SHARE = 1505.0, 0.443  # at friction 1


def record(times, loads, velocity, rise=RISE, share=SHARE):
    """Variables of a point whose temperature is known only at its end."""
    times, loads = np.array(times), np.array(loads)
    late = np.full(len(times), np.nan)
    late[-1] = 1.0
    return {
        "time": times,
        "normal_load": loads,
        "sliding_distance": velocity * times,
        "mean_pressure": np.full(len(times), 1e9),
        "contact_width": np.full(len(times), 4e-4),
        "pin_heat_share": share * late,
        "mean_rise": rise * late,
    }


def added(corrections, columns):
    """Rise [K] that corrections add at the end of a point."""
    *before, last = corrections.added_rise(columns)
    assert all(np.isnan(before))
    return last


def left_by_turns(velocity, speed, share, duration, load):
    """Warming of a disc's tread [K] at the end of a ramp, as a sum over its turns."""
    age = np.arange(1, int(duration * speed / AROUND) + 1) * AROUND / speed
    heat = share * velocity * load * (1 - age / duration) / speed / WIDTH  # heat of a turn [J/m²]
    strip = erf(WIDTH / (4 * np.sqrt(DIFFUSIVITY * age)))
    return (heat * strip / (CAPACITY * np.sqrt(np.pi * DIFFUSIVITY * age))).sum()


@pytest.mark.parametrize("load", [3000.0, 8000.0])
def test_both_discs_are_warmed_by_their_own_turns(load):
    velocity, duration = 4.1, load / 500.0
    columns = record([duration / 2, duration], [load / 2, load], velocity)
    pin = left_by_turns(velocity, 1.5 * velocity, SHARE, duration, load)
    disk = left_by_turns(velocity, 2.5 * velocity, 1 - SHARE, duration, load)
    of_both = tribo.Corrections(track=TRACK, pin_track=TRACK, motion=ROLLING)
    # With the heat share of each turn instead of the last one the sum differs by less than 0.1 %.
    assert added(of_both, columns) == pytest.approx(SHARE * pin + (1 - SHARE) * disk, rel=0.01)


@pytest.mark.parametrize(("load", "kelvin"), [(3000.0, 25.6), (8000.0, 42.3)])
def test_a_disc_as_wide_as_the_contact_loses_no_heat_to_its_sides(load, kelvin):
    """Expected values: PHYSICS.md, section 14, whose sum omits the factor for a strip."""
    velocity = {3000.0: 6.6, 8000.0: 2.5}[load]
    columns = record([load / 500.0], [load], velocity, rise=1e9)
    narrow = replace(TRACK, disc=tribo.Disc(diameter=10.0, width=WIDTH))  # nearly plane rim
    of_both = tribo.Corrections(track=narrow, pin_track=narrow, motion=ROLLING)
    assert 0.06 * added(of_both, columns) == pytest.approx(kelvin, rel=0.01)
    wide = tribo.Corrections(track=TRACK, pin_track=TRACK, motion=ROLLING)
    between = replace(TRACK, disc=tribo.Disc(diameter=10.0, width=1.2 * WIDTH))
    of_some = tribo.Corrections(track=between, pin_track=between, motion=ROLLING)
    assert added(wide, columns) < added(of_some, columns) < added(of_both, columns)


def test_a_body_that_earlier_turns_have_warmed_takes_less_of_the_heat():
    """This disc's track is a fifth as long: with a heat share for each turn 39.9 K, not 50 K."""
    track = replace(TRACK, length=0.063)
    columns = record([5.0, 65.0], [2000.0] * 2, 4.1, rise=1000.0, share=0.5)
    corrections = tribo.Corrections(track=TRACK, pin_track=track, motion=ROLLING)
    assert 0.06 * added(corrections, columns) == pytest.approx(39.9, rel=0.01)


@pytest.mark.parametrize("steps", [4, 5])
def test_a_recorded_load_warms_a_track_as_its_own_loads_do(steps):
    """The point ends at the record's last load, or before it, at half of it."""
    times, loads = [0.0, 4.0, 8.0, 10.0, 20.0], [0.0, 2400.0, 600.0, 1500.0, 3000.0]
    course = tuple((time, load / 3000.0) for time, load in zip(times, loads, strict=True))
    by_loads, recorded = (
        tribo.Corrections(track=TRACK, course=record_course) for record_course in ((), course)
    )
    warming = added(by_loads, record(times[:steps], loads[:steps], 4.1))
    # Of a recorded load few steps are stored; what came before follows from the record.
    last = record(times[steps - 1 : steps], loads[steps - 1 : steps], 4.1)
    assert added(recorded, last) == pytest.approx(warming, rel=1e-12)
    assert added(by_loads, last) != pytest.approx(warming, rel=0.01)


def test_in_a_hold_each_earlier_turn_leaves_the_heat_of_the_constant_load():
    """A ramp of 1000 N in 2 s is held for 8 s; only its last step is recorded."""
    velocity, load, ramp, end = 4.1, 1000.0, 2.0, 10.0
    columns = record([end], [load], velocity)
    age = np.arange(1, int(end * velocity / AROUND) + 1) * AROUND / velocity
    loads = np.interp(end - age, [0.0, ramp], [0.0, load])
    strip = erf(WIDTH / (4 * np.sqrt(DIFFUSIVITY * age)))
    warming = loads * strip / (WIDTH * CAPACITY * np.sqrt(np.pi * DIFFUSIVITY * age))
    corrections = tribo.Corrections(track=TRACK, rate=load / ramp)
    heat = load * velocity
    pin, disk = SHARE * heat / RISE, 1 / (RISE / ((1 - SHARE) * heat) + warming.sum() / heat)
    expected = heat / (pin + disk) - RISE
    assert added(corrections, columns) == pytest.approx(expected, rel=0.01)
