"""Fidelity: every numerical choice that trades speed for accuracy, in one object."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args, get_origin, get_type_hints

from tribo.errors import InputError, require_integer
from tribo.wear import WearScheme


@dataclass(frozen=True, slots=True, kw_only=True)
class Fidelity:
    """Numerical choices of a simulation.

    Parameters
    ----------
    pixels_per_element : int
        Pixels of the surface along each side of an element; if `elements_per_summit` is above 0,
        the largest number allowed.
    averaging : {"mean", "sample"}
        An element's height: the mean of its pixels, as Bosman & de Rooij coarsen measured surfaces,
        or the height of one pixel in its middle. A sample keeps the distribution of heights and
        slopes that the mean smooths, and so comes nearer to a computation on the pixels.
    history_coarsening : int
        Largest factor by which the sides of elements are lengthened in the steps of a point. The
        last step is then repeated on the scene's own grid. Earlier steps affect it only by the
        worn depth. Coarse elements resolve that depth if the wear pattern is "swept" and many of
        them touch. With the pattern "local", wear follows the roughness, and the grid is not
        coarsened.
    elements_per_summit : float
        Least width of the surface's summits, in elements. If it is above 0, elements are made small
        enough for this, down to the pixels; see `tribo.simulation.element_size`. Half of it is
        enough under a ball or crowned pin with the wear pattern "swept".
    fewest_summits : int
        If fewer summits are expected to touch, elements are single pixels. Used only if
        `elements_per_summit` is above 0.
    fewest_elements : int
        Least number of elements that are expected to touch. Elements are made small enough for
        this, down to the pixels, also in steps before the last. Used only if `elements_per_summit`
        is above 0.
    increments : int
        Steps of the ramp up to its reference load. If a scene gives it, it also replaces the
        preset's `hold_increments` and `imprint`.
    hold_increments : int
        Like `increments`, but for the steps of a hold, which grow with time; 0 for the same number.
    imprint : float
        Largest depth to which the roughness may wear itself into the pin within a part of a step,
        divided by the height of the roughness. Steps are cut into as many parts as this takes, at
        most 4; 0 for no parts. With 25 `increments` or more they are not cut. Local wear and ridges
        along y leave such imprints.
    contact_tolerance : float
        Residual of the contact at which its solver stops. See `tribo.contact.solve_contact`. With
        the wear pattern "local" a larger value than 0.03 is replaced by 0.03, because the error of
        each contact stays in the worn shape.
    heat_model : {"elapsed", "history"}
        ``"elapsed"``: the present friction heat is taken to have acted since time 0 (Bosman & de
        Rooij); ``"history"``: all heat since then acts at its own time, linear between the steps.
        Every step then needs its temperature. With ``"elapsed"`` the rise of a growing contact is
        too high: in the system of Bosman & de Rooij at 600 N by 0.2, 0.8, 1.5 and 2.4 % at 1.25,
        0.1, 0.01 and 0.001 m/s.
    as_published : bool
        True for the scheme of Bosman & de Rooij: only the nearest periodic image of each element
        deforms and heats the patch, contacts are solved until the pressure changes by less than
        their tolerance, and the wear is explicit. If not, all images deform it, the heated contact
        is as long as the pin, the tolerance bounds the residual of the gaps, and the wear is
        integrated by an implicit Runge-Kutta scheme of second order.
    partition : {"local", "uniform"}
        Division of friction heat between the bodies: each element for itself, or one share for the
        whole contact. See `tribo.thermal.partition_heat`.
    heat_tolerance : float
        Relative residual of the heat partition at which its solver stops.

    Examples
    --------
    >>> import tribo
    >>> from dataclasses import replace
    >>> replace(tribo.PRESETS["standard"], increments=50).increments
    50
    """

    pixels_per_element: int = 2
    averaging: Literal["mean", "sample"] = "mean"
    history_coarsening: int = 1
    elements_per_summit: float = 0.0
    fewest_summits: int = 0
    fewest_elements: int = 0
    increments: int = 100
    hold_increments: int = 0
    imprint: float = 0.0
    contact_tolerance: float = 1e-3
    heat_model: Literal["elapsed", "history"] = "elapsed"
    as_published: bool = False
    partition: Literal["local", "uniform"] = "local"
    heat_tolerance: float = 1e-6

    def __post_init__(self) -> None:
        for name, lowest in (
            ("pixels_per_element", 1),
            ("history_coarsening", 1),
            ("fewest_summits", 0),
            ("fewest_elements", 0),
            ("increments", 1),
            ("hold_increments", 0),
        ):
            require_integer(lowest, **{name: getattr(self, name)})
        for name in ("elements_per_summit", "imprint"):
            if not 0 <= getattr(self, name) < math.inf:
                value = getattr(self, name)
                raise InputError(f"{name} is {value!r}; it must be finite and at least 0")
        if not 0 < self.contact_tolerance <= 1:
            raise InputError(
                f"contact_tolerance is {self.contact_tolerance!r}; it must be above 0 and at most 1"
            )
        if not 1e-14 <= self.heat_tolerance < 1:
            raise InputError(
                f"heat_tolerance is {self.heat_tolerance!r}; it must be from 1e-14 to below 1"
            )
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise InputError(
                    f"{name} is {getattr(self, name)!r}; allowed are {', '.join(choices)}"
                )
        if self.heat_model == "history" and self.history_coarsening > 1:
            raise InputError(
                f"history_coarsening is {self.history_coarsening}; the heat model 'history' needs "
                "every step on the scene's own grid, so it must be 1"
            )

    @property
    def wear_scheme(self) -> WearScheme:
        """Time integration of the wear, one of `tribo.wear.WEAR_SCHEMES`."""
        return "explicit" if self.as_published else "sdirk2"


_CHOICES = {
    name: get_args(choice)
    for name, choice in get_type_hints(Fidelity).items()
    if get_origin(choice) is Literal
}

PRESETS: dict[str, Fidelity] = {
    "standard": Fidelity(
        pixels_per_element=2,
        averaging="sample",
        history_coarsening=4,
        elements_per_summit=1.7,
        fewest_summits=300,
        fewest_elements=100,
        increments=6,
        hold_increments=25,
        imprint=3.0,
        contact_tolerance=0.09,
        heat_tolerance=3e-3,
    ),
    "fine": Fidelity(
        pixels_per_element=1,
        averaging="sample",
        history_coarsening=4,
        elements_per_summit=1.7,
        fewest_elements=300,
        increments=16,
        hold_increments=25,
        imprint=3.0,
        contact_tolerance=0.05,
        heat_tolerance=1.5e-3,
    ),
    "reference": Fidelity(
        pixels_per_element=1,
        increments=100,
        contact_tolerance=1e-5,
        heat_tolerance=1e-8,
    ),
}
"""Fidelity by name, from fast to exact. ``irg trade`` measures cost and error of each."""
