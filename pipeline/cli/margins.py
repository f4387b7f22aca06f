"""The command that says how far an operating point lies from severe wear."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import pipeline
from pipeline.analysis.margin_table import table_of_margins
from pipeline.analysis.operating_points import OperatingPoints, Place
from pipeline.cli.exit_codes import DONE
from pipeline.cli.next_steps import after_margin
from pipeline.cli.output import counted, show, table_path
from pipeline.cli.scenes import CONDITIONS, given, opened
from pipeline.cli.unknowns import judged_by, notes, samples_of
from pipeline.store.schema import PENDING
from tribo import InputError

if TYPE_CHECKING:
    import xarray as xr

    from pipeline.analysis.margin import Margin
    from pipeline.uncertain.answers import MarginIntervals


_ONLY_IN_FILES = (
    "certain", "critical_velocity", "critical_load", "velocity_outcome", "load_outcome", "note",
)  # fmt: skip
"""Columns of a table of margins for which a terminal is too narrow."""


def margin(options: argparse.Namespace) -> int:
    """Print the distance of one operating point to the boundary, or of those of a table."""
    if options.points is not None:
        return _of_points(options)
    if options.load is None or options.velocity is None:
        raise InputError("give --load and --velocity, or --points FILE.csv")
    out = table_path(options)
    ds, conditions = opened(options), given(options, *CONDITIONS)
    if "sample" in ds.dims:
        return _of_samples(options, ds, conditions)
    if options.given_measured or options.scatter is not None:
        raise InputError(
            "--given-measured and --scatter need samples of unknown inputs: give [unknown] and "
            "sweep.samples in the scene"
        )
    found = pipeline.margins(ds, options.load, options.velocity, **conditions)
    document = found[0].as_dict() if len(found) == 1 else _document(found)
    text = _on_one(found[0]) if len(found) == 1 else _on_several(found)
    command = _command(options, ds, conditions, found)
    from pipeline.analysis.attributes import attributes_of  # with xarray

    lines = [*text, *after_margin(attributes_of(ds), options.store, found)]
    if command:
        lines.append(f"compute more of the boundary with: {command}")
    warned = pipeline.warned(ds, **conditions)
    here = OperatingPoints((Place(options.load, options.velocity),), {})
    tables = [table_of_margins(here, [found])]
    show(options, document | {"command": command}, lines, warned=warned, out=out, tables=tables)
    return DONE


def _of_samples(options: argparse.Namespace, ds: xr.Dataset, conditions: dict[str, Any]) -> int:
    """Print the distance of an operating point as intervals of probability."""
    out = table_path(options)
    if conditions and (options.given_measured or options.scatter is not None):
        flags = ", ".join(f"--{name.replace('_', '-')}" for name in conditions)
        raise InputError(
            "--given-measured and --scatter weigh the conditions as they were drawn: leave out "
            f"{flags}"
        )
    measured, here = None, dict[str, float]()
    if conditions:
        ensemble, here = judged_by(ds, conditions)
    else:
        ensemble, measured = samples_of(options, ds)
    found = pipeline.margin_intervals(
        ensemble, options.load, options.velocity, measured.draws if measured else None, here
    )
    document = {"given_measured": measured is not None, "intervals": found.as_dict()}
    rows = [
        {"quantity": name, "low": each.low, "middle": each.middle, "high": each.high}
        for name, each in (
            ("deciding temperature [K]", found.decisive_temperature),
            ("distance [K]", found.distance),
            ("critical velocity [m/s]", found.critical_velocity),
            ("critical load [N]", found.critical_load),
        )
        if each is not None
    ]
    lines = [*_on_intervals(found), *notes(ensemble, measured)]
    show(options, document, lines, warned=pipeline.warned(ds), out=out, rows=rows)
    return DONE


def _of_points(options: argparse.Namespace) -> int:
    """Print the distances of a table of operating points."""
    if given(options, "load", "velocity", "scatter") or options.given_measured:
        raise InputError("--points stands alone, without --load, --velocity or --given-measured")
    out = table_path(options)
    ds, conditions = opened(options), given(options, *CONDITIONS)
    if "sample" in ds.dims:
        raise InputError(
            "--points takes no sweep with samples: give each operating point alone, as --load and "
            "--velocity, here or to irg risk"
        )
    points = OperatingPoints.read(options.points)
    table = pipeline.margin_table(ds, points, **conditions)
    verdicts = Counter(table.as_dict()["verdict"])
    counts = ", ".join(f"{number} {verdict}" for verdict, number in sorted(verdicts.items()))
    text = [f"{counted(len(table.rows), 'operating point', 'operating points')}: {counts}"]
    notes = table.as_dict()["note"]
    if out is None:
        text += ["", *table.without(_ONLY_IN_FILES).without_empty().lines()]
    text += [
        f"{place.load:g} N at {place.velocity:g} m/s: {note}"
        for place, note in zip(points.places, notes, strict=True)
        if note
    ]
    document = {"verdicts": verdicts, "margins": table.as_dict()}
    warned = pipeline.warned(ds, **conditions)
    show(options, document, text, warned=warned, out=out, tables=[table])
    return DONE


def _command(
    options: argparse.Namespace,
    ds: xr.Dataset,
    conditions: dict[str, Any],
    found: Sequence[Margin],
) -> str | None:
    """The command that computes transitions beyond what was computed; None where there are none."""
    from pipeline.analysis.attributes import attributes_of  # with xarray
    from pipeline.analysis.conditions import conditions_of
    from pipeline.analysis.dataset import asked
    from pipeline.analysis.transition import BEYOND, OUTCOMES, command_of

    beyond = {OUTCOMES[each] for each in BEYOND}
    if not any(beyond & {each.velocity_outcome, each.load_outcome} for each in found):
        return None
    is_pending = bool((asked(ds) & (ds["status"] == PENDING)).any())
    judged = conditions_of(ds, **conditions).as_dict()
    return command_of(options.store, attributes_of(ds), judged, is_pending)


def _on_intervals(found: MarginIntervals) -> Iterator[str]:
    """Say how an operating point stands where inputs are not known exactly."""
    at = found.risk
    yield (
        f"{at.load:g} N at {at.velocity:g} m/s: severe wear with a probability of "
        f"{at.probability:.3g} ± {at.error:.2g}"
    )
    yield f"{'':24}{'in the middle':>16}   in 90 % of cases"
    at_velocity, at_load = found.velocity_range, found.load_range
    for name, unit, interval, told in (
        ("deciding temperature", "°C", found.decisive_temperature, lambda v: f"{v - 273.15:.4g}"),
        ("below the critical one", "K", found.distance, lambda v: f"{v:.1f}"),
        ("in velocity", "times", found.critical_velocity, _factor(at.velocity, at_velocity)),
        ("in load", "times", found.critical_load, _factor(at.load, at_load)),
    ):
        if interval is not None:
            low, middle, high = map(told, (interval.low, interval.middle, interval.high))
            yield f"  {name:22}{middle:>16}   {low} to {high} {unit}"


def _factor(own: float, ends: tuple[float, float]) -> Callable[[float], str]:
    """Writer of a critical value as a multiple of the point's; beyond the sweep of its end."""

    def told(value: float) -> str:
        if not 0 < value < np.inf:
            return f"> {ends[1] / own:.3g}" if value else f"< {ends[0] / own:.3g}"
        return f"{value / own:.3g}"

    return told


