"""All refusals of unknown inputs: what causes each, and what its message says."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

import pipeline
from pipeline.scene.scenefile import load_scene
from pipeline.store.create import writing
from pipeline.uncertain import critical_temperature, entries
from pipeline.uncertain.unknown import Unknown
from tests.helpers import synthetic
from tests.helpers.refusals import command, refusal_tests
from tests.helpers.samples import LOADS, dataset, ensemble, field
from tests.helpers.scenes import SCENE
from tests.helpers.unknowns import ALL, LENGTH, RATE
from tribo import Corrections, Friction

RATES = '"wear.specific_wear_rate" = { median = "1.2e-6 mm^3/(N m)", factor = 1.5 }'
FRICTIONS = '"friction.coefficient" = { mean = 0.13, sd = 0.01 }'
RADII = '"pin.radius" = { mean = "2 mm", sd = "0.1 mm" }'
PLACE = "--load", "500 N", "--velocity", "1 m/s"


def scene(*unknown, sweep="samples = 8", text=SCENE, overrides=None):
    """Function that reads a scene with these unknown inputs."""

    def build():
        inputs = "\n".join(["[unknown]", *unknown]) if unknown else ""
        Path("scene.toml").write_text(text.replace("fields = true", sweep) + inputs)
        return load_scene("scene.toml", overrides=overrides)

    return build


def inferred(*options, text=SCENE):
    def build():
        Path("scene.toml").write_text(text)
        return command("infer", "scene.toml", *options)

    return build


def asked(name, *options):
    """Function that runs a command on a store in which no sample is computed."""

    def build():
        with writing("samples.zarr", scene(RATES, FRICTIONS)()):
            pass
        return command(name, "samples.zarr", *options)

    return build


def weighed(loads=3, unknown=ALL, load=400.0, velocity=2.0, **told):
    """Function that weighs the unknown inputs by one test."""

    def build():
        test = {"normal_load": load, "velocity": velocity, "friction": 0.1} | told
        made = ensemble(unknown, tests=[test])
        made = replace(made, loads=LOADS[:loads], rises=made.rises[:, :loads])
        return pipeline.posterior(made, 0.01)

    return build


def all_fixed():
    """Ask for the sensitivity of samples without an unknown input."""
    return pipeline.sensitivity(replace(ensemble(), unknown=()))


def failing():
    """Infer critical temperatures while the simulation of a point fails."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(critical_temperature, "results_of", lambda *_: ({}, {"a point"}))
        patch.setattr(critical_temperature, "run_sweep", lambda *_, **__: None)
        patch.setattr(critical_temperature, "opened", lambda _: None)
        return pipeline.critical_temperatures("first_try")


def too_few():
    with writing("samples.zarr", scene(RATES, FRICTIONS)()):
        pass
    return pipeline.Ensemble.of(pipeline.open_sweep("samples.zarr"))


def an_input(kind, *parameters):
    return lambda: Unknown("friction.coefficient", kind, parameters)


def rough():
    hurst = Unknown("disk.roughness.hurst_exponent", "uniform", (0.7, 0.9))
    drawn = dataset(ensemble((*ALL, hurst), 32))
    return pipeline.at(drawn, **{hurst.path: "a"})


DUTY = {"load [N]": [400.0], "velocity [m/s]": [2.0], "friction": [0.1]}


def bent():
    """Judge a row with its own friction by samples whose friction falls with velocity."""
    falling = Corrections(friction=Friction(by_velocity=((1.0, 1.2), (4.0, 0.8))))
    conditions = replace(ensemble().conditions, corrections=falling)
    return field(replace(ensemble(), conditions=conditions)).judged_by({"friction": 0.09})


def weighed_rows():
    test = {"normal_load": 400.0, "velocity": 2.0, "friction": 0.1}
    judged = pipeline.at(dataset(ensemble(tests=[test])), given_measured=True)
    return pipeline.margin(judged, DUTY)["notes"].item()


