"""Kinds of parts that somebody adds, and what no field of a sweep may be."""

import json
from dataclasses import dataclass

import pytest

import tribo
from pipeline.sweep.about import Measurement
from pipeline.sweep.codec import CodecError, sweep_text, text_sweep
from tests.helpers import tiny
from tests.helpers.scenes import STEEL


def test_a_pin_and_wear_with_slots_that_derive_from_others_come_back(monkeypatch):
    @dataclass(frozen=True, slots=True)
    class Tapered(tribo.Cylinder):
        crown: float = 1.0

    @dataclass(frozen=True, slots=True)
    class Slowing(tribo.Wear):
        factor: float = 2.0

    monkeypatch.setitem(tribo.PINS, "tapered", Tapered)
    pin, wear = Tapered(2e-3, 3.4e-3, STEEL, crown=0.2), Slowing(1e-15, "swept", 3.0)
    sweep, arrays = tiny.sweep(pin=pin, wear=wear), {}
    back = text_sweep(sweep_text(sweep, arrays), arrays)
    assert back == sweep
    assert (type(back.scene.pin), type(back.scene.wear)) == (Tapered, Slowing)


def test_a_test_has_an_outcome_that_is_known_or_none():
    tests = Measurement(400.0, 2.0, outcome="mild"), Measurement(400.0, 3.0)
    document = json.loads(sweep_text(tiny.sweep(measured=tests), {}))
    assert text_sweep(json.dumps(document), {}).about.measured == tests
    document["about"]["measured"][0]["outcome"] = "Severe"
    with pytest.raises(CodecError, match="outcome is 'Severe', which it cannot be"):
        text_sweep(json.dumps(document), {})
