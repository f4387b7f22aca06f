"""What simpler criteria say at the measured transitions, beside the temperature of this model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.model import Measurement, Sweep
from pipeline.sweep.rivals import SmoothContact, load_speed_exponent
from tribo import InputError, lubrication_regime
from workflows.paper.ensemble import matching, name_of, range_of
from workflows.paper.printed import TABLE_4
from workflows.paper.report import Finding, Report, Table
from workflows.paper.study import Study, end_of

_SURFACES = 4
_STEP = 0.05  # of the logarithm of the velocity, to find an exponent
_LOOKS = {"ours": BLUE, "blok": VERMILION, "power": GREEN, "pv": GREY, "load": BLACK}


class _Criterion(NamedTuple):
    """A number at each measured transition, which would be the same at all were it what decides."""

    name: str
    unit: str
    values: list[float]  # at the measured friction
    alike: list[float]  # at the scene's friction everywhere
    exponents: list[float]  # of the number over the velocity
    shown: list[float]  # values in the unit, bulk temperature added where it is a rise
    fitted: bool = False  # whether it has a parameter fitted to these very transitions

    @property
    def spread(self) -> float:
        """Highest over lowest value, less one."""
        return max(self.values) / min(self.values) - 1

    @property
    def worst(self) -> float:
        """Largest relative error of a velocity, if the mean value were the limit."""
        return max(map(abs, _off(self.values, self.exponents)))

    @property
    def worst_alike(self) -> float:
        """The same where the friction is not known at each transition."""
        return max(map(abs, _off(self.alike, self.exponents)))


def _off(
    values: Sequence[float], exponents: Sequence[float], limit: float | None = None
) -> list[float]:
    """Relative errors of the velocities at which a number is at a limit, its mean if not given."""
    level = math.exp(float(np.mean(np.log(values)))) if limit is None else limit
    return [(level / value) ** (1 / n) - 1 for value, n in zip(values, exponents, strict=True)]


@dataclass(frozen=True, slots=True)
class _Computed:
    """All criteria at the measured transitions."""

    sweep: Sweep
    measured: Sequence[Measurement]
    criteria: dict[str, _Criterion]
    film: list[float] | None  # film parameters; None where the scene gives no oil
    exponents: tuple[float, float]  # n of F·Vⁿ along the measured line, and along ours

    @property
    def limit(self) -> float:
        """Rise at which the critical temperature is reached [K]."""
        conditions = self.sweep.conditions
        return conditions.known_critical_temperature() - conditions.bulk_temperature


def rivals(study: Study) -> Report:
    """Blok's flash temperature, power, PV and F·Vⁿ at the four transitions, and the film."""
    found = _computed(study)
    data = {
        key: {
            "unit": each.unit,
            "values": each.shown,
            "spread": each.spread,
            "worst_velocity_error": each.worst,
            "worst_velocity_error_at_one_friction": each.worst_alike,
        }
        for key, each in found.criteria.items()
    }
    return Report(
        name="rivals",
        title="what simpler criteria say at the measured transitions",
        table=_table(found),
        findings=(_on_blok(found), _on_constancy(found), *_on_film(found)),
        notes=(
            "A criterion is constant along the measured line if it decides. The last two columns "
            "make them comparable: by how much a velocity would be off at worst if the criterion's "
            "own mean were the limit, at the measured frictions and at one friction for all. "
            "Worn: of the measured contact widths, which include sliding at full load.",
            "The scuffing temperatures of the gear standards are left out: that of ISO/TS 6336-20 "
            "follows from an FZG test of the oil, which is not published for this one, and the "
            "constants of AGMA 925 could not be traced to the standard itself.",
        ),
        data={
            "load": [entry.normal_load for entry in found.measured],
            "criteria": data,
            "film_parameter": found.film,
            "load_speed_exponent": {"measured": found.exponents[0], "computed": found.exponents[1]},
        },
        figure=_draw(found),
    )


@dataclass(frozen=True, slots=True)
class _Line:
    """The measured line, on which every criterion is evaluated."""

    loads: list[float]  # [N]
    velocities: list[float]  # [m/s]
    own: list[float]  # friction at each transition
    friction: float  # of the scene
    bulk: float  # [°C]

    def of_friction(
        self,
        name: str,
        unit: str,
        values: Sequence[float],
        exponents: list[float],
        scale: float = 1.0,
    ) -> _Criterion:
        """A criterion in proportion to friction, from its values at friction 1."""
        own = [mu * value for mu, value in zip(self.own, values, strict=True)]
        alike = [self.friction * value for value in values]
        base = self.bulk if unit == "°C" else 0.0
        return _Criterion(name, unit, own, alike, exponents, [base + scale * v for v in own])

    def of_motion(
        self, name: str, unit: str, values: list[float], n: float = 1.0, scale: float = 1.0
    ) -> _Criterion:
        """A criterion that friction does not enter, in proportion to a power of the velocity."""
        shown = [scale * value for value in values]
        return _Criterion(name, unit, values, values, [n] * len(values), shown)


