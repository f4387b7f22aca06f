"""The largest absolute value of a field."""

from __future__ import annotations

from tribo.types import Array


def largest(field: Array) -> float:
    """Largest absolute value of a field, in its unit; 0 if it has no elements.

    Examples
    --------
    >>> import numpy as np
    >>> largest(np.array([1.0, -3.0])), largest(np.empty(0))
    (3.0, 0.0)
    """
    # To find the maximum and the minimum takes half the time of computing all absolute values.
    return max(float(field.max(initial=0.0)), -float(field.min(initial=0.0)))
