"""Probable slips in a scene, other pasts of tests, and what the scene leaves out."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence

from pipeline.quantities import display
from pipeline.scene.facts import USUAL_HARDNESS, Facts, Span, facts_of, single_cases
from pipeline.scene.format import SceneFile
from pipeline.scene.tables import number_at
from pipeline.sweep.case import SpecimenTest
from pipeline.sweep.left_out import note_on_ends, note_on_turns
from pipeline.sweep.remarks import Remark
from pipeline.sweep.sweep import Sweep
from pipeline.units import unusual
from pipeline.words import key_path
from tribo import MeasuredLoad, Ramp, SelfAffineRoughness, Stages

UNWORN = "not given: an unworn contact stays narrow, and gets hotter"
_LONGEST = 1 / 3  # largest correlation length over the side of the window
_REACH = 10.0  # factor beyond the ends of the sweep from which the unit of a test is in doubt
_ALONG = 30.0  # angle up to which grooves lie along sliding [°]
_MOST_CASES = 12  # cases that are looked at, each in some 0.1 s
_MOST_NAMED = 6  # of them, with one doubt
_Doubt = tuple[str, str]
"""Path of the doubtful entry, empty if it is not a single one, and the reason in words."""
Loading = Ramp | Stages | MeasuredLoad
_MANY = 3  # numbers of tests that are named


def doubts(sweep: Sweep, facts: Facts) -> tuple[Remark, ...]:
    """Warnings of probable mistakes in one scene, and of limits of the model, the gravest first.

    `facts` are the scene's numbers from `facts_of`.
    """
    found = [
        *_unusual(sweep, facts),
        ("window.pixels", _narrow_window(sweep, facts)),
        *_surface_doubts(sweep, facts),
        ("wear", UNWORN * (sweep.scene.wear is None)),
        *_test_doubts(sweep),
        ("", doubt_on_runs(sweep)),
        ("", note_on_turns(sweep)),
        ("pin.length", note_on_ends(sweep)),
    ]
    once = dict.fromkeys(found)  # pin and disk may be of one material
    return tuple(Remark(place, "warning", words) for place, words in once if words)


def doubts_of_all(sweep: Sweep) -> tuple[Remark, ...]:
    """Doubts of all cases of a sweep, those of values first; each says which cases have it.

    Of many cases a few are looked at, evenly spaced; of the values of an entry all are.
    """
    values = [*_unusual_values(sweep)]
    noted = [one for one in sweep.notes if one.grade == "warning" and one.place not in dict(values)]
    chosen, found = single_cases(sweep, _MOST_CASES), dict[str, dict[str, Remark]]()
    for label, case in chosen:
        for one in doubts(case, facts_of(case)):
            # Cases that differ in the numbers of a doubt share it.
            kind = one.place or re.sub(r"[\d.]+", "", one.words)
            found.setdefault(kind, {})[label] = one
    of_cases = list[Remark]()
    for held in found.values():
        first = next(iter(held.values()))
        of_cases.append(first._replace(words=first.words + _those_of(held, len(chosen))))
    valued = (Remark(place, "warning", words) for place, words in values)
    return *valued, *noted, *of_cases


def _those_of(held: Mapping[str, Remark], count: int) -> str:
    """Which of `count` cases have a doubt, in words; empty if all have the same."""
    texts = {one.words for one in held.values()}
    if len(held) == count and len(texts) == 1:
        return ""
    labels = [*held]
    more = f" and {len(labels) - _MOST_NAMED} more" * (len(labels) > _MOST_NAMED)
    named = f"{', '.join(labels[:_MOST_NAMED])}{more}" if len(held) < count else "all rows"
    alike = f"; numbers are of row {labels[0]}" * (len(texts) > 1)
    return f" (in {named}{alike})"


def _unusual_values(sweep: Sweep) -> Iterator[_Doubt]:
    """Warnings of values of the sweep's columns that are outside their entry's usual range."""
    for column in sweep.case_table.columns:
        kind = number_at(SceneFile, column.key)
        labels = (row[column.name] for row in sweep.case_table.rows)
        known = [*dict.fromkeys(one for one in labels if isinstance(one, int | float))]
        odd = [one for one in known if unusual(one, kind.usual, kind.unit)]
        if odd:
            several = f"{len(odd)} of {len(known)} values unusual: " * (len(known) > 1)
            yield column.key, several + unusual(odd[0], kind.usual, kind.unit)


def _unusual(sweep: Sweep, facts: Facts) -> Iterator[_Doubt]:
    """Warnings of values outside their usual range, where several entries determine the value."""
    for body, material in (("pin", sweep.scene.pin.material), ("disk", sweep.scene.disk)):
        share = material.hardness / material.elastic_modulus
        usual = USUAL_HARDNESS if math.isfinite(share) else None
        words = unusual(share, usual, "times the elastic modulus")
        name = sweep.source.entries[body]["material"]
        yield key_path(key_path("materials", name), "hardness"), words
    yield "loading", unusual(facts.duration.high, (0.05, 1e6), "s")
    loading, highest = sweep.scene.loading, max(sweep.loads)
    if isinstance(loading, Ramp):  # its reference load sets the steps
        span = highest / 100, highest * 100
        yield "loading.reference_load", unusual(loading.reference_load, span, "N")
    if facts.surface and facts.surface.measured:
        kind = number_at(SceneFile, "disk.roughness.ra")
        yield "disk.roughness.ra", unusual(facts.surface.ra, kind.usual, kind.unit)


def _narrow_window(sweep: Sweep, facts: Facts) -> str:
    """Warning that the window is narrower than the expected contact; empty if it is not."""
    side, pin = facts.window[0], sweep.scene.pin
    if pin.length is None:
        side = min(side, facts.window[1] / pin.hertz(1.0, 1e11).aspect)
    widest = max(facts.contact_width.high, 2 * facts.hertz_half_width.high)
    if widest < side:
        return ""
    return (
        f"the contact may grow to {display(widest, 'µm', 3)}, beyond the window's "
        f"{display(side, 'µm', 3)}; give more pixels"
    )


def _test_doubts(sweep: Sweep) -> Iterator[_Doubt]:
    """Warning of the first test that is so far outside the sweep that its units may be wrong."""
    loads, velocities = Span.of(sweep.loads), Span.of(sweep.velocities)
    for test in sweep.tests:
        places = (test.normal_load, loads), (test.velocity, velocities)
        if any(not low / _REACH <= value <= high * _REACH for value, (low, high) in places):
            place = f"{test.normal_load:g} N at {test.velocity:g} m/s"
            yield "", f"the test of {place} lies far outside the sweep: check its units"
            return


def _surface_doubts(sweep: Sweep, facts: Facts) -> Iterator[_Doubt]:
    scene, surface = sweep.scene, facts.surface
    along = surface is not None and surface.lay is not None and surface.lay <= _ALONG
    if along and scene.wear and scene.wear.pattern == "swept":
        yield (
            "wear.pattern",
            'the grooves lie along sliding; where the same ones pass the pin again, "swept" makes '
            'the rise about 50 % too high: give pattern = "local"',
        )
    if isinstance(scene.roughness, SelfAffineRoughness):
        sides = zip("xy", scene.roughness.correlation_length, facts.window, strict=True)
        for axis, length, side in sides:
            if length > _LONGEST * side:
                yield (
                    "disk.roughness.correlation_length",
                    f"that along {axis}, {display(length, 'µm', 3)}, is above a third of the "
                    "window, so that temperatures differ much from surface to surface: give more "
                    "window.pixels, or several surfaces (sweep.realizations)",
                )


def notes_on_scene(sweep: Sweep) -> tuple[Remark, ...]:
    """Notes on the entries of a scene, and how the past of tests differs from the plane's."""
    plane, found = sweep.scene.loading, dict[str, list[SpecimenTest]]()
    for test in sweep.tests:  # each is simulated with its own past
        if words := _difference(test.case.scene.loading, plane):
            found.setdefault(words, []).append(test)
    of_tests = (Remark("", "note", f"{_named(some)}: {words}") for words, some in found.items())
    return *(one for one in sweep.notes if one.grade == "note"), *of_tests


