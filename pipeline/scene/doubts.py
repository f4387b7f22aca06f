"""Probable slips in a scene: values far from the usual, contacts beyond the model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from typing import Any

from pipeline.quantities import display, shown_in
from pipeline.scene.declare import Either, List, Table, table_of
from pipeline.scene.facts import USUAL_HARDNESS, Facts, Span, tracks_of
from pipeline.scene.faults import joined
from pipeline.scene.format import BULK, Material, SceneFile
from pipeline.scene.kinds import Kind, Number, Quantity
from pipeline.scene.reference import usual_of, usual_range
from pipeline.scene.written import form_of
from pipeline.sweep.model import Sweep
from pipeline.sweep.physics import note_on_ends, note_on_turns
from pipeline.sweep.remarks import Remark
from pipeline.sweep.surface import SurfaceFacts
from tribo import Ramp, SelfAffineRoughness
from tribo.simulation.element_size import FEWEST_ACROSS, FEWEST_ROWS
from tribo.simulation.point_warnings import (
    FEWEST_PIXELS,
    FEWEST_TURNS,
    WIDEST,
)

_LONGEST = 1 / 3  # correlation length in sides of the window
_REACH = 10.0  # times the ends of the sweep, beyond which the unit of a test is in doubt
_MOST_RISE = 2.0  # rise of the mean plane over the window, in Rq
_ALONG = 30.0  # angle up to which grooves lie along sliding [°]
_Doubt = tuple[str, str]
"""Path of the entry that is in doubt, empty if it is none alone, and words."""
Usual = tuple[str, float | None, float, float, str]
"""Place with what is there, the value in SI, the usual range in a unit, and the unit."""


def doubts(sweep: Sweep, facts: Facts) -> tuple[Remark, ...]:
    """Probable slips, and limits to know of before the simulation."""
    found = (
        *_unusual(sweep, facts),
        *_wear_doubts(sweep, facts),
        *_test_doubts(sweep),
        ("", note_on_turns(sweep)),
        *_motion_doubts(sweep),
        *(_surface_doubts(sweep, facts.surface) if facts.surface else ()),
        *_contact_doubts(sweep, facts),
    )
    return tuple(Remark(place, "warning", words) for place, words in found if words)


def _unusual(sweep: Sweep, facts: Facts) -> Iterator[_Doubt]:
    """Quantities outside their usual ranges."""
    declared = dict(vars(sweep.parts().declared))
    for name, material in (declared.pop("materials") or {}).items():
        yield from material_doubts(joined("materials", name), material)
    for name, value in declared.items():
        yield from beyond_declared(table_of(SceneFile).keys[name].kind, value, name)
    others = [("loading: time until the end", facts.duration.high, 0.05, 1e6, "s")]
    loading, highest = sweep.scene.loading, max(sweep.plane.loads)
    if isinstance(loading, Ramp):  # whose steps it sets
        load = loading.reference_load
        others.append(("loading.reference_load", load, highest / 100, highest * 100, "N"))
    if facts.surface and facts.surface.measured:
        others.append(("disk.roughness.ra", facts.surface.ra, *usual_range("disk.roughness.ra")))
    yield from beyond_usual(others)
    band, friction = sweep.about.friction_band, sweep.conditions.friction
    if band and not min(band) <= friction <= max(band):
        outside = f"{min(band):g} to {max(band):g} does not hold friction.coefficient, {friction:g}"
        yield "friction.band", f"{outside}: give a band that does"


def material_doubts(place: str, material: Any) -> Iterator[_Doubt]:
    """Constants of a material outside their usual ranges."""
    yield from beyond_declared(table_of(Material), material, place)
    share = material.hardness / material.elastic_modulus
    yield from beyond_usual(
        [(f"{place}.hardness", share, *USUAL_HARDNESS, "times the elastic modulus")]
    )


def beyond_declared(kind: Kind, value: Any, path: str) -> Iterator[_Doubt]:
    """Entries outside the usual ranges that the format declares."""
    if value is None or value == ():
        return
    match kind:
        case Either():
            yield from beyond_declared(form_of(kind, value), value, path)
        case Table(keys):
            for key, entry in keys.items():
                yield from beyond_declared(entry.kind, getattr(value, key, None), joined(path, key))
        case List(of) if is_dataclass(value[0]):
            for number, one in enumerate(value):
                yield from beyond_declared(of, one, f"{path}[{number}]")
        case List(of):
            for end in sorted({min(value), max(value)}):
                yield from beyond_declared(of, end, path)
        case Quantity() | Number():
            yield from beyond_usual([(path, value, *usual_of(kind))])


def beyond_usual(quantities: Iterable[Usual]) -> Iterator[_Doubt]:
    """Those of some quantities that are outside their usual ranges."""
    for name, value, low, high, unit in quantities:
        shown = math.nan if value is None else shown_in(value, unit)
        if math.isfinite(shown) and not low <= shown <= high:
            (place, _, part), of = name.partition(": "), f" {unit}" if unit else ""
            words = f"{part} {shown:.3g}{of}, where {low:g} to {high:g}{of} are usual".lstrip()
            yield place, f"{words}: check the number and its unit"


def _wear_doubts(sweep: Sweep, facts: Facts) -> Iterator[_Doubt]:
    """A pin that keeps its shape, or turns too seldom to wear evenly."""
    scene = sweep.scene
    if scene.wear is None:
        yield (
            "wear",
            "not given: the pin keeps its shape, so its contact stays narrow and gets hotter than "
            "a worn one",
        )
    speeds = [abs(scene.velocities_at(v).pin) for v in sweep.plane.velocities if v]
    turns = [facts.duration.low * speed / scene.track_length for speed in speeds]
    few = sum(turn < FEWEST_TURNS for turn in turns)
    if scene.wears and few and any(turns):
        yield (
            "sweep.velocities",
            f"the pin turns only {min(turns):.2g} times until the end at the lowest load, fewer "
            f"than {FEWEST_TURNS} at {few} of {len(turns)} velocities, and its wear is taken to "
            "spread evenly around it: leave such velocities out, or let the pin turn faster",
        )


def _motion_doubts(sweep: Sweep) -> Iterator[_Doubt]:
    speeds = [sweep.scene.velocities_at(velocity) for velocity in sweep.plane.velocities]
    for body, track in tracks_of(sweep).items():
        if not any(getattr(speed, body) for speed in speeds):
            yield (
                body,
                f"the {body} is at rest, so that no earlier turn warms its track of "
                f"{display(track.length, 'mm', 4)}: leave out the {body}'s diameter or "
                "track_length",
            )


def _contact_doubts(sweep: Sweep, facts: Facts) -> Iterator[_Doubt]:
    share = facts.contact_width.high / 2 / sweep.scene.pin.radius
    if share > WIDEST:
        yield (
            "pin.radius",
            f"half of the contact's width is expected to reach {share:.2g} of the pin's radius, "
            f"where at most {WIDEST:g} is sound: the bodies are no half-spaces, and a worn pin has "
            "lost its shape",
        )
    if note := note_on_ends(sweep):
        yield "pin.length", note
    across = facts.contact_width.low / sweep.scene.pixels.spacing[0]
    fewest = FEWEST_ACROSS if sweep.scene.pin.length is None else FEWEST_ROWS
    if across < fewest:
        yield (
            "window.pixel_size",
            f"the contact is expected to be {across:.2g} pixels wide at the lowest load and "
            f"velocity; with fewer than {fewest} the rise is mostly too low, by 5 to 70 %: give "
            "smaller pixels",
        )
    side, window = facts.window[0], "window"
    if sweep.scene.pin.length is None:
        across = facts.window[1] / sweep.scene.pin.hertz(1.0, 1e11).aspect
        if across < side:
            side, window = across, "room for it in the window, by its length along y,"
    hertz = 2 * facts.hertz_half_width.high
    if hertz >= side:
        yield (
            "window.pixels",
            f"the contact of Hertz is {display(hertz, 'µm', 3)} wide at {max(sweep.plane.loads):g} "
            f"N, the {window} {display(side, 'µm', 3)}: give more pixels",
        )
        return
    points = len(sweep.plane.loads) * len(sweep.plane.velocities)
    wide = [width for row in facts.contact_widths for width in row if width >= side]
    if wide:
        yield (
            "window.pixels",
            f"the contact is expected to grow up to {display(max(wide), 'µm', 3)} wide, the "
            f"{window} is {display(side, 'µm', 3)}: it carries too little load at its edges at "
            f"about {len(wide)} of {points} points, those of high load and velocity; give more "
            "pixels if these matter",
        )


def doubts_of_row(own: Mapping[str, Any]) -> Iterator[str]:
    """Conditions of a test or an operating point that are probably in another unit, in words."""
    if (own.get("friction") or 0.0) > 1:
        yield f"friction is {own['friction']:g}, where 0 to 1 is usual: is it in per cent?"
    bulk, (coldest, hottest, unit) = own.get("bulk_temperature"), usual_of(BULK)
    if bulk is not None and not coldest <= shown_in(bulk, unit) <= hottest:
        yield (
            f"the bulk temperature is {display(bulk, unit)}, where {coldest:g} {unit} to "
            f"{hottest:g} {unit} are usual: check its unit"
        )


def _test_doubts(sweep: Sweep) -> Iterator[_Doubt]:
    """Tests so far outside the sweep that their units are in doubt."""
    loads, velocities = Span.of(sweep.plane.loads), Span.of(sweep.plane.velocities)
    far = [
        f"{test.normal_load:g} N at {test.velocity:g} m/s"
        for test in [*sweep.about.measured, *sweep.about.tested]
        if not loads.low / _REACH <= test.normal_load <= loads.high * _REACH
        or not velocities.low / _REACH <= test.velocity <= velocities.high * _REACH
    ]
    if far:
        spans = f"{loads.low:g} to {loads.high:g} N and {velocities.low:g} to {velocities.high:g}"
        more = f" and {len(far) - 1} more" if len(far) > 1 else ""
        verb = "lie" if len(far) > 1 else "lies"
        yield (
            "",
            f"the test of {far[0]}{more} {verb} far outside the sweep, {spans} m/s, and cannot be "
            "compared with it: check the units, or widen the sweep",
        )


def _surface_doubts(sweep: Sweep, surface: SurfaceFacts) -> Iterator[_Doubt]:
    for axis, rise in zip("xy", surface.rise, strict=True):
        if surface.measured and abs(rise) > _MOST_RISE * surface.rq:
            yield (
                "disk.roughness.level",
                f"the surface is tilted: its mean plane rises by {display(rise, 'µm', 3)} along "
                f"{axis} over the window, beside an Rq of {display(surface.rq, 'µm', 3)}; take the "
                "plane off with level = true",
            )
    if isinstance(sweep.scene.roughness, SelfAffineRoughness):
        yield from _correlation_doubts(sweep, sweep.scene.roughness)
    if surface.lay is None or surface.lay > _ALONG:
        return
    if sweep.scene.wear and sweep.scene.wear.pattern == "swept":
        yield (
            "wear.pattern",
            'the grooves lie along sliding, and pattern = "swept" assumes that ever new ones pass '
            "the pin; where the same ones persist around the whole track (rings turned or ground "
            'along it), give pattern = "local": there "swept" makes the rise about half too high',
        )
    if surface.measured:
        yield (
            "disk.roughness.transpose",
            "the grooves lie along x, the sliding direction; if they should lie across it, "
            "exchange x and y of the file with transpose = true",
        )


def _correlation_doubts(sweep: Sweep, roughness: SelfAffineRoughness) -> Iterator[_Doubt]:
    """Correlation lengths that the pixels do not resolve, or the window does not hold."""
    sides = zip("xy", roughness.correlation_length, sweep.scene.pixels.shape, strict=True)
    for (axis, length, count), pixel in zip(sides, sweep.scene.pixels.spacing, strict=True):
        place = "disk.roughness.correlation_length"
        said = f"that along {axis}, {display(length, 'µm', 3)}, is"
        if length < FEWEST_PIXELS * pixel * (1 - 1e-9):
            yield (
                place,
                f"{said} {length / pixel:.2g} pixels; below {FEWEST_PIXELS:g} the slopes of the "
                "roughness depend on the pixels: give a smaller window.pixel_size",
            )
        if length > _LONGEST * count * pixel:
            yield (
                place,
                f"{said} {length / (count * pixel):.2g} of the window's side; above a third the "
                "temperature differs much from surface to surface: give more window.pixels, or "
                "several surfaces (sweep.realizations)",
            )
