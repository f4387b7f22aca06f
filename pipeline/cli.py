"""The command ``irg``.

Results go to stdout, as text or with ``--json`` as one document; progress and messages to stderr.
Exit codes: 0 done, 1 some points failed, 2 wrong use or scene, 3 the store belongs to another
scene, 130 interrupted.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

import pipeline
from tribo import PRESETS, TriboError, failed_share, measures

if TYPE_CHECKING:
    from pipeline.execute import Progress
    from pipeline.sweep import Sweep

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130

_CONDITIONS = ("friction", "bulk_temperature", "critical_temperature", "share")
_NO_CROSSING = {1: "mild throughout", 2: "severe from the lowest", 3: "not known yet"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.command(options))
    except KeyboardInterrupt:
        _say("interrupted; finished points are safe: run the same command again to go on")
        return INTERRUPTED
    except pipeline.SceneFileError as error:
        _say(str(error))
        return WRONG_USE
    except pipeline.StoreMismatchError as error:
        _say(str(error))
        return OTHER_SCENE
    except TriboError as error:
        _say(str(error))
        return WRONG_USE
    except BrokenPipeError:
        sys.stderr.close()
        return DONE


def _run(options: argparse.Namespace) -> int:
    sweep = pipeline.load_scene(options.scene, preset=options.preset)
    out = options.output or Path("results") / f"{sweep.name}.zarr"
    with _ProgressLine(sweep) as line:
        outcome = pipeline.run_sweep(
            sweep,
            out,
            workers=options.workers,
            scheduler=options.scheduler,
            progress=line,
            retry_failed=options.retry_failed,
        )
    document = {
        "store": str(out),
        "points": outcome.total,
        "computed": outcome.computed,
        "done": outcome.done,
        "failed": [
            {"load": p.load, "velocity": p.velocity, "message": p.message} for p in outcome.failed
        ],
        "wall_time": outcome.wall_time,
    }
    _print(options, document, _run_text(document))
    return SOME_FAILED if outcome.failed else DONE


def _run_text(document: dict[str, Any]) -> Iterable[str]:
    yield (
        f"{document['store']}: {document['done']} of {document['points']} points done, "
        f"{document['computed']} of them now, in {document['wall_time']:.1f} s"
    )
    yield from _failed_text(document["failed"])
    if document["failed"]:
        yield "try these again with: irg run --retry-failed"


def _failed_text(failed: list[dict[str, Any]]) -> Iterable[str]:
    for point in failed:
        yield f"failed: {point['load']:g} N, {point['velocity']:g} m/s: {point['message']}"


def _check(options: argparse.Namespace) -> int:
    sweep = pipeline.load_scene(options.scene, preset=options.preset)
    found = pipeline.estimate(sweep, workers=options.workers)
    nx, ny = sweep.grid.shape
    text = [
        f"{sweep.title}",
        f"  points   {found.points}: {len(sweep.loads)} loads, {len(sweep.velocities)} velocities",
        f"  grid     {nx} × {ny} elements on {_um(sweep.grid.size[0])} × {_um(sweep.grid.size[1])}",
        f"  steps    {found.steps} contacts and {found.temperatures} temperatures to solve",
        f"  time     about {_duration(found.seconds)} on {found.workers} worker(s)",
        f"  memory   about {found.worker_bytes / 1e6:.0f} MB a worker",
        f"  disk     about {found.disk_bytes / 1e6:.0f} MB",
    ]
    _print(options, {"title": sweep.title} | found.as_dict(), text)
    return DONE


def _status(options: argparse.Namespace) -> int:
    found = pipeline.summary(options.store)
    failed = [{"load": p.load, "velocity": p.velocity, "message": p.message} for p in found.failed]
    document = {
        "title": found.title,
        "points": found.total,
        "done": found.done,
        "failed": failed,
        "pending": found.pending,
    }
    text = [
        found.title,
        f"{found.total} points: {found.done} done, {len(failed)} failed, {found.pending} pending",
        *_failed_text(failed),
    ]
    _print(options, document, text)
    return SOME_FAILED if failed else DONE


def _boundary(options: argparse.Namespace) -> int:
    result = pipeline.boundary(pipeline.open_sweep(options.store), **_given(options, *_CONDITIONS))
    document = {
        "conditions": {
            name: result.attrs[name]
            for name in ("friction", "bulk_temperature", "critical_temperature", "failing_share")
        },
        "missing_points": result.attrs["missing_points"],
        "load": result["load"].values.tolist(),
        "critical_velocity": _without_nan(result["critical_velocity"].values.tolist()),
        "velocity": result["velocity"].values.tolist(),
        "critical_load": _without_nan(result["critical_load"].values.tolist()),
    }
    text = [
        f"friction {result.attrs['friction']:g}, "
        f"bulk {pipeline.display(result.attrs['bulk_temperature'], '°C')}, "
        f"critical {pipeline.display(result.attrs['critical_temperature'], '°C')}, "
        f"failing share {result.attrs['failing_share']:g}",
        "",
        "  load [N]   critical velocity [m/s]",
        *_crossings(document["load"], document["critical_velocity"], result["outcome_at_load"]),
        "",
        "  velocity [m/s]   critical load [N]",
        *_crossings(document["velocity"], document["critical_load"], result["outcome_at_velocity"]),
    ]
    if document["missing_points"]:
        text += ["", f"{document['missing_points']} points are pending or failed and were left out"]
    _print(options, document, text)
    return DONE


def _crossings(axis: list[float], found: list[float | None], outcome: Any) -> Iterable[str]:
    for position, value, why in zip(axis, found, outcome.values.tolist(), strict=True):
        yield f"{position:10g}   " + (_NO_CROSSING[why] if value is None else f"{value:.4g}")


def _point(options: argparse.Namespace) -> int:
    sweep = pipeline.load_scene(options.scene, preset=options.preset)
    result = pipeline.run_point(sweep, options.load, options.velocity)
    found, heat, conditions = measures(sweep, result.state), result.state.heat, sweep.conditions
    if heat is None:
        raise TriboError("the point ended without a temperature")
    warming = conditions.critical_temperature - conditions.bulk_temperature
    share = (
        failed_share(heat.rise_quantile, warming / conditions.friction)
        if conditions.friction
        else 0.0
    )
    hottest = conditions.bulk_temperature + conditions.friction * heat.max_rise
    severe = share > conditions.failing_share
    document = found | {
        "velocity": options.velocity,
        "friction": conditions.friction,
        "max_temperature": hottest,
        "failed_fraction": share,
        "severe": severe,
        "warnings": list(result.warnings),
        "wall_time": result.wall_time,
    }
    text = [
        f"{options.load:g} N at {options.velocity:g} m/s after {found['time']:.3g} s "
        f"and {found['sliding_distance']:.3g} m: {'severe' if severe else 'mild'} wear",
        f"  failed share      {100 * share:.1f} % of the contact above "
        f"{pipeline.display(conditions.critical_temperature, '°C')} "
        f"(severe above {100 * conditions.failing_share:g} %)",
        f"  max temperature   {pipeline.display(hottest, '°C', 4)} at friction "
        f"{conditions.friction:g}",
        f"  pin's heat share  {100 * found['pin_heat_share']:.1f} %",
        f"  contact width     {_um(found['contact_width'])}",
        f"  contact area      {100 * found['contact_fraction']:.2f} % of the window",
        f"  pressure          {found['mean_pressure'] / 1e9:.3f} GPa on average, "
        f"{found['max_pressure'] / 1e9:.3f} GPa at most",
        f"  wear              {_um(found['wear_depth_max'])} deep, "
        f"{found['wear_volume'] * 1e9:.3g} mm³",
        f"  computed in       {result.wall_time:.2f} s",
        *(f"  warning: {warning}" for warning in result.warnings),
    ]
    _print(options, document, text)
    return DONE


def _plot(options: argparse.Namespace) -> int:
    ds = pipeline.open_sweep(options.store)
    out = options.output or options.store.with_name(f"{options.store.stem}_{options.kind}.png")
    written = pipeline.plot(
        ds, options.kind, out, **_given(options, "load", "velocity", *_CONDITIONS)
    )
    _print(options, {"kind": options.kind, "file": str(written)}, [f"{written}"])
    return DONE


def _given(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """The options of these names that the user gave."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}


