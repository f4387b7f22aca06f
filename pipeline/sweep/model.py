"""What a scene file says: a scene, where to simulate it, and under which conditions it fails."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

from pipeline.sweep.criterion import Conditions
from pipeline.sweep.selection import Selection
from tribo import InputError, Scene, SelfAffineRoughness


class Point(NamedTuple):
    """One place in the diagram, and on which surface.

    Attributes
    ----------
    load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    realization : int or None
        Seed of the random surface, in a sweep over several.

    Examples
    --------
    >>> print(Point(600.0, 1.5), Point(600.0, 1.5, realization=3), sep="; ")
    600 N, 1.5 m/s; 600 N, 1.5 m/s, surface 3
    """

    load: float
    velocity: float
    realization: int | None = None

    def __str__(self) -> str:
        surface = "" if self.realization is None else f", surface {self.realization}"
        return f"{self.load:g} N, {self.velocity:g} m/s{surface}"


@dataclass(frozen=True, slots=True)
class Measurement:
    """A measured transition from mild to severe wear.

    Attributes
    ----------
    normal_load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    friction : float or None
        Friction coefficient, if it was measured.
    """

    normal_load: float
    velocity: float
    friction: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep(Scene):
    """A scene, the loads and velocities at which to simulate it, and on which surfaces.

    Attributes
    ----------
    name, title : str
        The file's name without ending; a line for people.
    loads : tuple of float
        Normal loads on the whole pin, ascending, each once [N].
    velocities : tuple of float
        Sliding velocities, ascending, each once [m/s].
    conditions : Conditions
        Friction, temperatures and failing share of the scene.
    realizations : tuple of int
        Seeds of the random surfaces on which to simulate every load and velocity, one after the
        other in place of the scene's own; none if the scene's own surface is all there is.
    friction_band : tuple of float or None
        Lowest and highest friction coefficient measured.
    measured : tuple of Measurement
        Measured transitions, for comparison.
    store_fields : bool
        Whether the fields at the end of each point are kept.
    independent : bool
        Whether each point is simulated from the start instead of on from the next lower load.
    preset : str or None
        Name of the preset that the fidelity equals; None if it equals none.
    selection : Selection or None
        Why the fidelity is what it is, if it was picked for its accuracy.
    notes : tuple of str
        What was assumed on reading the scene, for the user to know.
    chosen : tuple of Point or None
        The points to simulate, if not all of them.

    Raises
    ------
    InputError
        If there are realizations, but the roughness is not a random one.
    """

    name: str
    title: str
    loads: tuple[float, ...]
    velocities: tuple[float, ...]
    conditions: Conditions
    realizations: tuple[int, ...] = ()
    friction_band: tuple[float, float] | None = None
    measured: tuple[Measurement, ...] = ()
    store_fields: bool = False
    independent: bool = False
    preset: str | None = None
    selection: Selection | None = None
    notes: tuple[str, ...] = ()
    chosen: tuple[Point, ...] | None = None

    def __post_init__(self) -> None:
        Scene.__post_init__(self)  # a slotted dataclass has no super()
        if self.realizations and not isinstance(self.roughness, SelfAffineRoughness):
            raise InputError(
                "realizations are seeds of a random roughness; that of the scene is not random"
            )

    def on_surface(self, seed: int | None) -> Self:
        """The sweep on the random surface of a seed alone; itself if None."""
        if seed is None:
            return self
        if not isinstance(self.roughness, SelfAffineRoughness):
            raise InputError(
                f"realization is {seed}, the seed of a random roughness; that of the scene is not "
                "random"
            )
        return replace(self, roughness=replace(self.roughness, seed=seed), realizations=())
