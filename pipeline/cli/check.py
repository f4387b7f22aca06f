"""The command ``irg check``; it imports no more than a scene needs."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, astuple

import numpy as np
import pandas as pd

import pipeline
from pipeline.answers.discretization_error import has_unknown_error
from pipeline.answers.scene_words import added_rise_words, warning_text
from pipeline.cli.given import scene_in
from pipeline.cli.output import Result, pluralized
from pipeline.frames import frame_of, records
from pipeline.progress import duration
from pipeline.quantities import display, display_sides, shown_in
from pipeline.run.estimate import Estimate, machine_memory, worker_bytes
from pipeline.scene.contact_estimate import (
    CaseEstimate,
    ContactEstimate,
    Span,
    estimate_case,
    estimate_contact,
    estimate_contacts,
    require_admissible_load,
    single_cases,
)
from pipeline.store.schema import require_free_names
from pipeline.surface.window import form_words
from pipeline.sweep.case_table import CASE
from pipeline.sweep.notes import SceneNote, library_tables
from pipeline.sweep.sweep import Sweep
from tribo import InputError, MeasuredLoad, Ramp, Scene, Stages, lubrication_regime
from tribo.simulation.lubrication import SurfaceSummary, find_lubrication


def check(options: argparse.Namespace) -> Result:
    """Answer ``irg check``: describe a scene, and estimate the cost of its sweep."""
    sweep = scene_in(options)
    cases, along = single_cases(sweep, _MOST_CASES), sweep.case_table.column("load") is not None
    for _, case in cases:
        key = "sweep.along" if along else "sweep.loads"
        require_admissible_load(case, max(case.loads), key)
    require_free_names(sweep)
    facts = estimate_contacts(cases) if along else estimate_contact(sweep)
    listed = [estimate_case(*one) for one in cases] if along else []
    memory, machine = worker_bytes(sweep), machine_memory()
    needed = f"about {display(memory, 'MB', '.0f')} of memory per worker"
    if memory > machine:
        raise InputError(
            f"the scene needs {needed}, but this machine has {display(machine, 'GB', '.0f')}; "
            "reduce window.pixels, or choose coarser settings in [fidelity]"
        )
    cost = pipeline.estimate(sweep, workers=options.workers)
    rows = [
        *_meaning_rows(sweep, facts, listed, needed),
        *(("library", f"{one}, from {source}") for one, source in library_tables(sweep.sources)),
        *(("note", one.text) for one in notes_on_scene(sweep)),
        *(("warning", warning_text(one)) for one in sweep.all_warnings),
        *_cost_rows(sweep, cost),
    ]
    frame = frame_of(_HEADS, rows)
    shown = frame[frame["subject"] != "library"].set_axis(["", ""], axis="columns")
    on_sources = ["for library values with their sources: -o TABLE.md"] * bool(sweep.sources)
    table = [_case_frame(listed), ""] if along else []
    document = {
        "title": sweep.title,
        "preset": sweep.preset,
        "contact": asdict(facts),  # in SI
        "cost": {**asdict(cost), "worker_bytes": memory},
        "cases": [asdict(one) for one in listed],  # in SI
        "statements": records([frame]),
    }
    return Result(document, [sweep.title, "", *table, shown, *on_sources], frames=[frame])


_HEADS = "subject", "meaning"
_MOST_CASES = 200  # of a sweep along a table, that are described
_IS_LEVEL = 0.01  # share of Rq below which a tilt or a mean height is not worth a word
_FILM_CARRIES = 0.35  # film parameter above which the film carries a share of the load
_MOST_NAMED = 3  # tests
_Row = tuple[str, str]
"""A subject (empty for a continued one), and a sentence on it."""


def _case_frame(cases: Sequence[CaseEstimate]) -> pd.DataFrame:
    """Table of the contacts in the cases of a sweep, each at its own load and velocity."""
    heads = (
        "case", "load [N]", "Hertz half-width [µm]", "pressure [GPa]", "pin [m/s]", "disk [m/s]",
        "slide–roll ratio", "Λ",
    )  # fmt: skip
    rows = (astuple(one) for one in cases)
    return frame_of(heads, [(*row[:2], *(float(f"{one:.4g}") for one in row[2:])) for row in rows])


def _meaning_rows(
    sweep: Sweep, facts: ContactEstimate, cases: Sequence[CaseEstimate], memory: str
) -> Iterator[_Row]:
    """Yield rows that describe a scene: contact, surface, motion, film, wear and heat."""
    scene, conditions = sweep.scene, sweep.conditions
    pressure, half_width = _text(facts.hertz_pressure, "GPa"), _text(facts.hertz_half_width, "µm")
    worn, rough = "worn" if facts.wear_depth else "unworn", "rough" if facts.surface else "smooth"
    smooth = f"Hertz: maximum pressure {pressure}, half-width {half_width}"
    yield "contact", f"{smooth}; {worn} and {rough}: width {_text(facts.contact_width, 'µm')}"
    nx, ny = scene.grid.shape
    yield "window", f"{display_sides(facts.window)}, {nx} × {ny} elements; {memory}"
    given = sweep.source.entries["window"]["pixels"]
    if wider := _wider(given, scene):
        yield "", f"widened from {given[0]} pixels because of wear in the load stages; {wider}"
    yield "surface", _surface_words(facts.surface) if facts.surface else "smooth"
    time, distance = _text(facts.duration, "s"), _text(facts.sliding_distance, "m")
    yield "motion", f"duration {time}, sliding distance {distance}"
    yield from _film_rows(sweep, [one.film_parameter for one in cases])
    depth = facts.wear_depth
    yield "wear", f"{_text(depth, 'µm')} deep at the end of the test" if depth else "none"
    u = "of the disk u" if scene.motion else "V"
    peclet = f"Péclet number {_text(facts.peclet_number)}, defined as {u} a/(2 κ) with the Hertzian"
    yield "heat", f"{peclet} half-width a" if scene.friction_heat else "none, as friction is zero"
    if added := added_rise_words(conditions):
        yield "", added
    elif scene.friction_heat and not sweep.tests:
        words = "heating through pin holder and surface films is not modelled; model.rise adds it"
        yield "", f"{words} (irg help physics)"
    if conditions.corrections:
        yield "corrections", conditions.corrections.text


def _wider(given: tuple[int, ...], scene: Scene) -> str:
    """Size and cost of a window that is wider than the `given` pixels; else empty."""
    share = _pixels(scene) / math.prod(given)
    if share <= 1:
        return ""
    nx, ny = scene.pixels.shape
    return f"{nx} × {ny} pixels; each step costs {share:.2g} times as much"


def _pixels(scene: Scene) -> int:
    return math.prod(scene.pixels.shape)


def _film_rows(sweep: Sweep, parameters: Sequence[float]) -> Iterator[_Row]:
    """Yield rows on the oil film, or on the entry that is missing to compute it.

    `parameters` are the film parameters of the sweep's cases, if each has its own place.
    """
    if sweep.lubricant is None:
        return
    bulk = sweep.conditions.bulk_temperature
    viscosity = f"{display(sweep.lubricant.viscosity(bulk), 'mPa s', 3)} at the bulk temperature"
    lubrication = find_lubrication(sweep.scene, sweep.lubricant)
    if lubrication is None:
        has_pressure_coefficient = sweep.lubricant.pressure_coefficient is not None
        missing = "a rough disk" if has_pressure_coefficient else "pressure_viscosity_coefficient"
        yield "oil", f"{viscosity}; film thickness unknown without {missing}"
        return
    loads, velocities = (np.array(axis)[[0, -1]] for axis in (sweep.loads, sweep.velocities))
    span = Span.from_values(
        parameters or lubrication.film_parameter(loads[:, None], velocities, bulk)
    )
    regimes = dict.fromkeys(lubrication_regime(value) for value in span)
    regime = " to ".join(regimes).replace(" lubrication to", " to")
    yield "oil", f"{viscosity}; Λ {_text(span)}: {regime}"
    if sweep.scene.pin.length is None and span.high >= _FILM_CARRIES:
        yield "", "the fraction of the load that the oil film carries is unknown (irg help physics)"


def _text(span: Span, unit: str = "") -> str:
    """Range of a quantity, or its single value, as text in a `unit`, such as "1.2 to 3 µm"."""
    low, high = (f"{shown_in(value, unit):.3g}" for value in span)
    return f"{low if low == high else f'{low} to {high}'} {unit}".rstrip()


def _cost_rows(sweep: Sweep, cost: Estimate) -> Iterator[_Row]:
    """Yield rows on the cost of a sweep: points, steps, time and disk."""
    velocities = sweep.case_table.column("velocity") or sweep.velocities
    loads = pluralized(len(sweep.loads), "load", "loads")
    counts = [loads, pluralized(len(velocities), "velocity", "velocities")]
    names = {"realization": "surfaces", CASE: "cases"}
    if sweep.case_table.column("load"):
        counts, names[CASE] = [], "cases, each at its own load and velocity"
    for name, values in sweep.case_table.axes.items():
        counts.append(f"{len(values)} {names.get(name, f'values of {name}')}")
    yield "points", f"{cost.points}: {', '.join(counts)}"
    if cost.tests:
        yield "tests", f"{pluralized(cost.tests, 'point', 'points')} for tests, simulated first"
        widest = max((test.case.scene for test in sweep.tests), key=_pixels)
        if wider := _wider(sweep.scene.pixels.shape, widest):
            yield "", f"tests with load stages need wider windows, up to {wider}"
    workers, size = pluralized(cost.workers, "worker", "workers"), cost.disk_bytes
    disk = f"about {display(size, 'MB', '.0f')}" if size >= 1e6 else "less than 1 MB"
    time = f"about {duration(cost.seconds)} on {workers} of an idle machine"
    yield "time", f"{time}; {disk} of disk space"
    if has_unknown_error(sweep):
        words = "unknown for custom numerical settings; --accuracy 2% replaces them by a preset"
        yield "error", words


def _surface_words(facts: SurfaceSummary) -> str:
    """Roughness, slope, lay, curvature and tilt in words."""
    lay = "no lay" if facts.lay is None else f"grooves at {facts.lay:.0f}° to the sliding direction"
    slope = "" if facts.slope is None else f"rms slope {facts.slope:.2g}, "
    heights = f"Ra {display(facts.ra, 'µm', 3)}, Rq {display(facts.rq, 'µm', 3)}, {slope}{lay}"
    if not facts.measured:
        return f"random: {heights}"
    curved = form_words(facts.radii)
    heights += f"; Ra and Rq exclude the curvature, R {curved}" if curved else ""
    if all(abs(place) < _IS_LEVEL * facts.rq for place in (facts.mean_height, *facts.rise)):
        return f"measured: {heights}; level"
    mean, x, y = (shown_in(place, "µm") for place in (facts.mean_height, *facts.rise))
    return (
        f"measured: {heights}; mean plane at {mean:.3g} µm, rising by {x:.3g} µm along x and "
        f"{y:.3g} µm along y over the window"
    )


def notes_on_scene(sweep: Sweep) -> tuple[SceneNote, ...]:
    """Notes on the entries of a scene, and on tests that are loaded in another way than the plane.

    Each test is simulated with its own past.
    """
    others = [one for one in sweep.tests if not _is_alike(one.case.scene.loading, sweep)]
    if not others:
        return sweep.notes
    names = [*dict.fromkeys(str(test.number) for test in others)]
    more = f" and {len(names) - _MOST_NAMED} more" * (len(names) > _MOST_NAMED)
    words = (
        f"test{'s' * (len(names) > 1)} {', '.join(names[:_MOST_NAMED])}{more}: loaded in another "
        "way than the sweep, so that wear before the end, and the temperature, differ"
    )
    return *sweep.notes, SceneNote("", words)


def _is_alike(own: Ramp | Stages | MeasuredLoad, sweep: Sweep) -> bool:
    """True if a test is loaded as the points of a sweep."""
    plane = sweep.scene.loading
    if isinstance(own, Stages) and isinstance(plane, Stages):
        return own.shares_stages(plane)
    if isinstance(own, Ramp) and isinstance(plane, Ramp):
        return math.isclose(own.rate, plane.rate) and own.hold == plane.hold
    return own == plane
