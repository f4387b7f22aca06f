"""Values of an elastic kernel."""

import numpy as np

from tribo.contact import ElasticHalfSpace
from tribo.numerics import padded_shape


def elastic_influence(grid, contact_modulus, kernel="periodic"):
    """Displacement under unit pressure on one element [m/Pa], in the order of `wrapped_offsets`."""
    solid = ElasticHalfSpace(grid, contact_modulus, kernel)
    return np.fft.irfft2(solid.spectrum, s=padded_shape(grid))
