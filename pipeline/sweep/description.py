"""Description of a scene or a point in a notebook or terminal: as lines, or as a table."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Mapping, Sequence

from pipeline.sweep.conditions import Conditions
from tribo import MeasuredRoughness, Ramp, Scene, SelfAffineRoughness, Wear
from tribo.simulation import PointWarning
from tribo.types import Array

Row = tuple[str, str]


def as_lines(title: str, rows: Sequence[Row]) -> str:
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


def as_html(title: str, rows: Sequence[Row]) -> str:
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


def on_scene(scene: Scene) -> Iterator[Row]:
    """Say what a scene is of, a row for each subject."""
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


def on_plane(loads: Sequence[float], velocities: Sequence[float]) -> Row:
    """Say at which loads and velocities a sweep is.

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


def on_conditions(conditions: Conditions) -> Iterator[Row]:
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


def on_point(columns: Mapping[str, Array], warnings: Iterable[PointWarning]) -> Iterator[Row]:
    """Say what a point has come to, a row for each subject."""
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
