"""Arrays of a scene, such as the heights of a measured surface: one variable holds all of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.store.schema import INPUTS, Variable
from tribo.types import Array

DIM = "input"
"""Dimension of the variable, which has no coordinate."""


def inputs_variable(sizes: Mapping[str, int]) -> dict[str, Variable]:
    """The variable that holds the arrays read from a scene's files, one after the other.

    It is returned as {name: variable}, or {} without arrays. `sizes` has the number of values of
    each array, by SHA-256.
    """
    table = {"digests": " ".join(sizes), "sizes": " ".join(map(str, sizes.values()))}
    meaning = "arrays that the attribute scene names by their digests, one after the other"
    return {INPUTS: Variable((DIM,), None, meaning, attributes=table)} if sizes else {}


def split_arrays(values: Array, attributes: Mapping[str, Any]) -> dict[str, Array]:
    """Split the values of the variable `INPUTS` into its arrays; return them by their SHA-256.

    `values` and the arrays have one dimension. `attributes` are those of the variable: ``digests``
    lists the SHA-256 of each array, and ``sizes`` the number of its values, in the same order.
    """
    digests = str(attributes["digests"]).split()
    ends = np.cumsum([int(size) for size in str(attributes["sizes"]).split()])
    return dict(zip(digests, np.split(np.asarray(values, float), ends[:-1]), strict=True))
