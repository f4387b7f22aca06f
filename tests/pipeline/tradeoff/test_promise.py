"""What `--accuracy` promises, on every scene that we keep and on windows of full size."""

import functools
from dataclasses import replace
from pathlib import Path

import pytest

import pipeline
from pipeline.sweep.criterion import boundary_velocity_error
from pipeline.tradeoff.choose import choose_fidelity
from pipeline.tradeoff.probe import fitted, near_the_boundary, probe
from tests.helpers.kept import ALUMINA, SCENES
from tribo import PRESETS, Cylinder, Grid, SelfAffineRoughness

SHIPPED = pipeline.load_scene(Path(__file__).parents[3] / "workflows" / "irg_transition.toml")
LARGE = {
    "shipped": SHIPPED,
    "shipped, another radius": replace(
        SHIPPED,
        pin=Cylinder(5e-3, 3.4e-3, SHIPPED.disk),
        pixels=Grid((480, 240), (1.3e-6, 1.9e-6), (False, True)),
    ),
    "shipped, another surface": replace(
        SHIPPED, roughness=SelfAffineRoughness(0.4e-6, 0.7, (6e-6, 12e-6), seed=5)
    ),
    "shipped, other loads and pin": replace(
        SHIPPED,
        pin=Cylinder(2e-3, 3.4e-3, ALUMINA),
        loads=tuple(float(load) for load in range(100, 301, 25)),
        pixels=Grid((480, 240), (0.6e-6, 0.95e-6), (False, True)),
    ),
}
ALL = SCENES | LARGE


@functools.cache
def truth(name):
    """The reference at every load of a scene, and where that is."""
    sweep = ALL[name]
    points, exponents = near_the_boundary(sweep, sweep.loads)
    return points, exponents, probe(sweep, fitted(sweep, PRESETS["reference"]), points)


@functools.cache
def true_error(name, fidelity):
    points, exponents, reference = truth(name)
    found = probe(ALL[name], fidelity, points)
    return max(
        abs(boundary_velocity_error(one.rise, true.rise, exponent))
        for one, true, exponent in zip(found.readings, reference.readings, exponents, strict=True)
    )


def kept(name, accuracy):
    """What was picked, and the true error, within what was asked for and what was foretold."""
    selection = choose_fidelity(ALL[name], accuracy)
    error = true_error(name, selection.fidelity)
    assert error <= selection.error + 1e-9 <= accuracy + 1e-9
    return selection, error


@pytest.mark.parametrize("name", ["no wear", "other materials", "smooth"])
def test_the_true_error_is_within_what_was_asked_for(name):
    kept(name, 0.02)


def test_what_may_err_more_costs_no_more():
    loose, strict = (kept("other materials", accuracy)[0] for accuracy in (0.05, 0.02))
    assert loose.saving >= strict.saving


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", [0.05, 0.02, 0.01])
@pytest.mark.parametrize("name", ALL)
def test_the_true_error_is_within_every_accuracy(name, accuracy, say):
    selection, error = kept(name, accuracy)
    work = truth(name)[2].work / len(truth(name)[0])
    say(
        f"\n{name:30} {100 * accuracy:g} %: {selection.name:38} foretold "
        f"{100 * selection.error:.2f} %, true {100 * error:.2f} %, {selection.saving:6.1f} times "
        f"less work than {selection.yardstick}; the probe took {selection.seconds:.0f} s, the work "
        f"of {selection.work / work:.1f} points of the reference"
    )
