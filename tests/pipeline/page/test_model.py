"""Numbers of a page's scripts, run by Node, beside `irg boundary` and `irg margin`."""

import math

import numpy as np
import pytest

import pipeline
from pipeline.analysis.boundary import WITH_TESTS
from pipeline.analysis.outcomes import CROSSES, SEVERAL
from pipeline.store.schema import PENDING
from pipeline.sweep.measurement import Measurement
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic
from tests.helpers.javascript import run

BOUNDARY = """
return argument.map((given) => {
  chosen.conditions = { ...content.conditions, ...given };
  const turns = (axis, places) => places.map((place) => turnAt(axis, place, chosen.conditions));
  const sides = [turns("velocity", content.loads), turns("load", content.velocities)];
  return [...sides, criticalVelocities()];
});
"""
MARGINS = """
return argument.map(({ conditions, places }) => {
  chosen.conditions = { ...content.conditions, ...conditions };
  return places.map(([load, velocity]) => {
    const [k, j] = nearestNode({ load, velocity });
    const { error, probabilities, verdict } = marginAt([k, j], chosen.conditions);
    return {
      place: [content.fine.load[k], content.fine.velocity[j]], error, probabilities, verdict,
      temperature: decidingTemperature(indexOf(k, j)), state: Number(content.state[indexOf(k, j)]),
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
        if "bulk_ratio" in ds.coords:
            conditions["disk_temperature"] = bulk + 12.0 * math.sin(conditions["friction"] * 300)
        yield conditions


def under(ds, conditions):
    """The sweep under conditions that are named as on the page."""
    conditions = dict(conditions)
    if "disk_temperature" in conditions:
        pin = conditions["bulk_temperature"]
        conditions["bulk_temperature"] = {"pin": pin, "disk": conditions.pop("disk_temperature")}
    return pipeline.at(ds, **conditions)


@pytest.mark.parametrize("kind", sweeps.KINDS)
def test_the_boundary_is_that_of_the_command(kind):
    ds, crossings = sweeps.KINDS[kind](), 0
    asked = [*random_conditions(ds)]
    for conditions, (at_loads, at_velocities, tested) in zip(
        asked, run(ds, BOUNDARY, asked), strict=True
    ):
        expected = pipeline.boundary(under(ds, conditions))
        for found, axis, name in (
            (at_loads, "load", "critical_velocity"), (at_velocities, "velocity", "critical_load"),
        ):  # fmt: skip
            places = np.array([one["place"] for one in found])
            known = np.isfinite(places) & np.isfinite(expected[name].values)
            # Between tabulated ratios of the bulk temperatures the page interpolates.
            near = 0.06 if "bulk_ratio" in ds.coords else 0.02
            np.testing.assert_allclose(places[known], expected[name].values[known], rtol=near)
            codes = expected[f"outcome_at_{axis}"].values
            assert (np.isfinite(places) <= np.isin(codes, (CROSSES, SEVERAL))).all()
            crossings += int(known.sum())
        lines = np.transpose(tested)
        for line, name in zip(lines[1:], WITH_TESTS, strict=True):
            both = np.isfinite(line) & np.isfinite(expected[name].values)
            np.testing.assert_allclose(line[both], expected[name].values[both], rtol=near + 0.01)
    assert crossings > 12


TESTS = (
    Measurement(400.0, 1.4, outcome="severe"),
    Measurement(500.0, 1.2, 0.12, outcome="mild"),
    Measurement(600.0, 1.6, 0.09),
)
ASKED = [{}, {"friction": 0.12}, {"critical_temperature": 438.15}, {"bulk_temperature": 320.0}]


@pytest.mark.parametrize("asked", ASKED, ids=str)
def test_a_place_beside_tests_has_the_verdict_of_the_command(asked):
    ds = synthetic.sweep(measured=TESTS[2:], tested=TESTS[:2])
    draw = np.random.default_rng(3)
    places = draw.uniform((200.0, 0.5), (750.0, 4.0), (60, 2)).tolist()
    (told,) = run(ds, MARGINS, [{"conditions": asked, "places": places}])
    loads, velocities = np.transpose([one["place"] for one in told])
    frame = pipeline.margin(under(ds, asked), {"load": loads, "velocity": velocities})
    for page, row in zip(told, frame.to_dict("records"), strict=True):
        assert page["probabilities"][1] == pytest.approx(row["probability"], abs=0.02)
        assert {page["verdict"], row["verdict"]} != {"mild", "severe"}
        assert page["temperature"] - 273.15 == pytest.approx(
            row["deciding temperature [°C]"], rel=1e-3
        )
    alike = [
        page["verdict"] == verdict for page, verdict in zip(told, frame["verdict"], strict=True)
    ]
    assert np.mean(alike) > 0.95


REGIONS = """
const all = regions();
return content.fine.load.flatMap((_, k) => content.fine.velocity.flatMap((_place, j) => {
  const here = all.filter(([, grid]) => grid[k][j] >= 0).map(([name]) => name);
  const { y, verdict } = marginAt([k, j], chosen.conditions);
  return [[Number.isNaN(y) ? "unknown" : verdict, here.join()]];
}));
"""


@pytest.mark.parametrize("is_whole", [True, False])
def test_each_node_lies_in_the_region_of_its_verdict(is_whole):
    velocities = (1.0, 1.5, 2.0, 3.0, 4.0)
    told = {} if is_whole else {"status": {(600.0, v): PENDING for v in velocities}}
    ds = synthetic.sweep((200.0, 300.0, 400.0, 500.0, 600.0), velocities, **told)
    nodes = run(ds, REGIONS)
    alike = {"mild": "mild", "severe": "severe", "not decided": "open", "unknown": ""}
    assert [here for _, here in nodes] == [alike[verdict] for verdict, _ in nodes]
    assert {verdict for verdict, _ in nodes} >= {"mild", "severe", "not decided"}
    assert ("unknown" in {verdict for verdict, _ in nodes}) == (not is_whole)


def test_where_inputs_are_uncertain_a_place_is_as_likely_severe_as_by_the_command(tmp_path):
    uncertain = {"uncertainty": {"pin.radius": "20 %", "temperature.critical": "10 K"}}
    small = {"sweep.loads": ["300 N", "500 N", "700 N"], "fidelity.pixels_per_element": 8}
    sweep = pipeline.load_scene("first_try", overrides=uncertain | small)
    pipeline.run_sweep(sweep, tmp_path / "out.zarr", workers=1)
    ds = pipeline.open_sweep(tmp_path / "out.zarr")
    asked = [{}, {"critical_temperature": 430.0}]
    places = np.random.default_rng(3).uniform((300.0, 1.0), (700.0, 4.0), (30, 2)).tolist()
    found = run(ds, MARGINS, [{"conditions": one, "places": places} for one in asked])
    for conditions, told in zip(asked, found, strict=True):
        loads, velocities = np.transpose([one["place"] for one in told])
        frame = pipeline.margin(under(ds, conditions), {"load": loads, "velocity": velocities})
        stated = [one["probabilities"][1] for one in told]
        # The page interpolates between 41 critical temperatures and 121 values of y.
        np.testing.assert_allclose(stated, frame["probability"], atol=0.04)
