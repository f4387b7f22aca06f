"""Uncertain inputs by the front door: what they do to places, and what tests say of them."""

import math
import re

import numpy as np
import pytest

import pipeline
import tribo
from pipeline import load_scene
from pipeline.store.schema import DONE, PENDING
from pipeline.sweep.measurement import Measurement
from tests.helpers import synthetic

CONDUCTIVITY, WEAR = "materials.steel.thermal_conductivity", "wear.specific_wear_rate"
LIMIT = synthetic.limit()


def transition(load, y, **own):
    """A transition where the computed ln(rise/limit) is `y`."""
    velocity = synthetic.critical_velocity(load, math.exp(y) * LIMIT)
    return Measurement(load, float(velocity), **own)


def swept(uncertainty, *tests, moved=None, status=None, **told):
    ds = synthetic.sweep(measured=tests, uncertainty=uncertainty, **told)
    if status is None:
        return synthetic.with_tests(ds, moved=moved)
    return synthetic.with_tests(ds, moved=moved, status=status)


def chance(ds, y, load=500.0, **given):
    velocity = synthetic.critical_velocity(load, math.exp(y) * LIMIT)
    return pipeline.margin(ds, load, float(velocity), **given).probability


def weighted_draws(count, tests, n):
    """Draws of `count` inputs, bias and scatter from the prior, and their weights by `tests`.

    `tests` are pairs (y, effects) of transitions.
    """
    rng = np.random.default_rng(1)
    z = rng.normal(size=(n, count))
    bias = 0.05 * rng.normal(size=n) / np.sqrt(rng.gamma(2, 1 / 2, n))
    scatter = 0.055 * np.sqrt(4 / rng.chisquare(4, n))
    weight = np.zeros(n)
    for y, a in tests:
        weight += -0.5 * ((y + z @ a + bias) / scatter) ** 2 - np.log(scatter)
    weight = np.exp(weight - weight.max())
    return z, bias, scatter, weight / weight.sum()


def drawn(inputs, tests, y, effects):
    """Probability by weighted draws: `inputs` standard deviations, `tests` pairs (y, effects)."""
    z, bias, scatter, weight = weighted_draws(len(inputs), tests, 1_000_000)
    total = (y + z @ effects + bias) / scatter
    severe = 0.5 * (1 + np.vectorize(math.erf)(total / math.sqrt(2)))
    return float((weight * severe).sum())


def test_inputs_widen_the_verdict_and_a_transition_narrows_it_as_weighted_draws_say():
    moved = {CONDUCTIVITY: math.exp(-0.14), WEAR: math.exp(-0.07)}
    uncertainty = {CONDUCTIVITY: "20 %", WEAR: "factor 2", "friction.coefficient": "5 %"}
    alone = swept(uncertainty, moved=moved)
    a = np.array([-0.14, -0.07, 0.05])
    assert chance(alone, -0.15) == pytest.approx(drawn(a, [], -0.15, a), abs=0.004)
    tests = [transition(750.0, 0.1, friction=0.1), transition(200.0, 0.05)]
    tested = swept(uncertainty, *tests, moved=moved)
    # The first test states its friction, which is exact for it.
    seen = [(0.1, np.array([-0.14, -0.07, 0.0])), (0.05, a)]
    assert chance(tested, -0.15) == pytest.approx(drawn(a, seen, -0.15, a), abs=0.004)


def test_what_a_test_changes_itself_is_exact_for_it():
    own = {WEAR: "1.2e-6 mm^3/(N m)"}
    uncertainty, moved = {WEAR: "factor 2"}, {WEAR: math.exp(-0.3)}
    stated = swept(uncertainty, transition(750.0, 0.3, changes=own), moved=moved)
    shared = swept(uncertainty, transition(750.0, 0.3), moved=moved)
    # Where the wear rate may explain the transition, other places are colder with it.
    assert chance(shared, 0.0) < 0.05 < chance(stated, 0.0)
    (known,) = pipeline.infer(stated).inputs
    assert (known.mean, known.spread) == pytest.approx((0.0, 1.0), abs=1e-6)


def test_kelvin_of_a_temperature_count_over_the_distance_from_each_bulk():
    ds = swept({"temperature.critical": "8 K"})
    # 8 K of 120 K above the bulk, and of 60 K above a warmer one
    for bulk, effect in ((298.15, 8 / 120), (358.15, 8 / 60)):
        velocity = synthetic.critical_velocity(500.0, 0.9 * synthetic.limit(bulk=bulk))
        found = pipeline.margin(ds, 500.0, float(velocity), bulk_temperature=bulk).probability
        a = np.array([effect])
        assert found == pytest.approx(drawn(a, [], math.log(0.9), a), abs=0.004)


def test_a_condition_given_keeps_its_uncertainty_unless_it_is_exact():
    ds = swept({"friction.coefficient": "20 %"})
    kept = pipeline.margin(ds, 500.0, 1.0, friction=0.09).probability
    exact = pipeline.margin(ds, 500.0, 1.0, friction=0.09, exact=True).probability
    certain = pipeline.margin(swept({}), 500.0, 1.0, friction=0.09).probability
    assert exact == pytest.approx(certain, abs=1e-9)
    assert abs(kept - 0.5) < abs(exact - 0.5)


