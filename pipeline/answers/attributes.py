"""Attributes of an answer, as text: conditions, errors, tests, notes, and what is not included."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.answers.discretization_error import error_in_words
from pipeline.answers.evidence import Evidence, waiting_text
from pipeline.answers.scene_wording import (
    added_rise_words,
    model_words,
    verdict_conditions,
    warning_lines,
)
from pipeline.answers.specimen import specimen_of
from pipeline.answers.verdict_model import VerdictModel
from pipeline.constants import SHARP_ENDS
from pipeline.messages import join_notes
from pipeline.sweep.sweep import cold_tracks, has_sharp_ends
from tribo import Corrections, Fidelity, Scene, Track
from tribo.simulation.corrections import NEEDED

ATTRIBUTES = (
    "conditions", "model_error", "realizations", "tests", "outliers", "tests_without_result",
    "verdicts_withheld", "not_included", "notes",
)  # fmt: skip
"""Attributes of an answer; they are coordinates if cases differ in them."""
POINT_CONDITIONS = "given for each point"
SHARP_PERCENTS = tuple(round(100 * share) for share in SHARP_ENDS)
_SHARP_ENDS = "sharp pin ends (severe wear at {} to {} % lower velocity)"
_OTHER_MODEL = (
    "warning: the critical temperature is from tests on another kind of surface, wear pattern or "
    "preset than {}; tests of two rigs gave 5 to 7 K more on a random surface than on a measured "
    "one, and 18 to 30 K more with wear pattern swept than with local"
)
_REVOLUTIONS = {
    "pin_track": {
        "known": "heat from earlier revolutions of the pin",
        "severe": "heat from earlier revolutions of the pin (severe {})",
        "unknown": (
            "heat from earlier revolutions of the pin (unknown; set motion.pin_track_length)"
        ),
    },
    "track": {
        "known": "heat from earlier revolutions of the disk",
        "severe": "heat from earlier revolutions of the disk (severe {})",
        "unknown": (
            "heat from earlier revolutions of the disk (unknown; set motion.disk_track_length)"
        ),
    },
    "both": {
        "known": "heat from earlier revolutions of the pin and the disk",
        "severe": "heat from earlier revolutions of the pin and the disk (severe {})",
    },
}
"""Texts on heat of earlier revolutions, by the track that is left out, or both."""
_MODEL_ERRORS = (
    "{} to {} % of the temperature rise (90 % range, from the prior)",
    "{} to {} % of the temperature rise (90 % range, from 1 test and the prior)",
    "{} to {} % of the temperature rise (90 % range, from {} tests and the prior)",
)
"""Range of the model error without tests, with one, and with several."""


def answer_attributes(model: VerdictModel) -> dict[str, str | int]:
    """Attributes of an answer, as text: its conditions, errors, tests and notes."""
    evidence, tests = model.evidence, model.case.sweep.tests
    from_tests = evidence.critical is not None
    return {
        "conditions": verdict_conditions(model.conditions, tests, from_tests),
        "model_error": model_error(evidence),
        "realizations": len(model.specimen.differences),
        "tests": len(evidence.specimens),
        "outliers": join_notes(evidence.outliers),
        "tests_without_result": waiting_text(evidence),
        "verdicts_withheld": join_notes(filter(None, model.rulings.withheld.values())),
        "not_included": ", ".join(_effects_left_out(model)),
        "notes": join_notes(_notes(model)),
    }


def model_error(evidence: Evidence) -> str:
    """Range of the model error relative to the rise, and the number of tests."""
    ends = (100 * math.expm1(-evidence.posterior.level(p)) for p in (0.95, 0.05))
    signed = [f"{x:+.0f}" if abs(x) >= 10 else f"{x:+.2g}" for x in ends]
    count = len(evidence.specimens)
    return _MODEL_ERRORS[min(count, 2)].format(*signed, count).replace("-", "−")


def _effects_left_out(model: VerdictModel) -> Iterator[str]:
    """Yield the effects that are not included and may be unsafe."""
    if has_sharp_ends(model.case.sweep):
        yield _SHARP_ENDS.format(*SHARP_PERCENTS)
    yield from _earlier_revolutions(model)
    if model.lacks_film:
        yield "an oil film that carries load (unknown here)"
    yield "uncertain inputs"
    if not model.evidence.specimens:
        bias = 100 * model.evidence.prior.bias
        yield f"a model bias beyond the assumed {bias:.3g} %, as no test confirms it"


def _earlier_revolutions(model: VerdictModel) -> Iterator[str]:
    """Heat from earlier revolutions, as text: of bodies with a known track, and of the others."""
    tracks = cold_tracks(model.case.sweep)
    known = {name: track for name, track in tracks.items() if track}
    if known:
        texts = _REVOLUTIONS["both" if len(known) == 2 else min(known)]
        velocities = _severe_with_earlier_revolutions(model, known)
        yield texts["severe"].format(velocities) if velocities else texts["known"]
    for name in tracks.keys() - known.keys():
        yield _REVOLUTIONS[name]["unknown"]


def _severe_with_earlier_revolutions(model: VerdictModel, tracks: Mapping[str, Track]) -> str:
    """Velocities at which wear is severe with heat of earlier revolutions; empty if unknown.

    Keys of `tracks` are those of `Corrections`.
    """
    case = model.case
    if not {*NEEDED} <= {*case.ds}:
        return ""
    corrections = model.conditions.corrections or Corrections()
    corrections = replace(corrections, motion=case.sweep.scene.motion, **dict[str, Any](tracks))
    conditions = replace(model.conditions, corrections=corrections)
    field = specimen_of(case, conditions).field
    lines = field.along_velocity(field.loads, np.full(field.loads.shape, model.limit))
    if case.status.size == 1:  # a row with its own load and velocity
        return "with it" if lines.is_severe[0] else ""
    texts = []
    for k in (0, -1):
        if lines.is_severe[k]:
            texts.append(f"at all simulated velocities at {field.loads[k]:g} N")
        elif math.isfinite(lines.critical[k]):
            texts.append(f"from {lines.critical[k]:.2g} m/s at {field.loads[k]:g} N")
    return ", ".join(texts)


def _notes(model: VerdictModel) -> Iterator[str]:
    """Limits of all answers of a case, in addition to the effects that are not included."""
    sweep = model.case.sweep
    unknown = error_in_words(sweep) if model.promised is None else ""
    if model.evidence.critical is not None and _has_tests_of_other_models(model):
        yield _OTHER_MODEL.format(model_words(sweep))
    lines = sweep.note, *warning_lines(sweep, answered=True), added_rise_words(model.conditions)
    yield from filter(None, (*lines, unknown))


def _has_tests_of_other_models(model: VerdictModel) -> bool:
    """True if a test has another kind of surface, wear pattern or settings than the case."""

    def kind(scene: Scene) -> tuple[type, str, Fidelity]:
        pattern = scene.wear.pattern if scene.wear else ""
        return type(scene.roughness), pattern, scene.fidelity

    sweep = model.case.sweep
    return any(kind(test.case.scene) != kind(sweep.scene) for test in sweep.tests)