def _on_one(found: Margin) -> Iterator[str]:
    """Say how one surface stands."""
    from pipeline.analysis.transition import in_words  # with xarray

    verdict = "severe wear" if found.is_severe else "mild wear"
    unsure = {True: "", False: ", but within the error", None: ""}[found.is_certain]
    yield f"{found.load:g} N at {found.velocity:g} m/s: {verdict}{unsure}"
    yield (
        f"  deciding temperature  {pipeline.display(found.decisive_temperature, '°C', 4)}"
        f"{_error(found)}"
    )
    side = "above" if found.is_severe else "below"
    critical = pipeline.display(found.critical_temperature, "°C", 4)
    yield f"  distance              {abs(found.distance):.1f} K {side} {critical}"
    for name, unit, factor, critical_value, outcome, ends in (
        (
            "velocity", "m/s", found.velocity_factor, found.critical_velocity,
            found.velocity_outcome, found.velocity_range,
        ),
        (
            "load", "N", found.load_factor, found.critical_load,
            found.load_outcome, found.load_range,
        ),
    ):  # fmt: skip
        way = (
            f"{factor:.3g} times, severe from {critical_value:.4g} {unit} on"
            if outcome == "crosses"
            else in_words(outcome, ends, name)
        )
        yield f"  in {name:<19}{way}"


def _error(found: Margin) -> str:
    error = found.temperature_error
    if found.is_continued:
        margin = "" if error is None else f" ± {error:.2g} K"
        return f"{margin}, continued as a power of the velocity beyond the computed points"
    if error == 0:
        return ", at a point of the sweep"
    if error is None:
        return ", from too few points about it to tell its error"
    return f" ± {error:.2g} K, interpolated between points of the sweep"


def _kind(found: Sequence[Margin]) -> str:
    """Kind of the several margins."""
    return "surfaces" if found[0].sample is None else "samples"


def _document(found: Sequence[Margin]) -> dict[str, Any]:
    """Plain data on several surfaces."""
    return {
        "load": found[0].load,
        "velocity": found[0].velocity,
        f"severe_{_kind(found)}": sum(each.is_severe for each in found),
        _kind(found): [each.as_dict() for each in found],
    }


def _on_several(found: Sequence[Margin]) -> Iterator[str]:
    """Say how several surfaces stand: the median, and the range without a tenth at either end."""
    from pipeline.analysis.band import BAND  # with xarray

    severe = sum(each.is_severe for each in found)
    yield (
        f"{found[0].load:g} N at {found[0].velocity:g} m/s: severe wear on {severe} of "
        f"{len(found)} {_kind(found)}"
    )
    low, middle, high = np.quantile([each.decisive_temperature - 273.15 for each in found], BAND)
    yield f"  deciding temperature  {middle:.4g} °C, on 80 % of them {low:.4g} to {high:.4g} °C"
    criticals = {each.critical_temperature for each in found}
    critical = "the critical temperature of each"
    if len(criticals) == 1:
        critical = pipeline.display(criticals.pop(), "°C", 4)
    low, middle, high = np.quantile([each.distance for each in found], BAND)
    yield (
        f"  distance              {middle:.1f} K below {critical}, on 80 % of them {low:.1f} to "
        f"{high:.1f} K"
    )
    for name, factors, outcomes in (
        ("velocity", [m.velocity_factor for m in found], [m.velocity_outcome for m in found]),
        ("load", [m.load_factor for m in found], [m.load_outcome for m in found]),
    ):
        if set(outcomes) == {"crosses"}:
            low, middle, high = np.quantile(factors, BAND)
            yield f"  in {name:<19}{middle:.3g} times, {low:.3g} to {high:.3g}"
        else:
            counts = {what: outcomes.count(what) for what in sorted(set(outcomes))}
            told = ", ".join(
                f"{number} {'cross' if what == 'crosses' else what}"
                for what, number in counts.items()
            )
            yield f"  in {name:<19}of {len(found)} {_kind(found)} {told}"
