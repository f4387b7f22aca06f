"""The command that simulates one point."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from typing import Any

import pipeline
from pipeline.analysis.laboratory import point_error
from pipeline.analysis.margin import (
    NOT_DECIDED,
    percent,
    probabilities_alone,
    verdict_between,
    what_decides,
)
from pipeline.analysis.rise_error import RiseError, add_counted, error_of_point
from pipeline.analysis.tables import frame_of, upright
from pipeline.cli.given import one_scene_in
from pipeline.cli.output import Result, working
from pipeline.quantities import column_heads
from pipeline.scene.facts import require_bearable_load
from pipeline.sweep.about import severe_words
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.caveats import caveats, joined
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.physics import note_on_turns
from pipeline.sweep.plan import PointResult
from pipeline.sweep.remarks import remarks
from pipeline.sweep.severity import MELTS, MOLTEN, rise_limits
from tribo import measures


def point(options: argparse.Namespace) -> Result:
    """Simulate one point."""
    place = Point(options.load, options.velocity)
    sweep = one_scene_in(options, points=[place])
    require_bearable_load(sweep, options.load, "--load")
    sweep = sweep.take_surface(options.realization)
    with working("simulating") as progress:
        result = pipeline.run_point(
            sweep.changed("sweep.steps", "end"), options.load, options.velocity, progress=progress
        )
    conditions, verdict = sweep.conditions, result.verdict(sweep.conditions)
    decisive, critical = verdict.decisive_temperature, conditions.critical_temperature
    scale = conditions.temperature_error(decisive)
    flags = sum({int(warning.kind) for warning in result.warnings})
    promised = velocity_error(sweep)
    alone = error_of_point(flags, result.state.time, promised)
    is_solved = not math.isnan(result.coupled.rise)
    rise = float(conditions.limit(decisive)) if conditions.rise_factor else 0.0
    relative = add_counted(alone, conditions, rise, is_solved)
    error = relative.times(scale)
    judged, decided_by = None, None
    distance = None if critical is None else critical - decisive
    model, chances = None, None
    if distance is not None:
        model = point_error(sweep, place, rise)
        here = abs(options.velocity)
        chances = probabilities_alone(
            rise, rise_limits(conditions).tolist(), model, relative,
            lambda ratio: conditions.friction_factor(here * ratio),
        )  # fmt: skip
        judged = verdict_between(chances[0], chances[2])
        if verdict.friction == "ignites" and verdict.is_severe:
            judged = "severe"
        if judged == NOT_DECIDED:
            by_model = verdict_between(chances[1], chances[1]) == NOT_DECIDED
            decided_by = what_decides(error, by_model)
    document = measures(sweep.scene, result.state) | {
        "velocity": options.velocity,
        "friction": conditions.friction,
        "max_temperature": verdict.max_temperature,
        "decisive_temperature": decisive,
        "failed_fraction": verdict.failed_fraction,
        "failed_fraction_time": verdict.time,
        "verdict": judged,
        "temperature_error": error.total,
        "probability": chances and chances[1],
        "probability_bound": chances and ("at least" if chances[1] > 0.5 else "at most"),
        "model_error": model and model.worded,
        "warnings": [{"kind": kind.label, "text": text} for kind, text in result.warnings],
        "molten": decisive > MELTS,
        "not_counted": note_on_turns(sweep),
        "wall_time": result.wall_time,
        "decided_by": decided_by,
    }
    notes = caveats(sweep, conditions)
    values = document | {"load": options.load, "distance": distance, "caveats": joined(notes)}
    frame = frame_of([*_COLUMNS.values()], [[values[name] for name in _COLUMNS]])
    text = [*_point_lines(sweep, result, document, error), "", upright(frame.drop(columns="notes"))]
    text += [f"would decide it: {decided_by}"] if decided_by else []
    text += ["", *notes]
    return Result(document | {"caveats": notes}, text, frames=[frame])


_COLUMNS = {
    **column_heads("load", "velocity", "friction", "verdict", "decisive_temperature"),
    **column_heads("temperature_error", "distance"),
    "max_temperature": "highest temperature [°C]", "failed_fraction_time": "hottest at [s]",
    "failed_fraction": "failed share [%]", "pin_heat_share": "pin's heat share [%]",
    "contact_width": "contact width [µm]", "contact_fraction": "contact area [%]",
    "mean_pressure": "mean pressure [GPa]", "max_pressure": "highest pressure [GPa]",
    "wear_depth_max": "wear depth [µm]", "wear_volume": "wear volume [mm³]", "time": "time [s]",
    "sliding_distance": "sliding distance [m]", "wall_time": "computed in [s]", "caveats": "notes",
}  # fmt: skip
"""Heads of the table of a point, by names in its document."""


def _point_lines(
    sweep: Sweep, result: PointResult, document: Mapping[str, Any], error: RiseError
) -> Iterator[str]:
    """Sentences on a point: its verdict, what that rests on, and notes."""
    load, velocity = result.point[:2]
    conditions, decisive, judged = sweep.conditions, sweep.conditions.decisive, document["verdict"]
    wear = judged if judged == NOT_DECIDED else f"{judged} wear"
    if judged is None:
        wear = "mild or severe is not known without temperature.critical"
    yield (
        f"{load:g} N at {velocity:g} m/s after {document['time']:.3g} s "
        f"and {document['sliding_distance']:.3g} m: {wear}"
    )
    severe = ""
    if conditions.critical_temperature is not None:
        severe = f"wear is severe with {severe_words(conditions)}; "
    yield f"{severe}the decisive temperature is {decisive.temperature}, its error {error.worded}"
    if (chance := document["probability"]) is not None:
        law = ", with friction by velocity" if conditions.has_friction_curve else ""
        bound = "" if law else f" {document['probability_bound']}"
        yield (
            f"the next run is severe with {percent(chance)} probability{bound}, if the rise "
            f"grows as the velocity{law}; the model's own error: {document['model_error']}"
        )
    block = sweep.scene.pixels.shape[0] // len(result.state.pressure)
    if block > 1 and sweep.scene.roughness is not None:
        yield from remarks(
            "note",
            f"area and pressure depend on the elements, here {block} × {block} pixels; on larger "
            "ones more of the surface touches, at lower pressure",
        )
    if velocity < 0:
        yield from remarks("note", "the velocity is negative, so the disk slides towards −x")
    yield from map(str, sweep.about.notes)
    warnings = [text for _, text in result.warnings]
    yield from remarks("warning", *warnings, MOLTEN * document["molten"], document["not_counted"])
