"""Probable mistakes in a scene, and what the model leaves out of it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pipeline.constants import LINEAR_UNCERTAINTY
from pipeline.messages import key_path
from pipeline.scene.contact_estimate import (
    ContactEstimate,
    estimate_contact,
    single_cases,
)
from pipeline.scene.format import number_at
from pipeline.sweep.case import CLOSED_FORM, SpecimenTest
from pipeline.sweep.notes import SceneWarning, unusual_warning
from pipeline.sweep.sweep import Sweep, cold_tracks
from tribo import Ramp, SelfAffineRoughness
from tribo.simulation.usual_values import USUAL

Warnings = Iterator[SceneWarning]


def warnings_of_case(sweep: Sweep, facts: ContactEstimate) -> tuple[SceneWarning, ...]:
    """Warnings of probable mistakes in one case, and of limits of the model, the gravest first.

    `facts` are the numbers of the case from `estimate_contact`.
    """
    warnings = [
        *_unusual(sweep, facts),
        *_narrow_window(sweep, facts),
        *_surface_warnings(sweep, facts),
    ]
    if sweep.scene.wear is None:
        warnings.append(SceneWarning("no_wear", "wear"))
    warnings += _large_uncertainties(sweep)
    warnings += [*_far_tests(sweep), *_fresh_specimens(sweep), *_cold_tracks(sweep)]
    return tuple(dict.fromkeys(warnings))  # pin and disk may be of one material


def warnings_of_all(sweep: Sweep) -> tuple[SceneWarning, ...]:
    """Warnings of all cases of a sweep, those of values first; each says which cases have it.

    Of many cases a few are checked, evenly spaced; the values of an entry are all checked.
    """
    of_columns = [*_unusual_values(sweep)]
    column_paths = {warning.path for warning in of_columns}
    of_entries = [warning for warning in sweep.warnings if warning.path not in column_paths]
    checked_cases = single_cases(sweep, 12)  # each takes some 0.1 s
    by_entry = dict[tuple[str, str], dict[str, SceneWarning]]()
    for label, case, _ in checked_cases:
        for warning in warnings_of_case(case, estimate_contact(case)):
            # Cases that differ in the numbers of a warning share it.
            by_entry.setdefault((warning.code, warning.path), {})[label] = warning
    of_cases = list[SceneWarning]()
    for by_label in by_entry.values():
        first, *others = by_label.values()
        cases = tuple(by_label) if len(by_label) < len(checked_cases) else ()
        differs = any(warning.values != first.values for warning in others)
        of_cases.append(
            first._replace(cases=cases, of_case=next(iter(by_label)) if differs else "")
        )
    return *of_columns, *of_entries, *of_cases


def _unusual_values(sweep: Sweep) -> Warnings:
    """Warnings of values of the sweep's columns that are outside their entry's usual range."""
    for column in sweep.case_table.columns:
        kind = number_at(column.key)
        labels = (row[column.name] for row in sweep.case_table.rows)
        numbers = [*dict.fromkeys(value for value in labels if isinstance(value, int | float))]
        warnings = [
            warning
            for number in numbers
            for warning in unusual_warning(column.key, number, kind.usual, kind.unit)
        ]
        if len(numbers) == 1 or not warnings:
            yield from warnings
        else:
            first, counts = warnings[0], (float(len(warnings)), float(len(numbers)))
            yield first._replace(code="unusual_values", values=(*counts, *first.values))


def _unusual(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warnings of values outside their usual range, where several entries determine the value."""
    for body, material in (("pin", sweep.scene.pin.material), ("disk", sweep.scene.disk)):
        ratio = material.hardness / material.elastic_modulus
        usual = USUAL["hardness_share"].ends if math.isfinite(ratio) else None
        name = sweep.source.entries[body]["material"]
        path = key_path(key_path("materials", name), "hardness")
        yield from unusual_warning(path, ratio, usual, "times the elastic modulus")
    yield from unusual_warning("loading", facts.duration.high, USUAL["duration"].ends, "s")
    loading, max_load = sweep.scene.loading, max(sweep.loads)
    if isinstance(loading, Ramp):  # its reference load sets the steps
        low, high = USUAL["reference_load"].ends
        usual = low * max_load, high * max_load
        yield from unusual_warning("loading.reference_load", loading.reference_load, usual, "N")
    if facts.surface and facts.surface.measured:
        path = "disk.roughness.ra"
        kind = number_at(path)
        yield from unusual_warning(path, facts.surface.ra, kind.usual, kind.unit)


def _narrow_window(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warning that the window is narrower than the expected contact."""
    side, pin = facts.window[0], sweep.scene.pin
    if pin.length is None:
        side = min(side, facts.window[1] / pin.hertz(1.0, 1e11).aspect)
    widest = max(facts.contact_width.high, 2 * facts.hertz_half_width.high)
    if widest >= side:
        yield SceneWarning("narrow_window", "window.pixels", (widest, side))


def _far_tests(sweep: Sweep) -> Warnings:
    """Warning of the first test that is so far outside the sweep that its units may be wrong."""
    for test in sweep.tests:
        load, velocity = test.normal_load, test.velocity
        if any(
            not min(simulated) / 10 <= value <= 10 * max(simulated)
            for value, simulated in ((load, sweep.loads), (velocity, sweep.velocities))
        ):
            yield SceneWarning("far_test", "", (load, velocity))
            return


def _surface_warnings(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    scene, surface = sweep.scene, facts.surface
    lies_along = surface is not None and surface.lay is not None and surface.lay <= 30  # [°]
    if lies_along and scene.wear and scene.wear.pattern == "swept":
        yield SceneWarning("lay_along_sliding", "wear.pattern")
    if isinstance(scene.roughness, SelfAffineRoughness):
        sides = zip("xy", scene.roughness.correlation_length, facts.window, strict=True)
        for axis, length, side in sides:
            if length > side / 3:
                path = "disk.roughness.correlation_length"
                yield SceneWarning("long_correlation", path, (axis, length))


def _large_uncertainties(sweep: Sweep) -> Warnings:
    """Warn of uncertainties by which the rise may no longer change linearly."""
    for entries, deviation in sweep.base.uncertainty:
        if deviation > LINEAR_UNCERTAINTY and not {*entries} & {*CLOSED_FORM}:
            path = f"uncertainty.{', '.join(entries)}"
            yield SceneWarning("large_uncertainty", path, (deviation, LINEAR_UNCERTAINTY))


def _cold_tracks(sweep: Sweep) -> Warnings:
    """Warning that the heat of earlier revolutions of a track is left out."""
    if tracks := cold_tracks(sweep):
        bodies = {"pin_track": "pin", "track": "disk"}
        values = list[float | str]()
        for name, track in tracks.items():
            values += [bodies[name], track.length if track else "unknown"]
        yield SceneWarning("cold_tracks", "", tuple(values))


def _fresh_specimens(sweep: Sweep) -> Warnings:
    """Warning of runs by stages that are simulated as fresh specimens.

    The stages before its two ends are stated by no entry.
    """
    runs = dict[str, list[SpecimenTest]]()
    for test in sweep.tests:
        if isinstance(test.case.scene.loading, Ramp):
            runs.setdefault(str(test.number), []).append(test)
    if names := [name for name, tests in runs.items() if len(tests) > 1]:
        unlisted = float(max(0, len(names) - 3))
        yield SceneWarning("fresh_specimens", "", (", ".join(names[:3]), unlisted))
