"""Mild load factors of rows, on rises that are known in closed form."""

import html
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import pipeline
from pipeline.answers.facts import load_factor_lines
from pipeline.store.schema import PENDING
from pipeline.sweep.case import Uncertainty
from tests.helpers import synthetic
from tests.helpers.answer_at import named
from tests.helpers.entries import bare_test, placed_rows
from tests.helpers.sweeps import attributes_of

FACTORS = (0.5, 0.75, 1.0, 1.25)
ROWS = ((300.0, 0.8), (250.0, 1.5), (180.0, 2.5), (150.0, 4.0))  # N, m/s
LIMIT, SIDE = synthetic.limit(), "mild_load_factor_side"


def rows_of(rows=ROWS, factors=FACTORS, rise=synthetic.rise, waiting=(), **options):
    """Dataset of rows, each (load, velocity), at shares of their loads; some are `waiting`."""
    labels = "ABCDEFGH"[: len(rows)]
    places = ((*row, {"place": label}) for row, label in zip(rows, labels, strict=True))
    table = placed_rows(*places, load_factors=factors)
    loads = [table.loads_of(row) for row in table.rows]
    plane = {"loads": tuple(sorted({*np.ravel(loads)})), "velocities": (0.8, 4.0)}
    parts = []
    for row, row_loads in zip(table.rows, loads, strict=True):
        status = dict.fromkeys(
            [(load, row["velocity"]) for load in row_loads if row["place"] in waiting], PENDING
        )
        part = synthetic.sweep(row_loads, [row["velocity"]], rise, status, **options)
        part = part.isel(velocity=0).assign_coords(load_factor=("load", [*factors]))
        part = part.swap_dims(load="load_factor").assign_coords(place=row["place"])
        parts.append(part)
    numbers = xr.DataArray(range(len(rows)), dims="case", name="case")
    ds = xr.concat(parts, numbers, coords="different", compat="equals", join="outer",
                   combine_attrs="override")  # fmt: skip
    return ds.assign_attrs(attributes_of(synthetic.scene(case_table=table, **options, **plane)))


def margins_of(ds, **conditions):
    """Margins of rows, with the codes of verdicts and sides as text."""
    answer = pipeline.margin(ds, **conditions)
    return answer.assign(
        {name: answer[name].copy(data=named(answer[name])) for name in ("verdict", SIDE)}
    )


@pytest.mark.parametrize("tests", [(), synthetic.MEASURED])
@pytest.mark.parametrize("rise", [synthetic.rise, synthetic.uneven(4)])
def test_a_row_is_mild_just_below_its_mild_load_factor_and_not_just_above(rise, tests):
    """At 60 random conditions; a row without a limit is judged at an end of its load factors."""
    ds, rng = rows_of(rise=rise, tests=tests), np.random.default_rng(7)
    frictions, bulks = rng.uniform((0.05, 280.0), (0.25, 340.0), (60, 2)).T
    conditions = {
        "friction": xr.DataArray(frictions, dims="draw"),
        "bulk_temperature": xr.DataArray(bulks.round(-1), dims="draw"),  # each with a posterior
    }
    answer = margins_of(ds, **conditions)
    for row, (load, velocity) in enumerate(ROWS):
        case = answer.isel(case=row)
        side, factor = case[SIDE].values, case["mild_load_factor"].values
        assert (np.isfinite(factor) == (side == "inside")).all()
        end = np.where(side == "above", FACTORS[-1], FACTORS[0])
        beside = np.clip(np.multiply.outer((0.999, 1.001), factor), FACTORS[0], FACTORS[-1])
        factors = np.where(side == "inside", beside, end)
        loads = xr.DataArray(load * factors, dims=("side", "draw"))
        judged = pipeline.margin(ds.isel(case=row), loads, velocity, **conditions)
        is_mild = named(judged["verdict"].transpose("side", "draw")) == "mild"
        assert (is_mild == [side != "below", side == "above"]).all()
    assert {"inside", "above", "below"} == {*np.ravel(answer[SIDE])}


