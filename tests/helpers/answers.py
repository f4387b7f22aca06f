"""Answers at one place, and of one curve, in tests."""

import numpy as np

from pipeline.analysis.margin import answers
from tribo import InputError


def answer(field, load, velocity, scatter):
    """The `Margin` of a field at one load and velocity; an `InputError` if there is none."""
    (found,) = answers(field, np.array([load]), np.array([velocity]), scatter, [()])
    if isinstance(found, str):
        raise InputError(found)
    return found


def crossings(curve, limit):
    """Abscissae at which one `Curve` passes a limit, as a tuple."""
    places = curve.crossings(limit)
    return tuple(places[np.isfinite(places)].tolist())
