"""All refusals of figures: what causes each; tests/kept has what it says."""

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
    "kind": plot("pie"),
    "option": plot("diagram", show="time"),
    "its option": lambda: pipeline.plot(TRADE, log=True),
    "suffix": plot("diagram", "figure.gif"),
    "folder": plot("diagram", "no/figure.png"),
    "width": plot("diagram", width=0.01),
    "places": of_places,
    "one of a pair": plot("diagram", load=500.0),
    "dpi": plot("diagram", dpi=5),
    "rows of two": rows_of_two,
    "no rows": plot("rows"),
    "rows": rows_beyond,
    "scenes": of_scenes,
    "pins": lambda: pipeline.plot(two_pins(), "tests"),
    "no number": plot("diagram", load=float("nan")),
    "no tests": over_computed(),
    "begun tests": begun_tests,
}  # fmt: skip


refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "figures", REFUSALS
)
