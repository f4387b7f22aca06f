"""What reading a scene is made of: units, cells, rows, kinds of values, seeds and doubts."""

import math

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.quantities import display, is_unit_of_head, shown_in, si_of
from pipeline.scene.along import OperatingPoints, Place
from pipeline.scene.doubts import doubts_of_row
from pipeline.scene.facts import Span
from pipeline.scene.faults import Fault, Faults, listed_faults, numbered
from pipeline.scene.kinds import Number, OneOf, Quantity, Share, Text, UnitText, Whole
from pipeline.scene.units import (
    UnitError,
    as_entry,
    clock_time,
    difference_in_si,
    hardness_pressure,
    in_si,
    require_count,
    share_of,
    si_unit,
    to_si,
)
from pipeline.sweep.about import Measurement
from pipeline.sweep.surface import SurfaceFacts
from tests.helpers.entries import changed
from tests.pipeline.scene.test_doubts import said_of, surface
from tests.pipeline.scene.test_facts import SMOOTH
from tribo import InputError

# Units


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("600 rpm at radius 30 mm", 2 * math.pi * 10 * 0.03),
        ("600 1/min at diameter 60 mm", 2 * math.pi * 10 * 0.03),
        ("-60 U/min at radius 1 m", -2 * math.pi),
    ],
)
def test_a_rotation_is_the_velocity_of_its_track(text, value):
    assert to_si(text, like="1 m/s") == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "like", "words"),
    [
        ("7 kg", "1 kN", '"7 kg" cannot be converted to kN; its weight is 68.65 N'),
        ("500 g", "1 N", "its weight is 4.903 N"),
        ("500 rpm", "1 m/s",
         'converted to m/s; give its track, too, such as "500 rpm at radius 30 mm"'),
        ("5 mm", "1 m/s", '"5 mm" cannot be converted to m/s'),
        ("25 C", "1 K", '"25 C": C is the unit coulomb; write 25 degC'),
        ("77 F", "1 degC", '"77 F": F is the unit farad; write 77 degF'),
        ("25 C", "1 m", '"25 C" cannot be converted to m'),
        ("0.5 1", "1 m", "has no unit"),
        ("4,5 mm", "1 m", "is not a number followed by a unit; write decimals with a point, and"),
        ("1,500,000 N", "1 N", "and thousands without a mark"),
        ("4 mm3", "1 m", '"4 mm3" cannot be converted to m'),
        ("4 foo", "1 m", "has an unknown unit"),
        ("19 HRC", "1 Pa", "outside the conversion of ASTM E140 for steel, 20 to 68 HRC"),
        ("225 HB", "1 Pa", "for steel, 226 to 739 HB; give it in HV, or as a pressure"),
    ],
)  # fmt: skip
def test_what_is_no_quantity_is_told_what_it_may_be_meant_as(text, like, words):
    with pytest.raises(UnitError) as caught:
        to_si(text, like)
    assert words in str(caught.value)


def test_texts_of_any_length_are_quoted_in_part():
    with pytest.raises(UnitError) as caught:
        to_si("1" * 81, like="1 m")
    assert str(caught.value).startswith(f'"{"1" * 80}..." is not a number')
    assert to_si("1" * 78 + " m", like="1 m") == float("1" * 78)


def test_the_vickers_numbers_of_a_rockwell_scale_rise_ever_faster():
    """The indentation of HRC saturates: no step of the conversion is smaller than that before."""
    numbers = [float(hardness_pressure(number, "HRC")) / 9.80665e6 for number in range(20, 69)]
    steps = np.diff(np.round(numbers, 6))
    assert (np.diff(steps) >= 0).all()
    assert (numbers[0], numbers[-1]) == pytest.approx((238.0, 940.0))
    assert hardness_pressure(1, "HRA") is None


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("1 mm", "m"), ("62 HRC", "Pa"), ("1 kN", "N"), ("1 GPa", "Pa"), ("1 km/h", "m s-1"),
        ("1 W/(m K)", "W m-1 K-1"), ("1 kg m^2", "kg m2"), ("1 1/s", "s-1"),
        ("1 A^2 s^3/kg", "s3 A2 kg-1"),
    ],
)  # fmt: skip
def test_units_of_si_are_written_as_cf_does(text, unit):
    found = si_unit(text)
    assert sorted(found.split()) == sorted(unit.split())
    powers = ["-" in part for part in found.split()]
    assert powers == sorted(powers)  # those below the fraction last


