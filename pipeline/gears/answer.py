"""What the command ``irg gears`` answers: as a document, in words and tables, as a figure."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.analysis.tables import frame_of, short, writable_path, write_text
from pipeline.cli import output
from pipeline.cli.output import Result, counted
from pipeline.gears.contact import Mesh, mesh
from pipeline.gears.fzg import (
    Critical,
    Prediction,
    critical_temperature,
    integral_limit,
    predict_stages,
)
from pipeline.gears.model import Simulated
from pipeline.gears.pair import Pair, read_pair
from pipeline.gears.rules import STAGES, integral_temperature
from pipeline.gears.scene import scene_toml
from pipeline.gears.spectrum import Spectrum, judge_spectrum
from pipeline.scene.units import display
from tribo import InputError, lubrication_regime

LIMITS = (
    "Not validated: no scuffing test of gears was held against this. The simulated contact is in "
    "boundary lubrication, while gears run mixed; what a film carries is not counted, nor tip "
    "relief. Pressure, flash and film are of smooth flanks, in closed form."
)
_DRAWN = 400  # places of the figure, so that the load steps where it steps
_WIDE = ("reduced radius [mm]", "load per length [N/mm]", "half-width [µm]")
"""Columns for which a terminal is too narrow."""


def gears(options: argparse.Namespace) -> Result:
    """Print the contact along a mesh; write its scene; simulate FZG's test, or a spectrum."""
    pair = read_pair(options.pair, _settings(options))
    if options.critical_temperature is not None:
        pair = pair.changed(critical=options.critical_temperature)
    _check(options, pair)
    one = mesh(pair, options.places)
    table = frame_of(_HEADS, map(_row_of, one.places))
    facts = frame_of(("subject", "value"), [*_facts(one)])
    document: dict[str, Any] = {"title": pair.title, "limits": LIMITS, **_document(one)}
    text: list[str | pd.DataFrame] = [pair.title, LIMITS]
    frames, figure = [table], partial(_draw, mesh(pair, _DRAWN))
    if not (options.failure_stage or options.stages or options.points):
        text += ["", facts, "", short(table, _WIDE)]
    critical = _critical(options, pair)
    if critical is not None and options.failure_stage:
        document["critical_temperature"] = asdict(critical)
        text += ["", *_on_critical(critical)]
    if options.stages:
        assert critical is not None  # by _check
        predicted = _with_progress(options, predict_stages, pair, critical)
        frames = [_stage_frame(predicted)]
        document["stages"] = _stage_document(predicted)
        text += ["", *_on_stages(predicted, critical), "", frames[0]]
    if options.points:
        assert critical is not None  # by _check
        judged = _with_progress(
            options, judge_spectrum, pair, options.points, critical, sheet=options.sheet
        )
        frames = [_spectrum_frame(judged)]
        document["spectrum"] = _spectrum_document(judged)
        text += ["", judged.sentence, "", frames[0], *_unused(judged)]
    if options.scene:
        document["scene"] = str(_write_scene(options, one))
        text += ["", f"{options.scene} is written; compute its margins with:",
                 f"  irg run {options.scene} -o {options.scene.with_suffix('.zarr').name}",
                 f"  irg margin {options.scene.with_suffix('.zarr').name}"]  # fmt: skip
    is_drawn = options.output and options.output.suffix.lower() not in (".csv", ".md")
    return Result(document, text, frames=frames, draw=figure if is_drawn else None)


def _settings(options: argparse.Namespace) -> dict[str, Any]:
    """Entries of --set, each once."""
    settings: dict[str, Any] = {}
    for key, value in options.set:
        if key in settings:
            raise InputError(f"--set: {key} is given more than once; give it once")
        settings[key] = value
    return settings


def _check(options: argparse.Namespace, pair: Pair) -> None:
    """Refuse options that do not go together, before anything is simulated."""
    if options.stages and options.points:
        raise InputError("--stages and --points are two questions; ask one at a time")
    if options.sheet and not options.points:
        raise InputError("--sheet is one of a workbook of --points; give that too, or leave it out")
    if options.failure_stage and options.critical_temperature is not None:
        raise InputError(
            "--failure-stage finds the critical temperature, which --critical-temperature gives; "
            "give one of them"
        )
    needs = "--stages" if options.stages else "--points" if options.points else ""
    if needs and not options.failure_stage and pair.critical is None:
        raise InputError(
            f"{needs} needs a critical temperature; give --failure-stage or "
            "--critical-temperature, or temperature.critical in the file"
        )
    if options.scene:
        writable_path(options.scene, (".toml",))


def _critical(options: argparse.Namespace, pair: Pair) -> Critical | None:
    """Critical temperature by the failure load stage, or as it is given; None if neither is."""
    if not options.failure_stage:
        return None if pair.critical is None else Critical(pair.critical, 0.0)
    found: Critical = _with_progress(options, critical_temperature, pair, options.failure_stage)
    return found