def _difference(own: Loading, plane: Loading) -> str:
    """How one past differs from another, and what follows; empty if they are alike."""
    if isinstance(own, MeasuredLoad) or isinstance(plane, MeasuredLoad):
        return "" if own == plane else "another record of the load than the plane's"
    if isinstance(own, Stages) and isinstance(plane, Stages):
        is_begun_alike = own.shares_stages(plane)
        return (
            "" if is_begun_alike else "other stages than the plane's: longer ones wear and cool it"
        )
    if isinstance(own, Stages):
        return "in stages, and the plane by a ramp: worn by them, it is cooler than the plane"
    if isinstance(plane, Stages):
        return "by a ramp, and the plane in stages: a fresh specimen is hotter than the plane"
    if not math.isclose(own.rate, plane.rate):
        way = "slower, worn more, and cooler" if own.rate < plane.rate else "faster, and hotter"
        return f"its load grows {way} than the plane"
    if own.hold != plane.hold:
        way = "longer" if own.hold > plane.hold else "less long"
        return f"held {way} than the plane, which counts where a body keeps heat of earlier turns"
    return ""


def doubt_on_runs(sweep: Sweep) -> str:
    """Which runs by stages are simulated as fresh specimens, in words; empty if none are.

    Both ends of such a run had a past that no entry states.
    """
    runs = dict[str, list[SpecimenTest]]()
    for test in sweep.tests:
        if isinstance(test.case.scene.loading, Ramp):
            runs.setdefault(str(test.number), []).append(test)
    alike = [test for tests in runs.values() if len(tests) > 1 for test in tests]
    if not alike:
        return ""
    return (
        f"{_named(alike)}: one specimen at several places, each simulated fresh, so too hot: give "
        "its stages"
    )


def _named(tests: Sequence[SpecimenTest]) -> str:
    """Tests by their numbers, such as "tests 1, 2 and 5 more"."""
    names = [*dict.fromkeys(str(test.number) for test in tests)]
    more = f" and {len(names) - _MANY} more" * (len(names) > _MANY)
    return f"test{'s' * (len(names) > 1)} {', '.join(names[:_MANY])}{more}"
