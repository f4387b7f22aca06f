"""Simpler criteria at the measured transitions, beside the temperature of this model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.rivals import SmoothContact, load_speed_exponent
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from pipeline.store.identity import describe
from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.model import Measurement, Sweep
from tribo import lubrication_regime
from tribo.types import Array
from workflows.paper.publication import TABLE_4
from workflows.paper.report import Report, Table
from workflows.paper.study import Study
from workflows.paper.transitions import end_of, exponent_of, matching, name_of

_SURFACES = 4
_STEP = 0.05  # of the logarithm of the velocity, to find an exponent
_LOOKS = {"ours": BLUE, "blok": VERMILION, "power": GREEN, "pv": GREY, "load": BLACK}


@dataclass(frozen=True, slots=True)
class _Criterion:
    """A number at each measured transition, which would be the same at all were it what decides."""

    name: str
    unit: str
    values: Array  # at the measured friction
    alike: Array  # at the scene's friction everywhere
    exponents: Array | float  # of the number over the velocity
    scaled: Array  # values in the unit, bulk temperature added where it is a rise
    fitted: bool = False  # True if it has a parameter fitted to these very transitions

    @property
    def spread(self) -> float:
        """Highest over lowest value, less one."""
        return float(self.values.max() / self.values.min() - 1)

    @property
    def worst(self) -> float:
        """Largest relative error of a velocity, if the mean value were the limit."""
        return float(abs(_off(self.values, self.exponents)).max())

    @property
    def worst_alike(self) -> float:
        """The same where the friction is not known at each transition."""
        return float(abs(_off(self.alike, self.exponents)).max())


def _off(values: Array, exponents: Array | float, limit: float | None = None) -> Array:
    """Relative errors of the velocities at which a number is at a limit, its mean if not given."""
    level = _mean(values) if limit is None else limit
    errors: Array = (level / values) ** (1 / exponents) - 1
    return errors


def _mean(values: Array) -> float:
    """Geometric mean."""
    return math.exp(float(np.mean(np.log(values))))


@dataclass(frozen=True, slots=True)
class _Line:
    """The measured line, on which every criterion is evaluated."""

    loads: Array  # [N]
    velocities: Array  # [m/s]
    frictions: Array  # measured at each transition
    friction: float  # of the scene
    bulk: float  # [°C]

    def criterion(
        self,
        name: str,
        unit: str,
        values: Array,
        exponents: Array | float,
        scale: float = 1.0,
        by_friction: bool = True,
    ) -> _Criterion:
        """A criterion from its values, at friction 1 where it is in proportion to friction."""
        frictions, friction = (self.frictions, self.friction) if by_friction else (1.0, 1.0)
        measured = frictions * values
        scaled = (self.bulk if unit == "°C" else 0.0) + scale * measured
        return _Criterion(name, unit, measured, friction * values, exponents, scaled)


def rivals(study: Study) -> Report:
    """Blok's flash temperature, power, PV and F·Vⁿ at the four transitions, and the film."""
    sweep = study.scene("irg_transition")
    measured = matching(sweep, [row.normal_load for row in TABLE_4])
    conditions = sweep.conditions
    line = _Line(
        np.array([entry.normal_load for entry in measured]),
        np.array([entry.velocity for entry in measured]),
        np.array([entry.friction or conditions.friction for entry in measured]),
        conditions.friction,
        float(celsius(conditions.bulk_temperature)),
    )
    rises, exponents, critical = _simulated(study, sweep, measured)
    share = f"exceeded on {100 * conditions.failing_share:g} % of the contact"
    ours = line.criterion(share, "°C", rises, exponents)
    criteria = {"ours": ours, **_simple(line, SmoothContact.stored({"scene": describe(sweep)}))}
    values = {
        "share": conditions.failing_share,
        "measured_exponent": load_speed_exponent(line.loads.tolist(), line.velocities.tolist()),
        "computed_exponent": load_speed_exponent(line.loads.tolist(), critical.tolist()),
        **_against_blok(
            criteria, conditions.known_critical_temperature() - conditions.bulk_temperature
        ),
        **_constancy(criteria),
    }
    verdicts = {
        "blok": ours.spread < min(values["unworn"].spread, values["worn"].spread),
        "constancy": ours.spread < values["best"].spread,
    }
    oil, bulk = Lubrication.of(sweep), conditions.bulk_temperature
    film = oil.film_parameter(line.loads, line.velocities, bulk) if oil else None
    if film is not None:
        regimes = dict.fromkeys(map(lubrication_regime, sorted(film)))
        values |= {"film": film, "regimes": ", ".join(regimes)}
        values["place"] = name_of(measured[int(np.argmax(film))])
        verdicts["film"] = set(regimes) == {"boundary lubrication"}
    return Report.of(
        "rivals",
        values,
        verdicts=verdicts,
        table=_table(criteria, measured, film, line),
        data={
            "load": line.loads,
            "criteria": {
                key: {
                    "unit": criterion.unit,
                    "values": criterion.scaled,
                    "spread": criterion.spread,
                    "worst_velocity_error": criterion.worst,
                    "worst_velocity_error_at_one_friction": criterion.worst_alike,
                }
                for key, criterion in criteria.items()
            },
            "film_parameter": film,
            "load_speed_exponent": {
                "measured": values["measured_exponent"],
                "computed": values["computed_exponent"],
            },
        },
        figure=_draw(criteria, [name_of(entry) for entry in measured]),
    )


