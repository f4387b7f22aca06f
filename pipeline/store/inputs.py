"""Arrays of a scene, such as the heights of a measured surface: one variable holds all of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.store.schema import Variable
from tribo.types import Array

DIM = "input"
"""Dimension of the variable, which has no coordinate."""


def inputs_variable(arrays: Mapping[str, Array]) -> Variable:
    """The variable of some arrays; its attributes tell where each lies."""
    table = {
        "digests": " ".join(arrays),
        "sizes": " ".join(str(array.size) for array in arrays.values()),
    }
    meaning = "arrays that the attribute sweep names by their digests, one after the other"
    return Variable((DIM,), None, meaning, attributes=table)


def joined_arrays(arrays: Mapping[str, Array]) -> Array:
    """Values of the variable."""
    return np.concatenate([array.ravel() for array in arrays.values()])


def split_arrays(values: Array, attributes: Mapping[str, Any]) -> dict[str, Array]:
    """Mapping[str, Array] by their digests, from the values and attributes of the variable."""
    digests = str(attributes["digests"]).split()
    ends = np.cumsum([int(size) for size in str(attributes["sizes"]).split()])
    return dict(zip(digests, np.split(np.asarray(values, float), ends[:-1]), strict=True))