def _computed(study: Study) -> _Computed:
    sweep = study.scene("irg_transition")
    measured = matching(sweep, [row.normal_load for row in TABLE_4])
    conditions = sweep.conditions
    line = _Line(
        [entry.normal_load for entry in measured],
        [entry.velocity for entry in measured],
        [entry.friction or conditions.friction for entry in measured],
        conditions.friction,
        float(celsius(conditions.bulk_temperature)),
    )
    rises, exponents, critical = _simulated(study, sweep, measured)
    ours = line.of_friction(
        f"exceeded on {100 * conditions.failing_share:g} % of the contact", "°C", rises, exponents
    )
    lubrication = Lubrication.of(sweep)
    return _Computed(
        sweep=sweep,
        measured=measured,
        criteria={"ours": ours, **_simple(line, SmoothContact.of(sweep))},
        film=None
        if lubrication is None
        else lubrication.film_parameter(
            line.loads, line.velocities, conditions.bulk_temperature
        ).tolist(),
        exponents=(
            load_speed_exponent(line.loads, line.velocities),
            load_speed_exponent(line.loads, critical),
        ),
    )


def _simple(line: _Line, contact: SmoothContact) -> dict[str, _Criterion]:
    """The criteria that need no simulation; worn ones have the measured width."""
    halves, ones = [0.5] * len(line.loads), [1.0] * len(line.loads)
    power = [F * V for F, V in zip(line.loads, line.velocities, strict=True)]
    widths = {
        "unworn": [contact.width(load) for load in line.loads],
        "worn": [row.measured_width for row in TABLE_4],
    }
    found: dict[str, _Criterion] = {"power": line.of_friction("friction power", "W", power, ones)}
    for state, across in widths.items():
        points = list(zip(line.loads, line.velocities, across, strict=True))
        rises = [contact.flash_rise(F, V, 1.0, width) for F, V, width in points]
        density = [F * V / contact.area(F, width) for F, V, width in points]
        found |= {
            f"blok_{state}": line.of_friction(f"Blok, smooth, {state}", "°C", rises, halves),
            f"power_per_area_{state}": line.of_friction(
                f"power per {state} area", "W/mm²", density, ones, 1e-6
            ),
            f"pv_{state}": line.of_motion(f"PV, {state}", "GPa m/s", density, scale=1e-9),
        }
    n = load_speed_exponent(line.loads, line.velocities)
    together = [F * V**n for F, V in zip(line.loads, line.velocities, strict=True)]
    fitted = line.of_motion(f"F·Vⁿ, n = {n:.2f} fitted here", "N (m/s)ⁿ", together, n)
    return found | {"load_speed": fitted._replace(fitted=True)}


def _simulated(
    study: Study, sweep: Sweep, measured: Sequence[Measurement]
) -> tuple[list[float], list[float], list[float]]:
    """Deciding rise at friction 1, its exponent over velocity, and critical velocity.

    Each is the mean over the surfaces, by transition; the velocity is at the scene's friction.
    """
    conditions, limit = sweep.conditions, rise_limit(sweep.conditions)
    if sweep.wear is None:
        raise InputError(f"the scene {sweep.name} must have a [wear]")
    found = np.empty((3, len(measured), len(study.seeds(_SURFACES))))
    for surface, seed in enumerate(study.seeds(_SURFACES)):
        study.tell(f"surface {surface + 1} of {found.shape[2]}")
        scene = replace(sweep, store_fields=False).on_surface(seed)
        for number, entry in enumerate(measured):
            V, faster = entry.velocity, entry.velocity * math.exp(_STEP)
            rise, higher = (
                end_of(scene, entry.normal_load, at).decisive_rise(conditions) for at in (V, faster)
            )
            exponent = math.log(higher / rise) / _STEP
            critical = V * (1 + boundary_velocity_error(rise, limit, exponent))
            found[:, number, surface] = rise, exponent, critical
    rises, exponents, velocities = found.mean(axis=2).tolist()
    return rises, exponents, velocities


def _table(found: _Computed) -> Table:
    rows = []
    for each in found.criteria.values():
        digits = 0 if min(each.shown) >= 10 else 2
        rows.append(
            (
                f"{each.name} [{each.unit}]",
                *(f"{value:.{digits}f}" for value in each.shown),
                f"{100 * each.spread:.0f} %",
                f"{100 * each.worst:.0f} %",
                f"{100 * each.worst_alike:.0f} %",
            )
        )
    if found.film:
        bulk = celsius(found.sweep.conditions.bulk_temperature)
        film = (f"{value:.2f}" for value in found.film)
        rows.append((f"film parameter Λ at {bulk:g} °C", *film, "", "", ""))
    return Table(
        (
            "",
            *(name_of(entry) for entry in found.measured),
            "highest over lowest",
            "velocity off",
            f"at friction {found.sweep.conditions.friction:g}",
        ),
        tuple(rows),
    )