def _simulated(study: Study, sweep: Sweep, measured: Sequence[Measurement]) -> Array:
    """Deciding rise at friction 1, its exponent over velocity, and critical velocity.

    Means over the surfaces, shape (3, transition); the velocity is at the scene's friction.
    """
    decisive, limit = sweep.conditions.decisive, rise_limit(sweep.conditions)
    outcomes = np.empty((3, len(measured), len(study.seeds(_SURFACES))))
    for surface, seed in enumerate(study.seeds(_SURFACES)):
        study.tell(f"surface {surface + 1} of {outcomes.shape[2]}")
        scene = replace(sweep, store_fields=False).on_surface(seed)
        for number, entry in enumerate(measured):
            rise = float(end_of(scene, entry).rise(decisive))
            exponent = exponent_of(scene, entry, rise, _STEP)
            critical = entry.velocity * (1 + boundary_velocity_error(rise, limit, exponent))
            outcomes[:, number, surface] = rise, exponent, critical
    means: Array = outcomes.mean(axis=2)
    return means


def _simple(line: _Line, contact: SmoothContact) -> dict[str, _Criterion]:
    """The criteria that need no simulation; worn ones have the measured width."""
    power = line.loads * line.velocities
    widths = {
        "unworn": [contact.width(load) for load in line.loads],
        "worn": [row.measured_width for row in TABLE_4],
    }
    criteria = {"power": line.criterion("friction power", "W", power, 1.0)}
    for state, across in widths.items():
        points = list(zip(line.loads, line.velocities, across, strict=True))
        rises = np.array([contact.flash_rise(F, V, 1.0, width) for F, V, width in points])
        density = np.array([F * V / contact.area(F, width) for F, V, width in points])
        criteria |= {
            f"blok_{state}": line.criterion(f"Blok, smooth, {state}", "°C", rises, 0.5),
            f"power_per_area_{state}": line.criterion(
                f"power per {state} area", "W/mm²", density, 1.0, 1e-6
            ),
            f"pv_{state}": line.criterion(
                f"PV, {state}", "GPa m/s", density, 1.0, 1e-9, by_friction=False
            ),
        }
    n = load_speed_exponent(line.loads.tolist(), line.velocities.tolist())
    together = line.loads * line.velocities**n
    name = f"F·Vⁿ, n = {n:.2f} fitted here"
    fitted = line.criterion(name, "N (m/s)ⁿ", together, n, by_friction=False)
    return criteria | {"load_speed": replace(fitted, fitted=True)}


def _against_blok(criteria: Mapping[str, _Criterion], limit: float) -> dict[str, Any]:
    """Blok's criterion beside ours, and the errors of velocities with the critical temperature."""
    chosen = {
        "ours": criteria["ours"],
        "unworn": criteria["blok_unworn"],
        "worn": criteria["blok_worn"],
    }
    off = {
        f"{name}_off": _off(criterion.values, criterion.exponents, limit)
        for name, criterion in chosen.items()
    }
    return {"limit": limit, **chosen, **off}


def _constancy(criteria: Mapping[str, _Criterion]) -> dict[str, Any]:
    """The most constant of the simple criteria, and those nearer than ours in velocity."""
    ours = criteria["ours"]
    others = [other for other in criteria.values() if other is not ours and not other.fitted]

    def nearer(error: str) -> str:
        """Criteria with smaller errors of a velocity than ours."""
        errors = {other.name: getattr(other, error) for other in others}
        texts = (
            f"{name} ({100 * value:.0f} %)"
            for name, value in errors.items()
            if value < getattr(ours, error)
        )
        return ", ".join(texts) or "none"

    return {
        "ours": ours,
        "best": min(others, key=lambda other: other.spread),
        "nearer": nearer("worst"),
        "nearer_alike": nearer("worst_alike"),
    }


def _table(
    criteria: Mapping[str, _Criterion],
    measured: Sequence[Measurement],
    film: Array | None,
    line: _Line,
) -> Table:
    rows = [
        (
            f"{criterion.name} [{criterion.unit}]",
            *(
                f"{value:.{0 if criterion.scaled.min() >= 10 else 2}f}"
                for value in criterion.scaled
            ),
            *(
                f"{100 * value:.0f} %"
                for value in (criterion.spread, criterion.worst, criterion.worst_alike)
            ),
        )
        for criterion in criteria.values()
    ]
    if film is not None:
        texts = (f"{value:.2f}" for value in film)
        rows.append((f"film parameter Λ at {line.bulk:g} °C", *texts, "", "", ""))
    columns = ("highest over lowest", "velocity off", f"at friction {line.friction:g}")
    return Table(("", *map(name_of, measured), *columns), tuple(rows))


@in_house_style
def _draw(criteria: Mapping[str, _Criterion], ticks: list[str]) -> Figure:
    figure = Figure(figsize=(8.4, 4.6))
    axes = figure.subplots()
    places = np.arange(len(ticks))
    for number, (key, criterion) in enumerate(criteria.items()):
        is_ours = key == "ours"
        axes.plot(
            places,
            criterion.values / _mean(criterion.values),
            marker="os^vDdPXp"[number % 9],
            color=_LOOKS[key.split("_")[0]],
            lw=2.4 if is_ours else 1.1,
            ls="-" if is_ours else ":" if key.endswith("_worn") else "--",
            zorder=3 if is_ours else 2,
            label=criterion.name,
        )
    axes.axhline(1, color=BLACK, lw=0.8)
    axes.set_xticks(places, ticks)
    axes.set_xlim(-0.3, len(ticks) - 0.7)
    axes.set_ylabel("over its mean along the line")
    axes.set_title("criteria along the measured line; rises are above the bulk temperature")
    figure.legend(loc="outside lower center", ncols=3)
    return figure
