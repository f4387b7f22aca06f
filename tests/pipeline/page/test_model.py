"""Numbers of a page's scripts, run by Node, beside `irg boundary` and `irg margin`."""

import math
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.analysis.field import point_field
from pipeline.analysis.laboratory import model_error
from pipeline.analysis.transition import CROSSES
from pipeline.store.schema import PENDING
from pipeline.sweep.measurement import Measurement
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic
from tests.helpers.javascript import run
from tests.helpers.page_sweeps import same
from tests.helpers.sweeps import with_fields
from tribo import Corrections, Friction

RISE = "model.rise"
BOUNDARY = """
return argument.map((given) => {
  chosen.conditions = { ...content.conditions, ...given };
  const { velocity, load } = boundaries();
  return [velocity, load].map((rows) => [
    rows.map(({ low, middle, high }) => [low, middle, high].map((x) => isFinite(x) ? x : NaN)),
    rows.map(({ transitions }) => transitions.map(({ outcome }) => outcome)),
  ]);
});
"""
MARGINS = """
return argument.map(({ conditions, places }) => {
  chosen.conditions = { ...content.conditions, ...conditions };
  return places.map(([load, velocity]) => {
    const [k, j] = nearestNode({ load, velocity });
    const [f, v] = [content.fine.load[k], content.fine.velocity[j]];
    const state = (one, i, n) => content.state[indexOf(one, i, n)];
    const { rises, error, probabilities, verdict } = marginAt([k, j], chosen.conditions);
    const way = (axis, node) =>
      medianTurn(transitions(axis, node, chosen.conditions), firstTurn) || Infinity;
    return {
      place: [f, v], temperature: quantileOf(rises.map(temperature), 0.5), error, probabilities,
      outcomes: Object.entries({ velocity: k, load: j }).map(([axis, node]) =>
        content.outcomes[axis][transitions(axis, node, chosen.conditions)[0].outcome]),
      verdict, velocity: way("velocity", k), load: way("load", j),
      states: surfaces().map((one) => Number(state(one, k, j))), words: modelError().words,
      isWhole: content.fine.load.every((_, i) => content.inner.every((_, n) =>
        (i !== k && n + content.first !== j) ||
        surfaces().every((one) => state(one, i, n + content.first) < "3"))),
    };
  });
});
"""


def random_conditions(ds, count=4):
    """Yield random conditions of all kinds, after the sweep's own."""
    draw = np.random.default_rng(ds.sizes["velocity"])
    yield {}
    yield {"friction": 0.0}
    for _ in range(count - 2):
        bulk = draw.uniform(250.0, 400.0)
        conditions = {
            "friction": round(draw.uniform(0.04, 0.25), 4),
            "bulk_temperature": bulk,
            "critical_temperature": bulk + draw.uniform(20.0, 250.0),
        }
        conditions["unmodelled_rise"] = round(0.4 * math.sin(100 * conditions["friction"]), 3)
        if "bulk_ratio" in ds.coords:
            conditions["disk_temperature"] = bulk + 12.0 * math.sin(conditions["friction"] * 300)
        if pipeline.results(ds).conditions.criterion.name == "share":
            conditions["failing_share"] = draw.choice([0.0, 0.1, draw.uniform(0.0, 0.6)])
        yield conditions


def under(ds, conditions):
    """The sweep under conditions that are named as on the page."""
    conditions = dict(conditions)
    if "disk_temperature" in conditions:
        pin = conditions["bulk_temperature"]
        conditions["bulk_temperature"] = {"pin": pin, "disk": conditions.pop("disk_temperature")}
    if "failing_share" in conditions:
        conditions["share"] = conditions.pop("failing_share")
    if "unmodelled_rise" in conditions:
        conditions[RISE] = conditions.pop("unmodelled_rise")
    return pipeline.at(ds, **conditions)