def many():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(entries, "MOST_INPUTS", 1)
        return scene(RATES, FRICTIONS)()


def oils():
    test = {"normal_load": 400.0, "velocity": 2.0, "friction": 0.1}
    return pipeline.posterior(ensemble((RATE, LENGTH), tests=[test, test | {"oil": "B"}]), 0.05)


def recorded():
    Path("load.csv").write_text("time [s],load [N]\n0,0\n1,200\n4,600\n")
    ramp = 'rate = "150 N/s"\nreference_load = "750 N"'
    assert ramp in SCENE
    text = SCENE.replace(ramp, 'file = "load.csv"')
    return inferred("--contact-width", "0.2 mm", *PLACE, "--duration", "9 s", text=text)()


TWO_BULKS = {"temperature.bulk": {"pin": "30 degC", "disk": "25 degC"}}
SHARE = '"temperature.failing_share" = { from = 0.05, to = 0.2 }'
OIL = """
[oil]
kinematic_viscosity = ["32 mm^2/s", "5 mm^2/s"]
density = "866 kg/m^3"
pressure_viscosity_coefficient = "20 1/GPa"
"""
# Each of the two inputs is valid with the scene's value of the other one.
DISC = SCENE.replace("[disk]", '[disk]\ndiameter = "60 mm"\nwidth = "5 mm"\nbore = "10 mm"')
RING = (
    '"disk.diameter" = { from = "20 mm", to = "60 mm" }',
    '"disk.bore" = { from = "10 mm", to = "50 mm" }',
)
UNFIT = (
    RATES,
    FRICTIONS.replace(" }", ', correlated = { "wear.specific_wear_rate" = 0.9 } }'),
    RADII.replace(
        " }",
        ', correlated = { "wear.specific_wear_rate" = 0.9, "friction.coefficient" = -0.9 } }',
    ),
)


def joint(other, *more, inner=""):
    """Function that reads a scene whose wear rate has a correlation of 0.5 with another input."""
    return scene(RATES.replace(" }", f", correlated = {{ {other} = 0.5 }}{inner} }}"), *more)