def test_a_difference_of_temperatures_is_in_kelvin():
    assert difference_in_si("8 K", "300 K") == 8.0
    assert difference_in_si("5 mm", "1 m") == pytest.approx(5e-3)
    with pytest.raises(UnitError, match='"8 degC" is a temperature; give a difference, such as'):
        difference_in_si("8 degC", "300 K")


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (2e-3, "mm", 2.0), (3e-6, "µm", 3.0), (6.6e9, "GPa", 6.6), (0.25, "%", 25.0),
        (5e6, "MB", 5.0), (1.2e-15, "mm³/(N m)", 1.2e-6), (2e-8, "1/GPa", 20.0),
        (4e-9, "mm³", 4.0), (3e-6, "mm² K/W", 3.0), (3.6e6, "MJ/(m³ K)", 3.6),
        (32e-6, "mm²/s", 32.0), (418.15, "°C", 145.0), (7.0, "N", 7.0),
    ],
)  # fmt: skip
def test_values_are_shown_in_usual_units_and_read_back(value, unit, shown):
    assert shown_in(value, unit) == pytest.approx(shown)
    assert si_of(shown, unit) == pytest.approx(value)
    assert is_unit_of_head(unit)
    assert display(value, unit).partition(" ")[0] == f"{shown:g}"
    assert not is_unit_of_head("furlong")


def test_shares_and_counts_are_read_or_refused():
    assert [share_of(value) for value in (0.2, "10%", " 5 % ", "0.3")] == [0.2, 0.1, 0.05, 0.3]
    with pytest.raises(InputError, match='"two": give a share such as 10% or'):
        share_of("two")
    assert in_si("load", "2 kN", "600 N") == 2000.0
    assert in_si("load", 3, "600 N") == 3.0
    with pytest.raises(InputError, match=r'load: .*; give one such as "600 N"'):
        in_si("load", "2 m", "600 N")
    require_count("workers", 1)
    for value in (0, 1.5, -1):
        with pytest.raises(InputError, match=f"workers is {value}; it must be a whole number of"):
            require_count("workers", value)


# Kinds of values


def read(kind, value):
    """The value as a kind reads it, or the fault."""
    faults = Faults()
    found = kind.read(value, "key", faults)
    assert (found is None) == bool(faults)
    return found if not faults else faults[0].problem


@pytest.mark.parametrize(
    ("kind", "fits", "unfit", "words"),
    [
        (Number(), [0.0, 1e-15, -1e15, 2], [9e-16, 1.1e15], "a number without a unit"),
        (Number(above=0, at_most=2), [1e-15, 2], [0, 2.1],
         "a number without a unit, above 0 and at most 2"),
        (Number(at_least=1, below=3), [1, 2.9], [0.9, 3], "at least 1 and below 3"),
        (Whole(), [0, 1, -1, 2**63 - 1], [2**63, 1.0], "a whole number"),
        (Share(above=0, below=1), [0.5, "50%", "0.5"], [1, "100%", 0], 'a share such as 0.1 or'),
        (OneOf(("mild", "severe")), ["mild"], ["mid", 1], '"mild" or "severe"'),
        (OneOf(("a", "b", "c")), ["c"], ["d"], '"a", "b" or "c"'),
        (Text(), ["a"], ["", 1, "a\\0"], "text in quotes"),
        (Quantity("5 mm"), ["5 mm", "1e-12 m", "1e5 m"],
         ["0 mm", "-1 mm", "9e-13 m", "1.1e5 m", 5], 'a length above 0, such as "5 mm"'),
        (Quantity("5 s", zero=True), ["0 s", "1e12 s"], ["-1 s", "1.1e12 s"],
         'a duration of at least 0, such as "5 s"'),
        (Quantity("5 m/s", ends=("1 m/s", "2 m/s"), name="a speed"), ["1 m/s", "2 m/s"],
         ["0.99 m/s", "2.01 m/s"], "a speed above 0"),
        (UnitText("a unit of length", "mm"), ["um", "m"], ["kg", "x"],
         'a unit of length, such as "mm"'),
    ],
)  # fmt: skip
def test_each_kind_reads_what_fits_and_says_what_does_not(kind, fits, unfit, words):
    for value in fits:
        assert not isinstance(read(kind, value), str) or isinstance(kind, Text | OneOf)
    for value in (one.replace("\\0", "\0") if isinstance(one, str) else one for one in unfit):
        assert words in read(kind, value)
    assert words in str(kind)


