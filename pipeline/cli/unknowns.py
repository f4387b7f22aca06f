"""The commands on inputs that are not known exactly: risk, sensitivity, what measurements say."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import pipeline
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import counted, output_path, show, table_path
from pipeline.cli.progress import working
from pipeline.cli.scenes import given
from tribo import InputError

if TYPE_CHECKING:
    import xarray as xr

    from pipeline.uncertain.answers import Risk
    from pipeline.uncertain.ensemble import Ensemble
    from pipeline.uncertain.sensitivity import Sensitivity
    from pipeline.uncertain.weigh import Judged, Posterior


_SHOWN = 12  # candidates
_GOOD = 0.3  # of the spread of a velocity, which its error may be


def risk(options: argparse.Namespace) -> int:
    """Print the probability of severe wear at a point, or draw it over the plane."""
    if (options.load is None) != (options.velocity is None):
        raise InputError("give --load and --velocity, or neither for the whole plane")
    out, ds = output_path(options), pipeline.open_sweep(options.store)
    ensemble, found = samples_of(options, ds)
    draws = found.draws if found else None
    document: dict[str, Any] = {"given_measured": found is not None, **_about(ensemble)}
    figure: dict[str, Any] = {}
    text = list(notes(ensemble, found))
    if options.load is not None:
        with working("finding the probability"):
            at = pipeline.risk(ensemble, options.load, options.velocity, draws)
        document |= at.as_dict()
        text = [
            f"{at.load:g} N at {at.velocity:g} m/s: severe wear with a probability of "
            f"{at.probability:.3g} ± {at.error:.2g}",
            *text,
            f"  emulated by {at.samples} samples, whose rise errs by {100 * at.rise_error:.2g} %; "
            "the error of the probability has it in",
            *_if_given(ensemble, at, found),
        ]
    if options.load is None or out:
        with working("finding probabilities over the plane"):
            plane = pipeline.probabilities(ensemble, draws)
            at_loads = pipeline.probabilities(ensemble, draws, loads=ensemble.loads)
        place = given(options, "load", "velocity")
        document |= _lines(at_loads)
        text += [] if place else _table(at_loads)
        figure["out"] = out or _beside(options.store, "risk")
        figure["rows"] = _cells(plane)
        figure["draw"] = partial(pipeline.draw_risk, ensemble, plane, place, found)
    show(options, document, text, warned=pipeline.warned(ds), **figure)
    return DONE


def _if_given(ensemble: Ensemble, at: Risk, found: Posterior | None) -> Iterator[str]:
    """Line on the probability that the scene's own tests would give."""
    if found is not None or not (ensemble.measured or ensemble.tested):
        return
    with suppress(InputError), working("weighing the inputs by the tests"):
        weighed = pipeline.posterior(ensemble)
        after = pipeline.risk(ensemble, at.load, at.velocity, weighed.draws)
        yield (
            f"next: given the scene's {_tests(weighed)} it is {after.probability:.2g}: "
            "add --given-measured"
        )


def sensitivity(options: argparse.Namespace) -> int:
    """Print and draw which input moves the boundary how much."""
    out, ds = output_path(options), pipeline.open_sweep(options.store)
    ensemble, found = samples_of(options, ds)
    with working("finding Sobol' indices"):
        indices = pipeline.sensitivity(ensemble, found.draws if found else None)
    draw = partial(pipeline.draw_sensitivity, indices, ensemble.title)
    most = indices.unknown[int(np.argmax(indices.first.mean(axis=0)))]
    target = "" if most.kind == "list" else f" --for {most.path}"
    text = [
        *notes(ensemble, found),
        *_indices(indices),
        f"next: {most.path} moves the boundary most; tests to make: irg infer {options.store} "
        f"--next{target}",
    ]
    show(
        options, _about(ensemble) | indices.as_dict(), text,
        warned=pipeline.warned(ds), out=out, rows=_index_rows(indices), draw=draw,
    )  # fmt: skip
    return DONE


