"""Cost and error of numerical choices, side by side: the values, and their printed table."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import pandas as pd

from pipeline.analysis.tables import frame_of, lines_of
from pipeline.sweep.model import Point
from tribo import Fidelity

_BOUNDS = (0.05, 0.03, 0.02, 0.01, 0.005)  # of the error, for each of which the cheapest is named


@dataclass(frozen=True, slots=True)
class Choice:
    """One fidelity against the reference.

    Attributes
    ----------
    name : str
        Name of a preset, or what is varied in it.
    varied : str or None
        Field of the fidelity that is varied; None if it is a preset as it is.
    fidelity : Fidelity
        All of the numerical choices.
    velocity_errors : tuple of float
        Relative error of the boundary velocity at each load, with its sign.
    velocity_error, rise_error, width_error, share_error : float
        Largest errors at any point, without sign: of the boundary velocity, the decisive rise and
        the contact width, relative; and of the failed share.
    area_error, pressure_error, saturated_error : float
        Largest errors, with their sign, of what the size of the elements decides: the contact
        fraction and the mean pressure, relative; and the share of the contact at the hardness.
    seconds : float
        Processor time of the points [s].
    convolutions : int
        Convolutions of contacts and of heat.
    work : float
        Convolutions times the elements of their grids.
    peak_bytes : int or None
        Most memory that arrays took at a point [B].
    speedup, saving : float
        Factors by which the reference takes more time, and more work.

    Examples
    --------
    >>> from tribo import Fidelity
    >>> choice = Choice(
    ...     name="draft",
    ...     varied=None,
    ...     fidelity=Fidelity(),
    ...     velocity_errors=(-0.01, -0.06),
    ...     velocity_error=0.06,
    ...     rise_error=0.03,
    ...     width_error=0.01,
    ...     share_error=0.02,
    ...     area_error=0.01,
    ...     pressure_error=-0.01,
    ...     saturated_error=0.0,
    ...     seconds=0.1,
    ...     convolutions=400,
    ...     work=1e7,
    ...     peak_bytes=None,
    ...     speedup=50.0,
    ...     saving=80.0,
    ... )
    >>> max(map(abs, choice.velocity_errors)) == choice.velocity_error
    True
    """

    name: str
    varied: str | None
    fidelity: Fidelity
    velocity_errors: tuple[float, ...]
    velocity_error: float
    rise_error: float
    width_error: float
    share_error: float
    area_error: float
    pressure_error: float
    saturated_error: float
    seconds: float
    convolutions: int
    work: float
    peak_bytes: int | None
    speedup: float
    saving: float


@dataclass(frozen=True, slots=True)
class Finding:
    """A numerical choice that costs much and gains nothing.

    Attributes
    ----------
    preset, field : str
        Name of the preset, and of the field of its fidelity.
    value, cheaper : object
        Value that the preset has, and a cheaper one that would do.
    saving : float
        Factor by which the cheaper value takes less work.
    moves : float
        Largest relative change of the boundary velocity by the cheaper value.

    Examples
    --------
    >>> cheaper = Finding("fine", "contact_tolerance", 1e-6, 1e-4, saving=2.0, moves=0.0)
    >>> str(cheaper).split(": ")[1]
    'with 0.0001 the work is 2 times less, and the boundary moves by 0.00 %'
    """

    preset: str
    field: str
    value: Any
    cheaper: Any
    saving: float
    moves: float

    def __str__(self) -> str:
        return (
            f"{self.field} = {shown(self.value)} of {self.preset!r}: with {shown(self.cheaper)} "
            f"the work is {self.saving:.2g} times less, and the boundary moves by "
            f"{100 * self.moves:.2f} %"
        )


@dataclass(frozen=True, slots=True)
class Trade:
    """Speed and accuracy of numerical choices on a scene.

    Attributes
    ----------
    title : str
        Title of the scene.
    points : tuple of Point
        Points at which the errors are measured.
    base : str
        Preset that was varied.
    choices : tuple of Choice
        Fidelities that were measured, the reference last.
    wasted : tuple of Finding
        Choices of the base that cost much and gain nothing.
    not_converged : tuple of str
        Choices that did not converge, and why.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> draft = SimpleNamespace(name="draft", work=1.0, velocity_error=0.05)
    >>> slow = SimpleNamespace(name="slow", work=3.0, velocity_error=0.06)
    >>> exact = SimpleNamespace(name="exact", work=9.0, velocity_error=0.0)
    >>> points = (Point(200.0, 3.5),)
    >>> trade = Trade("A scene", points, "draft", (draft, slow, exact), ())
    >>> [choice.name for choice in trade.front], trade.cheapest(0.02).name
    (['draft', 'exact'], 'exact')
    """

    title: str
    points: tuple[Point, ...]
    base: str
    choices: tuple[Choice, ...]
    wasted: tuple[Finding, ...]
    not_converged: tuple[str, ...] = ()

    @property
    def reference(self) -> Choice:
        """The choice that the others are compared with."""
        return self.choices[-1]

    @property
    def front(self) -> tuple[Choice, ...]:
        """Choices that no other one beats in both work and error, the cheapest first."""
        best, choices = math.inf, []
        for choice in sorted(self.choices, key=lambda choice: (choice.work, choice.velocity_error)):
            if choice.velocity_error < best:
                best = choice.velocity_error
                choices.append(choice)
        return tuple(choices)

    def cheapest(self, error: float) -> Choice:
        """The choice of least work whose boundary velocity errs by no more than `error`."""
        return min(
            (choice for choice in self.choices if choice.velocity_error <= error),
            key=lambda choice: choice.work,
        )

    @property
    def table(self) -> pd.DataFrame:
        """Cost and errors of the choices, one in a row."""
        names = [head.split(" [")[0].replace(" ", "_") for head in _HEADS]
        return frame_of(_HEADS, ([getattr(one, name) for name in names] for one in self.choices))

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return asdict(self) | {
            "points": [{"load": point.load, "velocity": point.velocity} for point in self.points],
            "front": [choice.name for choice in self.front],
            "cheapest_within": {f"{bound:g}": self.cheapest(bound).name for bound in _BOUNDS},
        }

    def __str__(self) -> str:
        places = ", ".join(f"{point.load:g} N {point.velocity:.3g} m/s" for point in self.points)
        lines = [
            f"{self.title}: speed against accuracy at",
            f"  {places}",
            "",
            *lines_of(self.table),
            "",
            "Largest errors at these points: of boundary velocity, decisive rise, contact width",
            "and failed share; and of contact area, mean pressure and share of the contact at the",
            "hardness, which the size of the elements decides. All are against the reference on",
            "the same pixels, without the margin for other points that --accuracy adds.",
            "",
            *(
                f"cheapest within {100 * bound:g} %: {self.cheapest(bound).name}"
                for bound in _BOUNDS
            ),
            *(f"wasted: {finding}" for finding in self.wasted),
            *(f"no result: {reason}" for reason in self.not_converged),
        ]
        return "\n".join(lines)


def shown(value: Any) -> str:
    """A value as it is printed."""
    return f"{value:g}" if isinstance(value, float) else str(value)


_HEADS = (
    "name", "velocity error [%]", "rise error [%]", "width error [%]", "share error",
    "area error [%]", "pressure error [%]", "saturated error", "seconds [s]", "speedup", "saving",
    "convolutions", "peak bytes [MB]",
)  # fmt: skip
