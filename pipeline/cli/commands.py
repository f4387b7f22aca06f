"""What each command of ``irg`` does, given its options; each returns its exit code."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.cli.crossings import document_of, text_of
from pipeline.cli.meaning import meaning
from pipeline.cli.output import ProgressLine, duration, show, tell
from pipeline.run import forkserver
from pipeline.sweep.doubts import doubts
from pipeline.sweep.facts import facts_of, require_bearable_loads
from pipeline.sweep.left_out import left_out
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.selection import KEPT_FIELDS
from pipeline.tradeoff.forecast import machine_bytes, worker_bytes
from tribo import InputError, measures, specific_wear_rate

if TYPE_CHECKING:
    from pipeline.analysis.warned import Warned
    from pipeline.store.progress import FailedPoint, Summary
    from pipeline.store.verify import Damage

__all__ = [
    "CONDITIONS",
    "DONE",
    "INTERRUPTED",
    "OTHER_SCENE",
    "SOME_FAILED",
    "WRONG_USE",
    "boundary",
    "check",
    "compact",
    "infer",
    "plot",
    "point",
    "reproduce",
    "run",
    "setting",
    "status",
    "trade",
    "verify",
]

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130

CONDITIONS = ("friction", "bulk_temperature", "critical_temperature", "share")


def run(options: argparse.Namespace) -> int:
    """Run or resume a sweep, or the part of it that the boundary needs."""
    if options.scheduler is None:
        forkserver.start()
    out = options.output or Path("results") / f"{options.scene.stem}.zarr"
    sweep = _scene(options, store=out)
    for note in sweep.notes:
        tell(f"note: {note}")
    with ProgressLine() as line:
        cluster = {
            "workers": options.workers,
            "scheduler": options.scheduler,
            "progress": line,
            "retry_failed": options.retry_failed,
            "tell": tell,
        }
        if options.boundary_only is None:
            outcome = pipeline.run_sweep(sweep, out, **cluster, fill_fields=options.fill_fields)
        else:
            outcome = pipeline.follow_boundary(sweep, out, options.boundary_only, **cluster)
    document = {
        "store": str(out),
        "points": outcome.total,
        "computed": outcome.computed,
        "done": outcome.done,
        "failed": _failed(outcome.failed),
        "wall_time": outcome.wall_time,
        "warnings": (found := _warned(out)).as_dict(),
        **_selected(sweep),
    }
    text = [
        f"{out}: {outcome.done} of {outcome.total} points done, {outcome.computed} of them now, "
        f"in {outcome.wall_time:.1f} s",
        *(f"failed: {point}" for point in outcome.failed),
    ]
    if outcome.failed:
        text.append("try these again with: irg run --retry-failed")
    text += found.lines()
    show(options, document, text)
    return SOME_FAILED if outcome.failed else DONE


def _warned(store: Path) -> Warned:
    return pipeline.warned(pipeline.open_sweep(store))


def _failed(points: Iterable[FailedPoint | Damage]) -> list[dict[str, Any]]:
    """As in a JSON document; the surface only in a sweep over several."""
    return [
        {name: value for name, value in asdict(point).items() if value is not None}
        for point in points
    ]


def check(options: argparse.Namespace) -> int:
    """Say what a scene means, at once, and then what its sweep would cost."""
    sweep = _scene(options)
    require_bearable_loads(sweep)
    facts = facts_of(sweep)
    doubted, reasons = doubts(sweep, facts), tuple(left_out(sweep))
    memory = worker_bytes(sweep)
    nx, ny = sweep.grid.shape
    first = [
        f"{sweep.title}",
        *meaning(sweep, facts),
        *(f"  left out {reason}" for reason in reasons),
        *(f"  note     {note}" for note in sweep.notes),
        *(f"  warning  {doubt}" for doubt in doubted),
        f"  grid     {nx} × {ny} elements",
        f"  memory   about {memory / 1e6:.0f} MB a worker",
    ]
    if not options.json:
        print("\n".join(first), flush=True)
    document = {"title": sweep.title, "notes": sweep.notes, "meaning": facts.as_dict()}
    if memory > machine_bytes():
        doubt = (
            f"this machine has {machine_bytes() / 1e9:.0f} GB of memory, less than a worker needs: "
            "how long it would take is not tried; give fewer window.pixels, or a coarser fidelity"
        )
        known = {"left_out": reasons, "warnings": [*doubted, doubt], "worker_bytes": memory}
        show(options, document | known, [f"  warning  {doubt}"])
        return DONE
    found = pipeline.estimate(sweep, workers=options.workers)
    document |= found.as_dict() | {"warnings": [*doubted, *found.warnings]}
    surfaces = f", {len(sweep.realizations)} surfaces" if sweep.realizations else ""
    text = [
        f"  points   {found.points}: {len(sweep.loads)} loads, {len(sweep.velocities)} velocities"
        + surfaces,
        f"  steps    {found.steps} contacts and {found.temperatures} temperatures to solve",
        f"  time     about {duration(found.seconds)} on {found.workers} worker(s)",
        *(f"           {line}" for line in found.basis.split("; ")),
        f"  disk     about {found.disk_bytes / 1e6:.0f} MB",
        *(f"  warning  {what}" for what in found.warnings),
        *(f"  left out {reason}" for reason in found.left_out if reason not in reasons),
    ]
    show(options, document, text)
    return DONE


def status(options: argparse.Namespace) -> int:
    """Count points."""
    found = pipeline.summary(options.store)
    selection = pipeline.stored_selection(options.store)
    document = {
        "title": found.title,
        "points": found.total,
        "done": found.done,
        "failed": _failed(found.failed),
        "pending": found.pending,
        "running": found.running is not None,
        "points_per_minute": None if found.rate is None else 60 * found.rate,
        "time_to_go": found.time_to_go,
        "warnings": (warned := _warned(options.store)).as_dict(),
        "selection": selection.as_dict() if selection else None,
    }
    text = [
        found.title,
        f"{found.total} points: {found.done} done, {len(found.failed)} failed, "
        f"{found.pending} pending",
        *_pace_text(found),
        *([str(selection)] if selection else []),
        *(f"failed: {point}" for point in found.failed),
        *warned.lines(),
    ]
    show(options, document, text)
    return SOME_FAILED if found.failed else DONE


def _pace_text(found: Summary) -> Iterable[str]:
    if found.running:
        yield f"running: {found.running}"
    if found.pending and found.rate and found.time_to_go:
        yield (
            f"{60 * found.rate:.3g} points a minute {'now' if found.running else 'the last time'}, "
            f"{duration(found.time_to_go)} to go"
        )


def verify(options: argparse.Namespace) -> int:
    """Read everything and name what is damaged."""
    found = pipeline.verify_store(options.store, repair=options.repair)
    document = {
        "done": found.done,
        "damaged": _failed(found.damaged),
        "shared": found.shared,
        "repaired": found.repaired,
    }
    text = [
        f"{found.done} points are done and intact, {len(found.damaged)} are damaged",
        *(f"damaged: {damage}" for damage in found.damaged),
        *(f"damaged: {fault}" for fault in found.shared),
    ]
    if not found.is_clean:
        text.append(
            "repaired; damaged points are pending, and computed again by: irg run"
            if found.repaired
            else "set damaged points to be computed again with: irg verify --repair"
        )
    if found.is_clean or found.repaired:  # else they cannot be read
        warned = _warned(options.store)
        document["warnings"] = warned.as_dict()
        text += warned.lines()
    show(options, document, text)
    return DONE if found.is_clean else SOME_FAILED


def compact(options: argparse.Namespace) -> int:
    """Rewrite a store in large chunks."""
    pipeline.compact_store(options.store)
    show(options, {"store": str(options.store)}, [f"{options.store} is compact"])
    return DONE


def boundary(options: argparse.Namespace) -> int:
    """Print critical velocities and loads."""
    ds, conditions = pipeline.open_sweep(options.store), _given(options, *CONDITIONS)
    found, warned = pipeline.boundary(ds, **conditions), pipeline.warned(ds, **conditions)
    document = document_of(found) | {"warnings": warned.as_dict()}
    show(options, document, [*text_of(found), *warned.lines()])
    return DONE


def point(options: argparse.Namespace) -> int:
    """Simulate one point."""
    sweep = _scene(options, points=[Point(options.load, options.velocity)])
    sweep = sweep.on_surface(options.realization)
    result = pipeline.run_point(sweep, options.load, options.velocity)
    found, conditions = measures(sweep, result.state), sweep.conditions
    verdict = result.verdict(conditions)
    wear = "severe" if verdict.is_severe else "mild"
    document = found | {
        "velocity": options.velocity,
        "friction": conditions.friction,
        "max_temperature": verdict.max_temperature,
        "failed_fraction": verdict.failed_fraction,
        "failed_fraction_time": verdict.time,
        "severe": verdict.is_severe,
        "warnings": [{"kind": kind.label, "text": text} for kind, text in result.warnings],
        "wall_time": result.wall_time,
        **_selected(sweep),
    }
    text = [
        f"{options.load:g} N at {options.velocity:g} m/s after {found['time']:.3g} s "
        f"and {found['sliding_distance']:.3g} m: {wear} wear",
        f"  failed share      {100 * verdict.failed_fraction:.1f} % of the contact above "
        f"{pipeline.display(conditions.critical_temperature, '°C')} "
        f"(severe above {100 * conditions.failing_share:g} %)"
        + (f" at its worst, after {verdict.time:.3g} s" if verdict.time < found["time"] else ""),
        f"  max temperature   {pipeline.display(verdict.max_temperature, '°C', 4)} at friction "
        f"{conditions.friction:g}",
        f"  pin's heat share  {100 * found['pin_heat_share']:.1f} %",
        f"  contact width     {_um(found['contact_width'])}",
        f"  contact area      {100 * found['contact_fraction']:.2f} % of the window",
        f"  pressure          {found['mean_pressure'] / 1e9:.3f} GPa on average, "
        f"{found['max_pressure'] / 1e9:.3f} GPa at most",
        f"  wear              {_um(found['wear_depth_max'])} deep, "
        f"{found['wear_volume'] * 1e9:.3g} mm³",
        f"  computed in       {result.wall_time:.2f} s",
        *(f"  note: {note}" for note in sweep.notes),
        *(f"  warning: {warning}" for warning in result.warnings),
    ]
    show(options, document, text)
    return DONE


def infer(options: argparse.Namespace) -> int:
    """Find what was not measured from what was."""
    sweep = _scene(options).on_surface(options.realization)
    if options.contact_width is not None:
        return _wear_rate(options, sweep)
    if options.load is not None or options.velocity is not None:
        raise InputError("--load and --velocity belong to --contact-width, which is not given")
    found = pipeline.critical_temperatures(sweep, progress=tell)
    rows = zip(found.transitions, found.means, found.spreads, strict=True)
    several = f" on {len(found.surfaces)} surfaces" if len(found.surfaces) > 1 else ""
    text = [
        f"critical temperature from {len(found.transitions)} measured transition(s){several}: "
        f"exceeded on {100 * found.share:g} % of the contact",
        *(
            f"  {at.normal_load:g} N, {at.velocity:g} m/s, friction {at.friction:g}: "
            f"{pipeline.display(mean, '°C', 4)}" + (f" ± {spread:.1f} K" if spread else "")
            for at, mean, spread in rows
        ),
        f"on average {pipeline.display(found.mean, '°C', 4)}"
        + (f", {found.spread:.1f} K apart (standard deviation)" if found.spread else ""),
    ]
    show(options, found.as_dict(), text)
    return DONE


def _wear_rate(options: argparse.Namespace, sweep: Sweep) -> int:
    if options.load is None or options.velocity is None:
        raise InputError("--contact-width needs --load and --velocity: where it was measured")
    found = specific_wear_rate(sweep, options.contact_width, options.load, options.velocity)
    value, lowest, highest = (1e9 * rate for rate in (found.value, found.lowest, found.highest))
    text = (
        f"specific wear rate {value:.3g} mm³/(N m), from {lowest:.3g} to {highest:.3g} within half "
        "an element of the width"
    )
    show(options, asdict(found), [text])
    return DONE


def plot(options: argparse.Namespace) -> int:
    """Draw a figure of a store."""
    ds = pipeline.open_sweep(options.store)
    store = Path(options.store if isinstance(options.store, Path) else Path(options.store).name)
    out = options.output or store.with_name(f"{store.stem}_{options.kind}.png")
    given = _given(options, "load", "velocity", "realization", *CONDITIONS)
    written = pipeline.plot(ds, options.kind, out, **given)
    warned = pipeline.warned(ds, **_given(options, *CONDITIONS))
    document = {"kind": options.kind, "file": str(written), "warnings": warned.as_dict()}
    show(options, document, [f"{written}", *warned.lines()])
    return DONE


def trade(options: argparse.Namespace) -> int:
    """Measure speed against accuracy on a scene."""
    out = pipeline.figure_path(options.output) if options.output else None
    found = pipeline.trade(
        _scene(options), base=options.base, diagram=options.diagram, progress=tell
    )
    document, text = found.as_dict(), [str(found)]
    if out:
        pipeline.save_figure(pipeline.draw_trade(found), out)
        document["figure"] = str(out)
        text.append(f"figure: {out}")
    show(options, document, text)
    return DONE


def reproduce(options: argparse.Namespace) -> int:
    """Recompute a figure or table of the paper, all of them, or list them."""
    if options.list or options.name is None:
        results = pipeline.RESULTS
        show(options, results, [f"{name:12} {what}" for name, what in results.items()])
        return DONE
    chosen = _given(options, "preset", "surfaces", "workers")
    if options.name == "all":
        reports = pipeline.write_gallery(options.output or Path("results"), progress=tell, **chosen)
        text = [line for report in reports for line in (*report.lines(), "")]
        show(options, {report.name: report.as_dict() for report in reports}, text)
        return DONE
    report = pipeline.reproduce(options.name, options.output, progress=tell, **chosen)
    show(options, report.as_dict(), report.lines())
    return DONE


def _scene(
    options: argparse.Namespace, points: Sequence[Point] | None = None, store: Path | None = None
) -> Sweep:
    """The scene, at the fidelity that the user asked for.

    For an accuracy that is the one that `store` has, or else one that is accurate at `points`.
    """
    sweep: Sweep = pipeline.load_scene(
        options.scene, preset=options.preset, overrides=dict(options.set)
    )
    if getattr(options, "accuracy", None) is not None:
        fields = (key.removeprefix("fidelity.") for key, _ in options.set)
        own = [f"--set {key}" for key in fields if "." not in key and key not in KEPT_FIELDS]
        if given := [*(["--preset"] if options.preset else []), *own]:
            raise InputError(
                f"--accuracy picks the numerical choices itself; leave out {', '.join(given)}"
            )
        sweep = pipeline.at_accuracy(
            sweep, options.accuracy, points, store, lambda name: tell(f"probing {name}")
        )
        tell(str(sweep.selection))
    return sweep


def _selected(sweep: Sweep) -> dict[str, Any]:
    """Why the fidelity was picked, if it was."""
    return {"selection": sweep.selection.as_dict()} if sweep.selection else {}


def setting(text: str) -> tuple[str, Any]:
    """Read ``KEY=VALUE``, the value as in a scene file, quotes left out.

    Examples
    --------
    >>> setting("increments=50"), setting("wear.pattern=local")
    (('increments', 50), ('wear.pattern', 'local'))
    """
    key, separator, value = text.partition("=")
    if not (separator and key and value):
        raise argparse.ArgumentTypeError(f'"{text}" is no setting; give one like increments=50')
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value


def _um(length: float) -> str:
    return pipeline.display(length, "µm", 4)


def _given(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """The options of these names that the user gave."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}
