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
from pipeline.store.root import FACTS
from pipeline.store.schema import path_of
from tests.helpers import tiny
from tests.helpers.stores import commit, forge, places

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


def edit(document, path, new):
    """Replace the value at a path of a JSON document."""
    for key in path[:-1]:
        document = document[key]
    document[path[-1]] = new


@pytest.fixture(scope="module")
def forged(alone, tmp_path_factory):
    return shutil.copytree(alone, tmp_path_factory.mktemp("forged") / "tiny.zarr")


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_any_value_of_the_root_may_be_any_other_with_the_right_digest(forged, alone, data):
    (forged / FACTS).write_bytes((alone / FACTS).read_bytes())
    facts = json.loads((alone / FACTS).read_text())["attributes"]
    path = data.draw(st.sampled_from([one for one in places(facts) if one]))
    new = data.draw(JSON)
    forge(forged, lambda _, facts: edit(facts, path, new))
    text, refused = (forged / FACTS).read_text(), 0
    for function in (pipeline.summary, pipeline.open_sweep, pipeline.verify_store):
        try:
            function(forged)
        except StoreError:
            refused += 1
    if refused:  # values that are not refused are not read, or make another sound sweep
        assert refused == 3
        with pytest.raises(StoreError):
            commit(forged, SWEEP, ())
        assert (forged / FACTS).read_text() == text


@settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_any_value_of_the_metadata_of_an_array_may_be_any_other(forged, alone, data):
    """Metadata of arrays follow from the sweep; only `verify_store` reads them."""
    (forged / FACTS).write_bytes((alone / FACTS).read_bytes())
    name = data.draw(st.sampled_from(["mean_rise", "status", "message", "load", "pressure"]))
    text = (alone / path_of(name) / ROOT).read_text()
    path = data.draw(st.sampled_from(list(places(json.loads(text)))))
    document = {"whole": json.loads(text)}
    edit(document, ("whole", *path), data.draw(JSON))
    (forged / path_of(name) / ROOT).write_text(json.dumps(document["whole"]))
    before = pipeline.open_sweep(alone)
    assert pipeline.open_sweep(forged).load().equals(before.load())
    assert pipeline.verify_store(forged).done == 9


def test_a_fault_of_this_program_is_not_called_damage_of_the_store(path, monkeypatch):
    commit(path, tiny.sweep(title="read with a fault"), ())

    def faulty(*_, **__):
        raise TypeError("a fault of this program")

    monkeypatch.setattr(tribo.Ramp, "__post_init__", faulty)
    for read in (pipeline.open_sweep, pipeline.summary):
        with pytest.raises(TypeError, match="a fault of this program"):
            read(path)
