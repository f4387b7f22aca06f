"""All refusals of figures: what causes each, and what its message says."""

from functools import cache

import pipeline
from pipeline.figures.tested import draw_tests
from pipeline.store.create import writing
from pipeline.store.schema import FAILED, PENDING
from pipeline.tradeoff.trade import Trade
from tests.helpers import synthetic, tiny
from tests.helpers.entries import bare_test, placed_rows
from tests.helpers.refusals import refusal_tests


@cache
def plane(**values):
    status = {(300.0, 1.5): FAILED, (750.0, 4.0): PENDING}
    return synthetic.sweep(status=status, fields=True, **values)


def plot(kind, *arguments, **options):
    return lambda: pipeline.plot(plane(), kind, *arguments, **options)


def of_places():
    with writing("a.zarr", tiny.sweep(variants=placed_rows((250.0, 1.0)))):
        pass
    return pipeline.plot("a.zarr", "diagram", log=True)


def of_scenes():
    several = pipeline.at(plane().isel(load=[0]), friction=(0.1, 0.12))
    return pipeline.plot(several, "diagram")


def begun():
    status = {(400.0, velocity): PENDING for velocity in synthetic.VELOCITIES}
    return pipeline.plot(synthetic.sweep(loads=[400.0], status=status), "ramp")


def over_computed(*measured, **values):
    return lambda: draw_tests(pipeline.results(synthetic.sweep(measured=measured, **values)))


def begun_tests():
    ds = synthetic.sweep(measured=(bare_test(600.0, 1.5),))
    return draw_tests(pipeline.results(synthetic.with_tests(ds, status=PENDING)))


TRADE = Trade("A scene", "scene.toml", (), (), ())

REFUSALS = {
    "kind": (plot("pie"), "kind is 'pie'; give one of diagram, ramp, fields"),
    "option": (plot("diagram", load=750.0), "diagram has no option 'load'; it has realization"),
    "its option": (lambda: pipeline.plot(TRADE, log=True), "has no option 'log'; it has none"),
    "suffix": (plot("diagram", "figure.gif"), "the suffix must be one of .pdf, .png, .svg"),
    "folder": (plot("diagram", "no/figure.png"), "there is no folder no"),
    "width": (plot("diagram", width=0.01), "width is 1 cm; it must be from 4 to 100 cm"),
    "places": (of_places, "so there is no plane of them; irg margin"),
    "scenes": (of_scenes, "needs at least two loads and two velocities"),
    "failed": (plot("ramp", load=300.0, velocity=1.5), "300 N, 1.5 m/s is not done: out of memory"),
    "pending": (plot("fields", velocity=4.0), "750 N, 4 m/s is not done; give another"),
    "begun": (begun, "no point at 400 N is done"),
    "load": (plot("fields", load=74.0), "load is 74 N; the sweep has 200 to 750 N: give a"),
    "velocity": (plot("fields", velocity=9.0), "velocity is 9 m/s; the sweep has 0.5 to"),
    "fields": (lambda: pipeline.plot(synthetic.sweep(), "fields"), "the sweep holds no fields"),
    "show": (plot("ramp", show="colour"), "show is 'colour'; stored at each step are"),
    "no tests": (over_computed(), "the scene has no tests to draw"),
    "begun tests": (begun_tests, "test 1 (transition, 600 N, 1.5 m/s) waits for its point"),
}  # fmt: skip


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "figures", REFUSALS, {"fields.fields InputError": "tests/pipeline/run/test_goal.py"}
)
