"""Contact, motion, wear and surface of a scene in closed form, before any simulation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.quantities import display, display_sides
from pipeline.sweep.case_table import PLACE_UNITS
from pipeline.sweep.sweep import Sweep
from tribo import InputError, Scene, contact_modulus
from tribo.simulation.lubrication import SurfaceSummary, find_lubrication, summarize_surface
from tribo.types import Array
from tribo.wear import evaluate_wear


class Span(NamedTuple):
    """Range of a quantity over the loads and velocities of a sweep, in SI."""

    low: float
    high: float

    @classmethod
    def from_values(cls, values: Iterable[float] | Array) -> Span:
        """Range from the lowest to the highest of `values`."""
        array = np.array(list(values))
        return cls(float(array.min()), float(array.max()))


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactEstimate:
    """Numbers that describe a scene. Each `Span` is over its loads and velocities."""

    hertz_pressure: Span  # highest pressure, smooth, elastic and unworn [Pa]
    hertz_half_width: Span  # half-width of that contact [m]
    contact_width: Span  # width expected at the end of the points, worn and rough [m]
    window: tuple[float, float]  # sides along x and y [m]
    duration: Span  # time from the first contact to the end of the points [s]
    sliding_distance: Span  # distance slid until then [m]
    wear_depth: Span | None = None  # expected on the pin at the end [m]; None without wear
    peclet_number: Span  # u a/(2κ) of the disk, a the half-width of Hertz
    pin_velocity: Span  # of the pin's surface past the contact [m/s]
    disk_velocity: Span  # [m/s]
    slide_roll_ratio: Span  # infinite where the mean of both velocities is 0
    film_parameter: Span | None = None  # None if it is not known
    surface: SurfaceSummary | None  # surface of the disk; None if it is smooth


class SingleCase(NamedTuple):
    """A case of a sweep with its label; a row has its velocity, and its load at each factor."""

    label: str
    sweep: Sweep
    load: float  # of a row itself, else the lowest [N]


def single_cases(sweep: Sweep, max_count: int) -> list[SingleCase]:
    """At most `max_count` cases of a sweep."""
    names, rows = sweep.case_table.without_surfaces.names, sweep.case_table.rows
    if len(names) == 1:
        return [SingleCase("", sweep, float(rows[0].get("load", sweep.loads[0])))]
    word_columns = [
        column
        for column in sweep.case_table.columns
        if column.along and not column.entry and column.name not in PLACE_UNITS
    ]
    cases = list[SingleCase]()
    for name in names[:: math.ceil(len(names) / max_count)]:
        row = next(row for row in rows if {*name} <= {*row.items()})
        case, labels = sweep.select_case(name), [*sweep.case_table.to_text(name).values()]
        if "load" in row:
            loads = sweep.case_table.loads_of(row)
            case = replace(case, loads=loads, velocities=(float(row["velocity"]),))
            labels = [column.to_text(row[column.name]) for column in word_columns] or labels
        load = float(row.get("load", case.loads[0]))
        cases.append(SingleCase(" ".join(map(str, labels)), case, load))
    return cases


def estimate_contacts(cases: Sequence[SingleCase]) -> ContactEstimate:
    """Numbers of cases together: each `Span` is over all of them."""
    estimates, spans = [estimate_contact(case.sweep) for case in cases], dict[str, Any]()
    for name in (field.name for field in fields(ContactEstimate)):
        if isinstance(getattr(estimates[0], name), Span):
            ends = [end for estimate in estimates for end in getattr(estimate, name) or ()]
            spans[name] = Span.from_values(ends)
    return replace(estimates[0], **spans)


def estimate_contact(sweep: Sweep) -> ContactEstimate:
    """Calculate numbers that describe a scene, in closed form: contact, motion, wear and film."""
    scene, surface = sweep.scene, summarize_surface(sweep.scene)
    pin, disk = np.transpose([scene.velocities_at(velocity) for velocity in sweep.velocities])
    expected = expect_contacts(scene, sweep.loads, sweep.velocities, surface.rq if surface else 0.0)
    estimates = expected | {
        "peclet_number": np.outer(expected["hertz_half_width"], np.abs(disk))
        / (2 * scene.disk.thermal_diffusivity),
        "pin_velocity": pin,
        "disk_velocity": disk,
        "slide_roll_ratio": np.divide(
            disk - pin, (pin + disk) / 2, out=np.full(pin.shape, math.inf), where=pin != -disk
        ),
    }
    if lubrication := find_lubrication(scene, sweep.lubricant):
        loads, velocities = (np.array(axis)[[0, -1]] for axis in (sweep.loads, sweep.velocities))
        bulk = sweep.conditions.bulk_temperature
        estimates["film_parameter"] = lubrication.film_parameter(loads[:, None], velocities, bulk)
    return ContactEstimate(
        **{name: Span.from_values(values) for name, values in estimates.items()},
        window=scene.grid.size,
        surface=surface,
    )


def require_admissible_load(sweep: Sweep, load: float, key: str) -> None:
    """Raise an `InputError` if `load` [N] is too high for the size of the simulated window.

    The mean pressure over the window must not exceed the hardness. The message names `key`, the
    entry or option that gives the load.
    """
    scene = sweep.scene
    if load > scene.greatest_load:
        raise InputError(
            f"{key}: {load:g} N exceeds what the window of {display_sides(scene.grid.size)} can "
            f"carry at the hardness of the softer body, {display(scene.hardness, 'GPa')}: "
            f"{scene.greatest_load:.4g} N on the pin; reduce the load, increase window.pixels, "
            "or check the units"
        )


def expect_contacts(
    scene: Scene, loads: Sequence[float], velocities: Sequence[float], rms_height: float = 0.0
) -> dict[str, Array]:
    """Estimate contact and wear at the end of each point, in closed form.

    `rms_height` is the Rq of the disk [m]. Returns arrays by name. Of shape (n_load,) are
    ``hertz_pressure`` [Pa], ``hertz_half_width`` [m] and ``duration`` [s]. Of shape (n_load,
    n_velocity) are ``contact_width``, ``sliding_distance`` and, if the pin wears, ``wear_depth``,
    all in metres.

    Examples
    --------
    >>> import pipeline
    >>> first_try = pipeline.load_scene("workflows/first_try.toml").scene
    >>> expected = expect_contacts(first_try, [600.0], [1.5])
    >>> f"{1e6 * expected['contact_width'][0, 0]:.0f} µm wide"
    '258 µm wide'
    """
    modulus = contact_modulus(scene.pin.material, scene.disk)
    hertz = [scene.pin.hertz(load, modulus) for load in loads]
    half_widths = np.array([contact.half_width for contact in hertz])
    durations, impulses = np.transpose([_loading_integrals(scene, load) for load in loads])
    distances, wear = np.outer(durations, velocities), scene.wear
    mean_over_peak = math.pi / 4 if scene.pin.length is not None else 2 / 3  # of Hertz's pressure
    wear_rates = np.zeros(distances.shape)
    for (i, j), distance in np.ndenumerate(distances):
        if wear:
            pressure = mean_over_peak * hertz[i].peak_pressure
            total = evaluate_wear(wear, 0.0, distance, pressure, velocities[j])
            wear_rates[i, j] = total.specific_wear_rate
    volumes = wear_rates * np.outer(impulses, velocities)
    if scene.velocities_at(max(velocities)).pin:  # a rolling pin wears all around, and stays round
        unworn_widths = 2 * half_widths[:, None]
        lengths = unworn_widths / 1.5 if scene.pin.length is None else scene.pin.length
        widths, depths = unworn_widths + 0 * volumes, volumes / (scene.track_length * lengths)
    else:
        wear_pin = np.vectorize(scene.pin.worn, otypes=[float, float])
        widths, depths = wear_pin(half_widths[:, None], volumes)
    if rms_height:
        peak_height = 3 * rms_height  # of the roughness above the smooth contact
        widths = np.sqrt(widths**2 + 8 * scene.pin.radius * peak_height)
    estimates = {
        "hertz_pressure": np.array([contact.peak_pressure for contact in hertz]),
        "hertz_half_width": half_widths,
        "contact_width": widths,
        "duration": durations,
        "sliding_distance": distances,
    }
    return estimates | ({"wear_depth": depths} if wear else {})


def _loading_integrals(scene: Scene, load: float) -> tuple[float, float]:
    """Duration of the loading to a load and of its hold [s], and the load's time integral [N s]."""
    load_steps = list(scene.all_load_steps(load))
    times = np.array([0.0, *(step.time for step in load_steps)])
    loads = np.array([0.0, *(step.normal_load for step in load_steps)])
    return float(times[-1]), float(np.trapezoid(loads, times))
