"""A sweep comes back from plain data as it was, and nothing else does."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pipeline
import tribo
from pipeline.analysis.dataset import stored_sweep
from pipeline.scene.shipped import shipped_scenes
from pipeline.sweep.codec import (
    CodecError,
    content_hash,
    decode,
    encode,
    fits,
    sweep_text,
    text_sweep,
)
from pipeline.sweep.laws import LawError
from pipeline.sweep.variants import rows, surfaces
from tests.helpers import synthetic, tiny
from tests.helpers.samples import dataset, ensemble
from tests.helpers.scenes import STEEL
from tests.helpers.unknowns import ALL


def back(sweep):
    """The sweep after a way through text."""
    arrays = {}
    text = sweep_text(sweep, arrays)
    assert json.loads(text)["type"] == "Sweep"
    return text_sweep(text, arrays)


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_shipped_scene_comes_back_equal(name):
    sweep = pipeline.load_scene(name)
    again = back(sweep)
    assert again == sweep
    assert hash(again.scene) == hash(sweep.scene)


RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0]), np.array([0.0, 80.0, 750.0]))
SCANNED = tribo.MeasuredRoughness(1e-7 * np.random.default_rng(0).standard_normal((32, 16)))


@pytest.mark.parametrize(
    "sweep",
    [
        tiny.full(roughness=SCANNED),
        tiny.sweep(loading=RECORD),
        tiny.sweep(variants=surfaces((7, 1))),
        tiny.sweep(
            variants=rows("pin", {"a": {"pin": tribo.Cylinder(1e-3, 3e-3, STEEL)}, "b": {}})
        ),
        tiny.sweep(disk=replace(STEEL, hardness=math.inf)),
        synthetic.scene(selection=synthetic.selection(), oil=synthetic.OIL),
        stored_sweep(dataset(ensemble(ALL, 32))),
    ],
    ids=["scan", "record", "surfaces", "rows by hand", "elastic", "picked", "samples"],
)
def test_a_sweep_of_any_kind_comes_back_equal(sweep):
    again = back(sweep)
    assert again == sweep
    assert again.variants.names == sweep.variants.names


PARTS = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63) + 1, 2**63 - 1)
    | st.floats()
    | st.text(st.characters(codec="utf-8"))
    | st.sampled_from(["nan", "inf", "-inf", "type"]),
    lambda inner: (
        st.lists(inner, max_size=3).map(tuple)
        | st.dictionaries(st.text(max_size=4) | st.integers(), inner, max_size=3)
    ),
    max_leaves=8,
)


def same(one, other):
    """True for equal values of equal types, NaN included."""
    if isinstance(one, float) and math.isnan(one):
        return isinstance(other, float) and math.isnan(other)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return type(one) is type(other) and one == other


@settings(max_examples=100, deadline=None)
@given(part=PARTS)
def test_any_part_comes_back_with_its_type(part):
    assert same(decode(json.loads(json.dumps(encode(part, {}))), {}), part)


@pytest.mark.parametrize(
    ("value", "hint", "is_fit"),
    [
        (2**63 - 1, int, True),  # the largest of a variable of whole numbers
        (-(2**63) + 1, int, True),
        (2**63, int, False),
        (1.0, int, False),
        (True, int, False),
        (3, float, True),
        (1.7976931348623157e308, float, True),
        (10**400, float, False),
        (math.inf, float, True),
        ("3", float, False),
        (True, float, False),
        (True, bool, True),
        (1, bool, False),
        ("a", str, True),
        (True, str, False),
        (None, float | None, True),
        ("b", Literal["a", "b"], True),
        ("c", Literal["a", "b"], False),
        ((1.0, 2), tuple[float, int], True),
        ((1.0,), tuple[float, int], False),
        ((1.0, 2.0), tuple[float, int], False),
        ((1.0, 2.0, 3.0), tuple[float, ...], True),
        ((1.0, "a"), tuple[float, ...], False),
        ([1.0], tuple[float, ...], False),
        ([1.0], list[float], True),
        ({"a": 1.0}, dict[str, float], True),
        ({"a": "b"}, dict[str, float], False),
        ({1: 1.0}, Mapping[str, float], False),
        (np.ones(3), tribo.types.Array, True),
        (object(), Any, True),
    ],
)
def test_a_value_fits_the_kind_of_its_field(value, hint, is_fit):
    assert fits(value, hint) is is_fit


def test_kinds_of_numbers_of_numpy_are_those_of_python():
    assert decode(encode((np.int64(3), np.float64(0.5), np.bool_(True)), {}), {}) == (3, 0.5, True)


def test_a_pin_or_a_part_that_is_new_needs_nothing_else(monkeypatch):
    class Barrel(tribo.Cylinder):
        """A pin that the package does not have."""

    monkeypatch.setitem(tribo.PINS, "barrel", Barrel)
    sweep = tiny.sweep(pin=Barrel(2e-3, 3.4e-3, STEEL))
    assert type(back(sweep).scene.pin) is Barrel


def places(data, path=()):
    """Paths of all values within plain data."""
    yield path
    if isinstance(data, dict | list):
        for key, inner in data.items() if isinstance(data, dict) else enumerate(data):
            yield from places(inner, (*path, key))


FORGED = st.sampled_from(
    [
        *(None, True, -1, 10**400, 1e300, "text", [], {}, [1.0, 2.0]),
        *({"type": name} for name in ("Law", "Rule", "Sweep", "os", 3)),
        {"type": "float", "value": "1"},
        {"type": "Cylinder", "radius": 1.0, "length": "x", "material": None},
    ]
)


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_a_forged_text_is_an_error_or_another_sweep_of_the_same_types(data):
    text = sweep_text(tiny.sweep(variants=surfaces((1, 2))), {})
    document = [json.loads(text)]
    path = (0, *data.draw(st.sampled_from([*places(document[0])])))
    inner = document
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = data.draw(FORGED)
    try:
        sweep = text_sweep(json.dumps(document[0]), {})
    except CodecError:
        return
    assert sweep_text(sweep, {})
    assert repr(sweep)


@dataclass(frozen=True)
class Fading:
    """A law of the user's own."""

    distance: float
    pattern: str = "swept"

    def over(self, begin, end):
        return tribo.Wear(1e-15 / (1 + end / self.distance), self.pattern)


def test_a_law_comes_back_as_its_name_and_hash_and_never_runs():
    law = Fading(distance=2.0)
    again = back(tiny.sweep(wear=law)).scene
    assert again.wear.name.endswith(":Fading")
    assert again.wears_by_law
    assert again.contact_pattern == "swept"
    assert content_hash(again) == content_hash(tiny.sweep(wear=law).scene)
    assert content_hash(again) != content_hash(tiny.sweep(wear=replace(law, distance=3.0)).scene)
    with pytest.raises(LawError, match="of which a store keeps the name alone"):
        again.wear.over(0.0, 1.0)