class _ProgressLine:
    """The state of a run on one line of stderr."""

    def __init__(self, sweep: Sweep) -> None:
        self._total = len(sweep.loads) * len(sweep.velocities)
        self._bar: Any = None

    def __enter__(self) -> Callable[[Progress], None]:
        on_terminal = sys.stderr.isatty()
        self._bar = tqdm(
            total=self._total,
            unit="point",
            mininterval=0.1 if on_terminal else 10.0,
            bar_format="{n_fmt} of {total_fmt} points done{postfix} |{bar:20}|",
            postfix="",
        )
        return self._show

    def _show(self, progress: Progress) -> None:
        self._bar.total = progress.total
        self._bar.n = progress.done
        parts = [f"{progress.failed} failed", f"{_duration(progress.elapsed)} so far"]
        if progress.time_to_go is not None:
            parts.append(f"{_duration(progress.time_to_go)} to go")
        self._bar.set_postfix_str(", ".join(parts), refresh=False)
        self._bar.update(0)

    def __exit__(self, *_: object) -> None:
        self._bar.refresh()
        self._bar.close()


def _duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes / 60:.1f} h"


def _um(length: float) -> str:
    return pipeline.display(length, "µm", 4)


def _without_nan(values: list[float]) -> list[float | None]:
    return [None if math.isnan(value) else value for value in values]


