"""Roots of stores that are not as they were written."""

import json
import math
import shutil

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pipeline
import tribo
from pipeline import StoreError
from pipeline.store.place import ROOT
from pipeline.store.root import FACTS, Root
from pipeline.store.schema import path_of
from tests.helpers import tiny
from tests.helpers.stores import commit, contents, places

SWEEP = tiny.full()
JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats()
    | st.text(st.characters(codec=None), max_size=8)
    | st.sampled_from([[], {}, -1, 10**12, "float32", "inf", [1, 1, 1], math.inf]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=5,
)


def edited(text, path, new):
    """A JSON document with another value at a path."""
    document = [json.loads(text)]
    inner, keys = document, (0, *path)
    for key in keys[:-1]:
        inner = inner[key]
    inner[keys[-1]] = new
    return document[0]


@pytest.fixture(scope="module")
def forged(alone, tmp_path_factory):
    return shutil.copytree(alone, tmp_path_factory.mktemp("forged") / "tiny.zarr")


@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_any_value_of_the_root_may_be_any_other(forged, alone, data):
    text = (alone / FACTS).read_text()
    path = data.draw(st.sampled_from(list(places(json.loads(text)))))
    document = edited(text, path, data.draw(JSON))
    if json.dumps(document, sort_keys=True) == json.dumps(json.loads(text), sort_keys=True):
        return
    (forged / FACTS).write_text(json.dumps(document))
    refused = 0
    for function in (pipeline.summary, pipeline.open_sweep, pipeline.verify_store):
        try:
            function(forged)
        except StoreError:
            refused += 1
    if refused:  # values that are not refused are not read
        assert refused == 3
        with pytest.raises(StoreError):
            commit(forged, SWEEP, ())
        assert (forged / FACTS).read_text() == json.dumps(document)
    else:
        found, before = (pipeline.open_sweep(store).load() for store in (forged, alone))
        assert found.equals(before)
        assert found.attrs["title"] == SWEEP.title


@settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_any_value_of_the_metadata_of_an_array_may_be_any_other(forged, alone, data):
    """Metadata of arrays follow from the sweep; only `verify_store` reads them."""
    (forged / FACTS).write_bytes((alone / FACTS).read_bytes())
    name = data.draw(st.sampled_from(["mean_rise", "status", "message", "load", "pressure"]))
    text = (alone / path_of(name) / ROOT).read_text()
    path = data.draw(st.sampled_from(list(places(json.loads(text)))))
    document = edited(text, path, data.draw(JSON))
    (forged / path_of(name) / ROOT).write_text(json.dumps(document))
    before = pipeline.open_sweep(alone)
    assert pipeline.open_sweep(forged).load().equals(before.load())
    assert pipeline.verify_store(forged).done == 9


def test_a_root_that_another_program_writes_in_another_form_is_read(forged, alone):
    (forged / ROOT).write_text(json.dumps(json.loads((alone / ROOT).read_text()), indent=1))
    assert pipeline.summary(forged).done == 9
    assert contents(forged).keys() == contents(alone).keys()


@pytest.mark.parametrize("kind", [TypeError, AttributeError, KeyError])
@pytest.mark.parametrize(
    ("room", "name"),
    [
        (tribo.Scene, "__post_init__"),
        (tribo.Ramp, "__post_init__"),
        (Root, "__init__"),
    ],
)
def test_a_fault_of_this_program_is_not_called_damage_of_the_store(
    path, monkeypatch, room, name, kind
):
    sweep = tiny.sweep(title=f"read with a {kind.__name__} of {room.__name__}")
    commit(path, sweep, ())

    def faulty(*_, **__):
        raise kind("a fault of this program")

    monkeypatch.setattr(room, name, faulty)
    for read in (pipeline.open_sweep, pipeline.summary):
        with pytest.raises(kind, match="a fault of this program"):
            read(path)