def test_true_is_no_number():
    assert "true is not a plain number" in read(Number(), value=True)
    assert "true is not a whole number" in read(Whole(), value=True)
    assert "which is from 1e-15 to 1e+15" in read(Number(), 1e16)
    assert "which is from 1e-12 m to 1e5 m" in read(Quantity("5 mm"), "1e6 m")


# Headings and cells


@pytest.mark.parametrize(
    ("cell", "unit", "entry"),
    [("3", "", 3), ("3.5", "", 3.5), ("3", "mm", "3 mm"), ("3 mm", "", "3 mm"), ("abc", "", "abc")],
)
def test_a_cell_is_a_number_or_a_text_with_its_unit(cell, unit, entry):
    assert as_entry(cell, unit) == entry
    assert type(as_entry(cell, unit)) is type(entry)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ([7], "row 7"),
        ([2, 3], "rows 2 and 3"),
        ([2, 3, 5], "rows 2, 3 and 5"),
        ([1, 2, 3, 4, 5, 6], "rows 1, 2, 3, 4, 5 and 6"),
        ([1, 2, 3, 4, 5, 6, 7], "rows 1, 2, 3, 4, 5, 6 and 1 more"),
        ([*range(1, 11)], "rows 1, 2, 3, 4, 5, 6 and 4 more"),
    ],
)
def test_rows_are_counted_in_words(numbers, words):
    assert numbered(numbers) == words


def test_faults_of_one_kind_are_one_line():
    cells = [
        (2, "load", '"a" has no unit'), (3, "load", '"b" has no unit'),
        (3, "velocity", '"b" has no unit'), (9, "load", "is empty"),
    ]  # fmt: skip
    faults = [Fault(name, problem, row=row) for row, name, problem in cells]
    assert listed_faults(faults) == [
        'rows 2 and 3, load: "a" has no unit',
        'row 3, velocity: "b" has no unit',
        "row 9, load: is empty",
    ]


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("10:00:00", 36000), ("04.05.2026 10:00:00,5", 36000.5), ("2026-05-04T10:01", 36060),
        ("1:30 PM", 48600), ("12:15:00 am", 900), ("23:59:59.5", 86399.5),
    ],
)  # fmt: skip
def test_a_clock_is_a_time_of_the_day(text, seconds):
    assert clock_time(text) == seconds
    with pytest.raises(UnitError, match="is no time of a clock"):
        clock_time(text.replace(":", "-"))


