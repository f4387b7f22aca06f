"""The commands that say when wear is severe, and at which temperature or wear rate."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.tables import Column, Table
from pipeline.cli.exit_codes import DONE
from pipeline.cli.next_steps import after_boundary
from pipeline.cli.output import counted, micrometres, show, table_path, tell
from pipeline.cli.progress import working
from pipeline.cli.scenes import CONDITIONS, PLACE, given, opened, scene_of, selected
from pipeline.cli.unknowns import boundary_of_samples, posterior
from pipeline.sweep.criterion import Verdict
from pipeline.sweep.facts import require_bearable_load
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointResult
from tribo import Criterion, InputError, Ramp, measures, specific_wear_rate

if TYPE_CHECKING:
    from pipeline.analysis.inference import CriticalTemperatures


_FLAGS = {
    name: f"--{name.replace('_', '-')}"
    for name in (*PLACE, *CONDITIONS, "log", "given_measured", "scatter")
} | {"rivals": "--rival"}
"""Options that only some kinds of figures have, as they are typed."""

_MORE_AREA = {2: "14 to 17", 4: "40 to 50"}
"""By how much more elements of so many pixels touch than the pixels do [%]."""


def boundary(options: argparse.Namespace) -> int:
    """Print critical velocities and loads."""
    out = table_path(options)
    from pipeline.analysis.attributes import attributes_of  # with xarray
    from pipeline.analysis.boundary_tables import tables_of
    from pipeline.cli.crossings import command_for, document_of, text_of

    ds, conditions = opened(options), given(options, *CONDITIONS)
    if "sample" in ds.dims:
        return boundary_of_samples(options, ds, conditions)
    found, warned = pipeline.boundary(ds, **conditions), pipeline.warned(ds, **conditions)
    command = command_for(found, options.store, ds)
    document = document_of(found) | {"command": command}
    tables = tables_of(found)
    text = [*text_of(found, command), *after_boundary(attributes_of(ds), options.store)]
    show(options, document, text, warned=warned, out=out, tables=tables)
    return DONE


def plot(options: argparse.Namespace) -> int:
    """Draw a figure of a store."""
    shown = given(options, *PLACE, "rivals", "scatter", "width", "dpi") | {
        "with_title": not options.no_title
    }
    shown |= {name: True for name in ("log", "given_measured") if getattr(options, name)}
    conditions = given(options, *CONDITIONS)
    _require_options(options.kind, [*shown, *conditions])
    if options.watch:
        return _watched(options, shown | conditions)
    ds = opened(options)
    store = Path(options.store if isinstance(options.store, Path) else Path(options.store).name)
    suffix = "gif" if options.kind == "animation" else "png"
    out = options.output or store.with_name(f"{store.stem}_{options.kind}.{suffix}")
    written = pipeline.plot(ds, options.kind, out, **shown, **conditions)
    document = {"kind": options.kind, "file": str(written)}
    show(options, document, [f"{written}"], warned=pipeline.warned(ds, **conditions))
    return DONE


def _watched(options: argparse.Namespace, shown: dict[str, Any]) -> int:
    """Draw the figure as points come."""
    state = pipeline.watch(
        options.store,
        options.output,
        options.kind,
        progress=lambda state: tell(f"{state.done} of {state.total} points drawn"),
        **shown,
    )
    document = {"kind": options.kind, "file": options.output and str(options.output)}
    text = [f"{options.store}: {state.done} of {state.total} points done, and no run goes on"]
    show(options, document | {"done": state.done, "points": state.total}, text)
    return DONE


def _require_options(kind: str, names: Iterable[str]) -> None:
    """Raise an `InputError` that names, as it is typed, an option that a kind of figure lacks."""
    from pipeline.figures.plot import options_of

    allowed = [name for name in options_of(kind) if name in _FLAGS]
    for name in names:
        if name in _FLAGS and name not in allowed:
            flags = ", ".join(_FLAGS[each] for each in allowed)
            raise InputError(f"--kind {kind} takes no {_FLAGS[name]}; it takes {flags}")


def explore(options: argparse.Namespace) -> int:
    """Write a page to explore a store in a browser."""
    ds = pipeline.open_sweep(options.store)
    out = options.output or _beside(options.store, ".html")
    fields = {"most_fields": 0} if options.no_fields else given(options, "most_fields")
    with working("writing the page"):
        page = pipeline.explore(ds, out, **fields)
    show(options, page.as_dict(), [str(page)], warned=pipeline.warned(ds))
    return DONE


def report(options: argparse.Namespace) -> int:
    """Write a report of a store."""
    ds, conditions = opened(options), given(options, *CONDITIONS)
    out = options.output or _beside(options.store, "_report.html")
    points = None if options.points is None else pipeline.OperatingPoints.read(options.points)
    with working("writing the report"):
        written = pipeline.report(ds, out, points, **conditions)
    warned = pipeline.warned(ds, **conditions)
    show(options, {"file": str(written)}, [str(written)], warned=warned)
    return DONE


def _beside(store: Path | str, ending: str) -> Path:
    """File beside a store, or here for a store at an address."""
    path = Path(store) if "://" not in str(store) else Path(Path(store).name)
    return path.with_name(f"{path.stem}{ending}")


def point(options: argparse.Namespace) -> int:
    """Simulate one point."""
    sweep = scene_of(options, points=[Point(options.load, options.velocity)])
    require_bearable_load(sweep, options.load, "--load")
    sweep = sweep.on_surface(options.realization)
    with working("simulating") as progress:
        result = pipeline.run_point(sweep, options.load, options.velocity, progress=progress)
    found, verdict = measures(sweep, result.state), result.verdict(sweep.conditions)
    document = found | {
        "velocity": options.velocity,
        "friction": sweep.conditions.friction,
        "max_temperature": verdict.max_temperature,
        "decisive_temperature": verdict.decisive_temperature,
        "failed_fraction": verdict.failed_fraction,
        "failed_fraction_time": verdict.time,
        "severe": verdict.is_severe,
        "warnings": [{"kind": kind.label, "text": text} for kind, text in result.warnings],
        "wall_time": result.wall_time,
        **selected(sweep),
    }
    show(options, document, _on_point(sweep, result, verdict, found))
    return DONE


def _of_elements(sweep: Sweep, result: PointResult) -> Iterator[str]:
    """Effect of the size of the elements, if a rough surface touches on larger ones."""
    block = sweep.pixels.shape[0] // len(result.state.pressure)
    if block > 1 and sweep.roughness is not None:
        room = " " * 20
        yield f"{room}area and pressure are those of elements of {block} × {block} pixels"
        if more := _MORE_AREA.get(block):
            yield f"{room}(in the paper's system these touch on {more} % more than pixels)"


def _on_point(
    sweep: Sweep, result: PointResult, verdict: Verdict, found: Mapping[str, float]
) -> Iterator[str]:
    load, velocity = result.point[:2]
    conditions = sweep.conditions
    at_worst = f" at its worst, after {verdict.time:.3g} s" if verdict.time < found["time"] else ""
    wear = "severe wear" if verdict.is_severe else "mild wear"
    if verdict.is_severe is None:
        wear = "mild or severe is open without temperature.critical"
    yield (
        f"{load:g} N at {velocity:g} m/s after {found['time']:.3g} s "
        f"and {found['sliding_distance']:.3g} m: {wear}"
    )
    if conditions.critical_temperature is not None and verdict.failed_fraction is not None:
        yield (
            f"  failed share      {100 * verdict.failed_fraction:.1f} % of the contact above "
            f"{pipeline.display(conditions.critical_temperature, '°C')} "
            f"(severe: {conditions.decisive.severe} it)"
        )
    if conditions.decisive.temperature != Criterion("highest").temperature:
        yield (
            f"  deciding          {pipeline.display(verdict.decisive_temperature, '°C', 4)}, "
            f"{conditions.decisive.temperature}"
        )
    yield (
        f"  max temperature   {pipeline.display(verdict.max_temperature, '°C', 4)} at friction "
        f"{conditions.friction:g}{at_worst}"
    )
    heat = found["pin_heat_share"]
    yield "  pin's heat share  " + (f"{100 * heat:.1f} %" if math.isfinite(heat) else "no heat")
    yield f"  contact width     {micrometres(found['contact_width'])}"
    yield f"  contact area      {100 * found['contact_fraction']:.2f} % of the window"
    yield (
        f"  pressure          {found['mean_pressure'] / 1e9:.3f} GPa on average, "
        f"{found['max_pressure'] / 1e9:.3f} GPa at most"
    )
    yield from _of_elements(sweep, result)
    yield (
        f"  wear              {micrometres(found['wear_depth_max'])} deep, "
        f"{found['wear_volume'] * 1e9:.3g} mm³"
    )
    yield f"  computed in       {result.wall_time:.2f} s"
    if velocity < 0:
        yield "  note: the velocity is negative, so the disk slides towards −x"
    yield from (f"  note: {note}" for note in sweep.notes)
    yield from (f"  warning: {text}" for _, text in result.warnings)


def infer(options: argparse.Namespace) -> int:
    """Find what was not measured from what was."""
    stores = [path for path in options.scene if path.is_dir()]
    if stores:
        if others := [str(path) for path in options.scene if path not in stores]:
            raise InputError(
                f"{others[0]} is no store, and stores do not go with others; give stores of "
                "samples alone, or one scene"
            )
        if names := [*given(options, "contact_width", "duration", "preset", *PLACE)]:
            flags = ", ".join(f"--{name.replace('_', '-')}" for name in names)
            raise InputError(
                f"{stores[0]} is a store, to which {flags} does not belong; give the scene"
            )
        return posterior(options, stores)
    if len(options.scene) > 1:
        raise InputError(f"give one scene, or several stores; {options.scene[1]} is no store")
    (options.scene,) = options.scene
    bulks = options.bulk_temperature or [None]
    sweep = None
    if len(bulks) == 1:
        options.bulk_temperature = bulks[0]
        sweep = scene_of(options)
    if sweep is None or (sweep.samples and options.contact_width is None):
        store = Path("results") / f"{options.scene.stem}.zarr"
        if not store.exists():
            raise InputError(
                f"the samples of {options.scene} are computed first: irg run {options.scene}; then "
                "irg infer OUT.zarr with what that wrote"
            )
        options.bulk_temperature = [bulk for bulk in bulks if bulk is not None]
        return posterior(options, [store])
    if options.next is not None or options.target or options.scatter is not None:
        raise InputError(
            "--next, --for and --scatter need samples of what is not known: give [unknown] and "
            "sweep.samples in the scene"
        )
    sweep = sweep.on_surface(options.realization)
    out = table_path(options)
    if options.contact_width is not None:
        return _wear_rate(options, sweep, out)
    if options.load is not None or options.velocity is not None:
        raise InputError("--load and --velocity belong to --contact-width, which is not given")
    found = pipeline.critical_temperatures(sweep, progress=tell)
    rows = zip(found.transitions, found.means, found.spreads, strict=True)
    measured = counted(len(found.transitions), "measured transition", "measured transitions")
    several = f" on {len(found.surfaces)} surfaces" if len(found.surfaces) > 1 else ""
    text = [
        f"critical temperature from {measured}{several}: {found.criterion.temperature}",
        *(
            f"  {at.normal_load:g} N, {at.velocity:g} m/s, friction {at.friction:g}: "
            f"{pipeline.display(mean, '°C', 4)}" + (f" ± {spread:.1f} K" if spread else "")
            for at, mean, spread in rows
        ),
        f"on average {pipeline.display(found.mean, '°C', 4)}"
        + (f", {found.spread:.1f} K apart (standard deviation)" if found.spread else ""),
    ]
    show(options, found.as_dict(), text, out=out, tables=[_transitions(found)])
    return DONE


def _transitions(found: CriticalTemperatures) -> Table:
    """Table with a row for each measured transition."""
    seeds = found.surfaces if found.spreads[0] else ()
    columns = (
        Column("load", "load", "N"),
        Column("velocity", "velocity", "m/s"),
        Column("friction", "friction"),
        Column("critical_temperature", "critical temperature", "°C"),
        Column("spread", "spread", "K"),
        *(Column(f"surface_{seed}", f"surface {seed}", "°C") for seed in seeds),
    )
    rows = zip(found.transitions, found.temperatures, found.means, found.spreads, strict=True)
    return Table(
        columns,
        tuple(
            (at.normal_load, at.velocity, at.friction, mean, spread, *(seeds and temperatures))
            for at, temperatures, mean, spread in rows
        ),
    )


def _wear_rate(options: argparse.Namespace, sweep: Sweep, out: Path | None) -> int:
    if options.load is None or options.velocity is None:
        raise InputError("--contact-width needs --load and --velocity: where it was measured")
    sweep = _slid_for(sweep, options.load, options.duration)
    *_, end = sweep.loading.stations(options.load, sweep.fidelity.increments)
    with working("seeking the wear rate, one simulation after the other"):
        found = specific_wear_rate(sweep, options.contact_width, options.load, options.velocity)
    value, lowest, highest = (1e9 * rate for rate in (found.value, found.lowest, found.highest))
    text = (
        f"specific wear rate {value:.3g} mm³/(N m), from {lowest:.3g} to {highest:.3g} within half "
        "an element of the width"
    )
    longer = end.normal_load / (end.impulse + end.normal_load)  # as wear goes with load times time
    basis = (
        f"for {end.time:.3g} s of sliding until the width was measured; each second more at full "
        f"load lowers it by about {100 * longer:.2g} %"
    )
    if options.duration is None:
        basis += ": give --duration, if the test went on"
    document = asdict(found) | {"duration": end.time}
    columns = [Column(name, name, "mm³/(N m)") for name in asdict(found)]
    columns.append(Column("duration", "duration", "s"))
    table = Table(tuple(columns), (tuple(document.values()),))
    show(options, document, [text, basis], out=out, tables=[table])
    return DONE


def _slid_for(sweep: Sweep, load: float, duration: float | None) -> Sweep:
    """The sweep with the load held from when it is reached until the end of a test [s]."""
    if duration is None:
        return sweep
    if not isinstance(sweep.loading, Ramp):
        raise InputError("--duration holds a ramp; a recorded load ends where the record does")
    ramp = load / sweep.loading.rate
    if duration < ramp:
        raise InputError(
            f"--duration is {duration:g} s; it must be at least the {ramp:g} s of the ramp to "
            f"{load:g} N"
        )
    return replace(sweep, loading=replace(sweep.loading, hold=duration - ramp, hold_steps=None))
