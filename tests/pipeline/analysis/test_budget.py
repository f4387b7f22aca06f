"""What makes a verdict uncertain and what would change it, by `irg margin`."""

import json
import math
import re

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.cli import main
from pipeline.run.here import compute_here
from pipeline.store.create import writing
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.plan import points
from tests.helpers import synthetic
from tests.pipeline.analysis.test_inputs import (
    CONDUCTIVITY,
    WEAR,
    swept,
    transition,
    weighted_draws,
)

UNCERTAINTY = {CONDUCTIVITY: "20 %", WEAR: "factor 2", "friction.coefficient": "5 %"}
MOVED = {CONDUCTIVITY: math.exp(-0.14), WEAR: math.exp(-0.07)}
A = np.array([-0.14, -0.07, 0.05])
LOAD, VELOCITY = 500.0, 1.5


@pytest.fixture
def asked(monkeypatch, capsys):
    """Function that returns the tables of `irg margin` on a dataset."""

    def ask(ds, *options, place=(LOAD, VELOCITY)):
        monkeypatch.setattr(pipeline, "open_sweep", lambda path: ds)
        where = ["--load", f"{place[0]} N", "--velocity", f"{place[1]} m/s"]
        assert main(["margin", "store.zarr", *where, *options, "--json"]) == 0
        rows = json.loads(capsys.readouterr().out)
        return [row for row in rows if "verdict" not in row]

    return ask


def moments(tests):
    """Shares of the variance, and what knowing an input takes, by weighted draws."""
    z, bias, scatter, weight = weighted_draws(3, tests, 2_000_000)
    parts = np.column_stack([z * A, bias])
    covariance = np.cov(parts.T, aweights=weight)
    own = weight @ scatter**2
    total = covariance.sum() + own
    shares = np.append(covariance.sum(axis=1), own) / total
    takes = covariance.sum(axis=1) ** 2 / (np.diag(covariance) * total)
    return shares, takes[:3]


def test_shares_of_the_variance_are_those_of_weighted_draws_and_add_up(asked):
    tests = [transition(750.0, 0.1, friction=0.1), transition(200.0, 0.05)]
    ds = swept(UNCERTAINTY, *tests, moved=MOVED)
    rows = asked(ds, "--budget")
    before, after, takes = (
        np.array([row[head] for row in rows[:5]], float)
        for head in ("before the tests [%]", "after the tests [%]", "knowing it takes [%]")
    )
    assert before.sum() == pytest.approx(100.0)
    assert after.sum() == pytest.approx(100.0)
    # A variance of Student's t and of the scatter is twice the square of its scale.
    variances = np.array([*A**2, 2 * 0.05**2, 2 * 0.055**2])
    assert before == pytest.approx(100 * variances / variances.sum(), abs=1.0)
    seen = [(0.1, A * [1, 1, 0]), (0.05, A)]
    shares, by_knowing = moments(seen)
    assert after == pytest.approx(100 * shares, abs=2.0)
    assert takes[:3] == pytest.approx(100 * by_knowing, abs=2.0)
    table = ds.irg.budget(LOAD, VELOCITY).table
    assert table["after the tests [%]"].tolist()[:5] == after.tolist()


def test_where_no_input_matters_a_test_is_advised(monkeypatch, capsys):
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: swept({"friction.coefficient": "1 %"}))
    assert main(["margin", "s", "--load", "500 N", "--velocity", "1.5 m/s", "--budget"]) == 0
    assert "would help most: none of these: a test here" in capsys.readouterr().out


@pytest.mark.parametrize("wanted", ["mild", "severe"])
def test_each_change_of_conditions_or_place_gives_the_verdict_and_is_the_least(asked, wanted):
    ds = swept({"friction.coefficient": "5 %"}, transition(750.0, 0.0))
    here = synthetic.critical_velocity(LOAD, synthetic.limit())
    rows = asked(ds, "--until", wanted, place=(LOAD, float(here)))
    names = {"friction", "bulk temperature", "load", "velocity"}
    assert names <= {row["change"] for row in rows}
    for row in rows:
        begin, end = (float(row[head].split()[0]) for head in ("from", "to"))
        name, place = row["change"].replace(" ", "_"), {"load": LOAD, "velocity": here}
        for value, gives in ((end, True), (begin + 0.93 * (end - begin), False)):
            own, at = {}, dict(place)
            if name in place:
                at[name] = value
            else:
                own[name] = value if name == "friction" else f"{value} degC"
            assert (pipeline.margin(ds, **at, **own).verdict == wanted) == gives