def test_columns_are_rows_of_places_with_what_else_they_give():
    columns = {
        "load": [400.0, 600.0], "velocity [m/min]": [60, 120], "friction": [0.1, 0.12],
        "gear": ["a", None], "critical temperature": ["145 degC", "150 degC"],
    }  # fmt: skip
    points = OperatingPoints.read(columns)
    assert points.places == (Place(400.0, 1.0), Place(600.0, 2.0))
    assert [own["friction"] for own in points.conditions] == [0.1, 0.12]
    assert [own["critical_temperature"] for own in points.conditions] == pytest.approx(
        [418.15, 423.15]
    )
    assert points.others["gear"] == ["a", None]
    assert [place for place, _ in points.rows] == [*points.places]


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ([1.0], "points are of type list; give a .csv or .xlsx file, or columns"),
        ({"load": [1.0, 2.0], "velocity": [1.0]},
         "points: columns of unlike lengths: load 2, velocity 1; give one of each in a row"),
    ],
)  # fmt: skip
def test_columns_that_make_no_rows_are_refused(columns, words):
    with pytest.raises(InputError, match=words):
        OperatingPoints.read(columns)


@pytest.mark.parametrize("name", ["pin.radius", "fidelity.increments", "wear.pattern", "hold"])
def test_columns_that_need_a_simulation_are_refused(name):
    columns = {"load": [400.0], "velocity": [1.0]}
    with pytest.raises(InputError, match=f'column "{name}" cannot act after the simulation'):
        OperatingPoints.read(columns | {name: ["1"]})
    for entry, cell in (("friction.coefficient", "0.1"), ("temperature.bulk", "300 K")):
        assert OperatingPoints.read(columns | {entry: [cell]}).places == (Place(400.0, 1.0),)


@pytest.mark.parametrize(
    ("name", "cell"),
    [("friction.same_rig", "0"), ("friction.band", "0.2"), ("temperature.bulk.pin", "300 K")],
)
def test_an_entry_beside_a_condition_is_not_taken_for_it(name, cell):
    with pytest.raises(InputError, match=f'column "{name}" cannot act after the sim'):
        OperatingPoints.read({"load": [400.0], "velocity": [1.0], name: [cell]})


# Seeds


def seeds(wanted, **entries):
    scene = pipeline.load_scene("first_try", overrides={"sweep.realizations": wanted} | entries)
    names = [dict(name)["realization"] for name in scene.variants.names]
    return names, scene.scene.roughness.seed


def test_realizations_begin_at_the_seed_of_the_scene_or_are_those_given():
    assert seeds(3, **{"disk.roughness.seed": 5}) == ([5, 6, 7], 5)
    assert seeds(2, without=["disk.roughness.seed"]) == ([0, 1], 0)
    assert seeds([9, 4], **{"disk.roughness.seed": 5}) == ([4, 9], 4)
    with pytest.raises(pipeline.SceneFileError, match=r"2 needs a .disk.roughness. that is made"):
        seeds(2, without=["disk.roughness"])


def test_the_rate_of_wear_and_the_pressure_coefficient_may_be_pairs():
    oil = {"oil": {"temperatures": ["40 degC", "100 degC"], "density": "900 kg/m^3",
                   "kinematic_viscosity": ["32 mm^2/s", "5 mm^2/s"],
                   "pressure_viscosity_coefficient": "20 1/GPa"}}  # fmt: skip
    one = pipeline.load_scene("first_try", overrides=oil).about.oil
    assert one.pressure_coefficients == pytest.approx((2e-8, 2e-8))
    oil["oil"]["pressure_viscosity_coefficient"] = ["20 1/GPa", "15 1/GPa"]
    two = pipeline.load_scene("first_try", overrides=oil).about.oil
    assert two.pressure_coefficients == pytest.approx((2e-8, 1.5e-8))
    del oil["oil"]["kinematic_viscosity"], oil["oil"]["density"]
    oil["oil"]["dynamic_viscosity"] = ["30 mPa s", "4 mPa s"]
    oil["without"] = ["oil"]
    thin = pipeline.load_scene("first_try", overrides=oil).about.oil
    assert thin.viscosity(313.15) == pytest.approx(0.03)
    assert thin.viscosity(373.15) == pytest.approx(0.004)


# Doubts


