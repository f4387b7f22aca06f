"""Sweeps of each kind that a page may be of, from closed forms that no power law fits exactly."""

import numpy as np
import xarray as xr

from tests.helpers import synthetic
from tribo import QUANTILES

_VELOCITIES = np.array([0.5, 0.75, 1.0, 1.4, 1.8, 2.4, 3.0, 4.0])
_LOADS = np.array([150.0, 200.0, 300.0, 450.0, 600.0, 750.0])


def uneven(seed):
    """Function of the rise: the closed form with a random wave that depends on the seed."""
    generator = np.random.default_rng(seed)
    a, b, c = generator.uniform(0.5, 3.0, 3)

    def rise(load, velocity, quantile=1.0):
        wave = 0.06 * np.sin(a * velocity + b * np.asarray(load) / 100 + c)
        tail = 0.1 * (np.asarray(quantile) ** 3 - np.asarray(quantile))
        return synthetic.rise(load, velocity, quantile) * (1 + wave) * (1 + tail)

    return rise


def one(**changes):
    """Sweep on one surface, with failed and pending points."""
    status = {(300.0, 1.4): 2, (600.0, 0.5): 0, (750.0, 4.0): 0}
    options = {"status": status, "rise": uneven(0)} | changes
    return synthetic.sweep(_LOADS, _VELOCITIES, **options)


def with_single_point():
    """Sweep with only one point at three of its loads."""
    alone = {150.0: 3.0, 200.0: 2.4, 450.0: 1.8}
    return one(status={(x, float(v)): 0 for x in alone for v in _VELOCITIES if v != alone[x]})


def with_zero_velocity():
    """Sweep that includes velocity 0, at which there is no heat."""
    return synthetic.sweep(_LOADS, np.append(0.0, _VELOCITIES), rise=uneven(1))


def over_surfaces(axis="realization", count=5):
    """Sweep on several surfaces, with failed and pending points."""
    parts = [one(rise=uneven(seed)) for seed in range(count)]
    return xr.concat(parts, xr.Variable(axis, np.arange(count)), combine_attrs="override")


def held():
    """Sweep with eight steps of hold, in which one part of the contact warms and another cools."""
    ds = one()
    ds = ds.assign_coords(step=ds["step"] - 8).reindex(step=np.arange(1 - ds.sizes["step"] - 8, 1))
    quantile = xr.DataArray(np.array(QUANTILES), dims="area_fraction_below")
    for k in range(8):
        here = ds["step"] == k - 7
        rise = ds["rise_quantile"].sel(step=-8)
        later = rise * (1 + 0.05 * np.sin(2 * k) + 0.02 * k * (quantile - 0.6))
        done = ds["time"].sel(step=-8).notnull()
        ds["rise_quantile"] = xr.where(here & done, later, ds["rise_quantile"])
        ds["normal_load"] = xr.where(here & done, ds["load"], ds["normal_load"])
        ds["time"] = xr.where(here & done, 10.0 + k, ds["time"])
    return ds.assign_attrs(one().attrs)


def along_boundary(seed=0):
    """Sweep with points only near the boundary, at other velocities for each load."""
    ds = one(status={}, rise=uneven(seed))
    severe = ds["rise_quantile"].isel(area_fraction_below=22).max("step") > synthetic.limit()
    chosen = [
        (float(load), float(velocity))
        for i, load in enumerate(ds["load"].values)
        for j, velocity in enumerate(ds["velocity"].values)
        if (i + j) % 3 == 0
        or bool(severe[i, j]) != bool(severe[i, max(j - 1, 0)])
        or bool(severe[i, j]) != bool(severe[i, min(j + 1, len(_VELOCITIES) - 1)])
    ]
    status = {
        (float(load), float(velocity)): 0
        for load in ds["load"].values
        for velocity in ds["velocity"].values
        if (float(load), float(velocity)) not in chosen
    }
    ds = one(status=status, rise=uneven(seed))
    asked = [
        [(float(load), float(velocity)) in chosen for velocity in ds["velocity"].values]
        for load in ds["load"].values
    ]
    return ds.assign(asked=(("load", "velocity"), np.array(asked, np.int8)))


def with_loads_left_out(seed=0):
    """Sweep of which a search of the boundary has left out two loads, and most other points."""
    ds = along_boundary(seed)
    here = (ds["asked"] == 1) & ~ds["load"].isin([200.0, 450.0])
    names = [name for name in ds.data_vars if ds[name].dtype.kind == "f"]
    masked = {name: ds[name].where(here) for name in names}
    flags = {"status": ds["status"].where(here, 0), "asked": xr.where(here, 1, 2)}
    return ds.assign(masked | {name: one.astype(np.int8) for name, one in flags.items()})


KINDS = {
    "one surface": one,
    "ragged ends": lambda: one(status={(x, v): 0 for x in _LOADS[::2] for v in _VELOCITIES[5:]}),
    "zero velocity": with_zero_velocity,
    "several surfaces": lambda: over_surfaces(count=3),
    "a hold": held,
}


def column(table, name):
    """Numbers in a column of a printed table; NaN for "–"."""
    return np.array([float(row[name].replace("–", "nan")) for row in table])


def same(actual, expected, rtol=0.01):
    """Assert equality within the error of linear interpolation between tabulated rises."""
    np.testing.assert_allclose(actual, expected, rtol=rtol, atol=0)
