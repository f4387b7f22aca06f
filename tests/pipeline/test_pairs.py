"""Pairs: rows with places of their own, from their store to what each command says of them."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.analysis.dataset import dataset_of
from pipeline.analysis.margin_frame import judged
from pipeline.sweep.plan import points, run_point
from tests.helpers.entries import placed_rows
from tests.helpers.tiny import sweep
from tests.pipeline.conftest import commit_all

RADII = 6e-3, 8e-3


def table(loads=(300.0, 300.0)):
    labels = ({"gear": "a", "angle": 20.0}, {"gear": "b", "angle": 5.0})
    radii = ({"pin.radius": f"{one!r} m"} for one in RADII)
    return placed_rows(*zip(loads, (1.0, 1.0), labels, radii, strict=True))


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """Pairs; and pairs with another load, without the last point."""
    folder = tmp_path_factory.mktemp("pairs")
    with np.errstate(all="raise", under="ignore"):
        commit_all(folder / "alone.zarr", sweep(variants=table()))
        other = sweep(variants=table((300.0, 600.0)))
        commit_all(folder / "other.zarr", other, [*points(other)][1:])
    return {name: folder / f"{name}.zarr" for name in ("alone", "other")}


def margins_of(ds):
    """The margins of the rows."""
    return [one.known() for one in judged(dataset_of(ds), None)]


def test_margins_are_those_of_points(stores, irg):
    margins = margins_of(pipeline.at(stores["alone"], critical_temperature="90 degC"))
    assert [(one.load, one.velocity) for one in margins] == [(300.0, 1.0)] * 2
    for margin, radius in zip(margins, RADII, strict=True):
        pin = replace(sweep().scene.pin, radius=radius)
        verdict = run_point(sweep(pin=pin), 300.0, 1.0).verdict(sweep().conditions)
        assert margin.decisive_temperature == verdict.decisive_temperature
    said = irg("margin", stores["alone"], "--critical-temperature", "90 degC")
    assert said.startswith("2 operating points: ")


def test_a_page_of_pairs_answers_row_by_row(stores, tmp_path):
    table = pipeline.margin(stores["alone"])
    page = pipeline.explore(stores["alone"], tmp_path / "page.html").path.read_text("utf-8")
    for words in ("<p>2 ", "<h2>Operating points</h2>", "<td>b</td>", *table["verdict"]):
        assert words in page
    assert "Not known" not in page


def test_one_row_of_pairs_is_a_plane_of_one_point(stores):
    row = pipeline.at(stores["alone"], variant=1)
    margin = pipeline.margin(row, 300.0, 1.0)
    assert margin.distance == pipeline.margin(stores["alone"])["distance [K]"][1]