@pytest.mark.parametrize(
    ("rise", "axes"),
    [((0.79e-6, -0.79e-6), []), ((0.81e-6, 0.0), ["x"]), ((0.0, -0.81e-6), ["y"])],
)
def test_a_surface_that_rises_by_more_than_twice_its_roughness_is_tilted(rise, axes):
    said = [doubt for doubt in said_of(SMOOTH, surface=surface(rise=rise)) if "tilted" in doubt]
    assert len(said) == len(axes)
    for axis, doubt in zip(axes, said, strict=True):
        assert f"µm along {axis} over the window, beside an Rq of 0.4 µm" in doubt
    random = SurfaceFacts(False, 0.3e-6, 0.4e-6, rise=(1.0, 1.0))
    assert not any("tilted" in doubt for doubt in said_of(SMOOTH, surface=random))


@pytest.mark.parametrize(
    ("lay", "measured", "pattern", "said"),
    [
        (30.0, True, "swept", ["pattern", "transpose"]),
        (30.1, True, "swept", []),
        (0.0, True, "local", ["transpose"]),
        (0.0, False, "swept", ["pattern"]),
        (0.0, False, None, []),
        (None, True, "swept", []),
    ],
)
def test_grooves_along_sliding_are_doubted(lay, measured, pattern, said):
    scene = changed(SMOOTH, wear=tribo.Wear(1.2e-15, pattern) if pattern else None)
    found = said_of(scene, surface=surface(lay=lay, measured=measured))
    words = {"pattern": "the grooves lie along sliding, and pattern", "transpose": "with transpose"}
    assert [name for name, text in words.items() if any(text in one for one in found)] == said


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ({"friction": 1.0}, []),
        ({"friction": 10.0}, ["friction is 10, where 0 to 1 is usual: is it in per cent?"]),
        ({"friction": None, "bulk_temperature": None}, []),
        ({"bulk_temperature": 223.15}, []),
        ({"bulk_temperature": 523.15}, []),
        ({"bulk_temperature": 523.25},
         ["the bulk temperature is 250.1 °C, where -50 °C to 250 °C are usual: check its unit"]),
        ({"bulk_temperature": 80.0, "friction": 2.0}, ["friction is 2", "-193.15 °C"]),
    ],
)  # fmt: skip
def test_conditions_of_a_row_are_doubted_beyond_the_usual(row, words):
    said = [*doubts_of_row(row)]
    assert len(said) == len(words)
    assert all(text in one for text, one in zip(words, said, strict=True))


def test_tests_far_outside_are_counted_and_those_in_other_units_named():
    far = [Measurement(load, 2.0) for load in (1.0, 2.0, 3.0)]
    sweep = changed(SMOOTH, loads=(200.0, 750.0), velocities=(1.0, 4.0), measured=tuple(far[:1]))
    one, several = (
        [d for d in said_of(s) if "far outside the sweep" in d]
        for s in (sweep, changed(sweep, measured=tuple(far)))
    )
    assert one[0].startswith(
        "the test of 1 N at 2 m/s lies far outside the sweep, 200 to 750 N and 1 to 4 m/s, and"
    )
    assert several[0].startswith("the test of 1 N at 2 m/s and 2 more lie far outside the sweep")
    fast = changed(sweep, measured=(Measurement(300.0, 40.1), Measurement(300.0, 40.0)))
    assert sum("test of 300 N at 40.1" in d for d in said_of(fast)) == 1
    slow = changed(sweep, measured=(Measurement(300.0, 0.1), Measurement(7500.0, 1.0)))
    assert not any("far outside" in d for d in said_of(slow))


@pytest.mark.parametrize(("duration", "is_usual"), [(0.051, 1), (0.049, 0), (9.9e5, 1), (1.1e6, 0)])
def test_a_test_of_unusual_duration_is_doubted(duration, is_usual):
    said = said_of(SMOOTH, duration=Span(duration / 2, duration))
    assert sum("time until the end" in doubt for doubt in said) == 1 - is_usual
