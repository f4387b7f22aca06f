"""Probabilities are about a half where wear is critical, and a row is as hot as in a plane."""

import numpy as np
import pandas as pd
import pytest

import pipeline
from tests.helpers import page_sweeps, synthetic
from tests.helpers.answer_at import named
from tests.helpers.scenes import MEASURED, SCENE
from tests.pipeline.conftest import commit_all

SAME = {"rel": 1e-9, "abs": 1e-12}  # all answers use one field and differ by rounding only
HEADS = "load [N]", "velocity [m/s]"


def band():
    """Sweep with points only near the transition, as a search of the boundary leaves them."""
    ds = synthetic.sweep()
    hot = synthetic.rise(ds["load"], ds["velocity"]) / synthetic.limit()
    done = (hot > 0.7) & (hot < 1.6)
    return ds.assign(status=ds["status"].where(done, 0).astype(np.int8))


STORES = {
    "plane": synthetic.sweep,
    "from rest": lambda: synthetic.sweep(velocities=(0.0, *synthetic.VELOCITIES)),
    "a band": band,
    "a single point at a load": page_sweeps.with_single_point,
    "one load": lambda: synthetic.sweep().isel(load=[5]),
    "a slice": lambda: synthetic.sweep().isel(load=slice(2, 9, 2), velocity=slice(1, 12, 3)),
    "the boundary alone": page_sweeps.along_boundary,
    "loads left out": page_sweeps.with_loads_left_out,
}


def places(ds, count):
    """Pairs of load [N] and velocity [m/s] inside a sweep, half of them computed points."""
    rng = np.random.default_rng(1)
    ends = {name: ds[name].values[ds[name].values > 0] for name in ("load", "velocity")}
    inside = [rng.uniform(x.min(), x.max(), count) for x in ends.values()]
    axes = [x.ravel() for x in ends.values()]
    done = (x[np.abs(x[:, None] - one).argmin(0)] for one, x in zip(inside, axes, strict=True))
    chosen = (np.where(np.arange(count) % 2, *pair) for pair in zip(inside, done, strict=True))
    return zip(*chosen, strict=True)


@pytest.mark.parametrize("name", STORES)
def test_wear_is_likelier_severe_where_it_is_hotter_than_critical(name):
    asked = np.transpose([*places(STORES[name](), 100)])
    ds = STORES[name]().assign_attrs(without_tests="yes")
    found = pipeline.margin(ds, [*asked[0]], [*asked[1]])
    known = found.isel(place=abs(found["temperature_margin"]) > 1e-6)
    assert ((known["temperature_margin"] < 0) == (known["probability"] > 0.5)).all()
    known = known["place"] if "place" in known.coords else known["verdict"]
    assert len(known) > 80


@pytest.fixture(scope="module")
def places_computed(tmp_path_factory):
    """Scene, and margins of some points: from a plane, computed alone, and from rows."""
    folder = tmp_path_factory.mktemp("doors")
    scene, rows = folder / "small.toml", [(200.0, 2.0), (400.0, 5.0), (400.0, 1.0)]
    # The numerical error of a preset is known.
    text = SCENE.replace("pixels_per_element = 1\nincrements = 10", 'preset = "standard"')
    scene.write_text(text + MEASURED)
    pd.DataFrame(rows, columns=HEADS).to_csv(folder / "rows.csv", index=False)
    axes = {"sweep.loads": ["200 N", "400 N"], "sweep.velocities": ["1 m/s", "2 m/s", "5 m/s"]}
    along = {"sweep.along": str(folder / "rows.csv")}
    with np.errstate(all="raise", under="ignore"):
        for name, changes in (("plane", axes), ("rows", along)):
            commit_all(folder / f"{name}.zarr", pipeline.load_scene(scene, overrides=changes))
    return scene, rows, folder / "plane.zarr", pipeline.margin(folder / "rows.zarr")


def test_a_point_and_a_row_are_as_hot_as_in_a_plane_and_never_decided_otherwise(
    places_computed, irg
):
    (scene, rows, plane, table), verdicts = places_computed, set()
    for load, velocity in rows:
        place = f"--load={load} N", f"--velocity={velocity} m/s"
        (alone,) = irg("point", scene, *place, "--json")
        (within,) = irg("margin", plane, *place, "--json")
        (row,) = np.flatnonzero((table["load"] == load) & (table["velocity"] == velocity))
        own = {"governing temperature [°C]": table["governing_temperature"].values[row] - 273.15}
        own["verdict"] = named(table["verdict"])[row].replace("_", " ")
        for door in (alone, own):
            hot = door["governing temperature [°C]"]
            assert hot == pytest.approx(within["governing temperature [°C]"], **SAME)
            assert door["verdict"] in (within["verdict"], "undecided")
            verdicts.add(door["verdict"])
    assert {"mild", "severe"} <= verdicts
