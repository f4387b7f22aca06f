"""The command ``irg gears``: sentences and tables, also as a JSON document."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import astuple, replace
from typing import Any

import pandas as pd

import pipeline.gears
from pipeline.analysis.tables import frame_of, records, short, transposed, writable_path, write_text
from pipeline.cli import output
from pipeline.cli.given import settings_in
from pipeline.cli.output import Result, wrapped
from pipeline.gears.contact import Mesh, mesh
from pipeline.gears.doubts import doubts
from pipeline.gears.fzg import critical_temperature, first_failure, predict_stages, stage_duty
from pipeline.gears.pair import Pair
from pipeline.gears.reading import read_pair
from pipeline.gears.scene import scene_toml
from pipeline.gears.spectrum import conclusion, judge_spectrum
from pipeline.quantities import si_of
from pipeline.sweep.remarks import join_notes, split_notes
from pipeline.sweep.sources import library_tables
from tribo import InputError

_PLACES = (
    "place", "position [mm]", "radius 1 [mm]", "radius 2 [mm]", "reduced radius [mm]",
    "rolling 1 [m/s]", "rolling 2 [m/s]", "sliding [m/s]", "share", "load [N]",
    "load per length [N/m]", "half-width [µm]", "pressure [GPa]", "flash [K]", "temperature [°C]",
    "film [µm]", "Λ",
)  # fmt: skip
"""Column headings for the fields of `MeshPlace`."""
_DRAWN = 400  # places in the figure, so that steps of the load are steep
_WIDE = (
    "radius 1 [mm]", "radius 2 [mm]", "reduced radius [mm]", "rolling 1 [m/s]", "rolling 2 [m/s]",
    "load per length [N/m]", "half-width [µm]", "load [N]", "velocity [m/s]", "sentence", "notes",
    "temperature error [K]", "integral temperature [°C]",
)  # fmt: skip
"""Columns left out of the printed table, which would be too wide with them."""


def gears(options: argparse.Namespace) -> Result:
    """Answer ``irg gears``: contact along a gear mesh, its scene, FZG's test or a duty spectrum."""
    pair = read_pair(options.pair, settings_in(options))
    if options.critical_temperature is not None:
        pair = pair.with_critical(options.critical_temperature, pair.file.temperature.critical_sd)
    _check(options, pair)
    if options.stage:
        pair = replace(pair, duty=stage_duty(pair, options.stage))
    found = list[pd.DataFrame]()
    if options.failure_stage:
        found.append(_simulate(options, critical_temperature, pair, options.failure_stage))
        value, sd, *_ = found[0].iloc[0]
        pair = pair.with_critical(si_of(value, "°C"), sd)
    found_mesh, sentences = mesh(pair), list[str]()
    if options.stages:
        table = _simulate(options, predict_stages, pair)
        sentences = [first_failure(table)]
    elif options.points:
        table = _simulate(options, judge_spectrum, pair, options.points, options.sheet)
        sentences = [conclusion(table), *table.attrs["remarks"]]
    else:
        table = frame_of(_PLACES, map(astuple, found_mesh.places))
        found.append(_facts(found_mesh))
    if options.new_scene:
        write_text(scene_toml([found_mesh]), options.new_scene)
        sentences.append(f"scene: {options.new_scene}")
    text = [part for row in found for part in (transposed(row), "")]
    if "notes" not in table:
        table["notes"] = join_notes(map(str, (*doubts(found_mesh), *pair.caveats)))
    caveats = split_notes(table["notes"])
    document = {"title": pair.title, "caveats": caveats, "said": sentences}
    return Result(
        document | {"facts": records(found), "rows": records([table])},
        [pair.title, "", *text, *wrapped(sentences), "", short(table, _WIDE), "", *caveats],
        frames=[table],
        draw=lambda: pipeline.gears.draw_mesh(mesh(pair, _DRAWN)),
    )


def _check(options: argparse.Namespace, pair: Pair) -> None:
    """Raise an `InputError` for options that contradict each other, before simulating."""
    if options.sheet and not options.points:
        raise InputError("--sheet needs --points; give --points, too, or leave out --sheet")
    if (options.stages or options.points) and not options.failure_stage and pair.critical is None:
        raise InputError(
            "--stages and --points need a critical temperature; give --failure-stage or "
            "--critical-temperature, or temperature.critical in the file"
        )
    if options.new_scene:
        writable_path(options.new_scene, (".toml",))


def _simulate(options: argparse.Namespace, simulate: Callable[..., Any], *given: Any) -> Any:
    """Call ``simulate(*given)`` with the user's preset and workers, and a progress line."""
    with output.run_line() as progress:
        return simulate(*given, preset=options.preset, workers=options.workers, progress=progress)


def _facts(one: Mesh) -> pd.DataFrame:
    """Data frame of one row with quantities of the whole mesh, such as load and friction."""
    pair, gears, duty, rule = one.pair, one.pair.gears, one.duty, one.integral
    angle = gears.working_angle
    pitch = next(place for place in one.places if place.position == 0)
    facts: dict[str, Any] = {
        "torque [N m]": duty.torque,
        "speed [rpm]": duty.turns,
        "bulk temperature [°C]": duty.bulk,
        "contact ratio": gears.contact_ratio,
        "overlap ratio": gears.overlap_ratio,
        "centre distance [mm]": gears.centre_distance,
        "working pressure angle [°]": math.degrees(angle),
        "pitch line velocity [m/s]": duty.speed * gears.base_radii[0] / math.cos(angle),
        "pitch pressure of one pair [GPa]": pitch.pressure / math.sqrt(pitch.share),
        "normal load [N]": one.normal_load,
        "friction": one.friction,
        "integral temperature [°C]": rule and rule.integral,
    }
    for number, (values, source) in enumerate(library_tables(pair.sources), 1):
        facts[f"library {number}"] = f"{values}; from {source}"
    return frame_of([*facts], [[*facts.values()]])
