"""What a scene says besides what is simulated and judged, and its description in a notebook."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.selection import Selection
from tribo import MeasuredRoughness, Oil, Ramp, Scene, SelfAffineRoughness, Wear
from tribo.simulation import PointWarning
from tribo.types import Array


@dataclass(frozen=True, slots=True)
class Measurement:
    """A test on a rig: a transition to severe wear, or a point that stayed mild or turned severe.

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


Line = tuple[str, str]


def as_lines(title: str, rows: Sequence[Line]) -> str:
    """Write rows below a title.

    Examples
    --------
    >>> print(as_lines("A scene", [("pin", "cylinder"), ("wear", "none")]))
    A scene
      pin   cylinder
      wear  none
    """
    width = max(len(name) for name, _ in rows)
    return "\n".join([title, *(f"  {name:{width}}  {text}" for name, text in rows)])


def as_html(title: str, rows: Sequence[Line]) -> str:
    """Write rows as a table for a notebook.

    Examples
    --------
    >>> as_html("<scene>", [("pin", "ball")])
    '<table><caption>&lt;scene&gt;</caption><tr><th>pin</th><td>ball</td></tr></table>'
    """
    cells = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in rows
    )
    return f"<table><caption>{html.escape(title)}</caption>{cells}</table>"


def on_scene(scene: Scene) -> Iterator[Line]:
    """Describe a scene, a row for each subject."""
    yield "pin", scene.pin.words
    yield "disk", _surface(scene)
    (nx, ny), (x, y) = scene.grid.shape, scene.grid.size
    yield "window", f"{1e6 * x:.4g} × {1e6 * y:.4g} µm, {nx} × {ny} elements"
    loading = scene.loading
    if isinstance(loading, Ramp):
        held = f", held for {loading.hold:g} s" if loading.hold else ""
        yield "loading", f"{loading.rate:g} N/s{held}"
    else:
        yield "loading", f"recorded, up to {loading.loads.max():g} N"
    wear = scene.wear
    if wear is None:
        yield "wear", "none"
    elif isinstance(wear, Wear):
        yield "wear", f"{1e9 * wear.specific_wear_rate:.3g} mm³/(N m), {wear.pattern}"
    else:
        yield "wear", f"{wear!r}, {wear.pattern}"


def on_plane(loads: Sequence[float], velocities: Sequence[float]) -> Line:
    """Describe the loads and velocities of a sweep.

    Examples
    --------
    >>> on_plane([600.0], [1.0, 2.0, 4.0])
    ('sweep', '600 N, 3 velocities from 1 to 4 m/s')
    """

    def spanned(values: Sequence[float], name: str, unit: str) -> str:
        if len(values) == 1:
            return f"{values[0]:g} {unit}"
        return f"{len(values)} {name} from {values[0]:g} to {values[-1]:g} {unit}"

    return "sweep", f"{spanned(loads, 'loads', 'N')}, {spanned(velocities, 'velocities', 'm/s')}"


def on_conditions(conditions: Conditions) -> Iterator[Line]:
    """Say when wear is severe, a row for each subject."""
    bulk = f"bulk {conditions.bulk_temperature - 273.15:g} °C"
    if conditions.disk_temperature is not None:
        bulk += f" (pin) and {conditions.disk_temperature - 273.15:g} °C (disk)"
    yield "friction", f"{conditions.friction:g}, {bulk}"
    if conditions.corrections:
        yield "besides", conditions.corrections.worded
    if conditions.critical_temperature is not None:
        critical = f"{conditions.critical_temperature - 273.15:g} °C"
        yield "severe", f"{conditions.decisive.severe} {critical}"


def on_point(columns: Mapping[str, Array], warnings: Iterable[PointWarning]) -> Iterator[Line]:
    """Describe the end of a point, a row for each subject."""
    end = {name: column[-1] for name, column in columns.items()}
    yield "after", f"{end['time']:.4g} s and {end['sliding_distance']:.4g} m"
    yield (
        "contact",
        (
            f"{1e6 * end['contact_width']:.4g} µm wide, {1e-9 * end['mean_pressure']:.3g} GPa on "
            f"average, {1e-9 * end['max_pressure']:.3g} GPa at most"
        ),
    )
    yield "wear", f"{1e6 * end['wear_depth_max']:.3g} µm deep, {1e9 * end['wear_volume']:.3g} mm³"
    yield "rise", f"{end['max_rise']:.4g} K at most, at friction 1"
    for warning in warnings:
        yield "warning", warning.text


def _surface(scene: Scene) -> str:
    roughness = scene.roughness
    if isinstance(roughness, SelfAffineRoughness):
        return f"random roughness, Ra {1e6 * roughness.ra:.3g} µm"
    if roughness is None:
        return "smooth"
    return "measured roughness" if isinstance(roughness, MeasuredRoughness) else "a surface law"
