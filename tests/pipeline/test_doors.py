"""The same places, asked of every door: each gives the same verdict, temperature and chance."""

import json

import numpy as np
import pytest

import pipeline
from pipeline.analysis.field import fields
from pipeline.analysis.laboratory import model_error
from pipeline.analysis.margin import DECIDED, verdict_plane
from pipeline.cli import main
from tests.helpers import synthetic
from tests.helpers.samples import dataset, ensemble

SAME = {"rel": 1e-9, "abs": 1e-12}
"""Doors ask one field, so that they differ by rounding alone."""
CHANCE = 0.02  # by which chances of samples may differ, as their draws are interpolated


def half_done():
    ds = synthetic.sweep()
    done = (ds["velocity"] < 2.1) | (ds["load"] == ds["load"][-1])
    rises = {name: ds[name].where(done) for name in ("rise_quantile", "max_rise", "mean_rise")}
    return ds.assign(rises | {"status": ds["status"].where(done, 0).astype(np.int8)})


def band():
    """Points near the transition alone, as a search of the boundary leaves them."""
    ds = synthetic.sweep()
    hot = synthetic.rise(ds["load"], ds["velocity"]) / synthetic.limit()
    done = (hot > 0.7) & (hot < 1.6)
    return ds.assign(status=ds["status"].where(done, 0).astype(np.int8))


def by_velocity():
    return pipeline.at(synthetic.sweep(), friction=0.12, bulk_temperature="40 degC")


def samples():
    ds = dataset(ensemble(), measured=(), tested=())
    return ds.assign(warning_flags=0 * ds["status"])


STORES = {
    "plane": synthetic.sweep,
    "judged otherwise": by_velocity,
    "a band": band,
    "half done": half_done,
    "one load": lambda: synthetic.sweep().isel(load=[5]),
    "one velocity": lambda: synthetic.sweep().isel(velocity=[7]),
    "a slice": lambda: synthetic.sweep().isel(load=slice(2, 9, 2), velocity=slice(1, 12, 3)),
    "samples": samples,
}


def places(ds, count):
    """Places within a sweep, half of them its own points [N, m/s]."""
    rng = np.random.default_rng(1)
    ends = {name: ds[name].values for name in ("load", "velocity")}
    inside = [rng.uniform(x.min(), x.max(), count) for x in ends.values()]
    return zip(
        *(
            np.where(
                np.arange(count) % 2, one, x.ravel()[np.abs(x.ravel()[:, None] - one).argmin(0)]
            )
            for one, x in zip(inside, ends.values(), strict=True)
        ),
        strict=True,
    )


def asked_of_a_place(ds, load, velocity):
    here = pipeline.margin(ds, float(load), float(velocity))
    return here.verdict, here.decisive_temperature - 273.15, here.probability


@pytest.mark.parametrize("name", STORES)
def test_every_door_gives_a_place_the_same_verdict(name, tmp_path, capsys):
    ds = STORES[name]()
    asked = [*places(ds, 10 if name == "samples" else 26)]
    table = {"load [N]": [a for a, _ in asked], "velocity [m/s]": [b for _, b in asked]}
    frame = pipeline.margin(ds, table)
    held = pipeline.results(ds)
    (field,) = fields(held)
    lines = [f"{float(load)!r},{float(velocity)!r}" for load, velocity in asked]
    (tmp_path / "duty.csv").write_text("\n".join(["load [N],velocity [m/s]", *lines]))
    ds.to_netcdf(tmp_path / "copy.nc")
    assert (
        main(["margin", str(tmp_path / "copy.nc"), f"--points={tmp_path}/duty.csv", "--json"]) == 0
    )
    told = json.loads(capsys.readouterr().out)
    for number, (load, velocity) in enumerate(asked):
        row = frame.iloc[number]
        if row["verdict"] == "not known":
            assert told[number]["verdict"] == "not known"
            continue
        verdict, temperature, chance = asked_of_a_place(held, load, velocity)
        error = {"abs": CHANCE} if name == "samples" else SAME
        assert (verdict, told[number]["verdict"]) == (row["verdict"],) * 2, (load, velocity)
        assert temperature == pytest.approx(row["decisive temperature [°C]"], **SAME)
        assert told[number]["decisive temperature [°C]"] == pytest.approx(temperature, **SAME)
        assert np.clip(chance, 1e-4, 1 - 1e-4) == pytest.approx(row["probability"], **error)
        ends = verdict_plane(field, [load], [velocity], model_error(held, field))
        low, high = (float(one[0, 0]) for one in ends)
        drawn = "mild" if high <= DECIDED[0] else "severe" if low >= DECIDED[-1] else "not decided"
        assert drawn == verdict, (load, velocity)
