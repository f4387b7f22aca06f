"""All refusals of accuracies and their trade-off: what causes each, and what its message says."""

from dataclasses import replace

import pipeline
from pipeline.store.create import writing
from pipeline.tradeoff.choose import choose_accuracy, choose_fidelity
from pipeline.tradeoff.trade import trade
from tests.helpers import synthetic, tiny
from tests.helpers.entries import changed
from tests.helpers.refusals import refusal_tests

PAPER = pipeline.load_scene("irg_transition")
COLD = changed(PAPER, conditions=replace(PAPER.conditions, friction=0.0))


def stored(**values):
    """Function that asks for an accuracy of 2 % with a store that exists."""

    def build():
        sweep = tiny.sweep(**values)
        with writing("a.zarr", sweep):
            pass
        return choose_accuracy(sweep, 0.02, store="a.zarr")

    return build


def vary_by(path, present):
    """Vary an entry of a scene by +20 %; the scene gives it the value `present`."""
    return pipeline.vary("first_try", {path: ["+20%"]}, overrides={path: present})


REFUSALS = {
    "no accuracy": (lambda: choose_fidelity(PAPER, 0.0), "accuracy is 0.0; it must be between 0"),
    "share": (lambda: choose_fidelity(PAPER, "two"), '"two": give a share such as'),
    "no friction": (lambda: choose_fidelity(COLD, 0.02), "friction is 0, so there is no boundary"),
    "own": (stored(), "was computed with the scene's own fidelity"),
    "coarser": (stored(selection=synthetic.selection(error=0.05)), "boundary may be off by 5 %"),
    "preset": (lambda: trade(PAPER, ("fast",)), "preset 'fast' is unknown; give one of draft"),
    "no number": (lambda: pipeline.vary("first_try", {"pin.shape": ["+5%"]}),
                  "pin.shape=+5%: the scene gives cylinder, no number; give a value"),
    "no digit": (lambda: vary_by("title", ".."), "title=+20%: the scene gives .., no number"),
    "of degrees": (lambda: vary_by("temperature.bulk", "25 degC "), "gives 25 degC , no number"),
    "of degrees in words": (lambda: vary_by("temperature.bulk", "25 celsius"), "gives 25 celsius"),
    "of Rockwell": (lambda: vary_by("materials.steel.hardness", "60 HRc"), "gives 60 HRc, no"),
    "no velocity": (lambda: trade(changed(PAPER, velocities=(0.0,))), "no velocity above 0"),
}  # fmt: skip

ELSEWHERE = {
    "choose.choose_fidelity ConvergenceError": "test_choice_of_readings",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "tradeoff", REFUSALS, ELSEWHERE
)
