"""Sweeps made of the fields of all their parts, by name."""

from dataclasses import fields

import numpy as np

from pipeline.sweep.about import About
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


def inputs_of(table):
    """Inputs of the samples of a table by row, shape (n_sample, n_input)."""
    labels = ("sample", "velocity")
    return np.array([one.values for one in table.coordinates if one.name not in labels]).T
