"""Boundary mode: a store that holds the boundary, for a fraction of the grid's work."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.analysis.curve import Curve
from pipeline.store.place import StoreError
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point, tasks
from pipeline.sweep.severity import momentary_rise, rise_limit
from tests.helpers.accuracy_scenes import PAPER
from tests.helpers.answers import crossings
from tests.helpers.entries import changed
from tribo import Fidelity, Grid
from tribo.simulation import Trunks

TOLERANCE = 0.01
# Without roughness the rise is a smooth function, and a point takes milliseconds.
SWEEP = changed(
    PAPER,
    roughness=None,
    pixels=Grid((96, 48), (4e-6, 4e-6)),
    fidelity=Fidelity(pixels_per_element=1, increments=15),
    conditions=replace(PAPER.conditions, critical_temperature=371.0),
    loads=tuple(float(load) for load in range(200, 751, 110)),
    velocities=tuple(float(velocity) for velocity in np.arange(0.5, 5.01, 0.25)),
)


def follow(sweep, out, **options):
    return pipeline.run_sweep(sweep, out, **{"workers": 1, "boundary_only": TOLERANCE} | options)


@pytest.fixture(scope="module")
def grid():
    """Critical velocities [m/s] by load, from every point of the sweep."""
    rises = {}
    trunks = Trunks()
    for task in tasks(points(SWEEP), SWEEP):
        for result in [run_point(SWEEP, task.point, trunks)]:
            rises[result.point] = momentary_rise(SWEEP.scene, result.state, SWEEP.conditions)
    velocities = np.array(SWEEP.plane.velocities)
    return [
        crossings(
            Curve(velocities, np.array([rises[Point(load, velocity)] for velocity in velocities])),
            rise_limit(SWEEP.conditions),
        )[0]
        for load in SWEEP.plane.loads
    ]


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    out = tmp_path_factory.mktemp("followed") / "followed.zarr"
    outcome = follow(SWEEP, out)
    assert outcome.computed == outcome.done == outcome.total
    return out


def test_the_boundary_is_that_of_the_grid_for_a_fifth_of_its_points(grid, followed):
    ds = pipeline.open_sweep(followed)
    velocities = pipeline.boundary(ds)["critical_velocity"].values
    # The boundary of the grid is interpolated, too, with an error of about 0.1 %.
    assert velocities == pytest.approx(grid, rel=TOLERANCE + 0.002)
    assert pipeline.summary(followed).done <= len(points(SWEEP)) / 5


def test_the_store_is_one_like_any_other(followed):
    ds = pipeline.open_sweep(followed)
    counts = pipeline.summary(followed)
    assert (counts.total, counts.pending, counts.failed) == (counts.done, 0, ())
    assert counts.done < ds["status"].size  # the store has room for more points
    result = pipeline.boundary(ds)
    assert result.attrs["missing_points"] == 0
    # It also answers for other conditions, where the boundary is still between its points.
    warmer = pipeline.boundary(pipeline.at(ds, friction=0.102))["critical_velocity"]
    assert np.isfinite(warmer).sum() > len(SWEEP.plane.loads) / 2
    assert ds["velocity"].min() >= 0.5
    assert ds["velocity"].max() <= 5.0


def test_it_ends_at_once_where_the_boundary_is_known(followed):
    again = follow(SWEEP, followed)
    assert again.computed == 0
    looser = follow(SWEEP, followed, boundary_only=0.05)
    assert looser.computed == 0


def test_a_search_that_was_stopped_goes_on_to_the_same_store(followed, tmp_path):
    out = tmp_path / "stopped.zarr"

    def stop(progress):
        if progress.done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        follow(SWEEP, out, progress=stop)
    stopped = pipeline.summary(out)
    assert 0 < stopped.done <= stopped.total
    follow(SWEEP, out)
    one, other = (
        pipeline.boundary(pipeline.open_sweep(path))["critical_velocity"].values
        for path in (out, followed)
    )
    assert one == pytest.approx(other, rel=TOLERANCE)


def test_a_grid_that_is_there_is_used(tmp_path):
    out = tmp_path / "grown.zarr"
    few = changed(SWEEP, loads=SWEEP.plane.loads[:1], velocities=(4.0, 4.5, 5.0))
    pipeline.run_sweep(few, out, workers=1)
    asked, searched = changed(few, velocities=SWEEP.plane.velocities), tmp_path / "searched.zarr"
    outcome = follow(asked, searched, source=out)
    assert outcome.computed == 0
    assert outcome.done == 3
    # A search can be completed to the whole sweep later.
    whole = pipeline.run_sweep(few, tmp_path / "whole.zarr", workers=1, source=searched)
    assert (whole.total, whole.computed) == (3, 0)
    for sweep, other in ((asked, out), (few, searched)):
        with pytest.raises(StoreError, match="a plane and a search of its boundary have a store"):
            pipeline.run_sweep(sweep, other, boundary_only=TOLERANCE if other == out else None)