def posterior(options: argparse.Namespace, stores: Sequence[Path]) -> int:
    """Print and draw the inputs as the tests leave them, and the tests to make next."""
    out = output_path(options)
    with working("reading samples"):
        datasets = [pipeline.open_sweep(store) for store in stores]
        ensembles = [_ensemble(*each) for each in zip(stores, datasets, strict=True)]
    with working("weighing the inputs by the tests"):
        found = pipeline.posterior(ensembles, **given(options, "scatter"))
    document: dict[str, Any] = found.as_dict()
    text = [*_on_inputs(found)]
    if options.next is not None:
        with working("ranking tests"):
            document["next"], lines = _next(options, found)
        text += lines
    elif options.target or options.bulk_temperature:
        name = "--for" if options.target else "--bulk-temperature"
        raise InputError(f"{name} belongs to --next, which is not given")
    else:
        text.append(f"next: the test that tells most: irg infer {stores[0]} --next")
    show(
        options, document, text,
        warned=pipeline.warned(datasets[0]),
        out=out,
        rows=map(_flat, found.summary()),
        draw=partial(pipeline.draw_posterior, found),
    )  # fmt: skip
    return DONE


def _ensemble(store: Path, ds: xr.Dataset) -> Ensemble:
    """Samples of one store among several, which an error names."""
    try:
        return pipeline.Ensemble.of(ds)
    except InputError as error:
        raise InputError(f"{store}: {error}") from error


def _next(options: argparse.Namespace, found: Posterior) -> tuple[list[dict[str, Any]], list[str]]:
    """Measurements ranked for a target, or a batch of tests, as plain data and as text."""
    about = {"target": options.target, "bulk_temperatures": options.bulk_temperature or ()}
    if options.next > 1:
        ranked = pipeline.batch(found, options.next, **about)
        head = f"{options.next} tests to make next, each beside those before it"
    else:
        ranked = pipeline.candidates(found, **about)[:_SHOWN]
        head = "measurements to make next, the best first"
    unknown = {each.path: each for each in found.unknown}.get(options.target or "")

    def shown(spread: float) -> str:
        if unknown is None or unknown.is_relative:
            return f"± {100 * spread:.2g} %"
        return f"± {unknown.spread.of(spread):.2g}{unknown.spread.suffix}"

    target = options.target or "the boundary, in velocity"
    lines = [f"{head}; {target} is known to {shown(ranked[0].before)} today"]
    lines += [
        f"  to {shown(each.spread):10} (by {100 * each.narrows:.0f} %)  {each.what}"
        for each in ranked
    ]
    rows = [
        {"what": each.what, "test": each.test, "spread": each.spread, "narrows": each.narrows}
        for each in ranked
    ]
    return rows, lines


def samples_of(options: argparse.Namespace, ds: Any) -> tuple[Ensemble, Posterior | None]:
    """The samples of a sweep, and what measurements say of them if that is to count."""
    from pipeline.uncertain.weigh import posterior_if_given  # with its libraries

    with working("reading samples"):
        ensemble = pipeline.Ensemble.of(ds)
    with working("weighing the inputs by what was measured"):
        return ensemble, posterior_if_given(ensemble, options.given_measured, options.scatter)


def _about(ensemble: Ensemble) -> dict[str, Any]:
    return {
        "samples": len(ensemble.inputs),
        "samples_left_out": ensemble.missing,
        "unknown": [each.as_dict() for each in ensemble.unknown],
    }


def notes(ensemble: Ensemble, found: Posterior | None) -> Iterator[str]:
    """Say on what the numbers rest."""
    what = "as the scene assumes them"
    if found:
        what = f"given {_tests(found)}, {_scattered(found)}"
    yield f"  {counted(len(ensemble.unknown), 'unknown input', 'unknown inputs')}, {what}"
    if found:
        yield from on_draws(found)
    if ensemble.missing:
        yield f"  {ensemble.missing} samples are left out: not done at every load"


def on_draws(found: Posterior) -> Iterator[str]:
    """Number of draws that the numbers rest on, in words."""
    effective, count = found.draws.effective, len(found.draws.weights)
    yield f"  effective sample size {effective:.0f} of {count}"


def _beside(store: Path | str, kind: str) -> Path:
    """File of a figure if none is named."""
    path = store if isinstance(store, Path) else Path(Path(store).name)
    return path.with_name(f"{path.stem}_{kind}.png")


def _cells(plane: Any) -> Iterator[dict[str, Any]]:
    """Rows of a table with the probability over the plane."""
    for load, row in zip(plane["load"].values.tolist(), plane.values.tolist(), strict=True):
        for velocity, probability in zip(plane["velocity"].values.tolist(), row, strict=True):
            yield {"load [N]": load, "velocity [m/s]": velocity, "probability": probability}


