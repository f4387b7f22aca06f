"""The rectangular grid on which every field lives, and the largest value of a field."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tribo.errors import InputError, require_integer, require_pair, require_positive
from tribo.types import Array

# Largest ratio of an element's sides; influences are summed over all scales between the two sides.
_MAX_SIDE_RATIO = 1e6


@dataclass(frozen=True, slots=True)
class Grid:
    """A grid of ``nx × ny`` rectangular elements, each axis free or periodic.

    Axis 0 is x, the sliding direction; axis 1 is y, along the cylinder's axis.

    Parameters
    ----------
    shape : tuple of int
        Number of elements ``(nx, ny)``, each at least 1.
    spacing : tuple of float
        Sides of an element ``(dx, dy)`` [m].
    periodic : tuple of bool
        True along x, and along y, if the grid repeats there. ``(False, True)`` is a line contact.

    Examples
    --------
    >>> grid = Grid(shape=(240, 240), spacing=(1.632e-6, 1.9e-6), periodic=(False, True))
    >>> f"{grid.size[1]:.3e} m, {grid.element_area:.4e} m²"
    '4.560e-04 m, 3.1008e-12 m²'
    """

    shape: tuple[int, int]
    spacing: tuple[float, float]
    periodic: tuple[bool, bool] = (False, True)

    def __post_init__(self) -> None:
        require_pair(shape=self.shape, spacing=self.spacing)
        if not (isinstance(self.periodic, tuple) and len(self.periodic) == 2):
            raise InputError(f"periodic is {self.periodic!r}; it must hold two values")
        require_integer(1, **dict(zip(("nx", "ny"), self.shape, strict=True)))
        require_positive(**dict(zip(("dx", "dy"), self.spacing, strict=True)))
        if max(self.spacing) > _MAX_SIDE_RATIO * min(self.spacing):
            raise InputError(
                f"spacing is {self.spacing}; one side must be at most {_MAX_SIDE_RATIO:g} times "
                "the other"
            )
        require_positive(element_area=self.element_area, area=self.area)

    @property
    def size(self) -> tuple[float, float]:
        """Sides of the area that the grid covers, along x and y [m]."""
        return self.shape[0] * self.spacing[0], self.shape[1] * self.spacing[1]

    @property
    def element_area(self) -> float:
        """Area of one element [m²]."""
        return self.spacing[0] * self.spacing[1]

    @property
    def area(self) -> float:
        """Area that the grid covers [m²]."""
        return math.prod(self.size)

    def coordinates(self, axis: int) -> Array:
        """Element centres along `axis` [m], with 0 at the centre of the grid.

        Examples
        --------
        >>> Grid((4, 1), (0.5, 1.0)).coordinates(0)
        array([-0.75, -0.25,  0.25,  0.75])
        """
        n, step = self.shape[axis], self.spacing[axis]
        return np.arange(-(n - 1), n, 2, dtype=np.float64) * (step / 2)


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