def _with_progress(options: argparse.Namespace, simulated: Any, *given: Any, **named: Any) -> Any:
    """What a simulation finds, with the line that shows how far it is."""
    with output.run_line() as progress:
        chosen = {"preset": options.preset, "workers": options.workers, "progress": progress}
        return simulated(*given, **chosen, **named)


def _draw(one: Mesh) -> Any:
    """The figure, with Matplotlib, which takes its time."""
    from pipeline.gears.figure import draw_mesh

    return draw_mesh(one)


def _write_scene(options: argparse.Namespace, one: Mesh) -> Path:
    note = f"Written by irg gears {options.pair}."
    return write_text(scene_toml([one], note), options.scene)


_HEADS = (
    "place", "position [mm]", "radius 1 [mm]", "radius 2 [mm]", "reduced radius [mm]",
    "rolling 1 [m/s]", "rolling 2 [m/s]", "sliding [m/s]", "share", "load [N]",
    "half-width [µm]", "pressure [GPa]", "flash [K]", "temperature [°C]", "film [µm]", "Λ",
)  # fmt: skip


def _row_of(place: Any) -> tuple[Any, ...]:
    return (
        place.letter, place.position, place.radius_1, place.radius_2, place.reduced_radius,
        place.rolling_1, place.rolling_2, place.sliding, place.share, place.load,
        place.half_width, place.pressure, place.flash, place.temperature, place.film,
        place.film_parameter,
    )  # fmt: skip


def _alone(one: Mesh) -> float:
    """Pressure at the pitch point if one pair carries all, as tables of the test give it [Pa]."""
    pitch = next(place for place in one.places if place.position == 0)
    return pitch.pressure / math.sqrt(pitch.share)


def _facts(one: Mesh) -> Iterator[tuple[str, str]]:
    """What holds for the whole mesh, a row for each subject."""
    pair, gears = one.pair, one.pair.gears
    yield (
        "contact ratio",
        f"{gears.contact_ratio:.4g}"
        + (f", overlap {gears.overlap_ratio:.3g}" if gears.overlap_ratio else ""),
    )
    angle = math.degrees(gears.working_angle)
    yield (
        "mesh",
        f"working pressure angle {angle:.5g}°, centre distance "
        + display(gears.centre_distance, "mm"),
    )
    velocity = one.duty.speed * gears.base_radii[0] / math.cos(gears.working_angle)
    yield "pitch line", f"{velocity:.4g} m/s, {1e-9 * _alone(one):.4g} GPa if one pair carries all"
    yield "load", f"{one.normal_load:.6g} N normal to the flanks; {_sharing(one)}"
    source = "as given" if pair.friction is not None else "mean, by ISO/TR 13989-2, Eq. 1"
    yield "friction", f"{one.friction:.3g}, {source}"
    hot = one.hottest
    yield (
        "hottest",
        (
            f"{hot.temperature - 273.15:.0f} °C at {1e3 * hot.position:.3g} mm, by Blok's flash "
            f"temperature of {hot.flash:.0f} K"
        ),
    )
    parameters = [place.film_parameter for place in one.places if place.film_parameter is not None]
    if parameters:
        low, high = min(parameters), max(parameters)
        regimes = dict.fromkeys(map(lubrication_regime, (low, high)))
        yield "film", f"Λ {low:.2g} to {high:.2g}: {' to '.join(regimes)}"
    if pair.oil is not None:
        rule = integral_temperature(pair, one.duty)
        yield (
            "integral",
            (f"{rule.integral - 273.15:.0f} °C, by the rule of ISO/TR 13989-2 for this bulk"),
        )
    taken: dict[tuple[str, str], list[str]] = {}
    for key, value, source in pair.sources:
        table, _, name = key.rpartition(".")
        taken.setdefault((table, source), []).append(f"{name.replace('_', ' ')} {value}")
    for (table, source), values in taken.items():
        yield "library", f"{table}: {', '.join(values)}; from {source}"


def _sharing(one: Mesh) -> str:
    """The rule by which pairs of teeth share the load, in words."""
    gears = one.pair.gears
    if gears.overlap_ratio:
        return "helical: shared as lines of contact are long, 1/εα from an overlap of 1 on"
    if gears.contact_ratio >= 2:
        return "shared equally by the pairs in mesh"
    return "all on one pair from B to D, beyond from a third at A and E to two thirds, AGMA 925-A03"


def _document(one: Mesh) -> dict[str, Any]:
    """The mesh as plain data in SI."""
    pair, gears = one.pair, one.pair.gears
    rule = integral_temperature(pair, one.duty) if pair.oil is not None else None
    return {
        "contact_ratio": gears.contact_ratio,
        "overlap_ratio": gears.overlap_ratio,
        "working_pressure_angle": gears.working_angle,
        "centre_distance": gears.centre_distance,
        "base_pitch": gears.base_pitch,
        "normal_load": one.normal_load,
        "load_sharing": _sharing(one),
        "friction": one.friction,
        "pitch_pressure_of_one_pair": _alone(one),
        "integral": None if rule is None else asdict(rule),
        "library": [source._asdict() for source in pair.sources],
        "places": [asdict(place) for place in one.places],
    }