def _index_rows(found: Sensitivity) -> Iterator[dict[str, Any]]:
    """Rows of a table with Sobol' indices."""
    for i, load in enumerate(found.loads):
        for k, each in enumerate(found.unknown):
            yield {
                "load [N]": load,
                "input": each.path,
                "first": float(found.first[i, k]),
                "total": float(found.total[i, k]),
            }


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """A row on one input, before and after."""
    return {"input": row["path"], "unit": row["unit"]} | {
        f"{word} {what}": row[name].get(what)
        for name, word in (("prior", "before"), ("posterior", "after"))
        for what in ("mean", "sd")
    }


def _lines(plane: Any) -> dict[str, Any]:
    """Velocities of some probabilities by load, as plain data."""
    shares, rows = pipeline.risk_lines(plane)
    rows = np.where((rows > 0) & np.isfinite(rows), rows, np.nan)  # null where it lies beyond
    return {
        "load": plane["load"].values.tolist(),
        "velocity_of_probability": dict(zip(map(str, shares), rows.T.tolist(), strict=True)),
    }


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def boundary_of_samples(options: argparse.Namespace, ds: Any, conditions: dict[str, Any]) -> int:
    """Print the velocities at which wear is severe with some probabilities."""
    out = table_path(options)
    ensemble, given_here = judged_by(ds, conditions)
    with working("finding probabilities at each load"):
        velocities = np.geomspace(*ensemble.velocities, 161)
        plane = pipeline.probabilities(
            ensemble, loads=ensemble.loads, velocities=velocities, conditions=given_here
        )
    shares, rows = pipeline.risk_lines(plane)
    table = [
        {"load [N]": load} | {
            f"velocity of {100 * share:g} % [m/s]": velocity if 0 < velocity < np.inf else None
            for share, velocity in zip(shares, row, strict=True)
        }
        for load, row in zip(plane["load"].values.tolist(), rows.tolist(), strict=True)
    ]  # fmt: skip
    text = [*_table(plane), *notes(ensemble, None)]
    document = _about(ensemble) | _lines(plane)
    show(options, document, text, warned=pipeline.warned(ds), out=out, rows=table)
    return DONE


def judged_by(ds: Any, conditions: dict[str, Any]) -> tuple[Ensemble, dict[str, float]]:
    """Samples of a sweep, judged by conditions that are given, and those of them by number."""
    from pipeline.analysis.conditions import conditions_of  # with xarray

    judged = conditions_of(ds, **conditions)
    frictions = conditions.get("friction")
    if isinstance(frictions, list | tuple) and len(frictions) > 1:
        raise InputError("samples are judged at one --friction at a time; give one")
    ensemble = pipeline.Ensemble.of(
        ds,
        share=judged.failing_share if "share" in conditions else None,
        criterion=conditions.get("criterion"),
    )
    names = ("friction", "bulk_temperature", "critical_temperature")
    return ensemble, {name: getattr(judged, name) for name in names if name in conditions}


def _table(plane: Any) -> Iterator[str]:
    """Velocities of some probabilities by load; beyond the sweep its end."""
    shares, rows = pipeline.risk_lines(plane)
    lowest, *_, highest = plane["velocity"].values.tolist()

    def shown(velocity: float) -> str:
        if not 0 < velocity < np.inf:
            return f"> {highest:.3g}" if velocity else f"< {lowest:.3g}"
        return f"{velocity:.3g}"

    heads = " ".join(f"{f'{100 * share:g} %':>8}" for share in shares)
    yield "velocity [m/s] at which wear is severe with a probability of"
    yield f"{'load [N]':>10} {heads}"
    for load, row in zip(plane["load"].values, rows.tolist(), strict=True):
        yield f"{load:10g} {' '.join(f'{shown(velocity):>8}' for velocity in row)}"


def _indices(found: Sensitivity) -> Iterator[str]:
    """A table for each kind of index: an input a row, a load a column."""
    heads = " ".join(f"{f'{load:g} N':>18}" for load in found.loads)
    width = max(len(each.path) for each in found.unknown) + 2
    tables = [("first index", found.first, found.first_interval)]
    if np.isfinite(found.total).all():
        tables.append(("total index", found.total, found.total_interval))
    for name, values, (low, high) in tables:
        yield f"{name:{width}} {heads}"
        for i in np.argsort(-values.mean(axis=0)):
            cells = " ".join(
                f"{f'{v:.2f} ({a:.2f}–{b:.2f})':>18}"
                for v, a, b in zip(values[:, i], low[:, i], high[:, i], strict=True)
            )
            yield f"{found.unknown[i].path:{width}} {cells}"
    if len(tables) == 1:
        yield f"no total index: {_why_dependent(found)} the inputs depend on one another"
    spreads = " ".join(f"{f'± {100 * each:.2g} %':>18}" for each in found.spread)
    yield f"{'spread of velocity':{width}} {spreads}"
    errors = " ".join(f"{f'{100 * each:.2g} %':>18}" for each in found.velocity_error)
    yield f"{'emulator errs by':{width}} {errors}"
    yield from (
        f"warning: at {load:g} N the emulated velocity errs by {100 * error:.2g} %, of a spread of "
        f"{100 * spread:.2g} %; run more samples"
        for load, error, spread in zip(found.loads, found.velocity_error, found.spread, strict=True)
        if error > _GOOD * spread
    )


