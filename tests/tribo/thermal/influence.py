"""Values of a thermal kernel."""

import math

import numpy as np

from tribo.numerics import padded_shape
from tribo.thermal import ConductingHalfSpace


def thermal_influence(grid, material, velocity, time, nodes=10, length=math.inf):
    """Rise per unit heat flux on one element [K m²/W], in the order of `wrapped_offsets`."""
    body = ConductingHalfSpace(grid, material, velocity, time, nodes, length)
    return np.fft.irfft2(body.spectrum, s=padded_shape(grid))
