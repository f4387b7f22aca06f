"""What the command ``irg gears`` answers: as a document, in words and tables, as a figure."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict
from operator import attrgetter
from typing import Any, TypeVar

import pandas as pd

import pipeline.gears
from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.tables import as_dict, frame_of, short, writable_path, write_text
from pipeline.cli import output
from pipeline.cli.given import settings_in
from pipeline.cli.output import Result
from pipeline.gears.contact import Mesh, mesh
from pipeline.gears.doubts import doubts
from pipeline.gears.fzg import critical_temperature, predict_stages, stage_duty
from pipeline.gears.pair import Pair
from pipeline.gears.reading import read_pair
from pipeline.gears.scene import scene_toml
from pipeline.gears.spectrum import judge_spectrum
from pipeline.quantities import display
from pipeline.sweep.about import library_tables
from pipeline.sweep.caveats import joined, parted
from tribo import InputError, lubrication_regime

T = TypeVar("T")

_PLACES = {
    "letter": "place", "position": "position [mm]", "radius_1": "radius 1 [mm]",
    "radius_2": "radius 2 [mm]", "reduced_radius": "reduced radius [mm]",
    "rolling_1": "rolling 1 [m/s]", "rolling_2": "rolling 2 [m/s]", "sliding": "sliding [m/s]",
    "share": "share", "load": "load [N]", "half_width": "half-width [µm]",
    "pressure": "pressure [GPa]", "flash": "flash [K]", "temperature": "temperature [°C]",
    "film": "film [µm]", "film_parameter": "Λ",
}  # fmt: skip
_CRITICAL = {
    "stage": "failure load stage", "value": "critical temperature [°C]", "doubt": "doubt [K]",
    "passed": "passed [°C]", "failed": "failed [°C]",
    "integral": "scuffing integral temperature [°C]",
}  # fmt: skip
_JUDGED = {
    "mesh.duty.torque": "torque [N m]", "mesh.duty.turns": "speed [rpm]",
    "mesh.duty.bulk": "bulk temperature [°C]", "place.position": "worst place [mm]",
    "verdict": "verdict", "told": "probability",
    "temperature": "decisive temperature [°C]", "error": "temperature error [K]",
    "distance": "distance [K]", "integral": "integral temperature [°C]", "notes": "notes",
}  # fmt: skip
_DRAWN = 400  # places of the figure, so that the load steps where it steps
_WIDE = ("reduced radius [mm]", "half-width [µm]", "temperature error [K]", "notes")
"""Columns for which a terminal is too narrow."""


def gears(options: argparse.Namespace) -> Result:
    """Print the contact along a mesh; write its scene; simulate FZG's test, or a spectrum."""
    pair = read_pair(options.pair, settings_in(options))
    if options.critical_temperature is not None:
        pair = pair.changed(critical=options.critical_temperature)
    _check(options, pair)
    if options.stage:
        pair = pair.changed(duty=stage_duty(pair, options.stage))
    answers, text, table = dict[str, Any](), list[str | pd.DataFrame](), pd.DataFrame()
    if options.failure_stage:
        critical = _simulated(options, critical_temperature, pair, options.failure_stage)
        pair = pair.changed(critical=critical.value, critical_sd=critical.doubt)
        answers["critical_temperature"] = asdict(critical)
        text, table = [*critical.words], _frame(_CRITICAL, [critical])
    one = mesh(pair, options.places)
    meshes = [one]
    if options.stages or options.points:
        told, lines, table, meshes = (_stages if options.stages else _spectrum)(options, pair)
        answers, text = answers | told, [*text, *lines]
    if not text:
        table = _frame(_PLACES, one.places)
        text = [frame_of(("subject", "value"), [*_facts(one)]), "", short(table, _WIDE)]
    if options.new_scene:
        note = f"Written by irg gears {options.pair}."
        answers["scene"] = str(write_text(scene_toml([one], note), options.new_scene))
        store = options.new_scene.with_suffix(".zarr").name
        text += ["", f"{options.new_scene} is written; its margins, place by place:"]
        text += [f"  irg run {options.new_scene} -o {store}", f"  irg margin {store}"]
    slips = [*map(str, doubts(meshes))]
    if "notes" not in table:
        table["notes"] = joined(pair.caveats)
    caveats = parted(table["notes"])
    document = {"title": pair.title, "caveats": caveats, "doubts": slips}
    return Result(
        document | _document(one) | answers,
        [pair.title, "", *text, *slips, "", *caveats],
        frames=[table],
        draw=lambda: pipeline.gears.draw_mesh(mesh(pair, _DRAWN)),
    )


def _frame(heads: Mapping[str, str], answers: Iterable[object]) -> pd.DataFrame:
    """Values of answers by their names, below heads."""
    return frame_of([*heads.values()], map(attrgetter(*heads), answers))


def _check(options: argparse.Namespace, pair: Pair) -> None:
    """Refuse options that do not go together, before anything is simulated."""
    if options.stages and options.points:
        raise InputError("--stages and --points are two questions; ask one at a time")
    if options.sheet and not options.points:
        raise InputError("--sheet names a sheet of --points; give that too, or leave it out")
    if options.failure_stage and options.critical_temperature is not None:
        raise InputError(
            "--failure-stage finds the critical temperature, which --critical-temperature gives; "
            "give one of them"
        )
    if (options.stages or options.points) and not options.failure_stage and pair.critical is None:
        raise InputError(
            "--stages and --points need a critical temperature; give --failure-stage or "
            "--critical-temperature, or temperature.critical in the file"
        )
    if options.new_scene:
        writable_path(options.new_scene, (".toml",))