def test_without_errors_the_mild_load_factor_is_that_of_the_closed_form():
    ds = rows_of(tests=(), model_bias=0.0, model_scatter=0.001)
    for friction in (0.08, 0.1, 0.12):
        answer = margins_of(ds, friction=friction)
        for (load, velocity), factor in zip(ROWS, answer["mild_load_factor"].values, strict=True):
            exact = synthetic.critical_load(velocity, synthetic.limit(friction)) / load
            if 0.55 < exact < 1.2:
                assert 0.9 * exact < factor < exact  # below it by the numerical error
    assert answer["mild_load_factor"].notnull().any()


def test_a_plane_of_loads_and_velocities_gives_the_same_factor():
    load, velocity = ROWS[1]
    answer = margins_of(rows_of(), friction=0.14)
    plane = synthetic.sweep([factor * load for factor in FACTORS], (1.0, 1.5, 2.0, 3.0))
    expected = pipeline.margin(plane, load, velocity, friction=0.14)
    assert answer["governing_temperature"][1].item() == pytest.approx(
        expected["governing_temperature"].item()
    )
    assert answer["mild_load_factor"][1].item() == pytest.approx(
        expected["load_safety_factor"].item(), rel=0.03
    )


def test_the_row_itself_has_the_answer_of_a_sweep_without_load_factors():
    answer, alone = margins_of(rows_of()), pipeline.margin(rows_of().sel(load_factor=1.0))
    for name in ("probability", "governing_temperature", "temperature_error", "mild_friction"):
        np.testing.assert_array_equal(answer[name], alone[name])
    assert "mild_load_factor" not in alone
    assert answer["load"].values.tolist() == [load for load, _ in ROWS]


@pytest.mark.parametrize(
    ("friction", "line"),
    [
        (0.02, "mild load factor of all rows: above 1.25; D governs, "),
        (0.6, "mild load factor of all rows: below 0.5; D governs, "),
    ],
)
def test_beyond_the_simulated_factors_the_limit_of_the_rows_is_stated_in_words(friction, line):
    answer = pipeline.margin(rows_of(), friction=friction)
    (text,) = load_factor_lines(answer)
    assert text == f"{line}at unchanged bulk temperature and friction"
    assert answer["mild_load_factor"].isnull().all()


def test_the_words_beyond_the_ends_are_the_factors_of_the_scene_whatever_the_loads():
    ds = rows_of(((297.7, 0.8), (133.3, 3.9), (89.27, 2.1)), (0.35, 0.7, 1.0, 1.1))
    for friction, words in ((0.01, "above 1.1"), (0.9, "below 0.35")):
        answer = pipeline.margin(ds, friction=friction)
        assert f"of all rows: {words}; " in next(load_factor_lines(answer))


def test_the_row_with_the_smallest_mild_load_factor_governs():
    answer = pipeline.margin(rows_of(), friction=[0.09, 0.1])
    assert answer["governs"].dims == ("case", "friction")
    hottest = np.argmin([synthetic.critical_load(v, LIMIT) / load for load, v in ROWS])
    assert answer["governs"].argmax("case").values.tolist() == [hottest, hottest]
    assert answer["governs"].sum("case").values.tolist() == [1, 1]
    smallest = answer["mild_load_factor"].min("case").values
    lines = [*load_factor_lines(answer)]
    for line, factor, friction in zip(lines, smallest, (0.09, 0.1), strict=True):
        start, _, rest = line.partition(": ")
        assert start == f"mild load factor of all rows with friction {friction:g}"
        printed = float(rest.partition(";")[0])
        assert factor - 0.01 < printed <= factor
        assert "D governs" in rest


def test_rows_without_a_result_have_no_mild_load_factor():
    answer = pipeline.margin(rows_of(waiting="D"))
    assert named(answer[SIDE]).tolist()[-1] == "unknown"
    (line,) = load_factor_lines(answer)
    assert line.startswith("mild load factor of 3 of 4 rows: ")
    assert not answer["governs"][-1]
    nothing = pipeline.margin(rows_of(waiting="ABCD"))
    assert [*load_factor_lines(nothing)] == ["mild load factor: no row has one"]