def test_bulk_temperatures_are_sought_below_the_critical_one_of_the_tests(asked):
    own = synthetic.CONDITIONS | {"critical_temperature": 533.15}
    tests = [
        Measurement(load, float(synthetic.critical_velocity(load, 900.0)))
        for load in (200.0, 300.0, 400.0, 600.0)
    ]
    ds = swept({"temperature.critical": "100 K"}, *tests, conditions=own)  # 115 °C by the tests
    velocity = float(synthetic.critical_velocity(LOAD, 900.0))
    for wanted, way in (("severe", 1), ("mild", -1)):
        rows = asked(ds, "--until", wanted, place=(LOAD, velocity))
        (bulk,) = (row["to"] for row in rows if row["change"] == "bulk temperature")
        assert 0 < way * (float(bulk.split()[0]) - 25.0) < 50.0
        assert (
            pipeline.margin(ds, LOAD, velocity, bulk_temperature=bulk.replace("°", "deg")).verdict
            == wanted
        )


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Store of a small scene with an uncertain conductivity."""
    folder = tmp_path_factory.mktemp("until")
    path = folder / "scene.toml"
    path.write_text(
        'extends = "first_try"\nwithout = ["measured"]\n'
        f'[uncertainty]\n"{CONDUCTIVITY}" = "20 %"\n'
        '[window]\npixels = [576, 60]\n[sweep]\nloads = ["600 N"]\n'
        'velocities = ["1 m/s", "1.5 m/s", "2 m/s"]\n',
        encoding="utf-8",
    )
    sweep = pipeline.load_scene(path)
    with writing(folder / "store.zarr", sweep) as store:
        compute_here(store, points(sweep))
    return folder / "store.zarr"


def test_a_change_of_an_entry_is_verified_by_a_simulation(store, capsys):
    place = ["--load", "600 N", "--velocity", "1.5 m/s"]
    assert main(["margin", str(store), *place, "--until", "mild", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    (row,) = (one for one in rows if one.get("change") == CONDUCTIVITY)
    value = row["to"].split()[0]
    sweep = pipeline.load_scene(store.parent / "scene.toml")
    changed = sweep.changed(CONDUCTIVITY, f"{value} W/(m K)")
    cold, own = (
        tribo.judge(one.scene, 600.0, 1.5, one.conditions).deciding_temperature - 298.15
        for one in (changed, sweep)
    )
    (effect,) = pipeline.results(store).stored.inputs
    assert effect.spread == 0.2
    # Without tests mild is y + e below −0.163; here the input widens that.
    assert math.log(cold / 120.0) < -0.163 < math.log(own / 120.0)
    assert float(value) < 90.0


def test_a_changed_entry_whose_point_carries_a_new_warning_is_not_promised(tmp_path, capsys):
    changes = {
        "without": ["measured"], "window.pixels": [336, 60], "sweep.loads": ["600 N"],
        "sweep.velocities": ["1 m/s", "1.3 m/s", "1.5 m/s"],
    }  # fmt: skip
    sweep, path = pipeline.load_scene("first_try", overrides=changes), tmp_path / "narrow.zarr"
    with writing(path, sweep) as store:
        compute_here(store, points(sweep))
    place = ["--load", "600 N", "--velocity", "1.3 m/s"]
    assert main(["margin", str(path), *place, "--until", "mild", "--entries", "pin.radius"]) == 0
    said = capsys.readouterr().out
    (value,) = re.findall(r"pin.radius (\S+ mm) may not give mild: contact touches the", said)
    changed = sweep.changed("pin.radius", value)
    *_, state = tribo.simulate(changed.scene, 600.0, 1.3)
    assert tribo.WarningKind.CONTACT_AT_EDGE in {
        one.kind for one in tribo.warnings(changed.scene, state)
    }


def test_what_margin_cannot_seek_is_refused(store, capsys):
    place = ["--load", "600 N", "--velocity", "1.5 m/s"]
    for options, said in (
        (["--entries", "pin.radius"], "--entries belongs to --until"),
        (["--until", "mild", "--entries", "disk.roughness.seed"], "is a whole number"),
        (["--until", "mild", "--entries", "temperature.bulk"], "tried in any case"),
    ):
        assert main(["margin", str(store), *place, *options]) == 2
        assert said in capsys.readouterr().err
