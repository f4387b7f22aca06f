"""A sweep in the layout of an opened store, whose transition boundary is known in closed form."""

import math

import numpy as np
import xarray as xr

import tribo
from pipeline import Conditions
from pipeline.answers.results import sweep_of
from pipeline.store.schema import COLUMNS, DONE, FAILED, TEST_STEP, variable_of_tests
from pipeline.sweep.plan import TEST_POINT
from tests.helpers.entries import bare_test
from tests.helpers.scenes import STEEL
from tests.helpers.sweeps import attributes_of, sweep_of_fields
from tribo import QUANTILES

FACTOR, LOAD_EXPONENT, VELOCITY_EXPONENT = 24.0, 0.58, 0.7
CONDITIONS = {"friction": 0.1, "bulk_temperature": 298.15, "critical_temperature": 418.15}
MEASURED = (
    bare_test(750.0, 1.25, 0.103),
    bare_test(600.0, 1.5, 0.1),
    bare_test(400.0, 2.25, 0.091),
    bare_test(200.0, 3.75),
)
OIL = tribo.Oil((32e-6, 5e-6), 866.0, 20e-9)
LOADS = np.arange(200.0, 751.0, 50.0)
VELOCITIES = np.arange(0.5, 4.01, 0.25)
RATE, INCREMENT = 150.0, 37.5
_STEP = ("load", "velocity", "step")


def profile(quantile):
    """Ratio of the rise at a quantile to the maximum rise; linear."""
    return 0.3 + 0.7 * np.asarray(quantile)


def rise(load, velocity, quantile=1.0):
    """Temperature rise [K] at friction 1 of the synthetic sweep, a power law."""
    return FACTOR * load**LOAD_EXPONENT * velocity**VELOCITY_EXPONENT * profile(quantile)


def falling(load, velocity, quantile=1.0):
    """Rise [K] that makes wear severe from 1.1 to 2.4 m/s at any load, and mild elsewhere."""
    over = (2 * np.log(velocity) - np.log(1.1 * 2.4)) / np.log(2.4 / 1.1)
    shape = profile(quantile) / profile(0.9)
    return limit() * np.exp(0.3 * (1 - over**2)) * shape


def uneven(seed):
    """Function of the rise: the closed form with a random wave that depends on the seed."""
    a, b, c = np.random.default_rng(seed).uniform(0.5, 3.0, 3)

    def bent(load, velocity, quantile=1.0):
        wave = 0.06 * np.sin(a * velocity + b * np.asarray(load) / 100 + c)
        tail = 0.1 * (np.asarray(quantile) ** 3 - np.asarray(quantile))
        return rise(load, velocity, quantile) * (1 + wave) * (1 + tail)

    return bent


def limit(friction=0.1, critical=418.15):
    return (critical - 298.15) / friction


def critical_velocity(load, limit_rise, share=0.1):
    steady = FACTOR * load**LOAD_EXPONENT * profile(1 - share)
    return (limit_rise / steady) ** (1 / VELOCITY_EXPONENT)


def critical_load(velocity, limit_rise, share=0.1):
    steady = FACTOR * velocity**VELOCITY_EXPONENT * profile(1 - share)
    return (limit_rise / steady) ** (1 / LOAD_EXPONENT)


