"""Probable mistakes in a scene, and what the model leaves out of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from pipeline.constants import LINEAR_UNCERTAINTY
from pipeline.messages import key_path, listed
from pipeline.quantities import display
from pipeline.scene.contact_estimate import (
    ContactEstimate,
    estimate_contact,
    single_cases,
)
from pipeline.scene.format import number_at
from pipeline.sweep.case import CLOSED_FORM, SpecimenTest
from pipeline.sweep.notes import SceneWarning, unusual_warning
from pipeline.sweep.sweep import BODIES, Sweep, cold_tracks
from tribo import Ramp, SelfAffineRoughness
from tribo.simulation.usual_values import USUAL

Warnings = Iterator[SceneWarning]


def warnings_of_all(sweep: Sweep) -> tuple[SceneWarning, ...]:
    """Warnings of all cases of a sweep, those of values first; each says which cases have it.

    Warnings of probable mistakes and of limits of the model are there, the gravest first. Of many
    cases a few are checked, evenly spaced; the values of an entry are all checked.
    """
    of_columns = [*_unusual_values(sweep)]
    column_paths = {warning.path for warning in of_columns}
    of_entries = [warning for warning in sweep.warnings if warning.path not in column_paths]
    checked_cases = [  # each takes some 0.1 s
        (label, case, estimate_contact(case)) for label, case, _ in single_cases(sweep, 12)
    ]
    of_cases = list[SceneWarning]()
    for check in _CHECKS:
        by_path = dict[str, dict[str, SceneWarning]]()
        for label, case, facts in checked_cases:
            for warning in check(case, facts):
                by_path.setdefault(warning.path, {})[label] = warning
        for by_label in by_path.values():  # cases that differ in its numbers share a warning
            first, *others = by_label.values()
            cases = tuple(by_label) if len(by_label) < len(checked_cases) else ()
            of_case = next(iter(by_label)) if any(other != first for other in others) else ""
            of_cases.append(first._replace(cases=cases, of_case=of_case))
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
            count = f"{len(warnings)} of {len(numbers)} values"
            yield warnings[0]._replace(words=f"{count}: {warnings[0].words}")


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
        words = (
            f"the contact may grow to {display(widest, 'µm', 3)}, wider than the window "
            f"({display(side, 'µm', 3)}); increase window.pixels"
        )
        yield SceneWarning("window.pixels", words, is_in_answers=True)


def _no_wear(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warning of a scene without wear."""
    if sweep.scene.wear is None:
        words = "there is no table [wear]; an unworn contact stays narrow and runs hotter"
        yield SceneWarning("wear", words)


def _far_tests(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warning of the first test that is so far outside the sweep that its units may be wrong."""
    for test in sweep.tests:
        load, velocity = test.normal_load, test.velocity
        if any(
            not min(simulated) / 10 <= value <= 10 * max(simulated)
            for value, simulated in ((load, sweep.loads), (velocity, sweep.velocities))
        ):
            test_point = f"{load:g} N at {velocity:g} m/s"
            words = f"the test at {test_point} lies far outside the sweep: check its units"
            yield SceneWarning("", words)
            return


def _surface_warnings(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    scene, surface = sweep.scene, facts.surface
    lies_along = surface is not None and surface.lay is not None and surface.lay <= 30  # [°]
    if lies_along and scene.wear and scene.wear.pattern == "swept":
        words = (
            "the grooves run along the sliding direction; if the same grooves pass the pin again, "
            'pattern = "swept" makes the rise about 50 % too high: use pattern = "local"'
        )
        yield SceneWarning("wear.pattern", words)
    if isinstance(scene.roughness, SelfAffineRoughness):
        sides = zip("xy", scene.roughness.correlation_length, facts.window, strict=True)
        for axis, length, side in sides:
            if length > side / 3:
                words = (
                    f"along {axis} it is {display(length, 'µm', 3)}, more than a third of the "
                    "window, so that temperatures vary strongly between surface realizations: "
                    "increase window.pixels, or simulate several (sweep.realizations)"
                )
                yield SceneWarning("disk.roughness.correlation_length", words)


def _large_uncertainties(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warn of uncertainties by which the rise may no longer change linearly."""
    for entries, deviation in sweep.base.uncertainty:
        if deviation > LINEAR_UNCERTAINTY and not {*entries} & {*CLOSED_FORM}:
            words = (
                f"{100 * deviation:.3g} % is more than {100 * LINEAR_UNCERTAINTY:.3g} %, up to "
                "which inputs act linearly; a probability of severe wear can be wrong by more than "
                "0.02: compare values by sweep.over"
            )
            yield SceneWarning(f"uncertainty.{', '.join(entries)}", words)


def _cold_tracks(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warning that the heat of earlier revolutions of a track is left out."""
    if tracks := cold_tracks(sweep):
        lengths = {BODIES[name]: track and track.length for name, track in tracks.items()}
        texts = " and ".join(
            f"the {body} (track of {display(length, 'mm', 3)})"
            if length
            else f"the {body} (length of its track unknown: set motion.{body}_track_length)"
            for body, length in lengths.items()
        )
        entries = " and ".join(f"{body}.diameter" for body in lengths)
        words = (
            f"heat from earlier revolutions of {texts} is not included; it warms the contact "
            f"further: set {entries} and width, or track_length, or enter the bulk temperature of "
            "the warm tracks"
        )
        yield SceneWarning("", words, is_in_answers=True)


def _fresh_specimens(sweep: Sweep, facts: ContactEstimate) -> Warnings:
    """Warning of runs by stages that are simulated as fresh specimens.

    The stages before its two ends are stated by no entry.
    """
    runs = dict[str, list[SpecimenTest]]()
    for test in sweep.tests:
        if isinstance(test.case.scene.loading, Ramp):
            runs.setdefault(str(test.number), []).append(test)
    if names := [name for name, tests in runs.items() if len(tests) > 1]:
        words = (
            f"{'tests' if len(names) > 1 else 'test'} {listed(names, 3)}: one specimen at several "
            "points, but each is simulated as a fresh specimen and thus too hot: give its load "
            "stages"
        )
        yield SceneWarning("", words)


_CHECKS: tuple[Callable[[Sweep, ContactEstimate], Warnings], ...] = (
    _unusual, _narrow_window, _surface_warnings, _no_wear, _large_uncertainties, _far_tests,
    _fresh_specimens, _cold_tracks,
)  # fmt: skip
"""Checks of a case, by the gravity of what they warn of."""
