"""Settings of the process, which belong to the caller, change no answer and are not changed."""

import decimal
import subprocess
import sys

import numpy as np
import pytest
from matplotlib import rc_context

import pipeline
from tests.helpers import synthetic


def answers():
    """Text of several answers, on a scene whose quantities have many digits and on a sweep."""
    scene = pipeline.load_scene(
        "first_try",
        overrides={
            "pin.radius": "0.0787 inch",
            "temperature.bulk": "24.98765 degC",
            "sweep.loads": {"from": "0.1 kN", "to": "0.7 kN", "step": "0.2 kN"},
        },
    )
    point = pipeline.run_point(scene, "89.9236 lbf", "1.00001 m/s")
    ds = synthetic.sweep()
    rows = {"load": ["412.3456 N"], "velocity": ["1.423456 m/s"]}
    return repr(
        (
            scene.scene.pin.radius,
            scene.conditions.bulk_temperature,
            scene.loads,
            {name: values.tolist() for name, values in point.columns.items()},
            pipeline.boundary(ds)["critical_velocity"].values.tolist(),
            pipeline.margin(ds, "400.0001 N", "1.4 m/s").to_dict(),
            pipeline.margin(ds, rows).to_dict(),
            pipeline.temperatures(ds)["max_temperature"].values.tolist(),
        )
    )


@pytest.fixture(scope="module")
def usual():
    return answers()


SETTINGS = {
    "every floating-point error raises": lambda: np.errstate(all="raise"),
    "arrays are printed short": lambda: np.printoptions(precision=2, threshold=3),
    "three decimals": lambda: decimal.localcontext(prec=3, rounding=decimal.ROUND_UP),
    "traps": lambda: decimal.localcontext(
        traps=[decimal.Inexact, decimal.Rounded, decimal.FloatOperation]
    ),
    "figures": lambda: rc_context({"axes.formatter.use_locale": True, "font.size": 20}),
}


@pytest.mark.parametrize("name", SETTINGS)
def test_no_setting_of_the_process_changes_an_answer(usual, name):
    with SETTINGS[name]():
        found = answers()
    assert found == usual


def test_units_that_are_read_first_under_few_decimals_are_exact():
    code = (
        "import decimal; decimal.getcontext().prec = 3\n"
        "import pipeline; print(pipeline.to_si('89.9236 lbf', like='1 N'))\n"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    exact = pipeline.to_si("89.9236 lbf", like="1 N")
    assert shown.stdout.strip() == repr(exact) == "400.0001012420391"
