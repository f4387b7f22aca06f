"""Array types, named by their content."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Real numbers, as the values of a field."""

Mask = NDArray[np.bool_]
"""Truth values of the elements of a field."""

Indices = NDArray[np.intp]
"""Integer indices, for example the number of the row in which each node lies."""

Nodes = Indices
"""Ascending indices of nodes in the flattened field."""

Spectrum = NDArray[np.inexact]
"""Discrete Fourier transform of a kernel or of a field; real where the kernel is even."""
