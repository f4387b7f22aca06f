"""What a scene says besides what is simulated and judged: its names, tests, oil and sources."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from pipeline.sweep.selection import Selection
from tribo import Oil


@dataclass(frozen=True, slots=True)
class Measurement:
    """A test on a rig: a transition from mild to severe wear, or a point that was one of them.

    Attributes
    ----------
    normal_load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    friction : float or None
        Friction coefficient, if it was measured.
    load_scatter, velocity_scatter, friction_scatter : float or None
        Standard deviations of the three, if they are known [N, m/s, 1].
    bulk_temperature : float or None
        Bulk temperature of both bodies [K], where it was not the scene's.
    hold : float or None
        Duration at the full load [s], where it was not the scene's.
    outcome : {"mild", "severe"} or None
        Wear of the test; None at a transition.

    Examples
    --------
    >>> Measurement(normal_load=600.0, velocity=1.5, friction=0.1).as_dict()
    {'normal_load': 600.0, 'velocity': 1.5, 'friction': 0.1}
    """

    normal_load: float
    velocity: float
    friction: float | None = None
    load_scatter: float | None = None
    velocity_scatter: float | None = None
    friction_scatter: float | None = None
    bulk_temperature: float | None = None
    hold: float | None = None
    outcome: str | None = None

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> Measurement:
        """The test of an entry of a scene."""
        return cls(normal_load=entry["load"], **{k: v for k, v in entry.items() if k != "load"})

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as plain data, of those after the friction only what is known."""
        data = asdict(self)
        always = ("normal_load", "velocity", "friction")
        return {k: v for k, v in data.items() if v is not None or k in always}


class FromLibrary(NamedTuple):
    """A number that a scene takes from the library: key path, value with unit, and its source."""

    key: str
    value: str
    source: str


@dataclass(frozen=True, slots=True, kw_only=True)
class About:
    """What a scene says besides what is simulated and judged.

    Attributes
    ----------
    name, title : str
        The file's name without ending; a line for people.
    measured : tuple of Measurement
        Measured transitions, for comparison.
    tested : tuple of Measurement
        Tests that stayed mild or turned severe.
    friction_band : tuple of float or None
        Lowest and highest friction coefficient measured.
    same_rig : bool
        True if the friction that tests measured is that of the scene, False if of another machine.
    oil : Oil or None
        Lubricant, to tell the regime of lubrication; no number of the simulation depends on it.
    preset : str or None
        Name of the preset that the fidelity equals; None if it equals none.
    selection : Selection or None
        Why the fidelity is what it is, if it was picked for its accuracy.
    sources : tuple of FromLibrary
        Numbers that the scene takes from the library.
    notes : tuple of str
        Assumptions made on reading the scene.
    arguments : tuple of str
        Arguments by which the command reads the scene: its file, preset and settings; none if it
        was not read from a file.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.load_scene("first_try").about.preset
    'draft'
    """

    name: str
    title: str
    measured: tuple[Measurement, ...] = ()
    tested: tuple[Measurement, ...] = ()
    friction_band: tuple[float, float] | None = None
    same_rig: bool = True
    oil: Oil | None = None
    preset: str | None = None
    selection: Selection | None = None
    sources: tuple[FromLibrary, ...] = ()
    notes: tuple[str, ...] = ()
    arguments: tuple[str, ...] = field(default=(), compare=False)
