"""Datasets of answers: units and names of variables, attributes, and the cases of a sweep.

Whatever a command, a figure or a file states is a variable or an attribute of these datasets.
Attributes are text: conditions, errors, tests, notes, and what is not included.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from enum import IntFlag
from typing import Any

import numpy as np
import xarray as xr

from pipeline.answers.case_results import CaseResults
from pipeline.answers.error import PARTS, preset_error_text
from pipeline.answers.evidence import Evidence
from pipeline.answers.field import LineOutcome
from pipeline.answers.remedies import Remedy
from pipeline.answers.results import case_dims, sweep_of
from pipeline.answers.scene_wording import (
    added_rise_words,
    unusual_condition_lines,
    verdict_conditions,
    warning_lines,
)
from pipeline.answers.specimen import specimen_of
from pipeline.answers.value_text import join_texts
from pipeline.answers.verdict_limits import Side, round_to
from pipeline.answers.verdict_model import ORIGINS, VERDICTS, Flag, VerdictModel
from pipeline.condition_kinds import CONDITIONS
from pipeline.messages import pluralized
from pipeline.store.schema import PLANE
from pipeline.sweep.case_table import CASE
from pipeline.sweep.sweep import BODIES, cold_tracks
from tribo import Corrections, Track
from tribo.simulation.corrections import NEEDED

_VARIABLES = {
    "verdict": ("", "verdict on the next specimen at this point"),
    "probability": ("1", "probability of severe wear"),
    "probability_low": ("1", "probability of severe wear; its lower bound by the numerical error"),
    "probability_high": ("1", "probability of severe wear; its upper bound by the numerical error"),
    "log_rise_ratio": ("1", "ln(temperature rise over allowable rise)"),
    "log_rise_ratio_mild": ("1", "log_rise_ratio at which the specimen stayed mild"),
    "log_rise_ratio_severe": ("1", "log_rise_ratio at which the specimen was severe"),
    "governing_temperature": ("K", "contact temperature compared with the critical temperature"),
    "temperature_error": ("K", "numerical error of the governing temperature (95 % bound)"),
    "temperature_margin": ("K", "critical minus governing temperature"),
    "end_temperature": ("K", "governing temperature of the hottest end of the pin alone"),
    **{
        f"temperature_error_{part}": ("K", f"part of the numerical error: {meaning}")
        for part, meaning in PARTS.items()
    },
    "critical_velocity_p50": ("m/s", "critical velocity with tests: severe wear is 50 % probable"),
    "ruled_out_by": ("", "tests that decide mild_velocity or severe_velocity"),
    "velocity_error": ("1", "relative numerical error of the critical velocity (95 % bound)"),
    **{
        f"velocity_error_{part}": ("1", f"part of the relative numerical error: {meaning}")
        for part, meaning in PARTS.items()
    },
    "origin": ("", "origin of the result"),
    "warning_flags": ("", "what limits this answer"),
    "decided_by": ("", "what would decide an undecided verdict"),
    "reason": ("", "why the verdict is withheld or unknown"),
    "outcome": ("", "outcome of the test"),
    "loo_probability": ("1", "probability of this outcome, predicted from the other tests"),
    **{
        name: (condition.kind.si_unit or "1", condition.meaning)
        for name, condition in CONDITIONS.items()
    },
    "spread_another_rig": ("K", "standard deviation on another rig (model bias included)"),
    "spread_this_rig": ("K", "standard deviation on this rig (model bias excluded)"),
    "at_least": ("K", "lower bound, from tests that were only mild"),
    "at_most": ("K", "upper bound, from tests that were only severe"),
    "load": ("N", "normal load on the pin"),
    "velocity": ("m/s", "sliding velocity"),
}
"""Unit and long name of each variable of an answer."""
for _axis, _unit, _name in (
    ("velocity", "m/s", "velocity"), ("load", "N", "load"),
    ("friction", "1", "coefficient of friction"),
):  # fmt: skip
    _VARIABLES |= {
        f"critical_{_axis}": (_unit, f"lowest {_name} at which severe wear is computed"),
        f"mild_{_axis}": (_unit, f"highest {_name} up to which the verdict is mild"),
        f"severe_{_axis}": (_unit, f"lowest {_name} from which the verdict is severe"),
        f"{_axis}_safety_factor": ("1", f"mild limit of {_axis} over operating {_axis}"),
        f"film_parameter_at_{_axis}": ("1", "film parameter on the boundary"),
        f"outcome_along_{_axis}": ("", f"outcome along the line of rising {_axis}"),
    }
_LIMITS = "mild_velocity", "mild_load", "mild_friction", "severe_velocity", "severe_load"
_VARIABLES |= {f"{name}_side": ("", f"where {name} lies") for name in _LIMITS}
_CODES = {
    "verdict": VERDICTS,
    "origin": ORIGINS,
    "outcome_along_velocity": tuple(outcome.name.lower() for outcome in LineOutcome),
    "outcome_along_load": tuple(outcome.name.lower() for outcome in LineOutcome),
    **{f"{name}_side": tuple(side.name.lower() for side in Side) for name in _LIMITS},
}
"""Names of the codes 0, 1, 2 … of a variable."""
_FLAGS: dict[str, type[IntFlag]] = {"warning_flags": Flag, "decided_by": Remedy}
"""Flags of a variable, each a bit."""
SIDES = Side.BELOW, Side.INSIDE, Side.ABOVE
"""Sides of limits of rows that have one, that of the smallest limit first."""
ATTRIBUTES = (
    "conditions", "model_error", "uncertain_inputs", "largest_input", "realizations", "tests",
    "outliers",
    "tests_without_result", "verdicts_withheld", "not_included", "notes",
)  # fmt: skip
"""Attributes of an answer; they are coordinates if cases differ in them."""


def answer_dataset(
    models: Sequence[VerdictModel],
    variables: Mapping[str, Any],
    overrides: Mapping[str, xr.DataArray],
) -> xr.Dataset:
    """Dataset of an answer with units, long names, conditions and attributes.

    There is a model for each oil. `overrides` are conditions in place of the scene's.
    """
    # A condition that varies has its dimension, or a value at each point.
    varied = {
        name: variables.get(name, array) if name not in array.dims else array
        for name, array in overrides.items()
        if array.ndim
    }
    axes = {name: getattr(models[0].conditions, name) for name in CONDITIONS} | {**varied}
    axes |= {name: variables[name] for name in PLANE}
    data = {name: variable for name, variable in variables.items() if name not in axes}
    is_varied = any(len({*array.values.ravel().tolist()}) > 1 for array in varied.values())
    attributes, *further = (answer_attributes(model, is_varied) for model in models)
    for name, text in attributes.items():
        if isinstance(text, str):
            attributes[name] = join_texts((text, *(str(other[name]) for other in further)))
    unusual = unusual_condition_lines(models[0].case.sweep, varied)
    attributes["notes"] = join_texts((*unusual, str(attributes["notes"])))
    answer = with_attributes(xr.Dataset(data, axes)).assign_attrs(attributes)
    for axis, ends in models[0].ranges.items():
        for name in (f"mild_{axis}", f"severe_{axis}"):
            if name in answer:
                answer[name].attrs["valid_range"] = [*ends]
    return answer


def with_attributes(ds: xr.Dataset) -> xr.Dataset:
    """The dataset with unit and long name of each variable, and the names of codes and flags."""
    for variable in ds.variables:
        name = str(variable)
        unit, meaning = _VARIABLES.get(name, ("", ""))
        attributes: dict[str, Any] = {"units": unit} if unit else {}
        attributes |= {"long_name": meaning} if meaning else {}
        if codes := _CODES.get(name):
            attributes["flag_values"] = np.arange(len(codes), dtype=np.int8)
            attributes["flag_meanings"] = " ".join(codes)
        if flags := _FLAGS.get(name):
            attributes["flag_masks"] = np.array([*map(int, flags)], np.int16)
            attributes["flag_meanings"] = " ".join(str(flag.name).lower() for flag in flags)
        ds.variables[name].attrs.update(attributes)
    return ds


def join_cases(
    ds: xr.Dataset, cases: Sequence[CaseResults], answers: Sequence[xr.Dataset]
) -> xr.Dataset:
    """Join the answers for all cases of a sweep along the dimensions of its varied entries.

    Attributes in which the cases differ become coordinates.
    """
    dims, first = case_dims(ds), answers[0].attrs
    common = {k: v for k, v in first.items() if all(v == answer.attrs[k] for answer in answers)}
    parts = [
        answer.assign_coords({k: v for k, v in answer.attrs.items() if k not in common})
        for answer in answers
    ]
    for axis in (ds[dim] for dim in reversed(dims)):
        parts = [part.drop_vars(str(axis.name), errors="ignore") for part in parts]
        parts = [
            xr.concat(
                parts[start : start + axis.size], axis, data_vars="all", coords="different",
                compat="equals", combine_attrs="drop_conflicts",
            )
            for start in range(0, len(parts), axis.size)
        ]  # fmt: skip
    (joined,) = parts
    labels = [
        column.name
        for column in sweep_of(ds).case_table.columns
        if column.along in dims and not column.entry and column.name not in joined.coords
    ]
    names = {name: f"{name} (given)" if name in joined.dims else name for name in labels}
    joined = joined.assign_coords({names[name]: ds[name].variable for name in labels})
    joined.attrs = common | {"missing_points": sum(case.missing for case in cases)}
    return joined


def answer_attributes(model: VerdictModel, is_varied: bool = False) -> dict[str, str | int]:
    """Attributes of an answer, as text: its conditions (unless varied), errors, tests and notes."""
    evidence = model.evidence
    conditions = verdict_conditions(model.conditions, evidence.critical is not None)
    return {
        "conditions": "given for each point" if is_varied else conditions,
        "model_error": model_error(evidence),
        "uncertain_inputs": uncertain_inputs(evidence),
        "largest_input": evidence.inputs.largest[0] if evidence.inputs else "",
        "realizations": len(model.specimen.differences),
        "tests": len(evidence.specimens),
        "outliers": join_texts(evidence.outliers),
        "tests_without_result": evidence.waiting_text,
        "verdicts_withheld": join_texts(evidence.withheld.values()),
        "not_included": ", ".join(_effects_left_out(model, is_varied)),
        "notes": join_texts(_notes(model)),
    }


def model_error(evidence: Evidence) -> str:
    """Range of the model error relative to the rise, and the number of tests."""
    ends = (100 * math.expm1(-evidence.posterior.level(p)) for p in (0.95, 0.05))
    low, high = (f"{x:+.0f}" if abs(x) >= 10 else f"{x:+.2g}" for x in ends)
    count = len(evidence.specimens)
    source = f"{pluralized(count, 'test', 'tests')} and the prior" if count else "the prior"
    text = f"{low} to {high} % of the temperature rise (90 % range, from {source})"
    return text.replace("-", "−")


def uncertain_inputs(evidence: Evidence) -> str:
    """Standard deviation of the rise by uncertain inputs, before tests; empty without any."""
    if evidence.inputs is None:
        return ""
    name, part = evidence.inputs.largest
    text = (
        f"± {100 * evidence.inputs.deviation:.2g} % of the rise (one standard deviation), most by "
        f"{name} (± {100 * part:.2g} %)"
    )
    is_narrowed = any(not rows[0].test.has_own_inputs for rows in evidence.specimens)
    return f"{text}; narrowed by the tests, as they have the same inputs" if is_narrowed else text


def _effects_left_out(model: VerdictModel, is_varied: bool) -> Iterator[str]:
    """Yield the effects that are not included and may be unsafe."""
    if model.case.sweep.scene.pixels.periodic[1]:
        yield "pin ends"
    tracks = cold_tracks(model.case.sweep)
    known = {name: track for name, track in tracks.items() if track}
    if known:
        bodies = " and the ".join(BODIES[name] for name in known)
        severe = "" if is_varied else _severe_with_earlier_revolutions(model, known)
        yield f"heat from earlier revolutions of the {bodies}{severe}"
    for name in sorted(tracks.keys() - known.keys()):
        body = BODIES[name]
        yield (
            f"heat from earlier revolutions of the {body} (unknown; set motion.{body}_track_length)"
        )
    if model.lacks_film:
        yield "an oil film that carries load (unknown here)"
    if model.case.sweep.base.uncertainty and model.evidence.inputs is None:
        yield "uncertain inputs, whose points are not simulated (irg run SCENE)"
    elif model.evidence.inputs is None:
        yield "uncertain inputs"
    if not model.evidence.specimens:
        bias = 100 * model.evidence.prior.bias
        yield f"errors beyond the assumed model bias of {bias:.3g} %, which no test confirms"


def _severe_with_earlier_revolutions(model: VerdictModel, tracks: Mapping[str, Track]) -> str:
    """Where wear is severe with heat of earlier revolutions, in parentheses; empty if nowhere.

    Keys of `tracks` are those of `Corrections`.
    """
    case = model.case
    if not {*NEEDED} <= {*case.ds}:
        return ""
    corrections = model.conditions.corrections or Corrections()
    corrections = replace(corrections, motion=case.sweep.scene.motion, **dict[str, Any](tracks))
    field = specimen_of(case, replace(model.conditions, corrections=corrections)).field
    lines = field.along_velocity(field.loads, np.full(field.loads.shape, model.limit))
    if case.is_row:  # at its own load and velocity
        is_own = field.loads == (case.own_load or field.loads[0])
        return " (severe with it)" if lines.is_severe[is_own].any() else ""
    load = field.loads[-1]
    if lines.is_severe[-1]:
        return f" (severe at all simulated velocities at {load:g} N)"
    if math.isfinite(lines.critical[-1]):
        return f" (severe from {lines.critical[-1]:.2g} m/s at {load:g} N)"
    return ""


def _notes(model: VerdictModel) -> Iterator[str]:
    """Limits of all answers of a case, in addition to the effects that are not included."""
    sweep = model.case.sweep
    unknown = preset_error_text(sweep) if model.preset_error is None else ""
    conditions = {name: getattr(model.conditions, name) for name in CONDITIONS}
    yield from unusual_condition_lines(sweep, conditions)
    warnings = warning_lines(sweep, answered=True)
    yield from (model.omitted_tests, sweep.note or "", *warnings)
    yield from (added_rise_words(model.conditions), unknown)
    if model.case.is_changed and model.evidence.specimens:
        yield (
            "the rises of the dataset were changed, but not those of the tests, which are a group "
            "of their own; without_tests=True leaves the tests out"
        )


# Mild load factors of rows, which are simulated at several shares of their load


def with_mild_load_factor(answer: xr.Dataset, case: CaseResults) -> xr.Dataset:
    """Margins of a row with its mild load factor; unchanged without load factors."""
    if case.own_load is None:
        return answer
    mild_load, side = answer["mild_load"], answer["mild_load_side"]
    factor = mild_load.copy(data=round_to(np.floor, mild_load.values / case.own_load))
    ends = [case.load_factors[0], case.load_factors[-1]]
    meaning = "largest share of the load of the row at which it is mild"
    factor.attrs = {"units": "1", "long_name": meaning, "valid_range": ends}
    side = side.assign_attrs(long_name="where mild_load_factor lies")
    return answer.assign(mild_load_factor=factor, mild_load_factor_side=side)


def with_governing_row(answer: xr.Dataset) -> xr.Dataset:
    """Margins of rows; ``governs`` is true at the row with the smallest mild load factor.

    Of several rows outside the simulated load factors it is that with the largest rise ratio.
    """
    if "mild_load_factor" not in answer or CASE not in answer.sizes:
        return answer
    names = "log_rise_ratio", "mild_load_factor", "mild_load_factor_side"
    ratio, factor, side = (answer[name].transpose(..., CASE) for name in names)
    rank = np.select([side == code for code in SIDES], range(len(SIDES)), len(SIDES))
    order = np.lexsort((-ratio.values, np.nan_to_num(factor.values), rank))
    is_first = np.arange(rank.shape[-1]) == order[..., :1]
    governs = factor.copy(data=is_first & (rank < len(SIDES)))
    governs.attrs = {"long_name": "the row has the smallest mild load factor of all rows"}
    return answer.assign(governs=governs.transpose(*answer["mild_load_factor"].dims))
