"""What figures mark: each mark, bar and line is at the number that it stands for, in its unit."""

import pytest

import pipeline
from tests.helpers import synthetic
from tests.helpers.entries import bare_test
from tests.pipeline.figures.test_plot import labels, lines

NARROW = (200.0, 400.0, 600.0), (1.0, 2.0, 4.0)


def faces(axes):
    return {line.get_gid(): line.get_markerfacecolor() for line in axes.lines}


# The diagram


def test_tests_are_open_where_wear_stayed_mild_and_filled_where_it_was_severe():
    tests = (
        bare_test(250.0, 1.5, outcome="mild"),
        bare_test(500.0, 3.0, outcome="severe"),
        bare_test(350.0, 2.5, outcome="severe", bulk_temperature=333.15, number="warm"),
        bare_test(901.0, 2.0, outcome="mild"),
        bare_test(200.0, 9.0, outcome="mild"),
    )
    axes = pipeline.plot(synthetic.sweep(*NARROW, tests=tests)).axes[0]
    places, colours = lines(axes), faces(axes)
    assert places["test mild"].tolist() == [[1.5, 250.0]]
    assert places["test severe"].tolist() == [[3.0, 500.0]]
    assert places["test severe, elsewhere"].tolist() == [[2.5, 350.0]]
    assert colours["test mild"] == "white"
    assert colours["test severe"] == colours["test severe, elsewhere"] != "white"
    numbers = {one.get_text(): one.xy for one in axes.texts if one.get_gid() == "number of a test"}
    assert numbers == {"1": (1.5, 250.0), "2": (3.0, 500.0), "warm": (2.5, 350.0)}
    (legend,) = axes.figure.legends
    assert "not shown (outside the axes): tests 4, 5" in legend.get_title().get_text()
    assert "test: mild, severe" in labels(legend)


def test_an_operating_point_is_marked_at_its_load_and_velocity():
    axes = pipeline.plot(synthetic.sweep(*NARROW), load="500 N", velocity=3.0).axes[0]
    assert lines(axes)["operating point"].tolist() == [[3.0, 500.0]]
    assert "500 N, 3 m/s" in {one.get_text() for one in axes.texts}


# Contact and temperature


def test_the_critical_temperature_is_outlined_in_the_contact():
    ds = synthetic.sweep(*NARROW, fields=True)
    figure = pipeline.plot(ds, "fields", load=600.0, velocity=4.0)
    panel = figure.axes[1]
    assert panel.child_axes[0].get_xlabel() == "contact temperature [°C]; outline at 145"
    (outline,) = (artist for artist in panel.collections if hasattr(artist, "levels"))
    here = ds.sel(load=600.0, velocity=4.0)
    temperature = 25.0 + 0.1 * here["rise"]
    for path in outline.get_paths():
        for x, y in path.vertices[:: max(1, len(path.vertices) // 5)]:
            at = {"x": 1e-6 * x, "y": 1e-6 * y}
            assert temperature.interp(**at).item() == pytest.approx(145.0, abs=6.0)
    assert [axes.get_ylabel() for axes in figure.axes[:3]] == ["y [µm]", "", ""]
    narrow = pipeline.plot(ds, "fields", width="8.5 cm")  # panels below each other
    assert [axes.get_xlabel() for axes in narrow.axes[:3]] == ["", "", "x, along sliding [µm]"]
    assert narrow.axes[1].collections[0].get_cmap().name == "inferno"  # bright where hot


# Studies