def _print(options: argparse.Namespace, document: dict[str, Any], text: Iterable[str]) -> None:
    if options.json:
        clean = {
            key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in document.items()
        }
        print(json.dumps(clean, indent=2, ensure_ascii=False, allow_nan=False))
    else:
        print("\n".join(text))


def _say(message: str) -> None:
    print(f"irg: {message}", file=sys.stderr)


def _quantity(like: str) -> Callable[[str], float]:
    """A parser of quantities with a unit, such as `like`."""

    def parse(text: str) -> float:
        try:
            return pipeline.to_si(text, like)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f'{error}; give one like "{like}"') from error

    return parse


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="irg",
        description="Predict where a lubricated sliding contact goes from mild to severe wear.",
    )
    commands = parser.add_subparsers(metavar="COMMAND", required=True)

    def command(
        name: str, function: Callable[[argparse.Namespace], int], what: str, given: str
    ) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=what, description=f"{what[0].upper()}{what[1:]}.")
        added.set_defaults(command=function)
        if given == "scene":
            added.add_argument("scene", metavar="SCENE.toml", type=Path)
            added.add_argument(
                "--preset",
                metavar="NAME",
                help=f"fidelity in place of the scene's own: {', '.join(PRESETS)}",
            )
        else:
            added.add_argument("store", metavar="OUT.zarr", type=Path)
        added.add_argument("--json", action="store_true", help="print one JSON document")
        return added

    run = command("run", _run, "run or resume the sweep of a scene", "scene")
    run.add_argument(
        "-o", "--output", metavar="OUT.zarr", type=Path, help="default: results/<scene>.zarr"
    )
    where = run.add_mutually_exclusive_group()
    where.add_argument("--workers", metavar="N", type=_workers, help="default: one for each core")
    where.add_argument("--scheduler", metavar="ADDRESS", help="a running Dask scheduler to use")
    run.add_argument("--retry-failed", action="store_true", help="compute failed points again")

    check = command("check", _check, "validate a scene and say what would run", "scene")
    check.add_argument("--workers", metavar="N", type=_workers, help="default: one for each core")

    command("status", _status, "count the points done, failed and pending", "store")

    boundary = command(
        "boundary", _boundary, "find the transition, without a new simulation", "store"
    )
    point = command("point", _point, "simulate one point", "scene")
    plot = command("plot", _plot, "draw a figure", "store")
    plot.add_argument("--kind", default="diagram", choices=("diagram", "ramp", "fields"))
    plot.add_argument(
        "-o", "--output", metavar="FILE.png", type=Path, help="default: beside the store"
    )
    for added in (boundary, plot):
        added.add_argument("--friction", type=float, help="coefficient of friction")
        added.add_argument(
            "--bulk-temperature", metavar="T", type=_quantity("25 degC"), help='like "25 degC"'
        )
        added.add_argument(
            "--critical-temperature",
            metavar="T",
            type=_quantity("145 degC"),
            help='like "145 degC"',
        )
        added.add_argument(
            "--share", type=float, help="of the contact above the critical temperature, like 0.1"
        )
    for added, required in ((point, True), (plot, False)):
        added.add_argument(
            "--load", metavar="F", type=_quantity("750 N"), required=required, help='like "750 N"'
        )
        added.add_argument(
            "--velocity",
            metavar="V",
            type=_quantity("1.25 m/s"),
            required=required,
            help='like "1.25 m/s"',
        )
    return parser


def _workers(text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} workers; give a whole number of at least 1")
    return number


if __name__ == "__main__":
    sys.exit(main())