def _simulated(options: argparse.Namespace, simulate: Callable[..., T], *given: Any) -> T:
    """Call what simulates, with the options of a run and a line of progress."""
    with output.run_line() as progress:
        return simulate(*given, preset=options.preset, workers=options.workers, progress=progress)


_Told = tuple[dict[str, Any], list[str | pd.DataFrame], pd.DataFrame, list[Mesh]]
"""What is simulated as plain data, in words, as a table, and at which duties."""


def _stages(options: argparse.Namespace, pair: Pair) -> _Told:
    """All load stages of the test, and those in which the pair fails, or may fail."""
    found = _simulated(options, predict_stages, pair)
    table = _frame(_JUDGED, found)
    table.insert(0, "stage", range(1, len(found) + 1))
    fails = next((k for k, one in enumerate(found, 1) if one.probability > 0.5), None)
    said = f"fails in load stage {fails}" if fails else "passes all load stages"
    text = [f"{said}, by a critical temperature of {pair.critical_words}"]
    if open_ones := [str(k) for k, one in enumerate(found, 1) if one.verdict == NOT_DECIDED]:
        text += [f"not decided, by all errors together: stage {', '.join(open_ones)}"]
    told = {"stages": {"fails": fails} | as_dict(table)}
    return told, [*text, "", short(table, _WIDE)], table, [one.mesh for one in found]


def _spectrum(options: argparse.Namespace, pair: Pair) -> _Told:
    """The rows of a duty spectrum, and one verdict."""
    judged = _simulated(options, judge_spectrum, pair, options.points, options.sheet)
    table = _frame(_JUDGED, [row.simulated for row in judged.rows])
    table.insert(0, "row", [row.number for row in judged.rows])
    table.insert(3, "hours", [row.hours for row in judged.rows])
    told = {
        "verdict": judged.verdict,
        "binding_row": judged.binding.number,
        "sentence": judged.sentence,
        "columns_not_used": [*judged.unused],
        "rows_read": judged.counted,
        "rows": as_dict(table),
    }
    text = [judged.sentence, "", short(table, _WIDE), *judged.remarks]
    meshes = [row.simulated.mesh for row in judged.rows]
    return {"spectrum": told}, [*filter(None, [judged.counted]), *text], table, meshes


def _alone(one: Mesh) -> float:
    """Pressure at the pitch point if one pair carries all, as tables of the test give it [Pa]."""
    pitch = next(place for place in one.places if place.position == 0)
    return pitch.pressure / math.sqrt(pitch.share)


def _facts(one: Mesh) -> Iterator[tuple[str, str]]:
    """What holds for the whole mesh, a row for each subject."""
    pair, gears, duty = one.pair, one.pair.gears, one.duty
    yield (
        "duty",
        f"{duty.torque:.4g} N m at {duty.turns:.4g} rpm on the pinion, teeth at "
        f"{display(duty.bulk, '°C', 4)}",
    )
    overlap = f", overlap {gears.overlap_ratio:.3g}" if gears.overlap_ratio else ""
    yield "contact ratio", f"{gears.contact_ratio:.4g}{overlap}"
    angle, apart = math.degrees(gears.working_angle), display(gears.centre_distance, "mm")
    yield "mesh", f"working pressure angle {angle:.5g}°, centre distance {apart}"
    speed = duty.speed * gears.base_radii[0] / math.cos(gears.working_angle)
    yield "pitch line", f"{speed:.4g} m/s, {display(_alone(one), 'GPa', 4)} if one pair carries all"
    yield "load", f"{one.normal_load:.6g} N normal to the flanks; {_sharing(one)}"
    source = "as given" if pair.friction is not None else "mean, by ISO/TR 13989-2, Eq. 1"
    yield "friction", f"{one.friction:.3g}, {source}"
    hot = one.hottest
    yield (
        "hottest",
        f"{display(hot.temperature, '°C', '.0f')} at {display(hot.position, 'mm', 3)}, by Blok's "
        f"flash temperature of {hot.flash:.0f} K",
    )
    parameters = [place.film_parameter for place in one.places if place.film_parameter is not None]
    if parameters:
        low, high = min(parameters), max(parameters)
        regimes = dict.fromkeys(map(lubrication_regime, (low, high)))
        yield "film", f"Λ {low:.2g} to {high:.2g}: {' to '.join(regimes)}"
    if pair.critical is not None:
        yield "critical", pair.critical_words
    if rule := one.integral:
        said = f"{display(rule.integral, '°C', '.0f')}, by the rule of ISO/TR 13989-2 for this bulk"
        yield "integral", said
    for values, source in library_tables(pair.sources):
        yield "library", f"{values}; from {source}"


def _sharing(one: Mesh) -> str:
    """The rule by which pairs of teeth share the load, in words."""
    gears = one.pair.gears
    if gears.overlap_ratio:
        return (
            "helical: shared as lines of contact are long, 1/εα from an overlap of 1 on, and up to "
            "1.3 times that at A and E, ISO/TR 13989-1"
        )
    if gears.contact_ratio >= 2:
        return "shared equally by the pairs in mesh"
    return "all on one pair from B to D, beyond from a third at A and E to two thirds, AGMA 925-A03"


def _document(one: Mesh) -> dict[str, Any]:
    """The mesh as plain data in SI."""
    gears = one.pair.gears
    names = "contact_ratio", "overlap_ratio", "centre_distance", "base_pitch"
    return {
        "duty": asdict(one.duty),
        **{name: getattr(gears, name) for name in names},
        "working_pressure_angle": gears.working_angle,
        "normal_load": one.normal_load,
        "load_sharing": _sharing(one),
        "friction": one.friction,
        "pitch_pressure_of_one_pair": _alone(one),
        "integral": one.integral and asdict(one.integral),
        "library": [source._asdict() for source in one.pair.sources],
        "places": [asdict(place) for place in one.places],
    }
