"""Sweeps made of the fields of all their parts, by name."""

from dataclasses import fields

import numpy as np

from pipeline.analysis.dataset import read_conditions, stored_sweep
from pipeline.analysis.decisive import decisive_rise
from pipeline.store.inputs import split_arrays
from pipeline.store.schema import INPUTS
from pipeline.sweep.about import About
from pipeline.sweep.codec import sweep_text
from pipeline.sweep.model import PART_OF, Plane, Record, Sweep
from pipeline.sweep.variants import Variants
from tribo import Scene

_KINDS = {"scene": Scene, "plane": Plane, "record": Record, "about": About}


def sweep_of_fields(**values):
    """A sweep with these values of the fields of its parts, and the usual ones of the others."""
    assert values.keys() <= PART_OF.keys(), values.keys() - PART_OF.keys()
    parts = {
        part: kind(**{one.name: values[one.name] for one in fields(kind) if one.name in values})
        for part, kind in _KINDS.items()
    }
    variants = values.get("variants", Variants())
    return Sweep(**parts, conditions=values["conditions"], variants=variants)


def attributes_of(sweep, held=frozenset()):
    """Attributes of the dataset of a sweep, as its store has them, but for words for people.

    Arrays of the sweep lie beside its text, in the dataset, which must hold them by these digests.
    """
    arrays = {}
    text = sweep_text(sweep, arrays)
    assert arrays.keys() <= held, "arrays of a scene lie beside its text"
    return {"title": sweep.about.title, "sweep": text}


def with_fields(ds, **values):
    """The dataset of a sweep with other values of fields of its parts, by their names."""
    held = split_arrays(ds[INPUTS].values, ds[INPUTS].attrs).keys() if INPUTS in ds else set()
    return ds.assign_attrs(attributes_of(stored_sweep(ds).changed(**values), held))


def deciding(ds):
    """Temperature that decides at each point of one scene [K]."""
    judged = read_conditions(ds)
    return judged.contact_temperature(decisive_rise(ds, judged))


def inputs_of(table):
    """Inputs of the samples of a table by row, shape (n_sample, n_input)."""
    labels = ("sample", "velocity")
    return np.array([one.values for one in table.coordinates if one.name not in labels]).T
