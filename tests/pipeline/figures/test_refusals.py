"""All refusals of figures: what causes each, and what its message says."""

from functools import cache

import pipeline
from pipeline.figures.rows_figure import draw_rows
from pipeline.run.trade import Trade
from pipeline.store.create import writing
from pipeline.store.schema import FAILED, PENDING
from tests.helpers import synthetic, tiny
from tests.helpers.entries import bare_test, placed_rows
from tests.helpers.refusals import refusal_tests
from tests.pipeline.figures.test_planes import two_pins


@cache
def plane(**values):
    status = {(300.0, 1.5): FAILED, (750.0, 4.0): PENDING}
    return synthetic.sweep(status=status, fields=True, **values)


def plot(kind, *arguments, **options):
    return lambda: pipeline.plot(plane(), kind, *arguments, **options)


def of_places():
    with writing("a.zarr", tiny.sweep(case_table=placed_rows((250.0, 1.0)))):
        pass
    return pipeline.plot("a.zarr", "diagram", log=True)


def rows_of_two():
    with writing("b.zarr", tiny.sweep(case_table=placed_rows((250.0, 1.0)))):
        pass
    return pipeline.plot("b.zarr", friction=[0.1, 0.12])


def of_scenes():
    return pipeline.plot(plane().isel(load=[0]), "diagram", friction=[0.1, 0.12])


def over_computed(*measured, **values):
    return lambda: pipeline.plot(synthetic.sweep(tests=measured, **values), "tests")


def begun_tests():
    ds = synthetic.sweep(tests=(bare_test(600.0, 1.5),))
    return pipeline.plot(synthetic.with_tests(ds, status=PENDING), "tests")


def rows_beyond():
    return draw_rows(pipeline.margin(plane(), [9000.0], [1.0]), "")


TRADE = Trade("A scene", (), ())

REFUSALS = {
    "kind": (plot("pie"), "unknown kind 'pie'; choose one of diagram, rows, tests"),
    "option": (plot("diagram", show="time"), "no option 'show'; available: log"),
    "its option": (lambda: pipeline.plot(TRADE, log=True), "has no option 'log'; available: none"),
    "suffix": (plot("diagram", "figure.gif"), "the file name must end in one of .pdf, .png, .svg"),
    "folder": (plot("diagram", "no/figure.png"), "the folder no does not exist"),
    "width": (plot("diagram", width=0.01),
              'width: "0.01 m" is outside the allowed range, which is 4 cm to 100 cm'),
    "places": (of_places, "so there is no plane of them; irg margin"),
    "one of a pair": (plot("diagram", load=500.0), "loads (1) and velocities (0) cannot be paired"),
    "dpi": (plot("diagram", dpi=5), "dpi is 5; it must be from 30 to 1200"),
    "rows of two": (rows_of_two, "cannot draw rows under several conditions"),
    "no rows": (plot("rows"), "the sweep has no rows, each with its own load; irg plot draws its"),
    "rows": (rows_beyond, "no row has a verdict: load 9000 N is outside"),
    "scenes": (of_scenes, "needs at least two loads and two velocities"),
    "pins": (lambda: pipeline.plot(two_pins(), "tests"), "select one by pin_radius"),
    "no number": (plot("diagram", load=float("nan")), 'load: "nan N" is not a number with a unit'),
    "no tests": (over_computed(), "the scene has no tests to draw"),
    "begun tests": (begun_tests, "test 1 (transition, 600 N, 1.5 m/s) has not been simulated yet"),
}  # fmt: skip


refusals, test_each_is_named, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "figures", REFUSALS
)
