"""What the agreement rests on: the lateral structure of the roughness, which is not published."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from pipeline.paper.printed import TABLE_4
from pipeline.paper.report import Finding, Report, Table, statistics
from pipeline.paper.study import Study, end_of
from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Sweep
from tribo import SelfAffineRoughness

LENGTHS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0)  # µm
LAYS = ((1.0, 1.0), (1.0, 4.0), (4.0, 1.0))  # factors on the length along x and along y
HURST = (0.5, 0.65, 0.8, 1.0)
_SURFACES = 4
_EXPONENT = 0.6  # of the rise over velocity, for a second guess
_GOOD = 0.15  # relative, of the boundary velocity


@dataclass(frozen=True, slots=True)
class _Outcome:
    """Of one kind of surface; a list over surfaces for each transition."""

    exceeded: list[list[float]]  # at the measured friction [°C]
    highest: list[list[float]]  # at the measured friction [°C]
    off: list[list[float]]  # of the critical velocity at the scene's friction, relative


_Found = Mapping[str, Mapping[str, _Outcome]]
"""Outcomes by the kind of change, and by the change."""


def sensitivity(study: Study) -> Report:
    """Temperatures at Table 4's transitions, and critical velocities, for other surfaces."""
    sweep = study.scene("irg_transition", usual_preset="standard")
    own = sweep.roughness
    if not isinstance(own, SelfAffineRoughness):
        raise TypeError("the sensitivity is to the parameters of a random surface")
    base = own.correlation_length[0] * 1e6
    known: dict[SelfAffineRoughness, _Outcome] = {}
    found = {
        kind: {
            name: _outcome_once(study, sweep, rough, f"{kind} {name}", known)
            for name, rough in variants.items()
        }
        for kind, variants in _kinds(own).items()
    }
    return Report(
        name="sensitivity",
        title=f"to the structure of the roughness, over {len(study.seeds(_SURFACES))} surfaces",
        table=_table(sweep, found),
        findings=(_on_velocities(found, known[own], base), _on_highest(found, known[own], base)),
        notes=(
            f"Ra is {own.ra * 1e6:g} µm throughout. The scene has a correlation length of "
            f"{base:g} µm, no lay and a Hurst exponent of {own.hurst_exponent:g}, all our choice.",
            "A lay is written as the correlation lengths along × across the sliding direction.",
        ),
        data={
            kind: {
                name: {
                    "exceeded_celsius": outcome.exceeded,
                    "max_celsius": outcome.highest,
                    "critical_velocity_off": outcome.off,
                }
                for name, outcome in row.items()
            }
            for kind, row in found.items()
        },
        figure=_draw(sweep, found),
    )


def _kinds(own: SelfAffineRoughness) -> dict[str, dict[str, SelfAffineRoughness]]:
    """Surfaces that differ from the scene's own in one kind of parameter, by what is changed."""
    base = own.correlation_length[0] * 1e6

    def of_lengths(along: float, across: float) -> SelfAffineRoughness:
        return replace(own, correlation_length=(along * 1e-6, across * 1e-6))

    return {
        "correlation length": {f"{length:g} µm": of_lengths(length, length) for length in LENGTHS},
        "lay": {
            f"{base * along:g} × {base * across:g} µm": of_lengths(base * along, base * across)
            for along, across in LAYS
        },
        "Hurst exponent": {f"{value:g}": replace(own, hurst_exponent=value) for value in HURST},
    }


def _on_velocities(found: _Found, own: _Outcome, base: float) -> Finding:
    lengths = {name: mean_off(outcome) for name, outcome in found["correlation length"].items()}
    shortest, *_, longest = lengths.values()
    good = [name for name, each in found["correlation length"].items() if _worst(each) < _GOOD]
    other = {
        kind: [mean_off(outcome) for outcome in found[kind].values()]
        for kind in ("lay", "Hurst exponent")
    }
    seeds = max(100 * statistics(column)[1] for column in own.off)
    return Finding(
        "the calculated transitions agree well with the measured ones",
        f"on average {100 * shortest:+.0f} % off in velocity with the shortest correlation "
        f"length to {100 * longest:+.0f} % with the longest; every transition within "
        f"{100 * _GOOD:g} % with {', '.join(good) or 'none'}",
        _worst(own) < _GOOD,
        f"The verdict is on the {base:g} µm of the scene. A lay moves it to "
        f"{_percent(other['lay'])}, another Hurst exponent to "
        f"{_percent(other['Hurst exponent'])}, another surface of the same kind by "
        f"{seeds:.1f} % (one spread).",
    )


def _on_highest(found: _Found, own: _Outcome, base: float) -> Finding:
    lengths = found["correlation length"]
    shortest, *_, longest = map(_mean, (outcome.highest for outcome in lengths.values()))
    fits = _nearest_highest(lengths)
    return Finding(
        "highest temperatures of 153 to 162 °C, 158 °C on average",
        f"{shortest:.0f} °C with the shortest correlation length to {longest:.0f} °C with "
        f"the longest, {_mean(own.highest):.0f} °C with the {base:g} µm of the scene",
        abs(_mean(own.highest) - _printed_highest()) < 5,
        f"The nearest is {fits}, with velocities {100 * mean_off(lengths[fits]):+.0f} % off: to "
        "choose it would be a fit, not a prediction.",
    )


