"""Fidelity: every numerical choice that trades speed for accuracy, in one object."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from tribo.constants import CONTACT_OVER_HEAT, HOLD_STEPS, TIGHTEST_HEAT
from tribo.errors import InputError, require_integer, require_number


@dataclass(frozen=True, slots=True, kw_only=True)
class Fidelity:
    """Numerical choices of a simulation.

    `pixels_per_element`, `increments`, `fewest_elements`, `contact_tolerance` and `parts` are the
    choices of a preset. `tribo.simulation.fit_elements` sets the others for each point.

    Parameters
    ----------
    pixels_per_element : int
        Pixels of the surface along each side of an element; if `fewest_elements` is above 0, the
        largest number allowed.
    increments : int
        Steps of the ramp up to its reference load.
    fewest_elements : int
        Least number of elements that are expected to touch. If it is above 0, elements are made
        small enough for this and for the surface's summits, down to the pixels. Steps before a
        point's last have larger elements, of which twice as many are expected to touch. Steps in
        which the contact would change much are divided. See `tribo.simulation.element_size`.
    contact_tolerance : float
        Residual of the contact at which its solver stops. See `tribo.contact.solve_contact`. With
        the wear pattern "local" a larger value than 0.03 is replaced by 0.03, because the error of
        each contact stays in the worn shape.
    history_coarsening : int
        Largest factor by which the sides of elements are lengthened in the steps of a point.
        Requested steps are then repeated on the scene's grid. Earlier steps affect them only by the
        worn depth. Coarse elements resolve that depth if the wear pattern is "swept" and many of
        them touch. With the pattern "local", wear follows the roughness, and the grid is not
        coarsened.
    imprint : float
        Largest depth to which the roughness may wear itself into the pin within a part of a step,
        divided by the height of the roughness. Steps are divided into as many parts as this needs,
        at most 4; 0 for no parts. With 25 steps or more they are not divided. Local wear leaves
        such imprints.
    parts : int
        Number of parts of each step of a rising load. `fit_elements` uses it where a pin wears
        under strips of the disk, see `tribo.simulation.disk_positions`: there more parts lower the
        random error.

    Examples
    --------
    >>> import tribo
    >>> from dataclasses import replace
    >>> replace(tribo.PRESETS["standard"], increments=50).increments
    50
    """

    pixels_per_element: int = 2
    increments: int = 100
    fewest_elements: int = 0
    contact_tolerance: float = 1e-3
    history_coarsening: int = 1
    imprint: float = 0.0
    parts: int = 1

    def __post_init__(self) -> None:
        for name, lowest in (
            ("pixels_per_element", 1),
            ("increments", 1),
            ("fewest_elements", 0),
            ("history_coarsening", 1),
            ("parts", 1),
        ):
            require_integer(lowest, **{name: getattr(self, name)})
        require_number(imprint=self.imprint, contact_tolerance=self.contact_tolerance)
        if not 0 <= self.imprint < math.inf:
            raise InputError(f"imprint is {self.imprint!r}; it must be finite and at least 0")
        if not 0 < self.contact_tolerance <= 1:
            raise InputError(
                f"contact_tolerance is {self.contact_tolerance!r}; it must be above 0 and at most 1"
            )

    @property
    def averaging(self) -> Literal["mean", "sample"]:
        """An element's height: the height of one pixel in its middle, or the mean of its pixels.

        A sample keeps the distribution of heights and slopes that the mean smooths, and so comes
        nearer to a computation on the pixels. Elements of a fixed size use the mean, as Bosman & de
        Rooij did to coarsen measured surfaces.
        """
        return "sample" if self.fewest_elements else "mean"

    @property
    def hold_increments(self) -> int:
        """Steps of a hold in which the impulse grows by a factor of exp(10)."""
        return max(HOLD_STEPS, self.increments) if self.fewest_elements else self.increments

    @property
    def heat_tolerance(self) -> float:
        """Relative residual of the heat partition at which its solver stops."""
        return max(self.contact_tolerance / CONTACT_OVER_HEAT, TIGHTEST_HEAT)


PRESETS: dict[str, Fidelity] = {
    "standard": Fidelity(
        pixels_per_element=2, increments=8, fewest_elements=100, contact_tolerance=0.12, parts=2
    ),
    "fine": Fidelity(
        pixels_per_element=1, increments=16, fewest_elements=300, contact_tolerance=0.03, parts=4
    ),
    "reference": Fidelity(pixels_per_element=1, increments=100, contact_tolerance=1e-5),
}
"""Fidelity by name, from fast to exact. ``irg trade`` states the cost of each."""
