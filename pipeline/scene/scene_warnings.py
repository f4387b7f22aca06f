"""Probable mistakes in a scene, and what the model leaves out of it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from pipeline.scene.contact_estimate import (
    USUAL_HARDNESS,
    ContactEstimate,
    Span,
    estimate_contact,
    single_cases,
)
from pipeline.scene.format import SceneFile
from pipeline.scene.tables import number_at
from pipeline.sweep.case import SpecimenTest
from pipeline.sweep.left_out import cold_tracks, has_sharp_ends
from pipeline.sweep.notes import SceneWarning, unusual_warning
from pipeline.sweep.sweep import Sweep
from pipeline.words import key_path
from tribo import Ramp, SelfAffineRoughness

_LONGEST = 1 / 3  # largest correlation length over the side of the window
_REACH = 10.0  # factor beyond the ends of the sweep from which the unit of a test is in doubt
_ALONG = 30.0  # angle up to which grooves lie along sliding [°]
_MOST_CASES = 12  # cases that are looked at, each in some 0.1 s
Warnings = Iterator[SceneWarning]
_MANY = 3  # numbers of tests that are named


def warnings_of_case(sweep: Sweep, facts: ContactEstimate) -> tuple[SceneWarning, ...]:
    """Warnings of probable mistakes in one case, and of limits of the model, the gravest first.

    `facts` are the numbers of the case from `estimate_contact`.
    """
    found = [
        *_unusual(sweep, facts),
        *_narrow_window(sweep, facts),
        *_surface_warnings(sweep, facts),
        *([SceneWarning("no_wear", "wear")] if sweep.scene.wear is None else []),
        *_far_tests(sweep),
        *_fresh_specimens(sweep),
        *_cold_tracks(sweep),
        *([SceneWarning("sharp_ends", "pin.length")] if has_sharp_ends(sweep) else []),
    ]
    return tuple(dict.fromkeys(found))  # pin and disk may be of one material


def warnings_of_all(sweep: Sweep) -> tuple[SceneWarning, ...]:
    """Warnings of all cases of a sweep, those of values first; each says which cases have it.

    Of many cases a few are looked at, evenly spaced; of the values of an entry all are.
    """
    values = [*_unusual_values(sweep)]
    valued = {one.place for one in values}
    noted = [one for one in sweep.warnings if one.place not in valued]
    chosen = single_cases(sweep, _MOST_CASES)
    found = dict[tuple[str, str], dict[str, SceneWarning]]()
    for label, case in chosen:
        for one in warnings_of_case(case, estimate_contact(case)):
            # Cases that differ in the numbers of a warning share it.
            found.setdefault((one.code, one.place), {})[label] = one
    of_cases = (_in_cases(held, len(chosen)) for held in found.values())
    return *values, *noted, *of_cases


def _in_cases(held: Mapping[str, SceneWarning], count: int) -> SceneWarning:
    """The first of the warnings `held` by label, which says in which of `count` cases it is."""
    labels, first = [*held], next(iter(held.values()))
    cases = tuple(labels) if len(held) < count else ()
    is_shared = all(_same_values(first, one) for one in held.values())
    return first._replace(cases=cases, of_case="" if is_shared else labels[0])


def _same_values(one: SceneWarning, other: SceneWarning) -> bool:
    """True if the values of two warnings of one code are equal within rounding."""
    return all(
        a == b or (isinstance(a, float) and isinstance(b, float) and math.isclose(a, b))
        for a, b in zip(one.values, other.values, strict=True)
    )


def _unusual_values(sweep: Sweep) -> Warnings:
    """Warnings of values of the sweep's columns that are outside their entry's usual range."""
    for column in sweep.case_table.columns:
        kind = number_at(SceneFile, column.key)
        labels = (row[column.name] for row in sweep.case_table.rows)
        known = [*dict.fromkeys(one for one in labels if isinstance(one, int | float))]
        odd = [
            warning
            for one in known
            for warning in unusual_warning(column.key, one, kind.usual, kind.unit)
        ]
        if len(known) == 1 or not odd:
            yield from odd
        else:
            counts = float(len(odd)), float(len(known))
            yield odd[0]._replace(code="unusual_values", values=(*counts, *odd[0].values))


def _unusual(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warnings of values outside their usual range, where several entries determine the value."""
    for body, material in (("pin", sweep.scene.pin.material), ("disk", sweep.scene.disk)):
        share = material.hardness / material.elastic_modulus
        usual = USUAL_HARDNESS if math.isfinite(share) else None
        name = sweep.source.entries[body]["material"]
        place = key_path(key_path("materials", name), "hardness")
        yield from unusual_warning(place, share, usual, "times the elastic modulus")
    yield from unusual_warning("loading", facts.duration.high, (0.05, 1e6), "s")
    loading, highest = sweep.scene.loading, max(sweep.loads)
    if isinstance(loading, Ramp):  # its reference load sets the steps
        span = highest / 100, highest * 100
        yield from unusual_warning("loading.reference_load", loading.reference_load, span, "N")
    if facts.surface and facts.surface.measured:
        place = "disk.roughness.ra"
        kind = number_at(SceneFile, place)
        yield from unusual_warning(place, facts.surface.ra, kind.usual, kind.unit)


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
    loads, velocities = Span.of(sweep.loads), Span.of(sweep.velocities)
    for test in sweep.tests:
        place = test.normal_load, test.velocity
        pairs = zip(place, (loads, velocities), strict=True)
        if any(not low / _REACH <= value <= high * _REACH for value, (low, high) in pairs):
            yield SceneWarning("far_test", "", place)
            return


def _surface_warnings(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    scene, surface = sweep.scene, facts.surface
    along = surface is not None and surface.lay is not None and surface.lay <= _ALONG
    if along and scene.wear and scene.wear.pattern == "swept":
        yield SceneWarning("lay_along_sliding", "wear.pattern")
    if isinstance(scene.roughness, SelfAffineRoughness):
        sides = zip("xy", scene.roughness.correlation_length, facts.window, strict=True)
        for axis, length, side in sides:
            if length > _LONGEST * side:
                place = "disk.roughness.correlation_length"
                yield SceneWarning("long_correlation", place, (axis, length))


def _cold_tracks(sweep: Sweep) -> Warnings:
    """Warning that the heat of earlier turns of a track is left out."""
    if tracks := cold_tracks(sweep):
        bodies = ["pin" if name == "pin_track" else "disk" for name in tracks]
        length = next(iter(tracks.values())).length
        yield SceneWarning("cold_tracks", "", (length, " ".join(bodies)))


def _fresh_specimens(sweep: Sweep) -> Warnings:
    """Warning of runs by stages that are simulated as fresh specimens.

    Both ends of such a run had a past that no entry states.
    """
    runs = dict[str, list[SpecimenTest]]()
    for test in sweep.tests:
        if isinstance(test.case.scene.loading, Ramp):
            runs.setdefault(str(test.number), []).append(test)
    if names := [name for name, tests in runs.items() if len(tests) > 1]:
        more = float(max(0, len(names) - _MANY))
        yield SceneWarning("fresh_specimens", "", (", ".join(names[:_MANY]), more))
