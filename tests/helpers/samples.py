"""Samples of a sweep whose rise is known in closed form."""

import numpy as np
import xarray as xr

import pipeline
import tribo
from pipeline.analysis.model_error import ModelError
from pipeline.store.schema import DONE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.measurement import Measurement
from pipeline.uncertain import weigh
from pipeline.uncertain.answers import draws_of
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.fields import SampleField
from pipeline.uncertain.inputs import BULK, prior
from pipeline.uncertain.inputs import CRITICAL as CRITICAL_PATH
from pipeline.uncertain.inputs import FRICTION as FRICTION_PATH
from pipeline.uncertain.samples import Design, Draw, drawn_rows, samples_per_contact
from tests.helpers import synthetic
from tests.helpers.answers import answer
from tests.helpers.sweeps import attributes_of
from tests.helpers.unknowns import ALL, LENGTH, RATE
from tribo import QUANTILES

LOADS, VELOCITIES = np.array([200.0, 400.0, 750.0]), (0.5, 6.0)
EXPONENT = 0.7  # d ln(rise)/d ln(velocity)


_AFTERWARDS = {BULK, CRITICAL_PATH, FRICTION_PATH}


def fewer_draws(monkeypatch):
    """Patch inference to a quarter of the usual draws, which suffice for means and spreads."""
    for name, count in {"_FIRST": 2**11, "_COUNT": 2**11, "_ENOUGH": 400}.items():
        monkeypatch.setattr(weigh, name, count)
    monkeypatch.setattr(prior, "__defaults__", (2**10,))


def rise(inputs, load, velocity, unknown=ALL):
    """Deciding rise [K] at friction 1 of each row of inputs, by a closed form."""
    rises = 24.0 * load**0.58 * velocity**EXPONENT * np.ones(len(inputs))
    for entry, column in zip(unknown, inputs.T, strict=True):
        if entry.path == RATE.path:
            rises = rises * (column / 1.2e-15) ** -0.12
        if entry.path == LENGTH.path:
            rises = rises * (1 + 0.02e6 * (column - 4.5e-6))
        if entry.kind == "list":
            rises = rises * np.where(column == 1.0, 1.03, 1.0)
    return rises


def ensemble(unknown=ALL, count=64, tests=(), noise=0.0):
    inputs = tuple(entry for entry in unknown if entry.path not in _AFTERWARDS)
    layers = tuple("wear rate" if entry.path == RATE.path else "contact" for entry in inputs)
    size = samples_per_contact(layers, wears=True, separable=True)
    design = Design(inputs, layers, VELOCITIES, 0, size)
    values, velocities = design.draw(count)
    rises = np.stack([rise(values, load, velocities, inputs) for load in LOADS], axis=1)
    rises = rises * np.exp(noise * np.random.default_rng(0).standard_normal((count, 1)))
    return Ensemble(
        title="Closed form",
        unknown=unknown,
        design=design,
        conditions=Conditions(0.1, 298.15, 418.15),
        inputs=values,
        sample_velocities=velocities,
        contacts=np.arange(count) // size,
        loads=LOADS,
        rises=rises,
        tests=tuple(tests),
        velocity_error=0.0,
    )


def limit(inputs):
    return (inputs[:, 0] - 298.15) / inputs[:, 2]


def critical_velocity(inputs, load):
    return (limit(inputs) / rise(inputs, load, 1.0)) ** (1 / EXPONENT)


def field(samples):
    """Field of samples, with draws of the scene's own distributions."""
    return SampleField(samples, draws_of(samples, None), pipeline.results(dataset(samples)))


def margin(samples, load, velocity, scatter=0.0):
    """Margin at a load and velocity; `scatter` is the prior of the model's own error."""
    return answer(field(samples), load, velocity, ModelError(usual=scatter))


def dataset(samples, growth=((0.0, 1.0),), **told):
    """Dataset like that of `pipeline.open_sweep` for the samples of an ensemble.

    `growth` has pairs of a hold [s] and the factor by which rises have grown then. `told` has
    values of fields of the sweep.
    """
    holds, factors = np.array(growth).T
    rise = (samples.rises[..., None] * factors)[..., None]
    quantiles = np.array(QUANTILES)
    dims = ("variant", "load", "step")
    loads = np.broadcast_to(samples.loads[:, None], rise.shape[:3])
    count, unknown = len(samples.rises), samples.unknown
    draw = Draw(unknown, samples.design, samples.fixed)
    tests = {
        kind: tuple(Measurement(**test) for test in samples.tests if ("outcome" in test) == told)
        for kind, told in (("measured", False), ("tested", True))
    }
    about = synthetic.scene(
        conditions=samples.conditions,
        loading=tribo.Ramp(150.0, 750.0, hold=samples.hold),
        loads=tuple(samples.loads.tolist()),
        velocities=tuple(VELOCITIES),
        variants=drawn_rows(draw, count),
        wear=tribo.Wear(1.2e-15),
        roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 4e-6)),
        **{"title": samples.title, "preset": "draft"} | tests | told,
    )
    inputs = zip(samples.design.inputs, samples.inputs.T, strict=True)
    return xr.Dataset(
        {
            "normal_load": (dims, loads),
            "time": (dims, np.broadcast_to(1.0 + holds, rise.shape[:3])),
            "mean_rise": (dims, 0.6 * rise[..., 0]),
            "status": (dims[:2], np.full(rise.shape[:2], DONE)),
            "rise_quantile": ((*dims, "cooler_share"), rise * (1 + 0.5 * (quantiles - 0.9))),
        },
        {
            "variant": np.arange(len(samples.rises)),
            "sample": ("variant", np.arange(len(samples.rises))),
            "load": samples.loads,
            "cooler_share": quantiles,
            "step": np.arange(1 - len(holds), 1),
            "velocity": ("variant", samples.sample_velocities),
            **{entry.path: ("variant", column) for entry, column in inputs},
        },
        attributes_of(about),
    )
