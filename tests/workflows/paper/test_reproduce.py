"""The paper's figures and tables, in small versions of the commands that make them."""

import functools
import json
import re
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from unittest import mock

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.lines import Line2D

import tribo
from pipeline import load_scene
from pipeline.cli import main
from pipeline.shipped import WORKFLOWS
from tests.helpers.kept import assert_as_kept
from tribo import InputError
from workflows import paper
from workflows.paper.gallery import pages
from workflows.paper.publication import TABLE_4, TABLE_6
from workflows.paper.recomputed import WORDS
from workflows.paper.study import Study
from workflows.paper.synthetic_record import synthetic_record

mpl.use("agg")
CONTRA = sys.modules["workflows.paper.contra"]  # not the function of its name
SMALLER = {
    "irg_transition": (
        ("pixels = [576, 480]", "pixels = [288, 240]"),
        ('"0.816 um", "0.95 um"', '"1.632 um", "1.9 um"'),
        ("fields = true", "fields = false"),
        ('step = "0.25 m/s"', 'step = "4.5 m/s"'),
        ('{ from = "200 N", to = "750 N", step = "50 N" }', '["200 N", "400 N", "600 N", "750 N"]'),
    ),
    "table4": (("pixels = [480, 480]", "pixels = [240, 240]"),),
    "oil_a": (("pixels = [720, 480]", "pixels = [360, 240]"),),
    "fig5": (("pixels = [480, 480]", "pixels = [240, 60]"),),
    "fig8": (("pixels = [480, 480]", "pixels = [240, 240]"),),
}
"""Texts in shipped scenes that are replaced by ones that take less time."""
SMALL = {"preset": "standard", "surfaces": 2, "workers": 1}
BEYOND = "contra", "ends", "heldout", "inverse", "rivals", "spacing", "steel"
"""Results beyond the paper's figures and tables, 4 to 10 s each: by ``-m slow`` alone."""
ONE_SURFACE = (
    "contra",
    "ends",
    "spacing",
    "steel",
    "fig6",
    "fig10",
    "heldout",
    "inverse",
    "table4",
    "table6",
)
"""Results that are computed on one surface here."""
COARSE = replace(tribo.PRESETS["standard"], fewest_elements=0)
"""Choices that take the place of the preset in figures and tables of the paper."""


@pytest.fixture(scope="module", autouse=True)
def _small_figures():
    with mpl.rc_context({"savefig.dpi": 40}):
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("paper")


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """Folder of the shipped scenes, on pixels twice as large, with fewer points in the diagram."""
    folder = tmp_path_factory.mktemp("scenes")
    for path in [*WORKFLOWS.glob("*.toml"), *WORKFLOWS.glob("*.csv")]:
        text = path.read_text(encoding="utf-8")
        for old, new in SMALLER.get(path.stem, ()):
            assert old in text
            text = text.replace(old, new)
        text = re.sub(r'^extends = "(\w+)"', r'extends = "\1.toml"', text, flags=re.MULTILINE)
        (folder / path.name).write_text(text, encoding="utf-8")
    return folder


@functools.cache
def _end(scene, load, velocity):
    *_, state = tribo.simulate(scene, load, velocity)
    return state


def simulate_once(scene, load, velocity, **options):
    """`tribo.simulate` with a cache for ends of tests, which several results show."""
    return (
        tribo.simulate(scene, load, velocity, **options)
        if options
        else (_end(scene, load, velocity),)
    )