def _worst(outcome: _Outcome) -> float:
    """Largest relative error of a critical velocity, each averaged over the surfaces."""
    return max(abs(statistics(column)[0]) for column in outcome.off)


def _outcome_once(
    study: Study,
    sweep: Sweep,
    rough: SelfAffineRoughness,
    name: str,
    known: dict[SelfAffineRoughness, _Outcome],
) -> _Outcome:
    """Simulate a kind of surface, unless its outcome is known; keep it."""
    if rough not in known:
        study.tell(name)
        known[rough] = _outcome(study, replace(sweep, roughness=rough))
    return known[rough]


def _outcome(study: Study, sweep: Sweep) -> _Outcome:
    limit = rise_limit(sweep.conditions)
    number_of = len(sweep.measured)
    outcome = _Outcome(*(_empty(number_of) for _ in range(3)))
    for seed in study.seeds(_SURFACES):
        surface = sweep.on_surface(seed)
        for number, entry in enumerate(sweep.measured):
            end = end_of(surface, entry.normal_load, entry.velocity)
            at_own_friction = sweep.conditions.changed(friction=entry.friction)
            outcome.exceeded[number].append(end.exceeded(at_own_friction))
            outcome.highest[number].append(end.highest(at_own_friction))

            rise = end.decisive_rise(sweep.conditions)
            step = math.log(limit / rise) / _EXPONENT or 0.01
            other = end_of(surface, entry.normal_load, entry.velocity * math.exp(step))
            exponent = math.log(other.decisive_rise(sweep.conditions) / rise) / step
            outcome.off[number].append(boundary_velocity_error(rise, limit, exponent))
    return outcome


def _empty(number: int) -> list[list[float]]:
    return [[] for _ in range(number)]


def mean_off(outcome: _Outcome) -> float:
    """Relative error of the critical velocity, averaged over transitions and surfaces."""
    return _mean(outcome.off)


def _mean(values: list[list[float]]) -> float:
    return float(np.mean(values))


def _percent(values: list[float]) -> str:
    return f"{100 * min(values):+.0f} to {100 * max(values):+.0f} %"


def _printed_highest() -> float:
    return sum(row.max_celsius for row in TABLE_4) / len(TABLE_4)


def _nearest_highest(row: Mapping[str, _Outcome]) -> str:
    return min(row, key=lambda name: abs(_mean(row[name].highest) - _printed_highest()))


def _table(sweep: Sweep, found: _Found) -> Table:
    rows: list[tuple[str, ...]] = []
    for kind, variants in found.items():
        rows.append((kind,))
        for name, outcome in variants.items():
            rows.append(
                (
                    f"  {name}",
                    f"{_mean(outcome.exceeded):.0f}",
                    f"{_mean(outcome.highest):.0f}",
                    *(f"{round(100 * statistics(column)[0]) + 0:+d} %" for column in outcome.off),
                )
            )
    return Table(
        (
            "",
            f"on {100 * sweep.conditions.failing_share:g} % [°C]",
            "highest [°C]",
            *(f"velocity at {entry.normal_load:g} N" for entry in sweep.measured),
        ),
        tuple(rows),
    )


@in_house_style
def _draw(sweep: Sweep, found: _Found) -> Figure:
    figure = Figure(figsize=(10.4, 6.4))
    rows = figure.subplots(2, len(found), sharex="col", sharey="row")
    critical = celsius(sweep.conditions.known_critical_temperature())
    for number, (kind, variants) in enumerate(found.items()):
        upper, lower = rows[0][number], rows[1][number]
        _line(upper, variants, lambda o: o.highest, BLUE, "highest")
        _line(upper, variants, lambda o: o.exceeded, GREEN, "exceeded on 10 %")
        upper.axhline(_printed_highest(), color=BLACK, ls="--", lw=1.2, label="printed, highest")
        upper.axhline(critical, color=GREY, ls=":", lw=1.2, label="critical")
        upper.set_title({"lay": "lay, along × across sliding"}.get(kind, kind))
        _line(lower, variants, lambda o: [[100 * v for v in c] for c in o.off], VERMILION, "")
        lower.axhline(0, color=BLACK, lw=1.0)
        lower.axhspan(-100 * _GOOD, 100 * _GOOD, color="#EEEEEE", zorder=0)
        lower.tick_params(axis="x", labelsize=9)
        lower.set_xticks(range(len(variants)), list(variants))
        lower.set_xlim(-0.4, len(variants) - 0.6)
    rows[0][0].set_ylabel("at the measured\ntransitions [°C]")
    rows[1][0].set_ylabel("critical velocity against\nthe measured one [%]")
    handles, labels = rows[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _line(
    axes: Axes,
    variants: Mapping[str, _Outcome],
    quantity: Callable[[_Outcome], list[list[float]]],
    colour: str,
    label: str,
) -> None:
    """Mean over transitions and surfaces, with the range of the transitions' own means."""
    by_transition = np.array([np.mean(quantity(outcome), axis=1) for outcome in variants.values()])
    mean = by_transition.mean(axis=1)
    axes.errorbar(
        range(len(variants)),
        mean,
        (mean - by_transition.min(axis=1), by_transition.max(axis=1) - mean),
        color=colour,
        marker="o",
        capsize=3,
        label=label,
    )