def test_uncertain_inputs_lower_the_mild_load_factor():
    uncertainty = (Uncertainty(("friction.coefficient",), 0.3),)
    plain, uncertain = (
        margins_of(rows_of(rows=ROWS[2:3], tests=(), **options))["mild_load_factor"].item()
        for options in ({}, {"uncertainty": uncertainty})
    )
    assert uncertain < 0.95 * plain


def test_one_row_states_its_own_factor_and_a_load_outside_the_factors_is_unknown():
    row = rows_of().isel(case=3)
    (line,) = load_factor_lines(pipeline.margin(row))
    assert re.match(r"mild load factor: 1\.0\d, at unchanged", line)
    outside = pipeline.margin(row, 50.0, 4.0)
    assert named(outside["verdict"]) == "unknown"
    assert outside["reason"].item() == (
        "load 50 N is outside the sweep (75 to 187.5 N); add a factor to sweep.load_factors, and "
        "run the scene again"
    )


def test_a_test_of_a_specimen_that_rules_mild_wear_out_limits_the_mild_load_factor():
    ruling = bare_test(80.0, 2.0, outcome="severe", number="weak")
    plain, ruled = (margins_of(rows_of(rows=ROWS[2:3], tests=tests)) for tests in ((), (ruling,)))
    assert plain[SIDE].item() == "inside"
    assert ruled[SIDE].item() == "below"


# Figure, report and command


def test_the_figure_of_rows_has_a_bar_up_to_each_mild_load_factor():
    ds = rows_of()
    answer = margins_of(ds, friction=0.1)
    panel = pipeline.plot(ds, "rows", friction=0.1).axes[1]
    ends = {"above": 1.25, "below": 0.0}
    expected = [
        ends.get(side, factor)
        for side, factor in zip(
            answer[SIDE].values.tolist(), answer["mild_load_factor"].values.tolist(), strict=True
        )
    ]
    bars = [bar.get_width() for bar in panel.containers[0]]
    assert bars == pytest.approx(expected)
    assert {"above", "inside"} <= {*answer[SIDE].values.tolist()}
    assert len(pipeline.plot(ds.sel(load_factor=1.0), "rows").axes) == 1


def test_text_json_csv_and_report_have_the_factor_of_each_row(irg, monkeypatch, tmp_path):
    ds = rows_of()
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: ds)
    answer, printed = margins_of(ds), irg("margin", "rows.zarr")
    (line,) = load_factor_lines(pipeline.margin(ds))
    for text in (" ".join(printed.split()), html.unescape(pipeline.report(ds))):
        assert line[1:] in text
        assert "above 1.25" in text
    rows = irg("margin", "rows.zarr", "--json")
    irg("margin", "rows.zarr", "-o", tmp_path / "rows.csv")
    table = pd.read_csv(tmp_path / "rows.csv")
    for column in ([row["mild load factor"] for row in rows], table["mild load factor"]):
        values = np.array([*column], float)
        np.testing.assert_allclose(values, answer["mild_load_factor"], rtol=1e-12)
    assert [row["governs"] for row in rows] == answer["governs"].values.tolist()
    assert table["mild load factor side"].tolist() == answer[SIDE].values.tolist()


def test_conditions_along_place_apply_to_rows_that_have_a_column_of_this_name():
    rows, frictions = rows_of(), xr.DataArray([0.08, 0.12], dims="place")
    answer = pipeline.margin(rows, friction=frictions)
    assert answer["place (given)"].values.tolist() == [*"ABCD"]
    for name in ("mild_load_factor", "governing_temperature", "friction"):
        for k, friction in enumerate(frictions.values.tolist()):
            expected = pipeline.margin(rows, friction=friction)[name]
            part = answer[name].isel(place=k).transpose(*expected.dims)
            np.testing.assert_allclose(part, expected, rtol=1e-12)