def _on_critical(critical: Critical) -> Iterator[str]:
    """The critical temperature in words, beside the rule of the standard."""
    assert critical.passed is not None  # as of a failure load stage
    assert critical.failed is not None
    yield (
        f"critical temperature: {critical.value - 273.15:.0f} ± {critical.doubt:.0f} °C by this "
        f"model, of an oil that fails in load stage {critical.stage} of FZG A/8.3/90"
    )
    yield (
        f"the hottest place was at {critical.passed - 273.15:.0f} °C in the stage before, and at "
        f"{critical.failed - 273.15:.0f} °C in that stage"
    )
    if critical.integral is not None:
        yield (
            f"scuffing integral temperature: {critical.integral - 273.15:.0f} °C by the rule of "
            "ISO/TR 13989-2, Eq. 94; a mean along the path of contact, not to be mixed with it"
        )


def _on_stages(predicted: Prediction, critical: Critical) -> Iterator[str]:
    """The stage that fails in words, with what the doubt moves it by."""
    limit = f"a critical temperature of {critical.value - 273.15:.0f} °C"
    if predicted.fails is None:
        yield f"passes all {len(STAGES)} stages, by {limit}"
    else:
        yield f"fails in load stage {predicted.fails}, by {limit}"
    if critical.doubt and predicted.soonest != predicted.latest:
        ends = (
            str(one or f"beyond {len(STAGES)}") for one in (predicted.soonest, predicted.latest)
        )
        yield f"by its doubt of {critical.doubt:.0f} K in stage {' to '.join(ends)}"


def _stage_frame(predicted: Prediction) -> pd.DataFrame:
    heads = (
        "stage", "torque [N m]", "bulk [°C]", "hottest place [mm]",
        "decisive temperature [°C]", "temperature error [K]", "integral temperature [°C]",
    )  # fmt: skip
    return frame_of(
        heads,
        (
            (number, *_simulated(one), _integral(one))
            for number, one in enumerate(predicted.stages, 1)
        ),
    )


def _simulated(one: Simulated) -> tuple[float, ...]:
    duty = one.mesh.duty
    return duty.torque, duty.bulk, one.place.position, one.temperature, one.error


def _integral(one: Simulated) -> float | None:
    pair = one.mesh.pair
    return integral_temperature(pair, one.mesh.duty).integral if pair.oil is not None else None


def _stage_document(predicted: Prediction) -> dict[str, Any]:
    pair = predicted.stages[0].mesh.pair
    return {
        "fails": predicted.fails,
        "soonest": predicted.soonest,
        "latest": predicted.latest,
        "stages": [
            {
                "stage": number,
                "torque": one.mesh.duty.torque,
                "bulk": one.mesh.duty.bulk,
                "position": one.place.position,
                "temperature": one.temperature,
                "temperature_error": one.error,
                "integral": _integral(one),
                "integral_limit": integral_limit(pair, number),
            }
            for number, one in enumerate(predicted.stages, 1)
        ],
    }


def _spectrum_frame(judged: Spectrum) -> pd.DataFrame:
    heads = (
        "row", "torque [N m]", "speed [rpm]", "hours", "bulk [°C]", "hottest place [mm]",
        "verdict", "decisive temperature [°C]", "distance [K]", "error [K]",
    )  # fmt: skip
    rows = []
    for row in judged.rows:
        one = row.simulated
        duty, rpm = one.mesh.duty, one.mesh.duty.speed * 30 / math.pi
        rows.append((row.number, duty.torque, rpm, row.hours, duty.bulk, one.place.position,
                     row.verdict, one.temperature, row.distance, row.error))  # fmt: skip
    return short(frame_of(heads, rows))


def _spectrum_document(judged: Spectrum) -> dict[str, Any]:
    return {
        "verdict": judged.verdict,
        "binding_row": judged.binding.number,
        "sentence": judged.sentence,
        "columns_not_used": [*judged.unused],
        "rows": [
            {
                "row": row.number,
                "hours": row.hours,
                "torque": row.simulated.mesh.duty.torque,
                "speed": row.simulated.mesh.duty.speed,
                "bulk": row.simulated.mesh.duty.bulk,
                "position": row.simulated.place.position,
                "temperature": row.simulated.temperature,
                "distance": row.distance,
                "error": row.error,
                "verdict": row.verdict,
            }
            for row in judged.rows
        ],
    }


def _unused(judged: Spectrum) -> Iterator[str]:
    """The verdict on the whole, and columns that no answer depends on."""
    yield (
        f"verdict on {counted(len(judged.rows), 'row', 'rows')}: {judged.verdict}; hours are "
        "counted, and wear over them is not"
    )
    if judged.unused:
        yield f"columns not used: {', '.join(judged.unused)}"