def _on_blok(found: _Computed) -> Finding:
    ours, unworn, worn = (found.criteria[key] for key in ("ours", "blok_unworn", "blok_worn"))
    off = {
        name: [100 * value for value in _off(each.values, each.exponents, found.limit)]
        for name, each in (("unworn", unworn), ("worn", worn), ("ours", ours))
    }
    return Finding(
        "Blok did not find one critical temperature, for want of a detailed thermal model",
        f"his flash temperature of the smooth contact is {range_of(unworn.shown)} °C along the "
        f"measured line if unworn, {range_of(worn.shown)} °C if worn as measured; exceeded on "
        f"{100 * found.sweep.conditions.failing_share:g} % of the rough one are "
        f"{range_of(ours.shown)} °C",
        ours.spread < min(unworn.spread, worn.spread),
        f"With the critical temperature, {found.limit:.0f} K above the bulk, as the limit, and "
        "the measured friction, the velocities are "
        f"{min(off['unworn']):+.0f} to {max(off['unworn']):+.0f} % off by the one, "
        f"{min(off['worn']):+.0f} to {max(off['worn']):+.0f} % by the other, "
        f"{min(off['ours']):+.0f} to {max(off['ours']):+.0f} % by this model.",
    )


def _on_constancy(found: _Computed) -> Finding:
    ours = found.criteria["ours"]
    others = [each for each in found.criteria.values() if each is not ours and not each.fitted]
    best = min(others, key=lambda each: each.spread)
    nearer = {each.name: each.worst for each in others if each.worst < ours.worst}
    nearer_alike = {
        each.name: each.worst_alike for each in others if each.worst_alike < ours.worst_alike
    }
    measured, computed = found.exponents
    return Finding(
        "the transition is thermal: a temperature decides, and is the same along the line",
        f"highest over lowest is {100 * ours.spread:.0f} % for the rise exceeded on "
        f"{100 * found.sweep.conditions.failing_share:g} % of the contact; the most constant of "
        f"the simple criteria, the {best.name}, has {100 * best.spread:.0f} %",
        ours.spread < best.spread,
        f"As errors of a velocity, nearer than ours ({100 * ours.worst:.0f} %) at the measured "
        f"frictions: {_names(nearer)}; at one friction ({100 * ours.worst_alike:.0f} %): "
        f"{_names(nearer_alike)}. A rise grows with about the root of the velocity, so that "
        "a small error of it is twice as large in velocity. The measured line is one of constant "
        f"F·Vⁿ with n = {measured:.2f}, the computed one with {computed:.2f}; smooth line contacts "
        "have ½ worn and ⅔ unworn by Blok's temperature, 1 by friction power.",
    )


def _names(errors: Mapping[str, float]) -> str:
    """Criteria, each with its error of a velocity."""
    return ", ".join(f"{name} ({100 * error:.0f} %)" for name, error in errors.items()) or "none"


def _on_film(found: _Computed) -> tuple[Finding, ...]:
    if found.film is None:
        return ()
    highest = found.measured[int(np.argmax(found.film))]
    regimes = dict.fromkeys(map(lubrication_regime, sorted(found.film)))
    return (
        Finding(
            "the contacts are boundary lubricated",
            f"film parameters of {range_of(found.film, 2)}: {', '.join(regimes)}",
            set(regimes) == {"boundary lubrication"},
            f"It is highest at {name_of(highest)}. The film is that of Dowson & Higginson at the "
            "bulk temperature, with the pin's radius before wear; the pressure coefficient of the "
            "oil is not published, and chosen in the scene.",
        ),
    )


@in_house_style
def _draw(found: _Computed) -> Figure:
    figure = Figure(figsize=(8.4, 4.6))
    axes = figure.subplots()
    at = np.arange(len(found.measured))
    for number, (key, each) in enumerate(found.criteria.items()):
        values = np.array(each.values)
        is_ours = key == "ours"
        axes.plot(
            at,
            values / math.exp(float(np.mean(np.log(values)))),
            marker="os^vDdPXp"[number % 9],
            color=_LOOKS[key.split("_")[0]],
            lw=2.4 if is_ours else 1.1,
            ls="-" if is_ours else ":" if key.endswith("_worn") else "--",
            zorder=3 if is_ours else 2,
            label=each.name,
        )
    axes.axhline(1, color=BLACK, lw=0.8)
    axes.set_xticks(at, [name_of(entry) for entry in found.measured])
    axes.set_xlim(-0.3, len(at) - 0.7)
    axes.set_ylabel("over its mean along the line")
    axes.set_title("criteria along the measured line; rises are above the bulk temperature")
    figure.legend(loc="outside lower center", ncols=3)
    return figure
