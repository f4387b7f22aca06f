"""All refusals of answers: what causes each; tests/kept has what it says."""

from functools import cache

import numpy as np
import xarray as xr

import pipeline
from pipeline.answers.results import refuse_cases
from pipeline.store.schema import PENDING
from tests.helpers import synthetic
from tests.helpers.entries import bare_test
from tests.helpers.refusals import refusal_tests
from tests.pipeline.figures.test_planes import two_pins


@cache
def plane():
    ds = synthetic.sweep((200.0, 400.0, 600.0), (0.5, 1.0, 2.0), tests=())
    ds = ds.set_coords(["normal_load", "time", "sliding_distance"])  # as in a store
    return ds.drop_vars("message")


def margin_of(change):
    """Judge a point by the plane after a change of its dataset."""

    def judge():
        with xr.set_options(keep_attrs=True):
            return pipeline.margin(change(plane()), 500.0, 1.5)

    return judge


def with_attribute(name, **attributes):
    return margin_of(lambda ds: ds.assign({name: ds[name].assign_attrs(attributes)}))


def with_sweep(text):
    return margin_of(lambda ds: ds.drop_attrs().assign_attrs(sweep=text))


def boundary_of(select):
    return lambda: pipeline.boundary(select(plane()))


def margin(*point, **conditions):
    return lambda: pipeline.margin(plane(), *point, **conditions)


def for_radii(*radii):
    friction = xr.DataArray([0.1] * len(radii), {"pin_radius": [*radii]}, "pin_radius")
    return pipeline.margin(two_pins(), 500.0, 1.5, friction=friction)


def without_test_results():
    ds = synthetic.sweep(tests=(bare_test(400.0, 2.0),), critical_from_tests=True)
    return pipeline.infer(synthetic.with_tests(ds, status=PENDING))


def of_unlike_lengths():
    loads, frictions = (xr.DataArray([*x], dims="k") for x in ((300, 400), (0.1, 0.11, 0.12)))
    return pipeline.margin(plane(), loads, 1.5, friction=frictions)


def without_friction():
    ds = synthetic.sweep(tests=(), friction_heat=False)
    return pipeline.margin(ds, 500.0, 1.5, friction=0.1)


def few_quantiles():
    return pipeline.temperatures(plane().isel(area_fraction_below=[0, 1]))


def compared_for_another_oil():
    ds = synthetic.sweep(tests=(bare_test(400.0, 2.0),))
    return pipeline.compare_tests(ds, critical_temperature="160 degC")


def computed(ds):
    """The dataset as it is after `round`, which loses the encoding of variables."""
    ds = ds.assign(wall_time=xr.zeros_like(ds["status"], float))
    ds.variables["normal_load"].encoding["store"] = "results/plane.zarr"
    return ds


REFUSALS = {
    "tests of another oil": compared_for_another_oil,
    # datasets
    "no dataset": lambda: pipeline.margin(5),
    "no scene": margin_of(xr.Dataset.drop_attrs),
    "broken scene": with_sweep("{"),
    "another scene": with_sweep("{}"),
    "no status": margin_of(lambda ds: ds.drop_vars("status")),
    "float status": margin_of(lambda ds: ds.assign(status=ds["status"].astype(float))),
    "no rise": margin_of(lambda ds: ds.drop_vars("rise_quantile")),
    "celsius": with_attribute("rise_quantile", units="degC"),
    "stacked": margin_of(lambda ds: ds.stack(point=("load", "velocity"))),
    "no end": margin_of(lambda ds: ds.isel(step=slice(-1))),
    "one step": margin_of(lambda ds: ds.sel(step=0)),
    "one quantile": margin_of(lambda ds: ds.sel(area_fraction_below=0.9)),
    "left out": margin_of(lambda ds: ds.isel(area_fraction_below=[0, -1])),
    "no load": margin_of(lambda ds: ds.drop_vars("load")),
    "endless load": margin_of(lambda ds: ds.assign_coords(load=[200.0, 400.0, np.inf])),
    "descending": margin_of(lambda ds: ds.isel(load=[1, 0])),
    "nearly equal": margin_of(lambda ds: ds.assign_coords(load=[200.0, 600.0, 600.01])),
    "other load": margin_of(lambda ds: ds.assign_coords(load=[200.0, 410.0, 600.0])),
    # results that xarray moved, or that are left out
    "rolled": margin_of(lambda ds: ds.roll(velocity=1)),
    "falling": margin_of(lambda ds: ds.roll(area_fraction_below=1)),
    "swapped": margin_of(lambda ds: ds.assign_coords(v=2 * ds["velocity"]).swap_dims(velocity="v")),
    "computed": margin_of(computed),
    "other times": margin_of(lambda ds: ds.assign_coords(time=2 * ds["time"])),
    # cases
    "cases": lambda: refuse_cases(two_pins()),
    "no radius": lambda: pipeline.margin(two_pins().isel(pin_radius=0, drop=True), 500.0, 1.5),
    "other radius": lambda: pipeline.margin(
        two_pins().assign_coords(pin_radius=[1e-3, 3e-3]), 500.0, 1.5),
    "one radius": lambda: for_radii(1e-3),
    # points and conditions
    "one load": boundary_of(lambda ds: ds.sel(load=400.0)),
    "polars": margin(type("DataFrame", (), {"__module__": "polars", "to_pandas": None})()),
    "load alone": margin(400.0),
    "no point": margin(),
    "unlike lengths": of_unlike_lengths,
    "empty": margin([], 2.0),
    "nested": margin([[1.0]], 2.0),
    "unknown": margin(fricton=0.1),
    "twice": margin(400.0, 2.0, friction=[0.1, 0.1]),
    "several": lambda: pipeline.infer(plane(), friction=[0.1, 0.2]),
    "cold": margin(400.0, 2.0, bulk_temperature=25),
    "without heat": without_friction,
    "quantiles": few_quantiles,
    "no result": without_test_results,
}  # fmt: skip

ELSEWHERE = {
    "answers.boundary InputError",  # of a table of rows, in test_outside
}

refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "answers", REFUSALS, ELSEWHERE
)