@pytest.fixture(scope="module")
def small(folder, scenes):
    """Function that returns the report of a small version of a result; cached."""
    reports = {}
    fewer = {
        "contra": {
            "_LOADS": (20.0, 75.0),
            "_VELOCITIES": (1.5, 4.0),
            "_CHANGES": {name: CONTRA._CHANGES[name] for name in ("as predicted", "Ra 0.05 µm")},
        },
        "checkerboard": {
            "_BLOCK": 1,
            "_DRAWN": tribo.Fidelity(pixels_per_element=2, increments=20),
        },
        "ends": {"_POINTS": ((400.0, 2.25),)},
        "heldout": {
            "_LENGTHS": {"white oil": (4.0, 5.0), "oil A": (4.0,)},
            "_FACTORS": (-0.3, 0.3),
        },
        "inference": {"_DURATIONS": (6.0, 8.0), "_CHOSEN": 1, "_FRICTIONS": (0.1, 0.2)},
        "resolution": {"_INCREMENTS": (20, 30)},
        "spacing": {"_SPACINGS": (20e-6, 60e-6), "_VELOCITIES": (0.8, 1.6, 3.2, 5.2)},
        "steel": {
            "_CONDUCTIVITIES": (21.0, 45.0),
            "_VELOCITIES": {"from": "0.3 m/s", "to": "4.3 m/s", "step": "4 m/s"},
        },
        "transitions": {"simulate": simulate_once},
        "transition_diagram": {"ACCURACY": None},  # of the plane alone
    }

    def report(name):
        if name not in reports:
            options = SMALL
            if name in ONE_SURFACE:
                options = SMALL | {"surfaces": 1}
            with ExitStack() as stack:
                stack.enter_context(np.errstate(all="raise", under="ignore"))
                if name not in BEYOND:
                    stack.enter_context(mock.patch.dict(tribo.PRESETS, {"standard": COARSE}))
                for module, names in fewer.items():
                    module = sys.modules[f"workflows.paper.{module}"]  # not a function of its name
                    stack.enter_context(mock.patch.multiple(module, **names))
                if name == "fig4":  # fast enough to be computed in full
                    (reports[name],) = paper.write_gallery(folder / "page", ["fig4"])
                    (folder / "fig4.png").symlink_to(folder / "page" / "fig4.png")
                else:
                    reports[name] = paper.reproduce(
                        name, folder / f"{name}.png", scenes=scenes, results=folder, **options
                    )
        return reports[name]

    return report


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in BEYOND)) for name in paper.RESULTS],
)
def test_every_result_has_a_figure_and_its_numbers_and_verdicts_are_kept(small, folder, name):
    report = small(name)
    assert report.name == name
    assert report.findings
    assert all(finding.printed and finding.computed for finding in report.findings)
    document = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert document["data"]
    assert document["agrees"] == all(finding["agrees"] for finding in document["findings"])
    text = "\n".join(report.lines())
    assert text.startswith(f"{name}: ")
    assert all(verdict in text for verdict in {f["printed"] for f in document["findings"]})
    if name not in BEYOND:
        plain = replace(report, seconds=0.0, file=None)
        assert_as_kept(f"paper/{name}", {name: "\n".join(plain.lines())})
    png = (folder / f"{name}.png").read_bytes()
    assert png.startswith(b"\x89PNG")
    assert len(png) < 200_000


@pytest.mark.slow
def test_each_transition_is_predicted_from_the_other_three_of_its_oil(small):
    """Expected velocities are by another script, at `standard` over 8 surfaces."""
    data = small("heldout").data
    expected = [1.11, 1.50, 2.60, 3.63, 3.77, 5.26, 1.09, 2.03]
    assert data["predicted [m/s]"] == pytest.approx(expected, rel=0.08)
    assert data["by y = 0 [m/s]"][:4] == pytest.approx([1.12, 1.48, 2.61, 3.62], rel=0.08)
    off = data["held out, ln(predicted/measured)"]
    assert np.std(off["friction_load"][:4]) < 0.02
    # Oil A at 100 °C: the velocity at 400 N from that at 700 N, by F·Vⁿ with n = 1.19.
    assert off["load"][7] == pytest.approx(
        np.log(1.25 / 1.88 * (700 / 400) ** (1 / 1.19)), abs=0.01
    )


@pytest.mark.slow
def test_a_better_conductor_is_cooler_at_every_transition_of_both_oils(small):
    data = small("steel").data
    for oil, count in (("white oil", 4), ("oil A", 4)):
        critical = np.array(data["critical_celsius"][oil])
        assert critical.shape == (count, 1, len(data["conductivity"]))
        assert (np.diff(critical, axis=-1) < 0).all()
    # A fast body takes heat as the square root of its conductivity, a resting one in proportion.
    white = np.array(data["critical_celsius"]["white oil"])[:, 0] - 25.0
    hard, soft = (white[:, data["conductivity"].index(K)] for K in (21.0, 45.0))
    assert (hard / soft > (45 / 21) ** 0.5).all()
    assert (hard / soft < 45 / 21).all()


@pytest.mark.slow
def test_a_longer_spacing_lowers_the_critical_velocities_most_at_the_lowest_load(small):
    data = small("spacing").data
    change = data["critical_velocity"] / data["critical_velocity_as_chosen"] - 1
    assert data["load"][0] == 200.0
    assert (change[0] > 0.03).all()
    assert (change[-1] < -0.03).all()
    assert (np.diff(np.abs(change), axis=1) < 0).all()


def test_the_nearest_image_overestimates_the_peak_of_hertz_by_one_percent(small):
    over = small("fig4").data["overestimate"]
    assert over["nearest_image"] == pytest.approx(0.011, abs=2e-4)
    assert abs(over["periodic"]) < 1e-4
    assert small("fig4").data["hertz_peak_pressure"] == pytest.approx(1.0063e9, rel=1e-4)
    assert small("fig4").data["hertz_half_width"] == pytest.approx(0.13955e-3, rel=1e-4)

    data = small("fig4").data
    # Without periodicity the ends punch.
    assert data["peak_pressure"]["free"] > 5 * data["centre_pressure_free"]
    assert data["centre_pressure_free"] < 0.9 * data["hertz_peak_pressure"]


