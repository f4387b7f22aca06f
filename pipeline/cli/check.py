"""The command ``irg check``; it imports no more than a scene needs."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pandas as pd

import pipeline
from pipeline.answers.error import has_boundary, has_unknown_preset_error, preset_error_text
from pipeline.answers.scene_wording import added_rise_words
from pipeline.cli.inputs import scene_in
from pipeline.cli.output import Result
from pipeline.frames import frame_of, records
from pipeline.messages import pluralized
from pipeline.progress import duration
from pipeline.quantities import display, display_sides, in_unit
from pipeline.run.estimate import Estimate, machine_memory, worker_bytes
from pipeline.scene.contact_estimate import (
    ContactEstimate,
    SingleCase,
    Span,
    estimate_contact,
    estimate_contacts,
    require_admissible_load,
    single_cases,
)
from pipeline.store.schema import require_free_names
from pipeline.surface.window import form_words
from pipeline.sweep.case_table import CASE
from pipeline.sweep.notes import library_tables
from pipeline.sweep.sweep import Sweep
from tribo import InputError, Oil, lubrication_regime
from tribo.simulation.lubrication import SurfaceSummary

_ENDS = {
    True: 'which pin.ends = "free" computes (irg help model: how much)',
    False: 'without a known size; pin.ends = "free" computes them',
}
"""What to do about the ends of a pin, by whether the pin rests and wears."""
_CASE_COLUMNS = {
    "Hertz half-width [µm]": "hertz_half_width", "pressure [GPa]": "hertz_pressure",
    "pin [m/s]": "pin_velocity", "disk [m/s]": "disk_velocity",
    "slide–roll ratio": "slide_roll_ratio", "Λ": "film_parameter",
}  # fmt: skip
"""Numbers of the contact of each case, by heading."""
_Row = tuple[str, str]
"""A subject (empty for a continued one), and a sentence on it."""


def check(options: argparse.Namespace) -> Result:
    """Answer ``irg check``: describe a scene, and estimate the cost of its sweep."""
    sweep = scene_in(options)
    cases, is_listed = single_cases(sweep, 200), sweep.case_table.column("load") is not None
    for case in cases:
        key = "sweep.along" if is_listed else "sweep.loads"
        require_admissible_load(case.sweep, max(case.sweep.loads), key)
    require_free_names(sweep)
    contact = estimate_contacts(cases) if is_listed else estimate_contact(sweep)
    case_estimates = [_case_estimate(case) for case in cases] if is_listed else []
    needed_bytes, available = worker_bytes(sweep), machine_memory()
    required = f"about {display(needed_bytes, 'MB', '.0f')} of memory per worker"
    if needed_bytes > available:
        raise InputError(
            f"the scene needs {required}, but this machine has {display(available, 'GB', '.0f')}; "
            "reduce window.pixels, or choose coarser settings in [fidelity]"
        )
    cost = pipeline.estimate(sweep, workers=options.workers)
    store = getattr(options, "store_path", None) or Path("results") / f"{options.scene.stem}.zarr"
    missing = _missing_of_inputs(sweep, store)
    missing = cost.uncertain if missing is None else missing
    rows = [
        *_meaning_rows(sweep, contact, case_estimates, required),
        *(("library", f"{text}, from {source}") for text, source in library_tables(sweep.sources)),
        *([("note", sweep.note)] if sweep.note else []),
        *(("note", note.text) for note in sweep.notes),
        *(("warning", warning.text) for warning in sweep.all_warnings),
        *_cost_rows(sweep, cost, missing),
    ]
    frame = frame_of(("subject", "meaning"), rows)
    statements = frame[frame["subject"] != "library"].set_axis(["", ""], axis="columns")
    sources_hint = ["-o TABLE.md lists library values with their sources"] if sweep.sources else []
    case_table = [_case_frame(case_estimates), ""] if is_listed else []
    document = {
        "title": sweep.title,
        "preset": sweep.preset,
        "contact": asdict(contact),  # in SI
        "cost": {**asdict(cost), "missing_uncertain": missing, "worker_bytes": needed_bytes},
        "cases": case_estimates,  # in SI
        "statements": records([frame]),
    }
    text = [sweep.title, "", *case_table, statements, *sources_hint]
    return Result(document, text, [frame])


def _case_estimate(case: SingleCase) -> dict[str, Any]:
    """Numbers of a row at its own load and velocity [SI]."""
    contact = estimate_contact(replace(case.sweep, loads=(case.load,)))
    spans = {name: getattr(contact, name) for name in _CASE_COLUMNS.values()}
    values = {name: span.low if span else math.nan for name, span in spans.items()}
    return {"case": case.label, "load": case.load, **values}


def _case_frame(cases: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Table of the contacts in the cases of a sweep, each at its own load and velocity."""
    rows = [
        (label, load, *(float(f"{value:.4g}") for value in values))
        for label, load, *values in (case.values() for case in cases)
    ]
    return frame_of(("case", "load [N]", *_CASE_COLUMNS), rows)


