"""Kinds of parts that somebody adds, and what no field of a sweep may be."""

import json

import pytest

from pipeline.scene.kept import SweepTextError, sweep_text, text_sweep
from pipeline.sweep.about import Measurement
from tests.helpers import tiny


def test_a_test_has_an_outcome_that_is_known():
    document = json.loads(sweep_text(tiny.sweep(tested=(Measurement(400.0, 2.0, outcome="mild"),))))
    assert text_sweep(json.dumps(document), {}).about.tested[0].outcome == "mild"
    document["entries"]["tested"][0]["outcome"] = "Severe"
    with pytest.raises(SweepTextError, match=r'tested\[0\].outcome: "Severe" is unknown'):
        text_sweep(json.dumps(document), {})