REFUSALS = {
    "text": (rough, 'disk.roughness.hurst_exponent: "a" is not a number'),
    "too far": (lambda: pipeline.at(dataset(ensemble()), **{RATE.path: 1.0}), "outside the"),
    "sd": (an_input("normal", 0.1, 0.0), "sd is 0; give a value above 0"),
    "falling": (an_input("uniform", 6.0, 3.0), "from 6 to 3 does not rise"),
    "one": (an_input("list", 1.0), "at least two different values"),
    "nan": (an_input("normal", math.nan, 1.0), "is not a distribution; give finite numbers"),
    # the scene
    "critical twice": (
        scene(FRICTIONS, overrides={"temperature.critical_sd": "8 K"}),
        "temperature.critical_sd: sweep.samples ignores this",
    ),
    "all known": (scene(), "sweep.samples: 8 needs unknown inputs"),
    "form": (scene('"friction.coefficient" = 0.1'), "0.1 is not a distribution"),
    "bulks": (scene(RATES, overrides=TWO_BULKS), "[unknown] needs one bulk temperature"),
    "many": (many, "inputs are unknown; give"),
    "surfaces": (
        scene(RATES, sweep="samples = 8\nrealizations = 3"),
        "sweep.samples excludes them",
    ),
    "velocity": (scene(RATES, overrides={"sweep.velocities": ["1 m/s"]}), "at least two above 0"),
    "unsound": (
        scene(*RING, text=DISC),
        "unknown: a sample is not a sound scene",
    ),
    "entry": (scene('"sweep.samples" = [1, 2]'), "this cannot be unknown; give an entry"),
    "units": (scene(RADII.replace('"0.1 mm"', "0.1")), "give all with a unit, or none"),
    "no unit": (scene(RADII.replace(" mm", "")), "or plain numbers"),
    "tried": (
        scene('"pin.radius" = { from = "-1 mm", to = "2 mm" }'),
        'unknown."pin.radius": pin.radius: "',
    ),
    "steps": (
        scene('"loading.reference_load" = { from = "500 N", to = "750 N" }'),
        "it changes the number of steps",
    ),
    "nothing": (scene(SHARE, overrides={"temperature.criterion": "mean"}), "depends on it"),
    "undecisive": (
        scene('"oil.density" = { from = "800 kg/m^3", to = "900 kg/m^3" }', text=SCENE + OIL),
        "depends on it",
    ),
    # datasets
    "cut to a load": (
        lambda: pipeline.boundary(dataset(ensemble()).sel(load=400.0)),
        "a single load and no such dimension; select a list with one value, such as ds.sel(load=",
    ),
    "cut to a sample": (
        lambda: pipeline.margin(dataset(ensemble()).isel(variant=0), 400.0, 2.0),
        "a single sample, but answers need all samples; do not select by variant",
    ),
    # correlations
    "no other": (joint('"pin.radius"', FRICTIONS), "this is not another input of [unknown]"),
    "a list": (
        joint('"disk.roughness.seed"', '"disk.roughness.seed" = [0, 1]'),
        "a list cannot be correlated, nor can inputs",
    ),
    "twice": (
        joint(
            '"pin.radius"',
            RADII.replace(" }", ', correlated = { "wear.specific_wear_rate" = 0.4 } }'),
        ),
        "elsewhere; give it once",
    ),
    "unfit": (scene(*UNFIT), "contradict each other; give smaller"),
    # tests
    "no test": (inferred(), "has no measured transition; give it a [[measured]]"),
    "failing": (failing, "a point could not be computed"),
    "far load": (weighed(load=900.0), "the test at 900 N and 2 m/s: load is 900 N"),
    "beyond": (lambda: ensemble().require_within([400.0], [9.0]), "the samples have 0.5 to 6 m/s"),
    "hold": (weighed(hold=60.0), "held the load for 60 s, the samples for 0 s"),
    "no draw": (weighed(velocity=0.55, velocity_scatter=0.005), "hardly any draw agrees"),
    "scatter": (lambda: pipeline.posterior(ensemble(), 2.0), "scatter is 2; give a share between"),
    "no tests": (
        lambda: pipeline.boundary(pipeline.at(dataset(ensemble()), given_measured=True)),
        "no measured transition and no test",
    ),
    "oils": (oils, "the tests are of 2 oils, each with a critical temperature"),
    # answers
    "no samples": (lambda: pipeline.Ensemble.of(synthetic.sweep()), "the sweep has no samples"),
    "too few": (too_few, "0 of 8 samples are done at every load"),
    "rows": (bent, "cannot be judged row by row at another"),
    "weighed rows": (weighed_rows, "tests weigh samples under the scene's own"),
    # commands
    "not run": (
        inferred(text=SCENE.replace("fields = true", "samples = 8") + f"[unknown]\n{RATES}"),
        "the samples of scene.toml are not computed; run irg run scene.toml",
    ),
    "stay": (asked("infer", "--preset", "draft"), "stay as they were computed; leave out --preset"),
    "not computed": (
        asked("infer", "--workers", "2", "--store", "other.zarr"),
        "stay as they were computed; leave out --store, --workers",
    ),
    "needs samples": (inferred("--scatter", "0.1"), "--scatter needs samples of unknown inputs"),
    "ignored": (inferred("--duration", "9 s"), "--duration belongs to --contact-width"),
    "no place": (inferred("--contact-width", "0.2 mm"), "needs a load and a velocity; give"),
    "short": (
        inferred("--contact-width", "0.2 mm", *PLACE, "--duration", "1 s"),
        "must be at least the",
    ),
    "record": (recorded, "--duration holds a ramp; a recorded load ends where the record does"),
    "none unknown": (all_fixed, "no input of the samples is unknown"),
}


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "uncertain", REFUSALS
)
