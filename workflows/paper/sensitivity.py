"""What the agreement rests on: the lateral structure of the roughness, which is not published."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Sweep
from tribo import InputError, SelfAffineRoughness
from workflows.paper.printed import TABLE_4
from workflows.paper.report import Finding, Report, Table, statistics
from workflows.paper.study import Study, end_of

LENGTHS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0)  # µm
LAYS = ((1.0, 1.0), (1.0, 4.0), (4.0, 1.0))  # factors on the length along x and along y
HURST = (0.5, 0.65, 0.8, 1.0)
RAS = (0.15, 0.2)  # µm, beside the scene's own
SMOOTHER = (0.2, 12.0)  # Ra and correlation length that fit the unworn widths and the shares [µm]
_SMOOTHER = f"{SMOOTHER[0]:g} µm, length {SMOOTHER[1]:g} µm"
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
    sweep = study.scene("irg_transition")
    own = sweep.roughness
    if not isinstance(own, SelfAffineRoughness):
        raise InputError(f"the scene {sweep.name} must have a random surface, as in Table 4")
    base = own.correlation_length[0] * 1e6
    kinds = _kinds(own)
    names = {
        rough: f"{kind} {name}"
        for kind, variants in kinds.items()
        for name, rough in variants.items()
    }
    known = {
        rough: _outcome(study, replace(sweep, roughness=rough))
        for rough in study.each(names, names.__getitem__)
    }
    found = {
        kind: {name: known[rough] for name, rough in variants.items()}
        for kind, variants in kinds.items()
    }
    widths = {
        name: _unworn_widths(study, replace(sweep, roughness=rough))
        for name, rough in study.each(kinds["Ra"].items(), lambda item: f"unworn, Ra {item[0]}")
    }
    return Report(
        name="sensitivity",
        title=f"to the structure of the roughness, over {len(study.seeds(_SURFACES))} surfaces",
        table=_table(sweep, found, widths),
        findings=(
            _on_velocities(found, known[own], base),
            _on_ra(found["Ra"], widths, f"{own.ra * 1e6:g} µm"),
        ),
        notes=(
            f"Ra is {own.ra * 1e6:g} µm where nothing else is said. The scene has a correlation "
            f"length of {base:g} µm, no lay and a Hurst exponent of {own.hurst_exponent:g}, all "
            "our choice. What the highest temperatures disagree in is counted in table4.",
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
        }
        | {"unworn_width_um": widths},
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
        "Ra": {
            f"{1e6 * ra:g} µm": replace(own, ra=ra) for ra in (*(1e-6 * ra for ra in RAS), own.ra)
        }
        | {_SMOOTHER: replace(of_lengths(SMOOTHER[1], SMOOTHER[1]), ra=1e-6 * SMOOTHER[0])},
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


def _on_ra(row: Mapping[str, _Outcome], widths: Mapping[str, list[float]], own: str) -> Finding:
    """What the unworn contact widths say of the Ra of the patch."""
    off = {name: _width_off(values) for name, values in widths.items()}
    of_length = {name: value for name, value in off.items() if name != _SMOOTHER}
    nearest = min(of_length, key=lambda name: abs(of_length[name]))
    velocities = ", ".join(f"{100 * statistics(column)[0]:+.0f}" for column in row[_SMOOTHER].off)
    return Finding(
        f"unworn contact widths of 186, 171, 153, 129 µm with a Ra of {own}",
        ", ".join(f"{100 * value:+.0f} % with {name}" for name, value in of_length.items())
        + f" on average, between the outermost elements in contact: {nearest} comes nearest",
        nearest == own,
        "A patch of 0.4 mm holds only the shorter waves of a surface, and so less than the Ra that "
        f"a longer profile has. With {_SMOOTHER}, which gives the widths to "
        f"{100 * off[_SMOOTHER]:+.0f} %, the velocities are {velocities} % off: to choose it "
        "would be a fit to the table.",
    )


def _width_off(widths: Sequence[float]) -> float:
    """Relative error of the unworn widths [µm], averaged over the transitions."""
    pairs = zip(widths, TABLE_4, strict=True)
    return sum(width / (1e6 * row.unworn_width) - 1 for width, row in pairs) / len(TABLE_4)


def _worst(outcome: _Outcome) -> float:
    """Largest relative error of a critical velocity, each averaged over the surfaces."""
    return max(abs(statistics(column)[0]) for column in outcome.off)


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


def _unworn_widths(study: Study, sweep: Sweep) -> list[float]:
    """Width of the unworn contact at each transition, averaged over the surfaces [µm]."""
    unworn = replace(sweep, wear=None)
    surfaces = [unworn.on_surface(seed) for seed in study.seeds(_SURFACES)]
    return [
        1e6 * sum(end_of(s, F, V).contact_width for s in surfaces) / len(surfaces)
        for F, V in ((entry.normal_load, entry.velocity) for entry in sweep.measured)
    ]


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


def _table(sweep: Sweep, found: _Found, widths: Mapping[str, list[float]]) -> Table:
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
                    f"{100 * _width_off(widths[name]):+.0f} %" if kind == "Ra" else "",
                )
            )
    return Table(
        (
            "",
            f"on {100 * sweep.conditions.failing_share:g} % [°C]",
            "highest [°C]",
            *(f"velocity at {entry.normal_load:g} N" for entry in sweep.measured),
            "unworn width",
        ),
        tuple(rows),
    )


@in_house_style
def _draw(sweep: Sweep, found: _Found) -> Figure:
    figure = Figure(figsize=(12.4, 6.4))
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
        names = [name.replace(", length ", "\n") for name in variants]
        lower.set_xticks(range(len(variants)), names)
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
