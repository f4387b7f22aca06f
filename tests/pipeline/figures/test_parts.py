"""Parts that figures share: words, scales, points that are chosen, bars and places of choices."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

import pipeline
from pipeline.figures import plot as live
from pipeline.figures import style
from pipeline.figures.fields import _edges, chosen_points, fields, indices_of, nearest_to
from pipeline.figures.overlays import mark_tests, name_regions, reachable_tests
from pipeline.figures.ramp import ramp, temperature
from pipeline.figures.studies import printed, signed
from pipeline.figures.tested import measured_over_computed
from pipeline.run.vary import Variation, Variations
from pipeline.store.schema import PENDING
from pipeline.sweep.about import Measurement
from pipeline.sweep.conditions import Conditions
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic
from tests.pipeline.analysis.test_boundary import falling
from tribo import InputError

NARROW = (200.0, 400.0, 600.0), (1.0, 2.0, 4.0)
OWN = synthetic.conditions()


def lines(axes):
    """Places of the lines of axes by their marks."""
    return {line.get_gid(): np.column_stack(line.get_data()) for line in axes.lines}


def labels(legend):
    return [text.get_text() for text in legend.get_texts()]


@pytest.fixture(scope="module")
def narrow():
    return synthetic.sweep(*NARROW, fields=True, measured=(), friction_band=None)


# Words


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("pin.radius", "pin: radius"),
        ("disk.roughness.hurst_exponent", "disk roughness: hurst\nexponent"),
        ("motion", "motion"),
    ],
)
def test_entries_are_words_in_short_lines(path, words):
    assert style.entry_label(path) == words


def test_words_of_a_figure_have_no_formulas_and_no_controls_and_end_somewhere():
    assert style.as_text("a $b$" + chr(27) + "c") == r"a \$b\$c"
    long = style.as_text("word " * 100)
    assert len(long) <= 240
    assert long.endswith("word …")
    assert style.as_text("x" * 240) == "x" * 240
    assert style.heating(OWN) == "friction 0.1, bulk 25 °C"


@pytest.mark.parametrize(
    ("value", "words"),
    [("1.2e-15 m^2/N", "1.2·10⁻¹⁵ m²/N"), ("3 mm", "3 mm"), ("2E+06", "2·10⁶"), ("true", "true")],
)
def test_values_are_printed_with_raised_powers(value, words):
    assert printed(value) == words


@pytest.mark.parametrize(
    ("change", "words"), [(0.1234, "+12.3 %"), (-0.05, "−5 %"), (0.0, "0 %"), (1.5, "+150 %")]
)
def test_changes_have_their_sign(change, words):
    assert signed(change) == words


@pytest.mark.parametrize(
    ("ends", "shown"),
    [
        ((1.0, 9.0), ["1", "2", "3", "4", "5", "6", "7", "8", "9"]),
        ((1.0, 10.0), ["1", "2", "5", "10"]),
        ((20.0, 700.0), ["20", "50", "100", "200", "500"]),
    ],
)
def test_logarithmic_axes_have_plain_numbers_and_enough_of_them(ends, shown):
    axes = Figure().add_subplot()
    axes.set(xscale="log", yscale="log", xlim=ends, ylim=(1.0, 9.0))
    style.plain_numbers(axes)
    low, high = ends
    ticks = axes.get_xticks()
    inside = ticks[(ticks >= low * (1 - 1e-9)) & (ticks <= high * (1 + 1e-9))]
    assert axes.xaxis.get_major_formatter().format_ticks(inside) == shown
    assert len(axes.xaxis.get_minorticklocs()) == 0
    alone = Figure().add_subplot()
    alone.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
    style.plain_numbers(alone, "y")
    assert alone.yaxis.get_major_formatter().format_ticks([2.0]) == ["2"]
    assert len(alone.xaxis.get_minorticklocs()) > 0


def titled():
    """A small figure with a title of each kind, and a legend below it."""
    figure = Figure(figsize=(4.0, 3.0))
    axes = figure.add_subplot()
    axes.plot([0.0, 1.0], label="a line", lw=2.0, marker="o", ms=5.0)
    axes.set(title="of axes", xlabel="x", ylabel="y")
    figure.suptitle("of the figure")
    figure.legend(title="bulk 25 °C and friction 0.1 at 600 N", fontsize=10.0)
    return figure, axes


def test_a_figure_without_titles_has_its_words_otherwise():
    figure, axes = titled()
    style.fit_to_width(figure, with_title=False)
    assert (figure.get_suptitle(), axes.get_title()) == ("", "")
    assert labels(figure.legends[0]) == ["a line"]
    assert figure.get_size_inches()[0] == 4.0
    figure, axes = titled()
    style.fit_to_width(figure)
    assert (figure.get_suptitle(), axes.get_title()) == ("of the figure", "of axes")
    # Numbers stay with their units where a line breaks.
    title = figure.legends[0].get_title().get_text()
    assert "25\N{NO-BREAK SPACE}°C" in title
    assert "600\N{NO-BREAK SPACE}N" in title


@pytest.mark.parametrize(("words", "columns"), [("short", 3), ("some words that are long", 1)])
def test_a_legend_keeps_its_columns_where_they_fit_and_the_figure_grows_else(words, columns):
    figure = Figure(figsize=(4.0, 3.0), layout="constrained")
    axes = figure.add_subplot()
    for number in range(3):
        axes.plot([0.0, 1.0], label=f"{words} {number}")
    figure.legend(loc="outside lower center", ncols=3, title="a title")
    style.fit_to_width(figure)
    (legend,) = figure.legends
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in legend.get_texts()]
    assert len({round(box.x0) for box in boxes}) == columns
    assert legend.get_window_extent().width <= figure.bbox.width
    width, height = figure.get_size_inches()
    assert width == 4.0
    assert height == 3.0 if columns == 3 else 3.2 < height < 3.6  # by two lines of 10 pt or so
    assert (labels(legend), legend.get_title().get_text()) == (
        [f"{words} {number}" for number in range(3)], "a title",
    )  # fmt: skip


def test_words_of_a_legend_that_is_wider_than_its_figure_are_broken_between_words():
    figure = Figure(figsize=(2.4, 3.0), layout="constrained")
    figure.add_subplot().plot([0.0, 1.0], label="beyond what was computed at 4 of 4 loads")
    figure.legend(loc="outside lower center")
    style.fit_to_width(figure)
    figure.draw_without_rendering()
    box = figure.legends[0].get_window_extent()
    assert 0 <= box.x0 < box.x1 <= figure.bbox.width
    (words,) = labels(figure.legends[0])
    assert " ".join(words.split()) == "beyond what was computed at 4 of 4 loads"
    assert figure.get_size_inches()[1] > 3.05  # by a line of 10 pt


@pytest.mark.parametrize("curves", [2, 6])
def test_a_legend_wider_than_its_axes_is_stacked_above_the_data(curves):
    figure = Figure(figsize=(3.0, 3.0), layout="constrained")
    axes = figure.add_subplot()
    for number in range(curves):
        axes.plot([0.0, 1.0], label=f"a name that is rather long {number}")
    right = axes.twinx()
    right.plot([0.0, 7.0])
    bottoms = [one.get_ylim()[0] for one in (axes, right)]
    axes.legend(ncols=2)
    style.fit_to_width(figure)
    figure.draw_without_rendering()
    legend = axes.get_legend()
    assert len({round(text.get_window_extent().x0) for text in legend.get_texts()}) == 1
    assert labels(legend) == [f"a name that is rather long {k}" for k in range(curves)]
    assert [one.get_ylim()[0] for one in (axes, right)] == bottoms
    lowest = legend.get_window_extent().y0
    for one, top in ((axes, 1.0), (right, 7.0)):
        highest = one.transData.transform((0.0, top))[1]
        assert lowest - 0.1 * axes.bbox.height < highest < lowest + 2.0  # [px]


def test_titles_of_legends_fill_the_width_of_their_figure():
    figure = Figure(figsize=(4.0, 3.0), layout="constrained")
    figure.add_subplot().plot([0.0, 1.0], label="a line")
    figure.legend(loc="outside lower center", title="some words " * 20 + "\nits own line")
    style.fit_to_width(figure)
    title = figure.legends[0].get_title()
    figure.draw_without_rendering()
    *lines, last = title.get_text().splitlines()
    assert (" ".join(lines), last) == (("some words " * 20).strip(), "its own line")
    assert 0.7 < title.get_window_extent().width / figure.bbox.width < 1.0


def test_titles_are_left_out_of_figures_of_sweeps_and_of_studies(narrow):
    study = Variations("A scene", (200.0,), Variation("", "", (2.0,), ("crosses",)), (
        Variation("pin.radius", "3 mm", (2.2,), ("crosses",)),), 1, 1)  # fmt: skip
    options = {"load": 400.0}
    for drawn, kind, given in ((narrow, "temperature", options), (study, None, {})):
        for with_title in (True, False):
            figure = pipeline.plot(drawn, kind, with_title=with_title, **given)
            title = figure.get_suptitle() or figure.axes[0].get_title()
            assert bool(title) == with_title
            if kind:  # words of a sweep's figure are wrapped at any width
                said = figure.legends[0].get_title().get_text()
                assert "25\N{NO-BREAK SPACE}°C" in said


@pytest.mark.parametrize(
    ("width", "words", "line"),
    [
        (0.04, 0.66, 0.6),  # of the figure's own sizes, below which nothing is readable
        (0.8 * 0.1016, 0.8, 0.8),
        (0.1016, 1.0, 1.0),
        (1.0, 1.0 / 0.1016, 1.0 / 0.1016),
    ],
)
def test_words_and_lines_shrink_with_a_figure_down_to_two_thirds(width, words, line):
    figure, axes = titled()
    style._shrink(figure, width)
    assert figure.get_size_inches()[0] == pytest.approx(width / 0.0254)
    assert figure.legends[0].get_texts()[0].get_fontsize() == pytest.approx(10.0 * words)
    assert axes.lines[0].get_linewidth() == pytest.approx(2.0 * line)
    assert axes.lines[0].get_markersize() == pytest.approx(5.0 * line)
    height = 3.0 * (width / 0.1016 * words) ** 0.5
    assert figure.get_size_inches()[1] == pytest.approx(height)


@pytest.mark.parametrize("width", [0.0399, 1.001])
def test_a_figure_is_from_4_to_100_cm_wide(width):
    with pytest.raises(InputError, match="it must be from 4 to 100 cm"):
        style._shrink(titled()[0], width)


def test_panels_lie_below_each_other_in_a_column_unless_told(narrow, monkeypatch):
    asked, (figure, _) = [], titled()

    def draw(ds, stacked=False):
        asked.append(stacked)
        return figure

    monkeypatch.setitem(live.KINDS, "fields", draw)
    monkeypatch.setattr(live, "fit_to_width", lambda *_: None)
    for options in ({"width": "11.9 cm"}, {"width": "12 cm"}, {}, {"width": 0.1, "stacked": False}):
        assert pipeline.plot(narrow, "fields", **options) is figure
    assert asked == [True, False, False, False]


# Points


def test_a_point_is_that_nearest_to_the_transition_of_the_highest_load_that_is_done(narrow):
    def chosen(load=None, velocity=None, status=None, conditions=OWN):
        ds = synthetic.sweep(*NARROW, status=status) if status else narrow
        return chosen_points(ds, load, velocity, conditions)

    # Wear turns severe at 3.7, 2.1 and 1.5 m/s; at 2 m/s the rise at 600 N is 23 % too high, at
    # 1 m/s 24 % too low.
    assert chosen() == [(2, 1)]
    assert chosen(load=200.0) == [(0, 2)]
    assert chosen(load=[200.0, 400.0]) == [(0, 2), (1, 1)]
    assert chosen(load="400 N", velocity=["1 m/s", 4.0]) == [(1, 0), (1, 2)]
    gone = {(600.0, velocity): PENDING for velocity in NARROW[1]}
    assert chosen(status=gone) == [(1, 1)]
    # Without a limit, and with one that nothing reaches, the hottest.
    unknown = replace(OWN, critical_temperature=None)
    assert chosen(conditions=unknown) == [(2, 2)]
    assert chosen(conditions=Conditions(0.1, 298.15, 1698.15)) == [(2, 2)]


def test_loads_between_those_of_the_sweep_are_refused_or_the_nearest_is_said(narrow):
    assert indices_of(narrow, "load", None) == []
    assert indices_of(narrow, "load", [600.0, 200.0]) == [2, 0]
    assert indices_of(narrow, "load", 200.0 * (1 + 9e-10)) == [0]
    with pytest.raises(InputError, match="load is 210 N, which the sweep does not hold; the near"):
        indices_of(narrow, "load", 210.0)
    assert indices_of(narrow, "load", 310.0, nearest=True) == [1]
    assert nearest_to(narrow, load=None, velocity=2.0) == ""
    assert nearest_to(narrow, load=[200.0, 210.0], velocity="3 m/s") == (
        ", nearest to 210 N and 3 m/s"
    )


def test_borders_of_elements_lie_midway_between_their_centres():
    assert _edges(np.array([1.0, 3.0, 5.0])).tolist() == [0.0, 2.0, 4.0, 6.0]
    assert _edges(np.array([7.0])).tolist() == [6.5, 7.5]


def test_a_single_row_of_elements_has_no_scale_along_y(narrow):
    wide = fields(narrow, load=600.0, velocity=4.0)
    assert [axes.get_ylabel() for axes in wide.axes[:3]] == ["y [µm]", "", ""]
    stacked = fields(narrow, load=600.0, velocity=4.0, stacked=True)
    assert [axes.get_ylabel() for axes in stacked.axes[:3]] == ["y [µm]"] * 3
    one = fields(narrow.isel(y=[4]), load=600.0, velocity=4.0)
    assert [axes.get_ylabel() for axes in one.axes[:3]] == [""] * 3
    assert len(one.axes[0].get_yticks()) == 0
    assert one.axes[1].child_axes[0].get_xlabel() == "contact temperature [°C]"
    cold = fields(narrow, load=200.0, velocity=1.0)
    assert cold.axes[1].child_axes[0].get_xlabel() == "contact temperature [°C]"
    assert "outlined" in wide.axes[1].child_axes[0].get_xlabel()
    # Nothing is drawn where nothing touches and nothing is worn; colours begin at 0 there.
    pressure, _, worn = (axes.collections[0] for axes in wide.axes[:3])
    assert pressure.get_array().mask.any()
    assert (pressure.norm.vmin, worn.norm.vmin) == (0.0, 0.0)
    assert worn.get_array().mask.any()
    bulk = wide.axes[1].collections[0]
    assert bulk.norm.vmin == pytest.approx(bulk.get_array().min())


@pytest.mark.parametrize("stacked", [False, True])
def test_panels_of_a_contact_share_their_scales_below_bars_of_their_own(narrow, stacked):
    figure = fields(narrow, load=600.0, velocity=4.0, stacked=stacked)
    figure.draw_without_rendering()
    first, second, third = figure.axes[:3]
    if stacked:
        assert first.bbox.y0 > second.bbox.y1
        assert second.bbox.y0 > third.bbox.y1
    else:
        assert first.bbox.x1 < second.bbox.x0
        assert second.bbox.x1 < third.bbox.x0
    first.set(xlim=(0.0, 50.0), ylim=(10.0, 60.0))
    assert (third.get_xlim(), third.get_ylim()) == ((0.0, 50.0), (10.0, 60.0))
    for panel in (first, second, third):
        (mesh,) = (one for one in panel.collections if hasattr(one, "get_coordinates"))
        assert mesh.get_rasterized()  # thousands of elements would be slow as vectors
        assert not any(line.get_visible() for line in panel.xaxis.get_gridlines())
        (bar,) = panel.child_axes
        assert (bar.bbox.x0, bar.bbox.x1) == pytest.approx((panel.bbox.x0, panel.bbox.x1))
        assert panel.bbox.y1 < bar.bbox.y0 < panel.bbox.y1 + 0.5 * figure.dpi
        assert 0.05 < bar.bbox.height / figure.dpi < 0.3  # [inch]
        assert bar.xaxis.get_ticks_position() == "top"
        for axes in (bar, panel) if not stacked or panel is third else (bar,):
            low, high = axes.bbox.x0 - 1.0, axes.bbox.x1 + 1.0
            boxes = [text.get_window_extent() for text in axes.get_xticklabels()]
            shown = [box for box in boxes if low <= (box.x0 + box.x1) / 2 <= high]
            assert len(shown) > 1
            assert all(left.x1 < right.x0 for left, right in itertools.pairwise(shown))


@pytest.mark.parametrize("stacked", [False, True])
@pytest.mark.parametrize("stretch", [1.0, 2.0, 100.0])
def test_a_contact_has_a_figure_as_high_as_its_panels(narrow, stacked, stretch):
    ds = narrow.assign_coords(y=stretch * narrow["y"])
    figure = fields(ds, load=600.0, velocity=4.0, stacked=stacked)
    figure.draw_without_rendering()
    panels = figure.axes[:3]
    aspect = np.ptp(panels[0].get_ylim()) / np.ptp(panels[0].get_xlim())
    drawn = panels[0].bbox.height / panels[0].bbox.width
    if stretch == 100.0:  # would be a line if lengths were the same along both axes
        assert drawn < 4.0
    else:
        assert drawn == pytest.approx(aspect)
    filled = sum(one.bbox.height for one in (panels if stacked else panels[:1]))
    assert 0.4 < filled / figure.bbox.height < 0.85


# The ramp and the temperatures


def test_a_ramp_has_the_temperatures_of_each_point_and_the_limit(narrow):
    figure = ramp(narrow, load=[200.0, 600.0], velocity=4.0)
    temperatures = figure.axes[0]
    key = labels(temperatures.get_legend())
    assert key == ["highest", "exceeded on 10 % of the contact", "critical, 145 °C"]
    assert figure.axes[1].get_xlim()[0] == 0.0
    assert figure.axes[1].get_ylim()[0] == 0.0
    for axes in figure.axes[1:]:  # with room for the legend, and more on the right
        highest = max(np.nanmax(line.get_ydata()) for line in axes.lines if len(line.get_ydata()))
        assert 1.15 * highest < axes.get_ylim()[1] < 1.8 * highest
    ends = [line.get_xdata()[-1] for line in temperatures.lines if len(line.get_xdata()) > 1]
    assert {round(end, 9) for end in ends if end > 1} <= {
        round(load / synthetic.RATE, 9) for load in (200.0, 600.0)
    }
    assert labels(figure.legends[0]) == ["200 N, 4 m/s", "600 N, 4 m/s"]
    assert figure.legends[0].get_title().get_text() == "friction 0.1, bulk 25 °C"
    # The key has room above the curves; lower loads lie over higher ones, all over the grid.
    low, high = temperatures.get_ylim()
    hottest = max(max(line.get_ydata()) for line in temperatures.lines if len(line.get_ydata()))
    assert 0.1 < (high - hottest) / (high - low) < 0.3
    order = {line.get_color(): line.get_zorder() for line in temperatures.lines}
    assert order["C0"] > order["C1"] >= 2
    assert not temperatures.texts  # no load is held
    for axes in figure.axes[3:]:  # the right ones, whose grid would cross that of the left
        assert not any(line.get_visible() for line in axes.yaxis.get_gridlines())
    blown = replace(OWN, criterion="highest")
    alone = ramp(synthetic.sweep(*NARROW, conditions=blown), load=600.0, velocity=4.0)
    assert labels(alone.axes[0].get_legend()) == ["highest", "critical, 145 °C"]
    unknown = replace(OWN, critical_temperature=None)
    free = ramp(synthetic.sweep(*NARROW, conditions=unknown), load=600.0, velocity=4.0)
    assert labels(free.axes[0].get_legend())[0] == "highest"
    assert not any(text.startswith("critical") for text in labels(free.axes[0].get_legend()))


def test_a_load_that_is_held_is_marked_from_when_it_is_reached_on():
    ds = sweeps.held()
    figure = ramp(ds, load=600.0, velocity=2.4)
    top = figure.axes[0]
    assert [[*line.get_xdata()] for line in top.lines].count([4.0, 4.0]) == 1
    (text,) = top.texts
    assert (text.get_text(), text.get_position()[0]) == (" load held", 4.0)
    for axes in figure.axes:
        assert axes.get_xlim() == (0.0, pytest.approx(1.01 * 17.0))  # 10 s and seven more
    point = ds.sel(load=600.0, velocity=2.4)
    factors = {
        "contact width [µm]": ("contact_width", 1e6),
        "in contact [% of window]": ("contact_fraction", 100.0),
        "greatest wear depth [µm]": ("wear_depth_max", 1e6),
        "worn volume [mm³]": ("wear_volume", 1e9),
    }
    assert [axes.get_ylabel() for axes in figure.axes[1:]] == [
        "contact width [µm]", "greatest wear depth [µm]", "in contact [% of window]",
        "worn volume [mm³]",
    ]  # fmt: skip
    for axes in figure.axes[1:]:
        name, factor = factors[axes.get_ylabel()]
        shown = np.concatenate([line.get_ydata() for line in axes.lines])
        known = factor * point[name].values
        np.testing.assert_allclose(np.sort(shown), np.sort(known[np.isfinite(known)]))
    decisive = next(line for line in top.lines if "exceeded" in str(line.get_label()))
    rises = point["rise_quantile"].interp(cooler_share=0.9).values
    expected = 25.0 + 0.1 * rises[np.isfinite(rises)]
    np.testing.assert_allclose(decisive.get_ydata()[-9:], expected[-9:])


def test_a_ramp_without_wear_has_no_panel_of_it(narrow):
    unworn = narrow.assign(wear_volume=0 * narrow["wear_volume"])
    assert len({one.get_ylabel() for one in ramp(unworn).axes}) == 3
    one_worn = narrow.assign(wear_volume=narrow["wear_volume"].where(narrow["load"] > 300.0, 0.0))
    both = ramp(one_worn, load=[200.0, 600.0], velocity=4.0)
    assert len({one.get_ylabel() for one in both.axes}) == 5
    assert len({one.get_ylabel() for one in ramp(narrow).axes}) == 5
    shown = ramp(narrow, load=600.0, velocity=4.0, show="mean_pressure")
    assert [one.get_ylabel() for one in shown.axes] == ["contact temperature [°C]",
                                                        "mean_pressure [Pa]"]  # fmt: skip


def test_a_load_that_falls_has_no_axis_above_its_time(narrow):
    assert len(ramp(narrow, load=600.0, velocity=4.0).axes[0].child_axes) == 1
    held = narrow.assign(normal_load=narrow["normal_load"].where(narrow["step"] != 0, 1.0))
    assert ramp(held, load=600.0, velocity=4.0).axes[0].child_axes == []


def test_temperatures_over_the_velocity_are_named_with_the_limit_and_the_transition(narrow):
    figure = temperature(narrow, load=400.0)
    axes = figure.axes[0]
    critical = synthetic.critical_velocity(400.0, synthetic.limit())
    said = labels(figure.legends[0])
    assert said[0] == "highest"
    assert said[2:] == ["critical, 145 °C", f"transition, {critical:.3g} m/s"]
    assert axes.get_title() == "White oil on ground steel\n400 N"
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "sliding velocity [m/s]",
        "contact temperature [°C]",
    )
    assert temperature(narrow).axes[0].get_title().endswith("\n600 N")  # the highest
    unknown = replace(OWN, critical_temperature=None)
    free = temperature(synthetic.sweep(*NARROW, conditions=unknown), load=400.0)
    assert len(labels(free.legends[0])) == 2
    highest = synthetic.sweep(*NARROW, conditions=replace(OWN, criterion="highest"))
    assert labels(temperature(highest, load=400.0).legends[0])[:2] == [
        "highest",
        "critical, 145 °C",
    ]


# Tests and regions


@pytest.mark.parametrize(
    ("test", "is_near"),
    [
        (Measurement(900.0, 2.0), True),  # 1.5 times the highest
        (Measurement(901.0, 2.0), False),
        (Measurement(200.0 / 1.5, 2.0), True),
        (Measurement(133.0, 2.0), False),
        (Measurement(400.0, -6.0), True),
        (Measurement(400.0, 6.01), False),
        (Measurement(400.0, 0.66), False),
    ],
)
def test_tests_are_in_the_figure_up_to_half_its_range_beyond_the_sweep(narrow, test, is_near):
    near, far = reachable_tests(narrow, [test])
    assert (near == [test], len(far)) == (is_near, 0 if is_near else 1)
    if far:
        assert far[0].get_label() == (
            f"beyond the figure: test of {test.normal_load:g} N at {test.velocity:g} m/s"
        )


@pytest.mark.parametrize(("own", "is_other"), [(299.15, False), (299.19, True), (297.0, True)])
def test_tests_at_another_bulk_temperature_are_faint_and_have_it_beside_them(own, is_other):
    axes = Figure().add_subplot()
    tests = [Measurement(400.0, 2.0, bulk_temperature=own), Measurement(300.0, 1.0)]
    legend = mark_tests(axes, tests, 298.15, 298.15)
    said = [line.get_label() for line in legend]
    other = "measured transition, at another bulk temperature"
    assert said == ["measured transition", *([other] if is_other else [])]
    assert [text.get_text() for text in axes.texts] == (
        [f"{own - 273.15:.3g} °C"] if is_other else []
    )
    if is_other:
        assert axes.lines[1].get_alpha() < 0.5
        assert axes.lines[0].get_alpha() is None
    warm = mark_tests(Figure().add_subplot(), tests[1:], 298.15, 333.15)  # of a warmer scene
    assert [line.get_label() for line in warm] == [other]


@pytest.mark.parametrize("log", [False, True])
def test_regions_are_named_on_their_own_side_and_over_no_test(log):
    axes = Figure().add_subplot()
    if log:
        axes.set(xscale="log", yscale="log")
    axes.set(xlim=(1.0, 9.0), ylim=(100.0, 900.0))
    velocities, loads = np.linspace(1.0, 9.0, 81), np.linspace(100.0, 900.0, 81)
    plane = xr.DataArray(
        np.repeat(velocities[None], 81, axis=0), {"load": loads, "velocity": velocities},
        ("load", "velocity"),
    )  # fmt: skip
    rows = np.linspace(100.0, 900.0, 5)
    name_regions(axes, plane, 5.0, rows, [Measurement(500.0, 3.0)])
    to_data = axes.transAxes + axes.transData.inverted()
    places = {text.get_text(): to_data.transform(text.get_position()) for text in axes.texts}
    mild, severe = "mild wear (I and II)", "severe adhesive wear (III* and III)"
    named = {words.replace("\n", " "): place for words, place in places.items()}
    assert set(named) == {mild, severe}
    assert 1.0 < named[mild][0] < 5.0 < named[severe][0] < 9.0
    for _, load in places.values():  # midway between two rows of points
        assert np.abs(load - np.array([200.0, 400.0, 600.0, 800.0])).min() < 1e-6
    free = Figure().add_subplot()
    free.set(xlim=(1.0, 9.0), ylim=(100.0, 900.0))
    name_regions(free, plane, 5.0, rows, [])
    middles = {text.get_text().split()[0]: text.get_position()[0] for text in free.texts}
    assert middles == pytest.approx({"mild": 0.25, "severe": 0.75}, abs=0.02)
    thin = plane.sel(velocity=slice(4.5, 9.0))  # where the name would not fit on the cold side
    cold = Figure().add_subplot()
    cold.set(xlim=(1.0, 9.0), ylim=(100.0, 900.0))
    name_regions(cold, thin, 4.8, rows, [])
    assert [text.get_text().split()[0] for text in cold.texts] == ["severe"]
    crowded = Figure().add_subplot()
    crowded.set(xlim=(1.0, 9.0), ylim=(100.0, 900.0))
    name_regions(crowded, plane, 5.0, np.linspace(100.0, 900.0, 61), [])
    assert not crowded.texts


def lines_of_tests(axes):
    return [line for line in axes.lines if str(line.get_gid()).startswith("tested")]


def test_tests_over_computed_are_in_one_scale_with_the_line_of_equals():
    tests = (Measurement(400.0, 2.25, 0.1), Measurement(600.0, 1.2, 0.1, outcome="severe"))
    figure = measured_over_computed(synthetic.sweep(measured=tests[:1], tested=tests[1:]))
    (axes,) = figure.axes
    computed = [synthetic.critical_velocity(test.normal_load, synthetic.limit()) for test in tests]
    ends = min(*computed, 1.2) / 1.25, max(*computed, 2.25) * 1.25
    assert axes.get_xlim() == pytest.approx(ends, rel=2e-3)
    assert axes.get_ylim() == axes.get_xlim()
    (equal,) = (line for line in axes.lines if str(line.get_label()).startswith("measured as comp"))
    np.testing.assert_array_equal(equal.get_xdata(), equal.get_ydata())
    said = labels(figure.legends[0])
    assert {"measured transition", "test: severe wear", "next run not decided"} <= set(said)
    assert not any("not known" in text for text in said)
    assert axes.get_title() == "White oil on ground steel\ncomputed against measured"
    assert axes.get_xlabel() == "critical velocity computed at the test's own conditions [m/s]"
    assert axes.get_ylabel() == "velocity of the test [m/s]"
    (band,) = (one for one in axes.collections if one.get_label() == "next run not decided")
    ratios = [y / x for x, y in band.get_paths()[0].vertices if x > 0]
    assert min(ratios) < 0.98 < 1.02 < max(ratios)
    assert min(ratios) * max(ratios) == pytest.approx(1.0, abs=0.3)


def test_a_test_of_a_slow_transition_is_drawn_too():
    fast = synthetic.sweep(velocities=[0.1, 0.2, 0.4, 0.8], measured=(),
                           tested=(Measurement(750.0, 0.4, 0.2, outcome="mild"),))  # fmt: skip
    (axes,) = measured_over_computed(fast).axes
    ((x, y),) = lines_of_tests(axes)[0].get_xydata()
    assert x == pytest.approx(synthetic.critical_velocity(750.0, synthetic.limit(0.2)), rel=1e-3)
    assert x < 1.0
    assert y == 0.4


def test_a_test_beside_a_turn_to_mild_wear_points_down_and_the_legend_tells_its_sides():
    tests = tuple(Measurement(400.0, v, None, outcome="mild") for v in (1.0, 2.3, 2.7))
    band = synthetic.sweep(rise=falling, measured=(), tested=tests)
    figure = measured_over_computed(band)
    markers = [line.get_marker() for line in lines_of_tests(figure.axes[0])]
    assert markers == ["^", "v", "v"]
    said = labels(figure.legends[0])
    assert {"test: mild wear", "test: mild wear; computed severe below, mild above"} <= set(said)


# Bars


def bars(others, loads=(200.0, 600.0), critical=(2.0, 1.0), outcomes=("crosses", "crosses")):
    base = Variation("", "", critical, outcomes)
    return pipeline.plot(Variations("A scene", loads, base, tuple(others), 1, 1)).axes[0]


def test_values_stand_at_the_ends_of_bars_and_what_has_no_transition_is_said():
    crosses = ("crosses", "crosses")
    axes = bars(
        [
            Variation("pin.radius", "1 mm", (1.0, math.nan), crosses),
            Variation("pin.radius", "3 mm", (1.8, 1.1), crosses),
            Variation("pin.radius", "5 mm", (math.nan, 1.5), crosses),
            Variation("friction.coefficient", "0.2", (math.nan, math.nan), crosses),
        ],
    )
    said = [(text.get_text(), text.get_position(), text.get_ha()) for text in axes.texts]
    words = [text for text, *_ in said]
    # Of radii 1 and 3 mm: −50 and −10 % at 200 N; of 3 and 5 mm: +10 and +50 % at 600 N.
    assert words.count("1 mm") == 1
    assert words.count("5 mm") == 1
    assert "3 mm" not in words  # between the ends
    assert "no transition at 5 mm" in words
    assert "no transition at 1 mm" in words
    assert words.count(" no transition") == 2
    sides = {text: side for text, _, side in said}
    assert (sides["1 mm"], sides["5 mm"]) == ("right", "left")
    # What has none stands on the side without a bar.
    assert (sides["no transition at 5 mm"], sides["no transition at 1 mm"]) == ("left", "right")
    low, high = axes.get_xlim()
    assert (low, high) == pytest.approx((-0.5 - 0.45, 0.5 + 0.45))
    assert axes.get_xlabel() == "change of the critical velocity"


@pytest.mark.parametrize(("letters", "is_beside"), [(20, True), (21, False)])
def test_values_stand_beside_their_bars_up_to_twenty_letters(letters, is_beside):
    value = "x" * letters
    axes = bars(
        [
            Variation("oxide", value, (1.0, 0.5), ("crosses", "crosses")),
            Variation("oxide", "none", (3.0, 1.5), ("crosses", "crosses")),
        ],
    )
    beside = {text.get_text() for text in axes.texts}
    (name,) = (label.get_text() for label in axes.get_yticklabels())
    assert (value in beside, value in name) == (is_beside, not is_beside)
    assert ("−50 %" in beside) == (not is_beside)
    assert "none" in beside


@pytest.mark.parametrize(
    ("critical", "ends"), [((2.2, 1.2), (-0.09, 0.29)), ((1.8, 0.8), (-0.29, 0.09))]
)
def test_bars_to_one_side_begin_at_no_change(critical, ends):
    axes = bars([Variation("pin.radius", "3 mm", critical, ("crosses",) * 2)])
    assert axes.get_xlim() == pytest.approx(ends)  # and 45 % of the longest for words


def test_where_nothing_moves_there_is_room_for_a_percent_on_either_side():
    axes = bars([Variation("pin.radius", "3 mm", (2.0, 1.0), ("crosses",) * 2)])
    assert axes.get_xlim() == pytest.approx((-0.019, 0.019))
    axes = bars(
        [Variation("pin.radius", "3 mm", (2.2,), ("crosses",))],
        loads=(200.0,), critical=(math.nan,), outcomes=("mild throughout",),
    )  # fmt: skip
    assert labels(axes.figure.legends[0]) == ["at 200 N, mild throughout"]


def test_lines_of_a_collection_shrink_with_their_figure():
    borders = LineCollection([], linewidths=[1.0, 2.0])
    style._resize(borders, 0.7, 0.6)
    assert list(borders.get_linewidth()) == [0.6, 1.2]