def test_wear_cools_the_contact_and_goes_on_doing_so_in_the_hold(small):
    curves = small("fig5").data
    at_full = {
        name: float(np.interp(4.0, c["time"], c["max_celsius"])) for name, c in curves.items()
    }
    assert at_full["no wear"] > at_full["swept wear"] + 10 > at_full["local wear"] + 20
    for name in ("swept wear", "local wear"):
        assert curves[name]["time"][-1] == pytest.approx(8.0)
        assert curves[name]["max_celsius"][-1] < at_full[name] - 5


def test_explicit_wear_is_unstable_in_fig6_and_needs_more_increments(small):
    report = small("fig6")
    unstable = report.data["unstable_increments"]
    assert unstable["explicit, local (as published)"] == [20, 30]
    assert unstable["implicit, local"] == []
    (published,) = (f for f in report.findings if "as published" in f.computed)
    assert not published.agrees


def test_the_published_steps_are_four_times_too_long_and_leave_a_checkerboard(small):
    data = small("fig2").data
    # The smallest compliance of the paper's grid, 1.632 × 1.9 µm, is 8.80e-18 m/Pa.
    distances = TABLE_4.velocity * TABLE_4.normal_load / 150.0 / 100
    assert data["stiffness"] == pytest.approx(1.2e-15 * distances / 8.80e-18, rel=1e-3)
    assert data["increments_needed"].max() == 427
    explicit, implicit = data["neighbours"].values()
    assert explicit < 0.2
    assert implicit > 0.7


def test_printed_equations_find_no_contact_or_half_the_heat(small):
    data = small("errata").data
    # The steel has ρC_p = 7800 · 470 J/(m³ K); with its root missing, the rise is too high.
    assert data["heat_ratio"]["outside the root"] == pytest.approx(0.5, rel=1e-9)
    assert data["heat_ratio"]["under the root"] == pytest.approx(np.sqrt(7800 * 470) / 2, rel=1e-9)
    within, carried = data["load_within_hertz"], data["load_carried"]
    assert within["corrected"] > 0.999
    assert within["Eq. (9) as printed"] < 0.001
    assert carried["corrected"] == pytest.approx(1.0)
    assert carried["Eq. (23) as printed"] > 100
    assert not any(finding.agrees for finding in small("errata").findings)
    (track,) = (f for f in small("errata").findings if f.name == "track")
    assert "885 to 977 times" in track.computed  # 340 mm over 384 and 348 µm
    assert "1227 to 1354 times at the rim" in track.computed  # 150 π mm over the same


def test_a_smooth_unworn_ball_scuffs_at_load_times_velocity(scenes):
    """Blok's rise of a fast ball goes with √(F V), so that n is 1; slow ones have more."""
    scene = Study(scenes=scenes).scene("mtm", {"motion.slide_roll_ratio": 20.0})
    smooth = scene.changed("disk.roughness", None).changed("wear", None)
    n, misfit = CONTRA._fit(smooth)
    assert n == pytest.approx(1.0, abs=0.1)
    assert misfit < 0.02


def test_the_shipped_record_is_the_synthetic_one():
    shipped = (WORKFLOWS / "fig8_load_record.csv").read_text(encoding="utf-8")
    assert shipped == synthetic_record()
    assert shipped.startswith("# Synthetic")
    rate, onset = load_scene(WORKFLOWS / "fig8.toml").scene.loading.linear_fit()
    assert rate == pytest.approx(150.0, rel=0.01)
    assert 0.3 < onset < 0.6


def test_the_legend_of_the_diagram_names_the_kind_of_wear_at_its_line(small):
    (legend,) = small("fig10").figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    (label,) = [name for name in names if "swept" in name]
    assert label == "computed boundary, swept wear"
    assert isinstance(legend.legend_handles[names.index(label)], Line2D)


def test_only_swept_wear_leaves_the_temperatures_of_table_4(small):
    data = small("table4").data
    assert data["load"].tolist() == TABLE_4.normal_load.tolist()
    assert np.shape(data["max_celsius"]["swept"]) == (len(TABLE_4), 1)
    assert np.mean(data["failed_percent"]["swept"]) == pytest.approx(10, abs=5)  # 13 on coarse ones
    assert np.mean(data["failed_percent"]["local"]) < 1
    assert np.all(np.array(data["failed_percent"]["unworn"]) > 20)


