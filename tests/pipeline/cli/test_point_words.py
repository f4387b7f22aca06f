"""Sentences on one point, at numbers that are given."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.analysis.rise_error import RiseError
from pipeline.cli.points import _point_lines
from pipeline.sweep.model import Point
from pipeline.sweep.remarks import Remark
from pipeline.sweep.severity import MOLTEN
from tests.helpers import tiny
from tests.helpers.entries import changed
from tribo import Corrections, Friction

SWEEP = tiny.sweep()
TOLD = {
    "time": 2.66667, "sliding_distance": 5.33333, "verdict": "mild", "probability": 0.123,
    "probability_bound": "at most", "model_error": "5 %", "molten": False, "not_counted": None,
}  # fmt: skip


def lines(sweep=SWEEP, velocity=2.0, elements=(32, 16), warnings=(), **told):
    state = SimpleNamespace(pressure=np.zeros(elements))
    result = SimpleNamespace(point=Point(400.0, velocity), state=state, warnings=warnings)
    return [*_point_lines(sweep, result, TOLD | told, RiseError(1.5, 2.0, 0.0))]


def test_a_point_has_its_verdict_what_decides_it_and_its_probability():
    assert lines() == [
        "400 N at 2 m/s after 2.67 s and 5.33 m: mild wear",
        "wear is severe with more than 10 % of the contact above 145 °C; the decisive temperature "
        "is exceeded on 10 % of the contact, its error ± 2.5 K: interpolation 1.5 K, preset 2 K",
        "the next run is severe with 12 % probability at most, if the rise grows as the velocity; "
        "the model's own error: 5 %",
    ]
    above = lines(probability=0.76, probability_bound="at least")
    assert above[2].startswith("the next run is severe with 76 % probability at least, if")
    assert lines(verdict="not decided")[0].endswith(" m: not decided")
    curve = Corrections(friction=Friction(by_velocity=((0.5, 1.2), (5.0, 0.8))))
    curved = changed(SWEEP, conditions=replace(SWEEP.conditions, corrections=curve))
    assert lines(curved)[2].startswith(
        "the next run is severe with 12 % probability, if the rise grows as the velocity, with "
        "friction by velocity; the model's"
    )
    unknown = changed(SWEEP, conditions=replace(SWEEP.conditions, critical_temperature=None))
    verdict, decisive = lines(unknown, verdict=None, probability=None)
    assert verdict.endswith(": mild or severe is not known without temperature.critical")
    assert decisive.startswith("the decisive temperature is ")


@pytest.mark.parametrize(
    ("changes", "notes"),
    [
        ({"velocity": -2.0}, ["note: the velocity is negative, so the disk slides towards −x"]),
        ({"velocity": 0.0}, []),
        ({"elements": (16, 8)},
         ["note: area and pressure depend on the elements, here 2 × 2 pixels; on larger ones more "
          "of the surface touches, at lower pressure"]),
        ({"elements": (16, 8), "sweep": tiny.sweep(roughness=None)}, []),
        ({"sweep": tiny.sweep(notes=(Remark("pin", "note", "new"),))}, ["note: pin: new"]),
        ({"warnings": [("few nodes", "few touch")], "molten": True, "not_counted": "the film"},
         ["warning: few touch", f"warning: {MOLTEN}", "warning: the film"]),
    ],
)  # fmt: skip
def test_a_point_has_notes_and_warnings_where_there_is_something_to_say(changes, notes):
    assert lines(**changes)[3:] == notes
