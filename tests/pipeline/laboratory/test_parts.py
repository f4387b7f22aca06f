"""What the laboratory's readers say: scans, traces, words of outcomes, headings and tilts."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pipeline.laboratory.headings import heading_of, is_named, may_be
from pipeline.laboratory.logs import Trace, outcome_of, read_log, read_trace
from pipeline.laboratory.scan import SurfaceStatistics
from pipeline.laboratory.surfaces import axis_note, levelled, tilt_doubts, tilts
from pipeline.scene.headings import Heading
from tribo.surface import AutocorrelationLengths, SelfAffineFit

# A scan


def scan(fit=None, lengths=None, **values):
    """Statistics of a scan without any doubt, but for these values."""
    fitted = {
        "correlation_length": (4e-6, 4.4e-6), "hurst_exponent": 0.8123, "lay": 3.0,
        "rms_error": 0.031, "length_error": (0.2e-6, 0.3e-6), "hurst_error": 0.02,
        "lay_error": 4.0, "misfit": 1.5,
    }  # fmt: skip
    found = {"along_x": 5e-6, "along_y": 6e-6, "shortest": 4.5e-6, "longest": 6.5e-6,
             "direction": 88.0}  # fmt: skip
    usual = {
        "file": "scan.npy", "shape": (200, 100), "pixel_size": (0.8e-6, 0.9e-6), "missing": 0,
        "ra": 0.27e-6, "rq": 0.338e-6, "skewness": 0.1, "kurtosis": 3.1, "tilt": (1.0, -2.0),
        "fit": SelfAffineFit(**fitted | (fit or {})),
        "lengths": AutocorrelationLengths(**found | (lengths or {})),
        "axis": "x is along the columns",
    }  # fmt: skip
    return SurfaceStatistics(**usual | values)


def test_a_scan_says_a_line_for_each_quantity():
    lines = [*scan().lines()]
    assert lines[0] == "scan.npy: 200 × 100 heights, 160 × 90 µm, pixels 0.8 × 0.9 µm"
    assert lines[1] == "  x is along the columns"
    said = {line[2:22].strip(): line[22:] for line in lines[2:]}
    assert said == {
        "Ra": "0.27 µm  ± 3.1 % from surface to surface of this size",
        "Rq": "0.338 µm",
        "skewness, kurtosis": "0.1, 3.1",
        "tilt": "1° along x, -2° along y, taken off",
        "lay": "none",
        "1/e lengths": "5 µm along x, 6 µm along y, of the autocorrelation",
        "Sal, Str": "4.5 µm, 0.69 (ISO 25178, at 1/e for its usual 0.2)",
        "correlation length": "4 ± 0.2 µm along x, 4.4 ± 0.3 µm along y, of the fitted spectrum",
        "Hurst exponent": "0.812 ± 0.02",
        "spectrum": "within a factor 1.5 of that of the fit",
    }
    assert str(scan()) == "\n".join(lines)
    long = {"along_y": math.inf, "longest": math.inf}
    said = {line[2:22].strip(): line[22:] for line in scan(lengths=long).lines()}
    assert said["1/e lengths"].startswith("5 µm along x, over half the scan along y")


def test_a_scan_that_no_random_surface_is_like_has_no_length_of_a_fit():
    unlike = scan(fit={"misfit": 5.1})
    said = {line[2:22].strip(): line[22:] for line in unlike.lines()}
    assert said["Ra"] == "0.27 µm"
    assert said["spectrum"] == (
        "not self-affine: the best fit is off by a factor 5.1; so it gives no length and no Hurst "
        "exponent"
    )
    assert "correlation length" not in said
    assert not unlike.is_self_affine
    assert unlike.as_dict()["fit"] is unlike.as_dict()["toml"] is None
    assert scan(fit={"misfit": 5.0}).is_self_affine
    wide = scan(fit={"length_error": (4.1e-6, 0.1e-6)})
    assert wide.fault_of_fit.startswith("too few heights, or too coarse pixels")
    assert scan(fit={"length_error": (4e-6, 0.1e-6)}).fault_of_fit == ""


@pytest.mark.parametrize(
    ("fit", "has_lay"),
    [
        ({"correlation_length": (4e-6, 4.4e-6)}, False),
        # ln 2 beside three standard errors of 0.0707 and 0.2 together.
        ({"correlation_length": (4e-6, 8e-6), "length_error": (0.2e-6, 0.4e-6)}, True),
        ({"correlation_length": (8e-6, 4e-6), "length_error": (0.4e-6, 0.2e-6)}, True),
        ({"correlation_length": (4e-6, 8e-6), "length_error": (0.6e-6, 1.0e-6)}, True),  # 0.195
        ({"correlation_length": (4e-6, 8e-6), "length_error": (0.8e-6, 1.0e-6)}, False),
    ],
)
def test_a_lay_is_a_difference_of_lengths_beyond_their_errors(fit, has_lay):
    here = scan(fit=fit | {"lay": 89.0})
    assert here.has_lay is has_lay
    said = {line[2:22].strip(): line[22:] for line in here.lines()}
    assert said["lay"] == ("89° from x ± 4°" if has_lay else "none")
    x, y = (f'"{1e6 * length:.3g} um"' for length in fit["correlation_length"])
    mean = f'"{1e6 * math.sqrt(math.prod(fit["correlation_length"])):.3g} um"'
    assert here.toml == (
        '[disk.roughness]\nra = "0.27 um"\nhurst_exponent = 0.812\n'
        f"correlation_length = {f'[{x}, {y}]' if has_lay else mean}\n"
    )


@pytest.mark.parametrize(("shortest", "has_lay"), [(3.24e-6, True), (3.26e-6, False)])
def test_without_a_fit_the_autocorrelation_tells_of_a_lay(shortest, has_lay):
    here = scan(fit={"misfit": 9.0}, lengths={"shortest": shortest})
    assert here.has_lay is has_lay
    said = {line[2:22].strip(): line[22:] for line in here.lines()}
    assert said["lay"] == ("88° from x" if has_lay else "none")


ROUGH = {"correlation_length": (4e-6, 8e-6), "length_error": (0.1e-6, 0.1e-6)}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, None),
        ({"rq": 0.9e-10}, "Rq is 9e-05 µm: check the unit of the heights"),
        ({"rq": 1.02e-10}, None),
        ({"rq": 1.02e-4}, "check the unit of the heights"),
        ({"pixel_size": (0.98e-9, 1e-8), "shape": (10**6, 10**5)}, "check the size of the pixels"),
        ({"pixel_size": (1.02e-9, 1e-8), "shape": (10**6, 10**5)}, None),
        ({"pixel_size": (1.02e-3, 1e-6)}, "check the size of the pixels"),
        ({"lengths": {"shortest": 0.79e-6}}, "hardly depend on each other: noise, or too coarse"),
        ({"lengths": {"shortest": 0.8e-6}}, None),
        ({"tilt": (20.1, 0.0)}, "the scan is tilted by 20.1°"),
        ({"missing": 300}, "300 heights (1.5 %) are missing and were filled"),
        ({"skewness": 0.51}, "skewness 0.51: a random surface has 0; simulate the scan itself"),
        ({"skewness": -0.51}, "skewness -0.51"),
        ({"skewness": 0.5}, None),
        ({"fit": ROUGH | {"lay": 30.0}}, "the lay runs at 30° from x, and [disk.roughness] has"),
        ({"fit": ROUGH | {"lay": 12.0}}, None),  # within three errors of 4°
        ({"fit": ROUGH | {"lay": 13.0}}, "the lay runs at 13° from x"),
        ({"fit": ROUGH | {"lay": 10.2, "lay_error": 1.0}}, "the lay runs at 10° from x"),
        ({"fit": ROUGH | {"lay": 78.0, "lay_error": 1.0}}, "the lay runs at 78° from x"),
        ({"fit": ROUGH | {"lay": 81.0, "lay_error": 1.0}}, None),
        ({"fit": {"lay": 45.0}}, None),  # there is none
        ({"lengths": {"along_x": 16.1e-6}}, "the scan is 9.9 1/e lengths long along x: measure a"),
        ({"lengths": {"along_y": 9.1e-6}}, "the scan is 9.9 1/e lengths long along y"),
        ({"lengths": {"along_y": 8.9e-6}}, None),
        ({"lengths": {"along_x": math.inf}}, "the scan is under 2 1/e lengths long along x"),
        ({"fit": {"misfit": 2.1}}, "the fitted spectrum is off by a factor 2.1 at some"),
        ({"fit": {"misfit": 2.0}}, None),
        ({"notes": ("a note",)}, "a note"),
    ],
)
def test_a_scan_is_doubted_beyond_what_is_usual(values, words):
    found = scan(**values).warnings
    assert len(found) == (words is not None)
    assert words is None or words in found[0]


def test_planes_that_are_taken_off_have_their_angles():
    i, j = np.indices((20, 30))
    rough = np.random.default_rng(0).normal(size=(20, 30)) * 1e-8
    sides = 2e-6, 3e-6
    heights = (
        rough + np.tan(np.radians(5.0)) * i * sides[0] - np.tan(np.radians(2.0)) * j * sides[1]
    )
    level = levelled(heights)
    assert tilts(heights, level, sides) == pytest.approx((5.0, -2.0), abs=0.1)
    assert level.mean() == pytest.approx(0.0, abs=1e-15)
    assert (level * i).sum() == pytest.approx(0.0, abs=1e-12)
    assert (level * j).sum() == pytest.approx(0.0, abs=1e-12)
    assert tilt_doubts((20.0, -20.0)) == ()
    (doubt,) = tilt_doubts((3.0, -20.5))
    assert doubt.startswith("the scan is tilted by 20.5°: check the unit of the heights and the si")
    assert axis_note(False).startswith(
        "x, the sliding direction, is along the columns of the file:"
    )
    assert axis_note(True).endswith("from row to row, or the y that it names")


# A trace of friction


def trace(friction, **columns):
    friction = np.array(friction, float)
    time = np.arange(len(friction)) / 2
    return Trace(time, friction, **{k: np.array(v, float) for k, v in columns.items()})


def test_a_rise_of_friction_is_where_both_parts_are_most_even():
    rises = trace([0.1] * 30 + [0.2] * 10, load=np.arange(40) * 10)
    assert rises.row == 30
    assert [*rises.lines()] == [
        "transition: friction rises from 0.1 to 0.2 at 15 s, at a load of 300 N; confirm it in the "
        "trace and on the surface"
    ]
    assert [*rises.toml()] == [
        "[[measured]]",
        'load = "300 N"',
        'velocity = "... m/s"  # not in the trace',
        "friction = 0.1",
    ]
    assert ", at a load of" not in next(trace([0.1] * 30 + [0.2] * 10).lines())


@pytest.mark.parametrize(
    ("friction", "row"),
    [
        ([0.1] * 20 + [0.1201] * 20, 20),  # a fifth more
        ([0.1] * 20 + [0.1199] * 20, None),
        ([0.2] * 20 + [0.1] * 20, None),  # it falls
        ([0.1] * 9 + [0.2] * 10, None),  # too few rows
        ([0.1] * 10 + [0.2] * 10, 10),
        # Beside a scatter of 1.4826 · 0.02 = 0.03 a step of 0.1 is scatter.
        ([0.08, 0.12] * 10 + [0.2] * 20, None),
        ([0.08, 0.12] * 10 + [0.217] * 20, None),
        ([0.08, 0.12] * 10 + [0.22] * 20, 20),
    ],
)
def test_a_rise_is_more_than_a_fifth_and_than_the_scatter_before(friction, row):
    assert trace(friction).row == row


@pytest.mark.parametrize("seed", range(3))
def test_a_rise_between_scattered_values_leaves_the_least_squares(seed):
    chance = np.random.default_rng(seed)
    friction = np.where(np.arange(60) < 20 + 10 * seed, 0.1, 0.18) + chance.normal(0, 0.015, 60)
    left = [np.var(friction[:k]) * k + np.var(friction[k:]) * (60 - k) for k in range(1, 60)]
    assert trace(friction).row == 1 + int(np.argmin(left))


def test_a_trace_without_a_rise_is_a_mild_test():
    flat = trace([0.1] * 40, load=[500.0] * 40, velocity=[2.0] * 40)
    assert [*flat.lines()] == ["no transition: friction stays about 0.1 for 19.5 s"]
    assert [*flat.toml()] == [
        "[[tested]]", 'load = "500 N"', 'velocity = "2 m/s"', "friction = 0.1", 'outcome = "mild"'
    ]  # fmt: skip


STEPS = [0.0] * 5 + [100.0] * 10 + [200.0] * 10 + [300.0] * 15


@pytest.mark.parametrize(
    ("friction", "stages"),
    [
        ([0.1] * 25 + [0.2] * 15, ['mild_up_to = "200 N"', 'severe_at = "300 N"']),
        ([0.1] * 40, ['mild_up_to = "300 N"']),
        ([0.1] * 15 + [0.2] * 25, ['mild_up_to = "100 N"', 'severe_at = "200 N"']),
    ],
)
def test_steps_of_the_load_are_a_run(friction, stages):
    stepped = trace(friction, load=STEPS, velocity=[2.0] * 40)
    assert [*stepped.toml()] == ["[[tested]]", *stages, 'velocity = "2 m/s"', "friction = 0.1"]
    speeds = trace(friction, load=[500.0] * 40, velocity=np.array(STEPS) / 100)
    found = [*speeds.toml()]
    assert found[-2:] == ['load = "500 N"', "friction = 0.1"]
    assert found[1 : 1 + len(stages)] == [
        line.replace("00 N", " m/s") for line in stages
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("load", "is_stepped"),
    [
        (STEPS, True),
        ([100.0] * 20 + [101.0] * 20, False),  # within 2 % of the highest
        ([100.0] * 20 + [103.0] * 20, True),
        ([100.0] * 36 + [200.0] * 4, False),  # too few rows of a step
        ([100.0] * 35 + [200.0] * 5, True),
        ([0.0] * 20 + [100.0] * 20, False),  # rest is no step
        (np.linspace(0.0, 400.0, 40), False),
        ([100.0] * 20 + [math.nan] * 20, False),
        ([0.0] * 10 + [100.0] * 15 + [101.0] * 15, False),
        ([1.9] * 20 + [100.0] * 20, False),  # a load cell's rest
        ([2.1] * 20 + [100.0] * 20, True),
    ],
)
def test_steps_are_apart_and_last(load, is_stepped):
    name, steps = trace([0.1] * 40, load=load).stepped
    assert (steps is not None) == is_stepped
    assert name == ("load" if is_stepped else "velocity")


def test_a_trace_in_other_units_has_its_magnitudes(tmp_path):
    path = tmp_path / "trace.csv"
    rows = "".join(f"{k / 60},{(-1) ** k * 0.1},0.5\n" for k in range(30))
    path.write_text(f"time [min],friction,load [kN]\n{rows},,\n")
    read = read_trace(path)
    assert read.time[-1] == pytest.approx(29.0)
    assert set(read.friction) == {0.1}
    assert set(read.load) == {500.0}
    assert len(read.time) == 30
    for count in (20, 19):
        lines = rows.splitlines(True)[:count]
        path.write_text("time [min],friction,load [kN]\n" + "".join(lines) + ",,\n" * 5)
        assert (read_trace(path) is None) == (count == 19)
    rows = "".join(f"{k},0.1,60,500\n" for k in range(20))
    path.write_text(f"time [s],COF,friction force [N],load [N]\n{rows}")
    assert set(read_trace(path).friction) == {0.1}  # as it was recorded
    path.write_text(f"time [s],x,friction force [N],load [N]\n{rows}")
    assert set(read_trace(path).friction) == {0.12}


# Words


@pytest.mark.parametrize(
    ("word", "heading", "outcome"),
    [
        ("ok", "result", "mild"), ("i.O.", "Befund", "mild"), ("Fresser", "Befund", "severe"),
        ("kein Fresser", "Befund", "mild"), ("n.i.O.", "Befund", "severe"),
        ("verschweißt", "Befund", "severe"), ("not passed", "result", "severe"),
        ("yes", "scuffed", "severe"), ("no", "scuffed", "mild"), ("ja", "gefressen", "severe"),
        ("yes", "passed", "mild"), ("no", "bestanden", "severe"), ("1", "severe", "severe"),
        ("yes", "result", None), ("not 1", "scuffed", None), ("perhaps", "scuffed", None),
        ("non-seizure", "remarks", "mild"), ("ohne Fresser", "Befund", "mild"),
    ],
)  # fmt: skip
def test_words_mean_an_outcome_by_their_heading(word, heading, outcome):
    assert outcome_of(word, heading) == outcome


@pytest.mark.parametrize(
    ("text", "title", "unit"),
    [
        ("Load (kN)", "Load", "kN"), ("Last in kN", "Last", "kN"), ("F_N / N", "F_N", "N"),
        ("v [m/s]", "v [m/s]", ""), ("time_s", "time", "s"), ("v/(m/s)", "v", "m/s"),
        ("speed, rpm", "speed", "rpm"), ("Load", "Load", ""), ("result (see below)",
         "result (see below)", ""), ("friction (-)", "friction", ""),
    ],
)  # fmt: skip
def test_units_stand_after_a_title_in_several_ways(text, title, unit):
    heading = heading_of(text)
    assert (heading.title, heading.unit, heading.text) == (title, unit, text)


@pytest.mark.parametrize(
    ("title", "unit", "name", "is_it"),
    [
        ("Normalkraft", "N", "load", True), ("friction force", "N", "load", False),
        ("load cell", "N", "load", False), ("Load", "s", "load", False),
        ("v", "", "velocity", False), ("v", "m/s", "velocity", True),
        ("entrainment velocity", "m/s", "velocity", False), ("COF", "", "friction", True),
        ("friction", "N", "friction", False), ("oil temp", "°C", "bulk_temperature", True),
        ("room temperature", "°C", "bulk_temperature", False),
        ("wear rate", "", "outcome", False), ("Ergebnis", "", "outcome", True),
        ("test no.", "", "number", True), ("run time", "s", "run", False),
        ("x", "", "nothing", False), ("Fn", "", "load", False), ("F_N", "", "load", True),
    ],
)  # fmt: skip
def test_headings_name_quantities_by_words_and_units(title, unit, name, is_it):
    assert is_named(Heading(title, title, unit), name) is is_it


def test_another_form_of_a_quantity_may_be_meant():
    assert may_be(Heading("n", "n", "rpm"), "velocity")
    assert may_be(Heading("speed", "speed", "kg"), "velocity")
    assert not may_be(Heading("colour", "colour", ""), "velocity")
    assert not may_be(Heading("outcome", "outcome", ""), "outcome")


def test_a_log_says_how_it_was_understood(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("Last [N];v [m/s];Befund;Prüfer\n400;2;ok;M\n;;;\n600;2;Fresser;M\n600;2;;\n")
    log = read_log(path)
    assert log.guessed[:2] == ['"Last [N]" as load', '"v [m/s]" as velocity']
    assert log.guessed[2:] == ['"Befund" as outcome', '"ok" as mild', '"Fresser" as severe']
    assert log.unused == ["Prüfer"]
    assert log.words == {"ok": "mild", "Fresser": "severe"}
    assert not log.is_only_wear
    assert replace(log, path=tmp_path / "brugger.csv").is_only_wear is False