def sweep(
    loads=LOADS,
    velocities=VELOCITIES,
    rise=rise,
    status=None,
    interval=0,
    fields=False,
    conditions=CONDITIONS,
    **overrides,
):
    """Dataset of a synthetic sweep; `status` has 0 or 2 for points (load, velocity) not done."""
    loads, velocities = np.asarray(loads, float), np.asarray(velocities, float)
    ramps = [np.append(np.arange(INCREMENT, F * (1 - 1e-12), INCREMENT), F) for F in loads]
    n_step = max(map(len, ramps))
    shape = (len(loads), len(velocities), n_step)
    scalars = {name: np.full(shape, np.nan) for name in COLUMNS.keys() - {"rise_quantile"}}
    quantiles = np.full((*shape, len(QUANTILES)), np.nan)
    flags = np.full(shape[:2], DONE, np.int8)
    messages = np.full(shape[:2], "", dtype=object)
    for (F, V), flag in (status or {}).items():
        i, j = np.flatnonzero(loads == F)[0], np.flatnonzero(velocities == V)[0]
        flags[i, j], messages[i, j] = flag, "out of memory" if flag == FAILED else ""

    for i, ramp in enumerate(ramps):
        hot = (np.arange(len(ramp)) + 1) % (interval or len(ramp)) == 0
        hot[-1] = True
        steps = ramp[:, None], velocities
        values = _columns(*steps) | _columns_of_heat(*steps, rise, hot[:, None])
        for name, value in values.items():
            scalars[name][i, :, -len(ramp) :] = value.T
        hottest = np.flatnonzero(hot) - len(ramp)
        hot_rises = rise(ramp[hottest, None], velocities[:, None, None], np.array(QUANTILES))
        quantiles[i][:, hottest] = hot_rises
    for values in (*scalars.values(), quantiles):
        values[flags != DONE] = np.nan

    data = {
        name: (_STEP, values, {"units": COLUMNS[name].units, "long_name": name})
        for name, values in scalars.items()
    }
    data["rise_quantile"] = ((*_STEP, "area_fraction_below"), quantiles, {"units": "K"})
    data["rise_realization_std"] = (
        ("load", "velocity", "area_fraction_below"),
        np.zeros((*flags.shape, len(QUANTILES))),
    )
    data["rise_realization_freedom"] = (("load", "velocity"), np.full(flags.shape, 7.0))
    data["status"] = (("load", "velocity"), flags, {"flag_values": [0, 1, 2]})
    data["wall_time"] = (("load", "velocity"), np.where(flags == DONE, 1.0, np.nan))
    data["warning_flags"] = (("load", "velocity"), np.zeros(shape[:2], np.int32))
    data["message"] = (("load", "velocity"), messages)
    coords = {
        "load": ("load", loads, {"units": "N"}),
        "velocity": ("velocity", velocities, {"units": "m/s"}),
        "step": ("step", np.arange(1 - n_step, 1)),
        "area_fraction_below": ("area_fraction_below", np.array(QUANTILES)),
    }
    if fields:
        data |= _fields(flags, loads, velocities, rise, coords)
    judged = Conditions(**conditions) if isinstance(conditions, dict) else conditions
    plane = {"loads": tuple(loads.tolist()), "velocities": tuple(velocities.tolist())}
    simulated = scene(conditions=judged, fields=fields, **plane | overrides)
    first = simulated.on_first_surface[0].scene
    area = np.prod(first.grid.size) * first.pin.windows(first.grid)
    with np.errstate(invalid="ignore"):
        pressure = scalars["normal_load"] / (scalars["contact_fraction"] * area)
    data["mean_pressure"] = (*data["mean_pressure"][:1], pressure, {"units": "Pa"})
    return with_tests(xr.Dataset(data, coords, attributes_of(simulated)), rise)


def with_tests(ds, rise=rise, status=DONE):
    """The dataset with results of the tests of its scene, each at the end of its load.

    `status` is one state of all their points, or one for each.
    """
    tests = enumerate(sweep_of(ds).tests)
    slots = [(number, *point) for number, test in tests for point in test.points]
    if not slots:
        return ds
    flags = np.broadcast_to(status, len(slots))
    is_done = flags == DONE
    numbers, loads, velocities = map(np.array, zip(*slots, strict=True))
    point_values = {"status": flags.astype(np.int8), "load": loads, "velocity": velocities}
    messages = {FAILED: "out of memory"}
    point_values["message"] = np.array([messages.get(int(flag), "") for flag in flags], object)
    point_values["warning_flags"] = np.zeros(len(slots), np.int32)
    coords = {variable_of_tests(k): (TEST_POINT, v) for k, v in point_values.items()}
    coords["test"] = TEST_POINT, numbers
    steps = {
        "normal_load": loads, "time": loads / RATE, "sliding_distance": velocities * loads / RATE,
        "max_rise": rise(loads, velocities), "mean_rise": rise(loads, velocities, 0.5),
        "contact_width": 9e-6 * loads**0.5, "pin_heat_share": np.full(len(slots), 0.4),
    }  # fmt: skip
    for name, values in steps.items():
        values = np.where(is_done, values, np.nan)[:, None]
        coords[variable_of_tests(name)] = (TEST_POINT, TEST_STEP), values
    hot = np.array(
        [rise(F, V, np.array(QUANTILES)) for F, V in zip(loads, velocities, strict=True)]
    )
    hot = np.where(is_done[:, None], hot, np.nan)[:, None]
    coords[variable_of_tests("rise_quantile")] = (TEST_POINT, TEST_STEP, "area_fraction_below"), hot
    return ds.assign_coords(coords)