@pytest.mark.parametrize("kind", sweeps.KINDS)
def test_the_boundary_is_that_of_the_command(kind):
    ds = sweeps.KINDS[kind]()
    asked, crossings = list(random_conditions(ds)), 0
    for conditions, sides in zip(asked, run(ds, BOUNDARY, asked), strict=True):
        expected = pipeline.boundary(under(ds, conditions))
        for side, axis, name in zip(
            sides, ("load", "velocity"), ("critical_velocity", "critical_load"), strict=True
        ):
            quantiles, codes = (np.array(part) for part in side)
            if f"{name}_quantile" in expected:
                same(quantiles.T, expected[f"{name}_quantile"])
                crossing = (expected[f"outcome_at_{axis}"] == CROSSES).sum("realization")
                same((codes == CROSSES).sum(axis=1), crossing)
            else:
                same(quantiles[:, 1], expected[name])
                assert codes[:, 0].tolist() == expected[f"outcome_at_{axis}"].values.tolist()
            crossings += int((codes == CROSSES).sum())
    assert crossings > 20


FALLING = (0.5, 2.6), (1.2, 1.0), (6.0, 0.9)


def banded(by_velocity=FALLING):
    """Sweep with friction by velocity, so that wear is severe, mild and severe again."""
    ds = synthetic.sweep()
    corrections = Corrections(friction=Friction(by_velocity=by_velocity))
    return with_fields(
        ds, conditions=replace(pipeline.results(ds).conditions, corrections=corrections)
    )


ENDS = [{}, {"critical_temperature": 1200.0}, {"critical_temperature": 310.0}]


@pytest.mark.parametrize("make", [synthetic.sweep, lambda: banded().sel(velocity=slice(0.7, 2.5))])
@pytest.mark.parametrize("is_whole", [True, False])
def test_a_page_counts_the_tests_beyond_the_velocities_that_the_command_counts(make, is_whole):
    tests = tuple(
        Measurement(600.0, velocity, friction, outcome=outcome)
        for velocity in (0.2, 1.0, 7.0)
        for friction, outcome in ((None, "mild"), (None, "severe"), (None, None), (0.1, "mild"))
    )
    ds, counted = with_fields(make(), measured=tests, tested=()), set()
    ds = ds.where(is_whole | (ds["load"] != 600.0) | (abs(ds["velocity"] - 1.5) < 0.6))
    script = """return argument.map((given) => {
      chosen.conditions = { ...content.conditions, ...given };
      return residuals();
    });"""
    for given, told in zip(ENDS, run(ds, script, ENDS), strict=True):
        there = pipeline.at(ds, **given)
        found = model_error(pipeline.results(there), point_field(pipeline.results(there)))
        expected = [*found.residuals, *found.wrong]
        here = [*told["turn"], *told["below"], *told["above"]]
        assert sorted(here) == pytest.approx(sorted(expected), rel=0.01, abs=0.01)
        counted.add(len(expected))
    assert 0 < min(counted) < max(counted) < len(tests)


REGIONS = """
const all = regions().map(([name, grid]) => [name, grid]);
return content.fine.load.flatMap((_, k) => content.inner.flatMap((_place, j) => {
  const node = [k, j + content.first];
  if (content.nodes.load.includes(k) || content.nodes.velocity.includes(node[1])) return [];
  const here = all.filter(([, grid]) => grid[k][j] >= 0).map(([name]) => name);
  const { rises, verdict } = marginAt(node, chosen.conditions);
  return [[rises.some(Number.isNaN) ? "unknown" : verdict, here.join()]];
}));
"""


@pytest.mark.parametrize("is_whole", [True, False])
def test_each_node_between_points_lies_in_the_region_of_its_verdict(is_whole):
    velocities = (1.0, 1.5, 2.0, 3.0, 4.0)
    told = {} if is_whole else {"status": {(600.0, v): PENDING for v in velocities}}
    ds = synthetic.sweep((200.0, 300.0, 400.0, 500.0, 600.0), velocities, **told)
    nodes = run(ds, REGIONS)
    alike = {"mild": "mild", "severe": "severe", "not decided": "open", "unknown": ""}
    assert [here for _, here in nodes] == [alike[verdict] for verdict, _ in nodes]
    assert {verdict for verdict, _ in nodes} >= {"mild", "severe", "not decided"}
    assert ("unknown" in {verdict for verdict, _ in nodes}) == (not is_whole)