def _meaning_rows(
    sweep: Sweep, contact: ContactEstimate, cases: Sequence[Mapping[str, Any]], memory: str
) -> Iterator[_Row]:
    """Yield rows that describe a scene: contact, surface, motion, film, wear and heat."""
    scene, conditions = sweep.scene, sweep.conditions
    pressure = _span_text(contact.hertz_pressure, "GPa")
    half_width = _span_text(contact.hertz_half_width, "µm")
    width = _span_text(contact.contact_width, "µm")
    wear_state = "worn" if contact.wear_depth else "unworn"
    texture = "rough" if contact.surface else "smooth"
    hertz = f"Hertz: maximum pressure {pressure}, half-width {half_width}"
    yield "contact", f"{hertz}; {wear_state} and {texture}: width {width}"
    nx, ny = scene.grid.shape
    yield "window", f"{display_sides(contact.window)}, {nx} × {ny} elements; {memory}"
    if scene.pixels.periodic[1]:
        yield "", "repeats along y; pin ends: not modelled, " + _ENDS[scene.wears_by_strips]
    yield "surface", _surface_words(contact.surface) if contact.surface else "smooth"
    time, distance = _span_text(contact.duration, "s"), _span_text(contact.sliding_distance, "m")
    yield "motion", f"duration {time}, sliding distance {distance}"
    if sweep.lubricant is not None:
        films = [case["film_parameter"] for case in cases]
        span = Span.from_values(films) if films else contact.film_parameter
        yield "oil", _oil_words(sweep.lubricant, conditions.bulk_temperature, span)
    depth = contact.wear_depth
    yield "wear", f"{_span_text(depth, 'µm')} deep at the end of the test" if depth else "none"
    velocity = "u" if scene.motion else "V"
    of_disk = "the velocity u of the disk and " if scene.motion else ""
    peclet = (
        f"Péclet number {velocity} a/(2 κ) {_span_text(contact.peclet_number)}, with {of_disk}the "
        "Hertzian half-width a"
    )
    yield "heat", peclet if scene.friction_heat else "none, as friction is zero"
    if added := added_rise_words(conditions):
        yield "", added
    if conditions.corrections:
        yield "corrections", conditions.corrections.text


def _oil_words(oil: Oil, bulk: float, film: Span | None) -> str:
    """Viscosity and film parameter of the oil, or the entry that is missing to compute it."""
    viscosity = f"{display(oil.viscosity(bulk), 'mPa s', 3)} at the bulk temperature"
    if film is None or math.isnan(film.low):
        missing = "a rough disk" if oil.pressure_coefficient else "pressure_viscosity_coefficient"
        return f"{viscosity}; film thickness unknown without {missing}"
    regime = " to ".join(dict.fromkeys(map(lubrication_regime, film)))
    return f"{viscosity}; Λ {_span_text(film)}: {regime}"


def _span_text(span: Span, unit: str = "") -> str:
    """Range of a quantity, or its single value, as text in a `unit`, such as "1.2 to 3 µm"."""
    low, high = (f"{in_unit(value, unit):.3g}" for value in span)
    return f"{low if low == high else f'{low} to {high}'} {unit}".rstrip()


def _missing_of_inputs(sweep: Sweep, store: Path) -> int | None:
    """Points for uncertain inputs that a store lacks; None without a store."""
    if not (sweep.base.uncertainty and store.is_dir()):
        return None
    from pipeline.run.boundary_variants import missing_variants  # imports Zarr

    return missing_variants(sweep, store)


def _cost_rows(sweep: Sweep, cost: Estimate, missing: int) -> Iterator[_Row]:
    """Yield rows on the cost of a sweep: points, tests and time."""
    velocities = sweep.case_table.column("velocity") or sweep.velocities
    loads = pluralized(len(sweep.loads), "load", "loads")
    counts = [loads, pluralized(len(velocities), "velocity", "velocities")]
    names = {"realization": "surfaces", CASE: "cases"}
    if sweep.case_table.column("load"):
        counts, names[CASE] = [], "cases, each at its own load and velocity"
    for name, values in sweep.case_table.axes.items():
        counts.append(f"{len(values)} {names.get(name, f'values of {name}')}")
    if factors := sweep.case_table.load_factors:
        counts.append(f"{len(factors)} load factors from {factors[0]:g} to {factors[-1]:g}")
    yield "points", f"{cost.points}: {', '.join(counts)}"
    if cost.tests:
        yield "tests", f"{pluralized(cost.tests, 'point', 'points')} for tests, simulated first"
    if cost.uncertain:
        count = pluralized(cost.uncertain, "point", "points")
        yield "inputs", f"{count} for uncertain inputs, simulated last; {missing} of them missing"
    time, workers = duration(cost.seconds), pluralized(cost.workers, "worker", "workers")
    yield "time", f"about {time} on {workers} of an idle machine"
    if has_unknown_preset_error(sweep):
        yield (
            "error",
            "unknown for custom numerical settings; irg run --accuracy 2% sets a preset instead",
        )
    elif has_boundary(sweep):
        yield "error", preset_error_text(sweep)


def _surface_words(surface: SurfaceSummary) -> str:
    """Roughness, slope, lay, curvature and tilt in words."""
    lay = "no lay"
    if surface.lay is not None:
        lay = f"grooves at {surface.lay:.0f}° to the sliding direction"
    slope = "" if surface.slope is None else f"rms slope {surface.slope:.2g}, "
    heights = f"Ra {display(surface.ra, 'µm', 3)}, Rq {display(surface.rq, 'µm', 3)}, {slope}{lay}"
    if not surface.measured:
        return f"random: {heights}"
    if radii := form_words(surface.radii):
        heights = f"{heights}; Ra and Rq exclude the curvature, R {radii}"
    # To 1e-5 of Ra, and of 1 nm on a smooth surface; below it there are rounding errors.
    digit = 1e-5 * max(surface.ra, 1e-9)  # [m]
    plane = (digit * round(height / digit) for height in (surface.mean_height, *surface.rise))
    mean, x, y = (in_unit(height, "µm") for height in plane)
    return (
        f"measured: {heights}; mean plane at {mean:.3g} µm, rising by {x:.3g} µm along x and "
        f"{y:.3g} µm along y over the window"
    )
