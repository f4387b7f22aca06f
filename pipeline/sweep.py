"""What a scene file says: a scene, where to simulate it, and under which conditions it fails."""

from __future__ import annotations

from dataclasses import dataclass

from tribo import Scene

__all__ = ["Conditions", "Measurement", "Sweep"]


@dataclass(frozen=True, slots=True)
class Conditions:
    """What turns a rise per unit friction into failure, after the simulation.

    Attributes
    ----------
    friction : float
        Friction coefficient.
    bulk_temperature, critical_temperature : float
        [K].
    failing_share : float
        Share of the contact area above the critical temperature from which wear is severe.
    """

    friction: float
    bulk_temperature: float
    critical_temperature: float
    failing_share: float = 0.1


@dataclass(frozen=True, slots=True)
class Measurement:
    """A measured transition from mild to severe wear.

    Attributes
    ----------
    normal_load : float
        [N].
    velocity : float
        [m/s].
    friction : float or None
        Friction coefficient, if it was measured.
    """

    normal_load: float
    velocity: float
    friction: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep(Scene):
    """A scene and the loads and velocities at which to simulate it.

    Attributes
    ----------
    name, title : str
        The file's name without ending; a line for people.
    loads, velocities : tuple of float
        [N], [m/s]; ascending, each once.
    conditions : Conditions
    friction_band : tuple of float or None
        Lowest and highest friction coefficient measured.
    measured : tuple of Measurement
    store_fields : bool
        Whether the fields at the end of each point are kept.
    independent : bool
        Whether each point is simulated from the start instead of on from the next lower load.
    preset : str or None
        Name of the preset that the fidelity equals.
    notes : tuple of str
        What reading the scene had to settle, and a user should know.
    chosen : tuple of (float, float) or None
        Loads and velocities of the points to simulate, if not all of them.
    """

    name: str
    title: str
    loads: tuple[float, ...]
    velocities: tuple[float, ...]
    conditions: Conditions
    friction_band: tuple[float, float] | None = None
    measured: tuple[Measurement, ...] = ()
    store_fields: bool = False
    independent: bool = False
    preset: str | None = None
    notes: tuple[str, ...] = ()
    chosen: tuple[tuple[float, float], ...] | None = None
