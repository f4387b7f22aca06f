"""The diagram of rows with places of their own: each margin is that of the answer."""

import numpy as np
import pytest

import pipeline
from pipeline.sweep.plan import points
from tests.helpers import tiny
from tests.helpers.entries import placed_rows
from tests.pipeline.conftest import commit_all
from tests.pipeline.figures.test_plot import labels, lines

NAMES = ("first run", "second", "third", "last")


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Four rows with names, of which the last one is pending."""
    places = zip((250.0, 600.0, 400.0, 300.0), (0.5, 3.0, 1.0, 1.0), strict=True)
    named = zip(places, NAMES, strict=True)
    table = placed_rows(*((*place, {"name": name}, {}) for place, name in named))
    sweep = tiny.sweep(variants=table)
    path = tmp_path_factory.mktemp("rows") / "rows.zarr"
    with np.errstate(all="raise", under="ignore"):
        commit_all(path, sweep, skip=[points(sweep)[-1]])
    return pipeline.open_sweep(path)


def test_each_row_stands_at_its_margin_with_its_error_and_its_name(rows):
    (axes,), answers = pipeline.plot(rows).axes, pipeline.margin(rows)
    names = {"mild": "mild wear", "severe": "severe wear", "not decided": "not decided",
             "not known": "not known: not computed"}  # fmt: skip
    assert answers["verdict"].iloc[-1] == "not known"
    marks = lines(axes)
    for place, (verdict, margin) in enumerate(answers[["verdict", "distance [K]"]].to_numpy()):
        height = 0.0 if verdict == "not known" else margin
        assert [place, pytest.approx(height)] in marks[names[verdict]].tolist()
    (bars,) = axes.containers
    heights = [np.ptp(ends[:, 1]) for ends in bars.lines[2][0].get_segments()]
    errors = np.nan_to_num(answers["temperature error [K]"].to_numpy(float))
    assert heights == pytest.approx(2 * errors)
    assert [one.get_text() for one in axes.get_xticklabels()] == [*NAMES]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("name", "margin to severe wear [K]")
    assert {"critical temperature", "error of the margin"} < {*labels(axes.figure.legends[0])}