def test_an_oil_of_100_kelvin_uncertainty_is_known_to_some_kelvin_by_four_transitions():
    own = synthetic.CONDITIONS | {"critical_temperature": 533.15}
    tests = [
        Measurement(load, float(synthetic.critical_velocity(load, 900.0)))
        for load in (200.0, 300.0, 400.0, 600.0)
    ]
    found = pipeline.infer(swept({"temperature.critical": "100 K"}, *tests, conditions=own))
    # ln(90/235) is 2.2 of its standard deviations, which draw the temperature by some kelvin.
    assert 298.15 + 90.0 < found.temperature < 298.15 + 94.0
    (known,) = found.inputs
    assert known.before == "260 °C ± 100 K"
    assert found.own_spread < found.spread < 15.0


def test_what_is_computed_keeps_the_stated_critical_temperature_whatever_tests_say():
    tests = [transition(load, 0.15) for load in (200.0, 400.0, 750.0)]
    ds, certain = swept({"temperature.critical": "30 K"}, *tests), swept({}, *tests)
    found, stated = (pipeline.boundary(one).sel(load=500.0) for one in (ds, certain))
    assert found["critical_velocity"].item() == stated["critical_velocity"].item()
    # All transitions lie higher, which the temperature explains, so that there is less bias.
    assert found["tested_velocity"].item() > 1.15 * found["critical_velocity"].item()
    here = pipeline.margin(ds, 500.0, found["tested_velocity"].item())
    assert here.probability == pytest.approx(0.5, abs=0.005)
    assert here.critical_temperature == 418.15


def test_while_the_points_of_an_input_wait_no_verdict_is_given():
    ds = swept({CONDUCTIVITY: "20 %"}, status=PENDING)
    here = pipeline.margin(ds, 200.0, 0.5)
    assert here.verdict == "not decided"
    assert CONDUCTIVITY in here.against


def test_a_test_that_waits_closes_its_own_side_alone_beside_an_uncertain_input():
    test = Measurement(400.0, 1.0, outcome="severe")
    ds = synthetic.sweep(measured=(), tested=(test,), uncertainty={CONDUCTIVITY: "20 %"})
    first = [PENDING] + [DONE] * (ds.sizes["test_point"] - 1)
    here = pipeline.margin(synthetic.with_tests(ds, status=first), 750.0, 3.5)
    assert here.verdict == "severe"
    assert "test 1" in here.not_mild
    assert here.not_severe == ""


def test_the_boundary_with_tests_is_where_half_of_the_runs_are_severe():
    moved = {CONDUCTIVITY: math.exp(-0.14)}
    tests = [transition(750.0, 0.1), transition(200.0, 0.05)]
    ds = swept({CONDUCTIVITY: "20 %"}, *tests, moved=moved)
    found = pipeline.boundary(ds)["tested_velocity"].sel(load=500.0).item()
    assert pipeline.margin(ds, 500.0, found).probability == pytest.approx(0.5, abs=0.005)


REFUSED = {
    '"disk.roughness.seed" = "5 %"': "is a whole number",
    '"pin.radus" = "5 %"': 'did you mean "pin.radius"',
    '"temperature.bulk" = "5 %"': 'give kelvin, "8 K"',
    '"temperature.bulk" = "25 degC"': 'give kelvin, "8 K"',
    '"temperature.failing_share" = "5 %"': "is a share",
    '"window.pixel_size" = "5 %"': "is a choice",
    '"wear.pattern" = "5 %"': "is not a number",
    '"pin.radius" = "5 K"': '"20 %", or "factor 2"',
    '"pin.radius" = "factor 20"': "up to 10",
    '"loading.hold" = "5 %"': "is 0, which has no logarithm",
    '"disk.roughness.hurst_exponent" = "50 %"': "one standard uncertainty more is refused",
    '"pin.length" = "from tests"': "no standard uncertainty",
}


@pytest.mark.parametrize("line", REFUSED)
def test_what_cannot_be_uncertain_is_refused_by_name(line, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(f'extends = "first_try"\n[uncertainty]\n{line}\n', encoding="utf-8")
    with pytest.raises(tribo.TriboError, match=re.escape(REFUSED[line])):
        load_scene(path)


def test_an_uncertain_input_may_also_have_several_values_in_the_sweep(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        'extends = "first_try"\n[uncertainty]\n"pin.radius" = "5 %"\n'
        '[sweep]\nover = { "pin.radius" = ["1 mm", "2 mm"] }\n',
        encoding="utf-8",
    )
    sweep = load_scene(path)
    assert [one.path for one in sweep.inputs] == ["pin.radius"]
    assert sweep.inputs[0].case.scene.pin.radius == pytest.approx(2e-3 * math.exp(0.05))
