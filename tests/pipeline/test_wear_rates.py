"""A sweep that answers for several wear rates: heat of each on the contacts of one."""

import numpy as np
import pytest

import pipeline
from pipeline.scene.over import with_rates_of
from pipeline.store.create import writing
from pipeline.sweep.plan import chains, points, run_points
from pipeline.sweep.severity import worst_rises
from pipeline.sweep.variants import Variants, wear_rates
from tests.helpers import tiny
from tests.helpers.javascript import run
from tests.helpers.scenes import SCENE
from tribo import Fidelity, InputError, Motion, Wear

OWN, RATES = 1.2e-15, (0.6e-15, 2.4e-15)
SWEEP = tiny.sweep(fidelity={"contact_tolerance": 1e-6}).changed(
    loads=(300.0, 600.0),
    velocities=(1.0, 1.25, 1.6, 2.0),
    variants=wear_rates(OWN, *RATES),
)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("rates") / "rates.zarr"
    with writing(path, SWEEP) as store, np.errstate(all="raise", under="ignore"):
        for chain in chains(points(SWEEP), SWEEP):
            for load in SWEEP.plane.loads:
                at_load = [point for point in chain if point.load == load]
                store.commit([one.record(False) for one in run_points(SWEEP, at_load)])
    return path


def direct(rate, load, velocity):
    """Deciding rise of a point that is simulated with a wear rate of its own."""
    scene = SWEEP.changed(wear=Wear(rate), variants=Variants())
    columns = pipeline.run_point(scene, load, velocity).columns
    return float(worst_rises(columns, load, scene.conditions))


@pytest.mark.parametrize("rate", [RATES[0], 1.5e-15])
def test_a_rise_at_another_rate_is_that_of_a_simulation_with_it(store, rate):
    ds = pipeline.at_wear_rate(store, rate)
    ratio = rate / SWEEP.scene.wear.specific_wear_rate
    assert ds["velocity"].values * ratio == pytest.approx(SWEEP.plane.velocities)
    tolerance = 1e-9 if rate in RATES else 1e-2  # interpolated, of few elements
    for load in SWEEP.plane.loads:
        for velocity in ds["velocity"].values[[0, -1]]:
            rises = ds.sel(load=load, velocity=velocity)
            columns = {name: rises[name].values for name in ("normal_load", "rise_quantile")}
            rise = float(worst_rises(columns, load, SWEEP.conditions))
            assert rise == pytest.approx(direct(rate, load, velocity), rel=tolerance)


def test_heat_is_taken_at_rates_no_more_than_twice_as_high_as_the_next():
    assert SWEEP.variants.wear_rates == (OWN, *RATES)
    wide = wear_rates(OWN, 0.3e-15, 4.8e-15).wear_rates
    assert wide == pytest.approx((OWN, 0.3e-15, 0.6e-15, 2.4e-15, 4.8e-15))
    assert wear_rates(OWN, OWN, 3e-15).wear_rates[::2] == (OWN, 3e-15)


def test_the_rate_of_the_scene_is_one_of_them(store):
    ds = pipeline.open_sweep(store)
    own = pipeline.boundary(ds)["critical_velocity"]
    for rate in ("1.2e-6 mm^3/(N m)", None):
        assert pipeline.boundary(pipeline.at_wear_rate(ds, rate))["critical_velocity"].equals(own)
    assert own.equals(pipeline.boundary(ds.sel(wear_rate=[OWN]))["critical_velocity"])


def test_the_command_answers_for_rates_within_those_of_the_scene(store, irg):
    assert "wear rate 2e-06 mm³/(N m)" in irg("boundary", store, "--wear-rate", "2e-6 mm^3/(N m)")
    margin = ["margin", str(store), "--load", "400 N", "--velocity", "1 m/s", "--wear-rate"]
    assert "6e-07 mm³/(N m) to 2.4e-06 mm³/(N m)" in irg(*margin, "3e-6 mm^3/(N m)", code=2)


def test_velocities_are_added_so_that_each_rate_has_those_of_the_scene():
    notes, rates = [], dict(zip(("from", "to"), RATES, strict=True))
    wider = with_rates_of(rates, SWEEP.changed(variants=Variants()), notes)
    ends = wider.plane.velocities[0], wider.plane.velocities[-1]
    assert ends == (0.5, 4.0)
    assert set(SWEEP.plane.velocities) < set(wider.plane.velocities)
    assert max(np.diff(np.log(wider.plane.velocities))) <= np.log(1.3)
    assert "0.5 m/s and 4 m/s" in notes[0]


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"wear": None}, "without specific_wear_rate"),
        ({"variants": wear_rates(2e-15, 2e-15, 3e-15)}, "is none of them"),
        ({"friction_heat": False}, "no friction"),
        ({"unequal_bulks": True}, "bulk temperatures are unequal"),
        ({"fidelity": Fidelity(heat_model="history")}, "heat of all the steps"),
        ({"motion": Motion(entrainment_velocity=1.0)}, "stands still"),
    ],
)
def test_it_is_refused_where_contacts_are_not_shared(changes, reason):
    with pytest.raises(InputError, match=reason):
        SWEEP.changed(**changes)


def test_a_scene_asks_for_them_and_a_search_refuses_them(tmp_path, irg):
    scene = tmp_path / "rates.toml"
    rates = 'wear_rates = { from = "1e-6 mm^3/(N m)", to = "2e-6 mm^3/(N m)" }'
    scene.write_text(SCENE.replace("[sweep]", f"[sweep]\n{rates}"))
    with pytest.raises(pipeline.SceneFileError, match="does not enclose"):
        pipeline.load_scene(scene, overrides={"sweep.wear_rates.from": "2e-6 mm^3/(N m)"})
    sweep = pipeline.load_scene(scene)
    assert sweep.variants.wear_rates == pytest.approx((OWN, 1e-15, 2e-15))
    cost = pipeline.estimate(sweep, workers=1)
    assert cost.temperatures == 3 * len(sweep.plane.loads) * len(sweep.plane.velocities)
    assert "own wear rate alone" in irg(
        "run", scene, "-o", tmp_path / "a.zarr", "--boundary-only", code=2
    )


def test_the_page_has_the_boundary_at_each_wear_rate(store):
    ds = pipeline.open_sweep(store)
    rates = [1.5e-15]
    conditions = [{"wear_rate": rate, "critical_temperature": 373.15} for rate in rates]
    script = """
    return argument.map((given) => {
      chosen.conditions = { ...content.conditions, ...given };
      sweep.takeWearRate(given.wear_rate);
      return [sweep.velocities, summary().velocity.map(({ middle }) => middle)];
    });
    """
    for rate, (velocities, critical) in zip(rates, run(ds, script, conditions), strict=True):
        at_rate = pipeline.at_wear_rate(ds, rate)
        expected = pipeline.boundary(at_rate, critical_temperature=373.15)["critical_velocity"]
        assert velocities == pytest.approx(at_rate["velocity"].values)
        assert critical == pytest.approx(expected.values, rel=5e-3, nan_ok=True)
        assert np.isfinite(expected).any()
