"""Friction by temperature element by element, beside a plain iteration with damping."""

import dataclasses
import math

import numpy as np
import pytest

import tribo
from tests.helpers import tiny
from tribo.simulation.coupled_friction import coupled_heat
from tribo.thermal import ConductingHalfSpace, contact_quantiles, partition_heat

BULK, LOAD, VELOCITY = 298.15, 600.0, 1.5
_CLOSE = 0.1  # [K], a third of the promised error: iteration may stop at 2e-4 of some 120 K


def line(slope):
    """Friction curve that changes linearly with temperature, by `slope` per kelvin."""
    return ((BULK, 1.0), (BULK + 150.0, 1.0 + 150.0 * slope))


CURVES = {
    "falls": line(-0.002),
    "rises": line(0.002),
    "falls much": line(-0.005),
    "bump": ((300.0, 1.0), (380.0, 1.6), (460.0, 0.6)),
    "step up": ((370.0, 1.0), (375.0, 1.15)),
    "step down": ((370.0, 1.0), (385.0, 0.7)),
}
JUMP = ((400.0, 1.0), (405.0, 3.0))


def scene(**fidelity):
    return tiny.sweep(fidelity={"history_coarsening": 1, **fidelity}).scene


def end(system):
    *_, state = tribo.simulate(system, LOAD, VELOCITY)
    return state


def iterated(system, state, curve, added=0.0):
    """Rise [K] exceeded by a tenth of the contact, by plain iteration in small steps."""
    contact, length = state.pressure > 0, system.pin.length
    bodies = [
        ConductingHalfSpace(system.grid, body, velocity, state.time, length=length)
        for body, velocity in ((system.pin.material, 0.0), (system.disk, VELOCITY))
    ]
    rise, unit = np.zeros(system.grid.shape), VELOCITY * state.pressure
    for _ in range(2000):
        friction = 0.1 * np.interp(BULK + rise, *np.array(curve).T)
        new = partition_heat(*bodies, friction * unit, contact).rise
        new += added * (friction * unit).sum() / unit.sum()
        moved = np.abs(new - rise)[contact].max()
        rise += 0.2 * (new - rise)
        if moved < 1e-4:
            break
    assert moved < 1e-4
    return contact_quantiles(rise, contact)[tribo.QUANTILES.index(0.9)]


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
@pytest.mark.parametrize("added", [0.0, 150.0])
def test_all_elements_heat_each_other(curve, added):
    system = scene()
    state, law = end(system), tribo.Friction(0.1, by_temperature=curve)
    found = coupled_heat(system, state, VELOCITY, law, BULK, added)
    assert found.outcome == "solved"
    exceeded = found.rise_quantile[tribo.QUANTILES.index(0.9)]
    assert exceeded == pytest.approx(iterated(system, state, curve, added), abs=_CLOSE)
    assert found.mean_rise < exceeded < found.rise_quantile[-1]


def test_a_contact_that_ignites_is_not_followed_to_its_hot_state():
    system = scene()
    state, law = end(system), tribo.Friction(0.1, by_temperature=JUMP)
    found = coupled_heat(system, state, VELOCITY, law, BULK)
    assert found.outcome == "ignites"
    assert np.isnan(found.rise_quantile).all()
    assert found.partitions <= 12
    cold = 0.1 * state.heat.rise_quantile[tribo.QUANTILES.index(0.9)]
    assert iterated(system, state, JUMP) > 1.5 * cold


def oil(curve, critical, **parts):
    friction = tribo.Friction(by_temperature=curve)
    return tribo.Conditions(
        friction=0.1,
        bulk_temperature=BULK,
        critical_temperature=critical,
        corrections=tribo.Corrections(friction=friction, **parts),
    )


def by_equation_1(system, conditions):
    """Deciding temperature [K] if each element's friction depends only on its own temperature."""
    state = end(system)
    rise = state.heat.rise_quantile[tribo.QUANTILES.index(0.9)]
    return conditions.contact_temperature(rise)


def test_a_verdict_that_hangs_on_friction_has_the_solved_temperature():
    system, conditions = scene(), oil(CURVES["bump"], 420.0)
    found = tribo.judge(system, LOAD, VELOCITY, conditions)
    solved = BULK + iterated(system, end(system), CURVES["bump"])
    assert found.decisive_temperature == pytest.approx(solved, abs=_CLOSE)
    assert abs(by_equation_1(system, conditions) - solved) > 10 * _CLOSE
    assert found.is_severe == (solved > 420.0)
    nearly = dataclasses.replace(conditions, critical_temperature=solved + 2 * _CLOSE)
    assert not tribo.judge(system, LOAD, VELOCITY, nearly).is_severe
    exceeded = dataclasses.replace(conditions, critical_temperature=solved - 2 * _CLOSE)
    assert tribo.judge(system, LOAD, VELOCITY, exceeded).is_severe


@pytest.mark.parametrize("critical", [330.0, 700.0])
def test_a_verdict_far_from_the_limit_does_not(critical):
    system, conditions = scene(), oil(CURVES["rises"], critical)
    found = tribo.judge(system, LOAD, VELOCITY, conditions)
    expected = by_equation_1(system, conditions)
    assert found.decisive_temperature == pytest.approx(expected, rel=1e-12)
    assert found.friction is None


def test_a_contact_that_ignites_is_judged_at_its_highest_friction():
    system, plain = scene(), oil((), None)
    cold, critical = by_equation_1(system, plain), 450.0
    assert cold < critical
    found = tribo.judge(system, LOAD, VELOCITY, oil(JUMP, critical))
    assert (found.is_severe, found.friction) == (True, "ignites")
    hottest = BULK + 3.0 * (cold - BULK)
    assert found.decisive_temperature == pytest.approx(hottest)
    assert not tribo.judge(system, LOAD, VELOCITY, oil(JUMP, hottest + 1.0)).is_severe


def test_a_stem_warms_the_friction_too():
    stem = tribo.Stem(8.0)
    system, conditions = scene(), oil(CURVES["falls"], None, stem=stem)
    without = dataclasses.replace(
        conditions, corrections=dataclasses.replace(conditions.corrections, stem=None)
    )
    warm, cold = (
        tribo.judge(system, LOAD, VELOCITY, one).decisive_temperature
        for one in (conditions, without)
    )
    plain = [
        tribo.judge(system, LOAD, VELOCITY, oil((), None, **parts)).decisive_temperature
        for parts in ({"stem": stem}, {})
    ]
    assert 0 < warm - cold < plain[0] - plain[1]  # less friction where it is warmer
    assert math.isfinite(warm)
