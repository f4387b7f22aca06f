"""All refusals of gear pairs: what causes each, and what its message says."""

import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from pipeline import gears
from pipeline.gears.contact import mesh
from pipeline.gears.fzg import critical_temperature, rig_pair
from pipeline.gears.reading import shipped_pairs
from pipeline.gears.rules import stage_torque, warm_duty
from pipeline.gears.scene import scene_toml
from pipeline.gears.spectrum import read_spectrum
from tests.helpers.refusals import command, refusal_tests
from tests.pipeline.gears.test_answer import CRITICAL, OWN
from tests.pipeline.gears.test_involute import pair as toothed
from tests.pipeline.gears.test_involute import plain
from tests.pipeline.gears.test_words import HELICAL
from tribo import InputError


def pair(*changes, **overrides):
    """Function that reads a user's pair file with texts replaced, or with other entries."""

    def build():
        text = OWN
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        Path("own.toml").write_text(text)
        return gears.read_pair("own.toml", overrides)

    return build


def fzg(*options):
    return partial(command, "gears", "fzg_a", *options)


def involutes(**changed):
    return partial(toothed, **changed)


def duties(text):
    def build():
        Path("duty.csv").write_text(text)
        return read_spectrum("duty.csv", gears.read_pair("fzg_a"))

    return build


def extending(entry):
    """Function that reads a pair file which extends the test gears and changes an entry."""

    def build():
        shutil.copy(shipped_pairs()["fzg_a"], "base.toml")
        Path("own.toml").write_text(f'extends = "base.toml"\n{entry}\n')
        return gears.read_pair("own.toml")

    return build


REFUSALS = {
    # the file
    "no file": (partial(gears.read_pair, "fzg_b"), "no such file; give that of a pair, or fzg_a"),
    "speed": (pair(('"157 rad/s"', '"25 1/s"')), '"25 1/s" is not in rpm or rad/s'),
    "key": (pair(("title", "colour = 3\ntitle")), "colour: unknown key"),
    "material": (pair(('"bronze CuSn12"', '"bronce"')), '"bronce" is neither a table'),
    "density": (pair(('like = "ISO VG 46"', 'temperatures = ["40 degC", "100 degC"]\n'
                      'kinematic_viscosity = ["46 mm^2/s", "7 mm^2/s"]')),
                "give kinematic_viscosity and density"),
    "temperatures": (partial(gears.read_pair, "fzg_a", {"temperature.oil": "90 degC"}),
                     "temperature: give either the key bulk"),
    # the teeth
    "interfering": (pair(("teeth = 21", "teeth = 12")), "contact begins at a radius of"),
    "distance": (involutes(centre_distance=95e-3), "mesh.centre_distance is 95 mm, but the"),
    "tip": (involutes(tip_diameters=(60e-3, 112.5e-3)), "pinion.tip_diameter is 60 mm, inside"),
    "ratio": (involutes(tip_diameters=(88.77e-3, 108e-3)), "contact ratio is 0.924"),
    "helical ratio": (partial(gears.read_pair, "fzg_a", HELICAL | {
        "pinion.tip_diameter": "77.5 mm", "wheel.tip_diameter": "113 mm"}),
                      "contact ratio is 0.837"),
    "shifts": (involutes(profile_shifts=(-3.0, -2.0)), "fit no centre distance"),
    "flank": (partial(plain, 12, 24), "or a smaller wheel.tip_diameter"),
    "undercut": (partial(plain, 14, 14), "contact begins at a radius of curvature of 235.1 mm"),
    "pitch point": (involutes(teeth=(38, 56), profile_shifts=(-1.0, -0.1), tip_diameters=(
        0.1647, 0.2574), centre_distance=0.20594), "contact at 0 mm, the pitch point"),
    # rules and simulations
    "stage": (partial(stage_torque, 13), "load stage is 13; FZG A/8.3/90 has 1 to 12"),
    "failure stage": (lambda: critical_temperature(gears.read_pair("fzg_a"), 13),
                      "failure load stage is 13; give 2 to 12"),
    "oil of a stage": (lambda: rig_pair(replace(pair()(), oil=None)),
                       "and the pair has no oil"),
    "friction": (lambda: mesh(gears.read_pair("fzg_a", {"without": ["oil"]})), "needs an oil"),
    "fine": (lambda: scene_toml([mesh(gears.read_pair("fzg_a", {
        "surface.correlation_length": ["1 nm", "4 um"]}))]), "surface.correlation_length is 0.001"),
    "no duty": (duties("torque [N m],speed [rpm]\n"), "there are no rows"),
    "bulk of a duty": (duties("torque [N m],speed [rpm]\n372.6,2170\n534.5,2170\n"),
                       "row 3, bulk_temperature: the bulk temperature of the file, 165.7 °C,"),
    "bulk of another": (lambda: warm_duty(gears.read_pair("fzg_a"), 534.5, 227.2),
                        "give the bulk temperature of this duty, or the temperature of the oil"),
    "bulk of a file": (partial(gears.read_pair, "fzg_a", {"duty.torque": "534.5 N m"}),
                       "temperature.bulk: the file's value is for its own duty"),
    "bulk of a base": (extending('duty.torque = "534.5 N m"'),
                       "temperature.bulk (in base.toml): the file's value is for its own duty"),
    "bulk and oil": (duties("torque [N m],speed [rpm],oil temperature [degC],bulk temperature "
                            "[degC]\n534.5,2170,90,203\n"), "give only one column"),
    "duty": (duties("torque [N m],speed [rpm]\nx,3\n"), "row 2, torque"),
    # options
    "stages": (fzg("--stages"), "need a critical temperature"),
    "two": (fzg("--failure-stage", "9", *CRITICAL), "not allowed with argument"),
    "sheet": (fzg("--sheet", "one"), "--sheet needs --points"),
}  # fmt: skip

ELSEWHERE = {
    "judge._worst_margins pipeline.ExecutionError": "by nobody: a place that fails, as in a run",
}
"""Refusals that are not in the table: where they are tested, or why not."""


def test_hours_and_factors_of_a_spectrum_are_in_range():
    columns = {"torque": ["1 N m"], "speed": ["9 rpm"], "hours": [-1], "load factor": [0]}
    with pytest.raises(InputError) as caught:
        read_spectrum(columns, gears.read_pair("fzg_a"))
    assert "row 1, hours: " in str(caught.value)
    assert "row 1, load_factor: 0 is out of range; give a number" in str(caught.value)


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "gears", REFUSALS, ELSEWHERE
)
