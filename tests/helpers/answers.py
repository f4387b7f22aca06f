"""Crossings of one curve, in tests."""

import numpy as np


def crossings(curve, limit):
    """Abscissae at which one `Curve` passes a limit, as a tuple."""
    places = curve.crossings(limit)
    return tuple(places[np.isfinite(places)].tolist())
