"""Diagrams of closed-form sweeps: regions, bands, points and labels."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.figures.style import THICK
from pipeline.store.schema import FAILED, PENDING
from tests.helpers import synthetic
from tests.helpers.entries import bare_test
from tests.helpers.entries import two_pins as radii_rows
from tribo import WarningKind

LOADS, VELOCITIES = (200.0, 300.0, 400.0, 500.0, 600.0), (1.0, 1.5, 2.0, 3.0, 4.0)
LIMIT = synthetic.limit()


def sweep(**options):
    defaults = {"loads": LOADS, "velocities": VELOCITIES, "tests": (), "friction_band": None}
    return synthetic.sweep(**defaults | options)


def drawn(ds, **options):
    """Axes of a drawn diagram, and texts of its legend."""
    figure = pipeline.plot(ds, **options)
    (legend,) = figure.legends or [figure.axes[0].get_legend()]
    return figure.axes[0], [text.get_text() for text in legend.get_texts()]


def vertices(axes, gid):
    """Vertices of the drawn line or area with this id, (velocity, load)."""
    (collection,) = [artist for artist in axes.collections if artist.get_gid() == gid]
    return np.concatenate([path.vertices for path in collection.get_paths()])


def marks(axes, gid):
    """Set of (velocity, load) of the drawn points with this id."""
    marked_lines = [line for line in axes.lines if line.get_gid() == gid]
    return {(v, load) for line in marked_lines for v, load in zip(*line.get_data(), strict=True)}


def test_the_boundary_of_a_diagram_is_that_of_the_closed_form():
    axes = drawn(sweep())[0]
    line = vertices(axes, "boundary")
    expected = synthetic.critical_velocity(line[:, 1], LIMIT)
    np.testing.assert_allclose(line[:, 0], expected, rtol=2e-3)
    assert axes.get_xlim() == (1.0, 4.0)


def test_the_band_about_the_boundary_is_as_wide_as_its_numerical_error():
    ds = sweep()
    flags = int(WarningKind.FEW_STEPS) + 0 * ds["warning_flags"]  # 10 % of the rise
    band = vertices(drawn(ds.assign(warning_flags=flags))[0], "error")
    ends = band[np.isclose(band[:, 1], 400.0), 0]
    expected = [synthetic.critical_velocity(400.0, LIMIT / share) for share in (1.1, 0.9)]
    assert (ends.min(), ends.max()) == pytest.approx(expected, rel=0.01)


def test_the_frictions_measured_have_a_line_each():
    axes = drawn(sweep(friction_band=(0.08, 0.12)))[0]
    edges = [edge for edge in axes.collections if edge.get_gid() == "friction"]
    for edge, friction in zip(edges, (0.08, 0.12), strict=True):
        line = np.concatenate([path.vertices for path in edge.get_paths()])
        expected = synthetic.critical_velocity(line[:, 1], synthetic.limit(friction))
        np.testing.assert_allclose(line[:, 0], expected, rtol=3e-3)
    legend_texts = drawn(sweep(friction_band=(0.1, 0.1)))[1]
    assert not any("at friction" in text for text in legend_texts)


def test_no_friction_has_a_line_that_lies_on_the_boundary_with_tests():
    early = [0.85 * float(synthetic.critical_velocity(load, LIMIT)) for load in LOADS]
    tests = {"tests": tuple(map(bare_test, LOADS, early))}
    velocity = pipeline.boundary(sweep(**tests))["critical_velocity_p50"].sel(load=400.0).item()
    friction = pipeline.margin(sweep(**tests), 400.0, velocity)["critical_friction"].item()
    assert friction > 0.103  # the boundary with tests is not the computed one
    assert "computed at friction 0.08" in drawn(sweep(**tests, friction_band=(0.08, friction)))[1]


@pytest.mark.parametrize(
    ("tests", "heavy"), [((), "boundary"), (synthetic.MEASURED, "boundary with tests")]
)
def test_the_heavy_line_is_the_boundary_with_tests_if_there_are_any(tests, heavy):
    axes = drawn(sweep(tests=tests))[0]
    lines = [line for line in axes.collections if str(line.get_gid()).startswith("boundary")]
    assert [line.get_gid() for line in lines if line.get_linewidth()[0] == THICK] == [heavy]


def surfaces(*factors):
    several = [
        sweep(rise=lambda *point, factor=factor: factor * synthetic.rise(*point))
        for factor in factors
    ]
    labels = xr.Variable("realization", range(1, len(factors) + 1))
    return xr.concat(several, labels, combine_attrs="override")


NOT_DONE = {(200.0, 4.0): FAILED, (300.0, 1.0): PENDING}


def test_points_that_are_not_done_are_marked():
    axes = drawn(sweep(status=NOT_DONE))[0]
    assert marks(axes, "lacking") == {(4.0, 200.0), (1.0, 300.0)}
    all_points = {(velocity, load) for velocity in VELOCITIES for load in LOADS}
    assert marks(axes, "simulated") == all_points - marks(axes, "lacking")


TESTED = (
    bare_test(250.0, 1.5, outcome="mild"),
    bare_test(500.0, 3.0, outcome="severe"),
    bare_test(350.0, 2.5, outcome="severe", bulk_temperature=333.15, number="warm"),
    bare_test(901.0, 2.0, outcome="mild"),
    bare_test(200.0, 9.0, outcome="mild"),
)


def test_tests_are_open_where_wear_stayed_mild_and_filled_where_it_was_severe():
    axes = pipeline.plot(sweep(tests=(*TESTED, bare_test(140.0, 2.0)))).axes[0]
    assert marks(axes, "test transition") == {(2.0, 140.0)}  # lighter than the sweep by less than
    assert axes.get_ylim() == (140.0, 600.0)  # a third, which the axes then contain
    colours = {line.get_gid(): line.get_markerfacecolor() for line in axes.lines}
    assert marks(axes, "test mild") == {(1.5, 250.0)}
    assert marks(axes, "test severe") == {(3.0, 500.0)}
    assert marks(axes, "test severe, elsewhere") == {(2.5, 350.0)}
    assert colours["test mild"] == "white"
    assert colours["test severe"] == colours["test severe, elsewhere"] != "white"
    sizes = {line.get_gid(): line.get_markersize() for line in axes.lines}
    assert sizes["test mild"] == sizes["test severe, elsewhere"] > 1.5 * sizes["simulated"]
    numbers = {
        text.get_text(): text.xy for text in axes.texts if text.get_gid() == "number of a test"
    }
    drawn_numbers = {"1": (1.5, 250.0), "2": (3.0, 500.0), "warm": (2.5, 350.0)}
    assert numbers == drawn_numbers | {"6": (2.0, 140.0)}


def test_a_test_is_also_marked_where_it_would_lie_at_the_friction_of_the_line():
    """The synthetic rise is a power of velocity, so that the shift follows by hand."""
    rows = (
        bare_test(400.0, 2.0, outcome="transition", friction=0.08),
        bare_test(300.0, 2.0, outcome="transition", friction=0.1),
    )
    ((velocity, load),) = marks(drawn(sweep(tests=rows))[0], "test at the line's friction")
    expected = synthetic.critical_velocity(400.0, 0.8 * synthetic.rise(400.0, 2.0, 0.9))
    assert (velocity, load) == (pytest.approx(expected, rel=2e-3), 400.0)
    assert expected < 1.5  # a visible distance
    assert not marks(drawn(sweep(tests=rows[1:]))[0], "test at the line's friction")


def test_operating_points_are_marked_as_pairs_with_their_numbers():
    axes = drawn(sweep(), load=["300 N", 500.0], velocity=[1.5, "3 m/s"])[0]
    assert marks(axes, "operating point") == {(1.5, 300.0), (3.0, 500.0)}
    sides = {text.get_text(): (text.get_ha(), text.get_va()) for text in axes.texts}
    assert sides["300 N, 1.5 m/s"] == ("left", "bottom")
    assert sides["500 N, 3 m/s"] == ("right", "top")
    for count, labelled in [(6, 6), (7, 0)]:
        axes = drawn(sweep(), load=np.linspace(300, 400, count), velocity=[1.0] * count)[0]
        assert sum(text.get_text().endswith("N, 1 m/s") for text in axes.texts) == labelled


def two_pins(factors=(1.0, 0.1), **options):
    radii = (1e-3, 2e-3)
    parts = [
        sweep(
            case_table=radii_rows(),
            rise=lambda *point, factor=factor: factor * synthetic.rise(*point),
            **options,
        )
        for factor in factors
    ]
    labels = xr.DataArray([*radii], dims="pin_radius", name="pin_radius", attrs={"units": "m"})
    return xr.concat(parts, labels, combine_attrs="override")


def test_each_scene_has_its_boundary():
    axes = drawn(two_pins())[0]
    boundary = vertices(axes, "boundary pin radius 1 mm")
    ends = boundary[:, 1].min(), boundary[:, 1].max()
    assert ends == pytest.approx((LOADS[0], LOADS[-1]), rel=1e-4)
    expected = synthetic.critical_velocity(boundary[:, 1], LIMIT)
    np.testing.assert_allclose(boundary[:, 0], expected, rtol=2e-3)
    axes, words = drawn(two_pins((1.0, 0.9), loads=LOADS[:2], velocities=(2.0, 4.0)))
    assert words == ["pin radius 1 mm", "pin radius 2 mm"]
    ends = [vertices(axes, f"boundary {name}")[:, 0].max() for name in words]
    assert ends[0] < ends[1]  # the cooler pin's boundary is faster
    colours = [collection.get_edgecolor()[0].tolist() for collection in axes.collections]
    assert colours[0] != colours[1]
    keys = [line.get_color() for line in axes.figure.legends[0].get_lines()]
    assert [list(key) for key in keys] == colours


def test_a_logarithmic_diagram_has_the_same_boundary_and_leaves_rest_out():
    ds = sweep(velocities=(0.0, 1.0, 2.0, 4.0))
    plain, log = drawn(ds)[0], drawn(ds, log=True)[0]
    assert (log.get_xscale(), log.get_yscale()) == ("log", "log")
    assert (log.get_xlim()[0], plain.get_xlim()[0]) == (1.0, 1.0)
    boundary = vertices(plain, "boundary")
    np.testing.assert_allclose(vertices(log, "boundary"), boundary)
    low, high = log.get_xlim()
    visible_labels = (
        label for label in log.get_xticklabels() if low <= label.get_position()[0] <= high
    )
    assert [label.get_text() for label in visible_labels] == ["1", "2", "3", "4"]