def test_the_hot_rows_of_table_6_are_those_of_room_temperature(small):
    data = small("table6").data
    assert data["misfit_by_bulk_celsius"]["100"] == pytest.approx(0.276, abs=5e-4)
    assert data["misfit_by_bulk_celsius"]["25"] == pytest.approx(0.042, abs=5e-4)
    ours = np.mean(data["max_celsius_at_room_temperature"], axis=1)
    rig = np.mean(data["max_celsius"]["swept"], axis=1)
    assert rig - ours == pytest.approx([0, 0, 75, 75])
    cold, second, hot, last = (TABLE_6.max_celsius - 25) / (ours - 25)
    assert hot == pytest.approx(last, rel=0.06)
    # The cold rows are nearer to each other than a quarter of their distance to the hot rows.
    assert abs(cold - second) < 0.25 * (min(hot, last) - max(cold, second))
    bulk, level, _ = small("table6").findings
    assert not bulk.agrees
    assert "cold rows" in level.why
    assert "unexplained" in level.why


@pytest.mark.slow
def test_oil_a_wears_at_its_own_rates_and_has_one_critical_temperature(small, scenes):
    rates = np.array(small("inverse").data["wear_rate_of_oil_a"]).reshape(2, 2)
    expected_rates = [
        load_scene(scenes / f"{name}.toml").scene.wear.specific_wear_rate
        for name in ("oil_a", "oil_a_hot")
    ]
    # Widths are whole numbers of elements, which are twice as large here.
    assert np.sqrt(np.prod(rates, axis=1)) == pytest.approx(expected_rates, rel=0.02)
    temperatures = np.mean(small("inverse").data["critical_celsius"]["oil A"], axis=1)
    critical = load_scene(scenes / "oil_a.toml").conditions.critical_temperature - 273.15
    assert np.mean(temperatures) == pytest.approx(critical, abs=4)
    assert np.std(temperatures, ddof=1) < 15


def test_the_shipped_pages_show_what_the_command_gives_now(small, folder):
    """Only the result that takes a second is compared; the others take too long."""
    findings = small("fig4").findings  # this writes the pages
    names = "README.md", "REPRODUCING.md"
    shipped = [(WORKFLOWS / name).read_text(encoding="utf-8") for name in names]
    assert [(folder / "page" / name).read_text(encoding="utf-8") for name in names] == shipped
    (row,) = (finding for finding in findings if finding.name == "compensation")
    assert f"| {row.printed} | {row.computed}." in "".join(shipped)


def test_a_statement_that_differs_must_be_on_a_page(small):
    report = small("fig4")
    differing = [replace(finding, agrees=False) for finding in report.findings]
    with pytest.raises(InputError, match=r"fig4\.hertz differs from the paper"):
        pages([replace(report, findings=tuple(differing))])


def test_the_pages_show_all_results_and_no_statement_twice():
    gallery = (WORKFLOWS / "README.md").read_text(encoding="utf-8")
    page = (WORKFLOWS / "REPRODUCING.md").read_text(encoding="utf-8")
    blocks = re.findall(r"<!-- findings: (.*) -->", page + gallery)
    statements = " ".join(blocks).split()
    for name in paper.RESULTS:
        assert f"## {name}\n" in gallery
        assert f"]({name}.png)" in gallery
        assert 0 < (WORKFLOWS / f"{name}.png").stat().st_size < 200_000
        for statement in WORDS[name]["findings"]:
            assert statements.count(f"{name}.{statement}") <= 1
    assert (page + gallery).count("\n| [") == len(statements)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("fig44", {}, 'did you mean "fig4"'),
        ("table1", {}, "table1 is not recomputed: data of the test rig"),
        ("fig4", {"out": "a.gif"}, ".png"),
        ("fig4", {"scenes": "nowhere"}, "nowhere/fig4.toml: cannot be read"),
    ],
)
def test_wrong_use_is_named(name, options, message):
    with pytest.raises(tribo.TriboError, match=re.escape(message)):
        paper.reproduce(name, **options)


def test_the_command_takes_its_options_and_its_texts_are_kept(small, monkeypatch, capsys):
    assert main(["paper", "--list"]) == 0
    listed = capsys.readouterr().out
    report = replace(small("fig4"), seconds=0.0, file=Path("fig4.png"))
    reproduce = mock.Mock(return_value=report)
    with monkeypatch.context() as patched:
        patched.setattr(paper, "reproduce", reproduce)
        options = ["-o", "fig4.png", "--preset", "fine", "--surfaces", "2", "-j", "3"]
        assert main(["paper", "fig4", *options]) == 0
    reproduce.assert_called_once_with(
        "fig4", Path("fig4.png"), progress=mock.ANY, preset="fine", surfaces=2, workers=3
    )
    assert_as_kept("paper/command", {"list": listed, "fig4": capsys.readouterr().out})


def test_all_results_are_written_to_a_folder(tmp_path):
    (tmp_path / "file").touch()
    for path, message in (
        (tmp_path / "all.png", "to the file {}; name a folder"),
        (tmp_path / "file" / "page", "cannot write to {}: Not a directory"),
    ):
        with pytest.raises(InputError, match=re.escape(message.format(path))):
            paper.write_gallery(path)
