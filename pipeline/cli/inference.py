"""The commands that simulate one point, and that infer unknown inputs from measurements."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

import pipeline
from pipeline.analysis.margin import (
    NOT_DECIDED,
    percent,
    probabilities_alone,
    verdict_between,
)
from pipeline.analysis.margin_error import RiseError, error_of_point
from pipeline.analysis.model_error import USUAL, ModelError
from pipeline.analysis.tables import TABLES, frame_of, short, upright, writable_path
from pipeline.cli.given import PLACE, conditions_in, flags_of, one_scene_in, selected, values_in
from pipeline.cli.next_steps import lines_on, point_that_decides
from pipeline.cli.output import Result, counted, run_line, tell, working
from pipeline.cli.weighed import posterior
from pipeline.scene.facts import require_bearable_load
from pipeline.scene.units import display
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.physics import note_on_turns
from pipeline.sweep.plan import PointResult
from pipeline.sweep.severity import MELTS, MOLTEN, rise_limit
from pipeline.sweep.wear_rates import note_on_wear
from tribo import InputError, Ramp, measures
from tribo.inverse import specific_wear_rate

if TYPE_CHECKING:
    from pipeline.run.critical_temperature import CriticalTemperatures  # with Dask


def point(options: argparse.Namespace) -> Result:
    """Simulate one point."""
    place = Point(options.load, options.velocity)
    sweep = one_scene_in(options, points=[place])
    require_bearable_load(sweep, options.load, "--load")
    sweep = sweep.on_surface(options.realization)
    with working("simulating") as progress:
        result = pipeline.run_point(
            sweep.changed(steps="end"), options.load, options.velocity, progress=progress
        )
    conditions, verdict = sweep.conditions, result.verdict(sweep.conditions)
    decisive, critical = verdict.decisive_temperature, conditions.critical_temperature
    rise = decisive - conditions.coldest_bulk_temperature
    flags = sum({int(warning.kind) for warning in result.warnings})
    promised = velocity_error(sweep)
    is_refined = not sweep.about.selection and result.state.pressure.shape != result.shape
    relative = error_of_point(flags, result.state.time, promised, is_refined)
    error = relative.times(rise)
    left_out = note_on_turns(sweep, options.load, options.velocity), note_on_wear(sweep)
    judged, commands = None, list[str]()
    distance = None if critical is None else critical - decisive
    usual = sweep.about.model_scatter
    model = ModelError(usual=USUAL if usual is None else usual)
    chances = None
    if distance is not None:
        rise_at_one = rise / conditions.rise_factor if conditions.rise_factor else 0.0
        chances = probabilities_alone(rise_at_one, rise_limit(conditions), model, relative)
        judged = verdict_between(chances[0], chances[2])
        by_model = verdict_between(chances[1], chances[1]) == NOT_DECIDED
        if judged == NOT_DECIDED and not by_model:
            about = distance, rise, conditions_in(options)
            commands = point_that_decides(sweep, place, options.realization, *about)
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
        "model_error": model.worded,
        "warnings": [{"kind": kind.label, "text": text} for kind, text in result.warnings],
        "molten": decisive > MELTS,
        "not_counted": "; ".join(filter(None, left_out)) or None,
        "wall_time": result.wall_time,
        "next": commands,
        **selected(sweep),
    }
    values = document | {"load": options.load, "distance": distance}
    frame = frame_of(tuple(_COLUMNS), [[values[name] for name in _COLUMNS.values()]])
    text = [*_on_point(sweep, result, document, error), "", upright(frame)]
    text += lines_on(commands, by_model=not commands) if judged == NOT_DECIDED else ()
    return Result(document, text, frames=[frame])


_COLUMNS = {
    "load [N]": "load", "velocity [m/s]": "velocity", "friction": "friction", "verdict": "verdict",
    "decisive temperature [°C]": "decisive_temperature",
    "temperature error [K]": "temperature_error", "distance [K]": "distance",
    "highest temperature [°C]": "max_temperature", "hottest at [s]": "failed_fraction_time",
    "failed share [%]": "failed_fraction", "pin's heat share [%]": "pin_heat_share",
    "contact width [µm]": "contact_width", "contact area [%]": "contact_fraction",
    "mean pressure [GPa]": "mean_pressure", "highest pressure [GPa]": "max_pressure",
    "wear depth [µm]": "wear_depth_max", "wear volume [mm³]": "wear_volume", "time [s]": "time",
    "sliding distance [m]": "sliding_distance", "computed in [s]": "wall_time",
}  # fmt: skip
"""Heads of the table of a point, and names in its document."""


def _on_point(
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
        critical = display(conditions.critical_temperature, "°C")
        severe = f"wear is severe with {decisive.severe} {critical}; "
    yield f"{severe}the decisive temperature is {decisive.temperature}, its error {error.worded}"
    if (chance := document["probability"]) is not None:
        yield (
            f"the next run is severe with {percent(chance)} probability at most where the rise "
            f"grows as the velocity; the model's own error: {document['model_error']}"
        )
    block = sweep.scene.pixels.shape[0] // len(result.state.pressure)
    if block > 1 and sweep.scene.roughness is not None:
        yield (
            f"note: area and pressure are those of elements of {block} × {block} pixels, more of "
            "which touch"
        )
    if velocity < 0:
        yield "note: the velocity is negative, so the disk slides towards −x"
    yield from (f"note: {note}" for note in sweep.about.notes)
    yield from (f"warning: {text}" for _, text in result.warnings)
    if document["molten"]:
        yield f"warning: {MOLTEN}"
    if cold := document["not_counted"]:
        yield f"warning: {cold}"


def infer(options: argparse.Namespace) -> Result:
    """Infer a critical temperature, a wear rate, or all unknown inputs."""
    stores = [path for path in options.scene if path.is_dir()]
    scenes = [path for path in options.scene if path not in stores]
    if scenes[1:] or (scenes and stores):
        raise InputError(f"{scenes[-1]} is not a store; give stores of samples alone, or one scene")
    if scenes:
        (options.scene,), bulks = scenes, options.bulk_temperature or [None]
        options.bulk_temperature = bulks[0]
        # Several bulk temperatures are to choose from: those of a test to plan, of samples.
        sweep = one_scene_in(options) if len(bulks) == 1 else None
        if sweep is not None and (options.contact_width is not None or not sweep.variants.draw):
            return _of_scene(options, sweep)
        options.bulk_temperature = [bulk for bulk in bulks if bulk is not None]
        stores = [Path("results") / f"{options.scene.stem}.zarr"]
        if not stores[0].exists():
            raise InputError(
                f"the samples of {options.scene} are not computed; run irg run {options.scene}, "
                "then irg infer with the store that it wrote"
            )
    if names := values_in(options, "contact_width", "duration", "preset", "set", *PLACE):
        raise InputError(
            f"the samples of {stores[0]} stay as they were computed; leave out {flags_of(names)}"
        )
    return posterior(options, stores)


def _of_scene(options: argparse.Namespace, sweep: Sweep) -> Result:
    """Wear rate from a contact width, or critical temperature from transitions or tests."""
    if given := values_in(options, "next", "target", "scatter", "discrepancy", "at"):
        raise InputError(
            f"{flags_of(given)} needs samples of unknown inputs: give [unknown] and "
            "sweep.samples in the scene"
        )
    if options.output is not None:
        writable_path(options.output, TABLES)
    sweep = sweep.on_surface(options.realization)
    if options.contact_width is not None:
        return _wear_rate(options, sweep)
    if ignored := values_in(options, "load", "velocity", "duration"):
        raise InputError(f"{flags_of(ignored)} belongs to --contact-width, which is not given")
    tested = () if sweep.about.measured else sweep.about.tested
    if tested:
        sweep = sweep.changed(measured=tested)
    with run_line() as progress:
        inferred = pipeline.critical_temperatures(
            sweep, tell=tell, out=options.kept, workers=options.workers, progress=progress
        )
    frame = _transitions(inferred)
    if tested:
        return _of_tests(inferred, [str(test.outcome) for test in tested], frame)
    measured = counted(len(frame), "measured transition", "measured transitions")
    several = f" on {len(inferred.surfaces)} surfaces" if len(inferred.surfaces) > 1 else ""
    apart = f", {inferred.spread:.1f} K apart (standard deviation)" if inferred.spread else ""
    text = [
        f"critical temperature from {measured}{several}: {inferred.criterion.temperature}",
        short(frame),
        f"on average {display(inferred.mean, '°C', 4)}{apart}",
    ]
    return Result(inferred.as_dict(), text, frames=[frame])


def _of_tests(at_tests: CriticalTemperatures, outcomes: list[str], frame: pd.DataFrame) -> Result:
    """Bounds of the critical temperature: hotter than mild tests, colder than severe ones."""
    judged = list(zip(outcomes, at_tests.means, strict=True))
    low = max((mean for outcome, mean in judged if outcome == "mild"), default=None)
    high = min((mean for outcome, mean in judged if outcome == "severe"), default=None)
    above, below = (end and display(end, "°C", 4) for end in (low, high))
    if low is None or high is None:
        said = f"the critical temperature is {'below' if low is None else 'above'} {above or below}"
    elif low < high:
        said = f"the critical temperature is between {above} and {below}"
    else:
        said = f"the tests contradict each other: mild up to {above}, severe from {below} on"
    frame.insert(3, "outcome", outcomes)
    frame = frame.rename(columns={"critical temperature [°C]": "temperature [°C]"})
    text = [
        f"temperature of {counted(len(outcomes), 'test', 'tests')}, below the critical "
        "temperature where wear stayed mild, above it where wear turned severe:",
        short(frame),
        said,
        "for the probability of each value give temperature.critical a range under [unknown], and "
        "samples under [sweep]: irg help your-tests",
    ]
    document = at_tests.as_dict() | {"outcomes": outcomes, "bounds": [low, high]}
    return Result(document, text, frames=[frame])


def _transitions(inferred: CriticalTemperatures) -> pd.DataFrame:
    """Frame with a row for each measured transition."""
    seeds = inferred.surfaces if inferred.spreads[0] else ()
    heads = (
        *("load [N]", "velocity [m/s]", "friction", "critical temperature [°C]", "spread [K]"),
        *(f"surface {seed} [°C]" for seed in seeds),
    )
    rows = zip(
        inferred.transitions, inferred.temperatures, inferred.means, inferred.spreads, strict=True
    )
    return frame_of(
        heads,
        (
            (test.normal_load, test.velocity, test.friction, mean, spread, *(seeds and values))
            for test, values, mean, spread in rows
        ),
    )


def _wear_rate(options: argparse.Namespace, sweep: Sweep) -> Result:
    """Specific wear rate from the width of a contact."""
    if options.load is None or options.velocity is None:
        raise InputError("--contact-width is that of a test; give its --load and --velocity, too")
    sweep = _slid_for(sweep, options.load, options.duration)
    *_, end = sweep.scene.loading.stations(options.load, sweep.scene.fidelity.increments)
    with working("seeking the wear rate, one simulation after the other"):
        rate = specific_wear_rate(
            sweep.scene, options.contact_width, options.load, options.velocity
        )
    value, lowest, highest = (1e9 * end for end in (rate.value, rate.lowest, rate.highest))
    longer = end.normal_load / (end.impulse + end.normal_load)  # as wear goes with load times time
    basis = (
        f"for {end.time:.3g} s of sliding until the width was measured; each second more at full "
        f"load lowers it by about {100 * longer:.2g} %"
    )
    if options.duration is None:
        basis += ": give --duration, if the test went on"
    text = [
        f"specific wear rate {value:.3g} mm³/(N m), from {lowest:.3g} to {highest:.3g} within half "
        "an element of the width",
        basis,
    ]
    document = asdict(rate) | {"duration": end.time}
    heads = *(f"{name} [mm³/(N m)]" for name in asdict(rate)), "duration [s]"
    return Result(document, text, frames=[frame_of(heads, [tuple(document.values())])])


def _slid_for(sweep: Sweep, load: float, duration: float | None) -> Sweep:
    """The sweep with the load held from when it is reached until the end of a test [s]."""
    if duration is None:
        return sweep
    if not isinstance(sweep.scene.loading, Ramp):
        raise InputError("--duration holds a ramp; a recorded load ends where the record does")
    ramp = load / sweep.scene.loading.rate
    if duration < ramp:
        raise InputError(
            f"--duration is {duration:g} s; it must be at least the {ramp:g} s of the ramp to "
            f"{load:g} N"
        )
    return sweep.changed(loading=replace(sweep.scene.loading, hold=duration - ramp, stops=()))