def scene(**values):
    """Sweep that a synthetic dataset belongs to, with these values of its fields."""
    return sweep_of_fields(
        **{
            "pin": tribo.Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
            "disk": STEEL,
            "pixels": tribo.Grid((32, 16), (13e-6, 15e-6)),
            "loading": tribo.Ramp(rate=RATE, reference_load=750.0),
            "roughness": tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 9e-6), seed=1),
            "wear": tribo.Wear(1.2e-15),
            "fidelity": tribo.Fidelity(pixels_per_element=1, increments=20),
            "title": "White oil on ground steel",
            "name": "synthetic",
            "friction_band": (0.09, 0.103),
            "tests": MEASURED,
            "preset": "fine",
            "loads": tuple(LOADS.tolist()),
            "velocities": tuple(VELOCITIES.tolist()),
            "conditions": Conditions(**CONDITIONS),
        }
        | values
    )


def _columns(ramp, velocity):
    """Variables of contact and wear, by name, at each step of a ramp."""
    time = ramp / RATE
    return {
        "time": time,
        "normal_load": ramp,
        "sliding_distance": velocity * time,
        "contact_fraction": 0.012 * ramp**0.5,
        "contact_width": 9e-6 * ramp**0.5 * (1 + 0.2 * velocity),
        "max_pressure": np.full_like(ramp, 6.6e9),
        "mean_pressure": np.full_like(ramp, math.nan),  # carries the load, see `sweep`
        "plastic_fraction": 0.02 + 1e-4 * ramp,
        "wear_depth_max": 2e-9 * velocity * ramp**0.9,
        "wear_volume": 1.2e-15 * 0.5 * RATE * time**2 * velocity,
        "iterations": np.full_like(ramp, 10.0),
        "residual": np.full_like(ramp, 1e-4),
    }


def _columns_of_heat(ramp, velocity, rise, hot):
    """Variables of heat, by name, at each step; NaN unless `hot`."""
    return {
        "max_rise": np.where(hot, rise(ramp, velocity), np.nan),
        "mean_rise": np.where(hot, rise(ramp, velocity, 0.5), np.nan),
        "pin_heat_share": np.where(hot, 0.4, np.nan),
    }


def _fields(flags, loads, velocities, rise, coords):
    """Fields of the contact for each point: round summits under a cylinder, hot behind."""
    nx, ny = 48, 36
    x, y = (np.arange(nx) - (nx - 1) / 2) * 8e-6, np.arange(ny) * 12e-6
    coords["x"], coords["y"] = ("x", x, {"units": "m"}), ("y", y, {"units": "m"})
    summits = np.cos(2 * np.pi * x / 5e-5)[:, None] * np.cos(2 * np.pi * y / 7.2e-5)
    dome = np.clip(1 - (x[:, None] / 1.3e-4) ** 2, 0, None)
    pressure = 5e9 * dome * np.clip(summits - 0.3, 0, None)
    heat = dome * (0.5 + 0.3 * summits + 0.2 * x[:, None] / 1.3e-4)
    wear = 2e-6 * np.broadcast_to(dome, (nx, ny))
    done = (flags == DONE)[..., None, None]
    hottest = rise(loads[:, None], velocities)[..., None, None]
    dims = ("load", "velocity", "x", "y")
    return {
        "pressure": (dims, np.where(done, pressure, np.nan), {"units": "Pa"}),
        "rise": (dims, np.where(done, hottest * heat, np.nan), {"units": "K"}),
        "wear_depth": (dims, np.where(done, wear, np.nan), {"units": "m"}),
    }