def _why_dependent(found: Sensitivity) -> str:
    """Reason for no total indices, which presume that no input tells of another."""
    return "given the measurements" if found.given_measured else "as the scene correlates them,"


def _tests(found: Posterior) -> str:
    """Numbers of transitions and of tests, in words."""
    outcomes = sum("outcome" in judged.test for judged in found.judged)
    transitions = len(found.judged) - outcomes
    words = []
    if transitions or not outcomes:
        words.append(counted(transitions, "measured transition", "measured transitions"))
    if outcomes:
        words.append(counted(outcomes, "test", "tests"))
    return " and ".join(words)


def _scattered(found: Posterior) -> str:
    """Scatter of the velocities, as said and as inferred."""
    low, middle, high = (100 * value for value in found.inferred_scatter)
    said = f"velocities said to scatter by {100 * found.scatter:g} %"
    if not found.judged:
        return said
    return f"{said}: by the tests {middle:.2g} % ({low:.2g} to {high:.2g})"


def _on_inputs(found: Posterior) -> Iterator[str]:
    """Lines on each input, before and after, and on each test."""
    samples = " and ".join(str(len(sweep.inputs)) for sweep in found.ensembles)
    yield f"{_tests(found)}, {_scattered(found)}; {samples} samples"
    if len(found.ensembles) > 1:
        yield from (f"  {n}: {sweep.title}" for n, sweep in enumerate(found.ensembles, 1))
    yield from on_draws(found)
    rows = list(found.summary())
    width = max(len(row["path"]) for row in rows) + 2
    yield f"{'':{width}} {'before':>24}   {'after':>24}   {'90 % within':>22}"
    for row, each in zip(rows, found.unknown, strict=True):
        if each.kind == "list":
            odds = row["posterior"]["probability"]
            best = max(odds, key=odds.__getitem__)
            value = f"{each.shown.of(float(best)):g}{each.shown.suffix}"
            likeliest = f"{value} likeliest, {odds[best]:.2f}"
            yield f"{each.path:{width}} {f'one of {len(odds)}':>24}   {likeliest:>24}"
            continue
        shown, spread = each.shown, each.spread
        before, after = (
            f"{shown.of(row[name]['mean']):.4g} ± {spread.of(row[name]['sd']):.3g}"
            for name in ("prior", "posterior")
        )
        within = " to ".join(f"{shown.of(value):.4g}" for value in row["posterior"]["interval"])
        unit = shown.suffix if spread == shown else f"{shown.suffix}, ± in{spread.suffix}"
        yield f"{each.path:{width}} {before:>24}   {after:>24}   {within:>22}{unit}"
    yield from (
        f"{a} and {b} cannot be told apart by these tests (correlation {_signed(c)})"
        for a, b, c in found.hidden()
    )
    for judged in found.judged:
        low, middle, high = judged.critical_velocity
        yield f"{_place(found, judged)}, computed {middle:.3g} ({low:.3g} to {high:.3g})"
    yield from (
        f"warning: {_place(found, judged)}: the other tests leave this a probability of "
        f"{judged.probability:.1g}; look at the test, or leave it out"
        for judged in found.judged
        if judged.contradicts
    )


def _place(found: Posterior, judged: Judged) -> str:
    """Test, in words."""
    test = judged.test
    words = [f"{judged.sweep + 1}: at" if len(found.ensembles) > 1 else "at"]
    words.append(f"{test['normal_load']:g} N")
    if "bulk_temperature" in test:
        words.append(f"and a bulk of {pipeline.display(test['bulk_temperature'], '°C')}")
    outcome = test.get("outcome")
    velocity = f"{test['velocity']:g} m/s"
    words.append(f"{outcome} at {velocity}" if outcome else f"measured {velocity}")
    return " ".join(words)
