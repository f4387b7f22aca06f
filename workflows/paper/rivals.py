"""Simpler criteria at the measured transitions, beside the temperature of this model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline import Conditions, Sweep
from pipeline.answers.scene_wording import governing_words
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, house_style
from pipeline.quantities import in_unit
from tribo import Cylinder, lubrication_regime
from tribo.types import Array

from .labels import label_ends
from .publication import TABLE_4
from .recomputed import Recomputation, cells, mean, texts
from .smooth import SmoothContact, load_speed_exponent
from .study import Study
from .transitions import around_transition, film_parameter, label_of, on_surfaces

_SURFACES = 4
_STEP = 0.05  # step of ln(velocity) to find an exponent
_FITTED = "load_speed"  # criterion with a parameter that is fitted to these transitions
_LOOKS = {"ours": BLUE, "blok": VERMILION, "power": GREEN, "pv": GREY, "load": BLACK}


@dataclass(frozen=True, slots=True)
class _Rival:
    """Criterion of severe wear: a number that is equal at all transitions if it holds."""

    name: str
    unit: str
    values: Array  # with the measured friction
    at_one_friction: Array  # with the scene's friction at all transitions
    exponents: Array | float  # d ln(value)/d ln(velocity)
    scaled: Array  # values in `unit`; a rise has the bulk temperature added

    @property
    def spread(self) -> float:
        """Highest value over lowest value, minus 1."""
        return float(self.values.max() / self.values.min() - 1)

    @property
    def worst(self) -> float:
        """Largest relative error of a critical velocity if the mean value is taken as the limit."""
        return float(abs(_off(self.values, self.exponents)).max())

    @property
    def worst_alike(self) -> float:
        """Largest relative error of a velocity, with the same friction at all transitions."""
        return float(abs(_off(self.at_one_friction, self.exponents)).max())


def _off(values: Array, exponents: Array | float) -> Array:
    """Relative errors of velocities, if a criterion's mean value is taken as its limit."""
    errors: Array = (_mean(values) / values) ** (1 / exponents) - 1
    return errors


def _mean(values: Array) -> float:
    """Geometric mean."""
    return math.exp(float(np.mean(np.log(values))))


def rivals(study: Study) -> Recomputation:
    """Report on simpler criteria beside the model: Blok, power, PV, F·Vⁿ, film."""
    sweep = study.scene("table4")
    conditions = sweep.conditions
    loads, velocities = TABLE_4.normal_load, TABLE_4.velocity
    seeds = study.stages(study.seeds(_SURFACES), "surface {}".format)
    ends = on_surfaces(
        [(sweep, row) for row in TABLE_4], seeds, partial(around_transition, step=_STEP)
    )
    criteria = _criteria(sweep, mean(ends["rise"]), mean(ends["exponent"]))
    critical = mean(velocities[:, None] * (1 + ends["velocity_off"]))
    film = np.array([film_parameter(sweep, row) for row in TABLE_4])
    regimes = dict.fromkeys(map(lubrication_regime, sorted(film)))
    values = {
        **criteria,
        **_constancy(criteria),
        "regimes": ", ".join(regimes),
    }
    return Recomputation.from_values(
        "rivals",
        values,
        verdicts={
            "blok": criteria["ours"].spread
            < min(criteria["blok_unworn"].spread, criteria["blok_worn"].spread),
            "constancy": criteria["ours"].spread < values["best"].spread,
            "film": set(regimes) == {"boundary lubrication"},
        },
        table=_table(criteria, film, conditions),
        data={
            "load": loads,
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
                "measured": load_speed_exponent(loads.tolist(), velocities.tolist()),
                "computed": load_speed_exponent(loads.tolist(), critical.tolist()),
            },
        },
        figure=_draw(criteria),
    )


def _criteria(sweep: Sweep, rises: Array, exponents: Array) -> dict[str, _Rival]:
    """Criteria by name: the model's, and simpler ones by closed forms with the measured widths."""
    conditions, pin = sweep.conditions, cast(Cylinder, sweep.scene.pin)
    contact = SmoothContact(pin, sweep.scene.disk)
    bulk = float(in_unit(conditions.bulk_temperature, "°C"))
    F, V, mu = TABLE_4.normal_load, TABLE_4.velocity, TABLE_4.friction

    def by_friction(
        name: str, unit: str, values: Array, exponents: Array | float, scale: float = 1.0
    ) -> _Rival:
        scaled = (bulk if unit == "°C" else 0.0) + scale * (mu * values)
        return _Rival(name, unit, mu * values, conditions.friction * values, exponents, scaled)

    ours = governing_words(conditions.critical_area_fraction)
    criteria = {
        "ours": by_friction(ours, "°C", rises, exponents),
        "power": by_friction("friction power", "W", F * V, 1.0),
    }
    unworn = np.array([contact.width(load) for load in F])
    for state, widths in (("unworn", unworn), ("worn", TABLE_4.measured_width)):
        points = list(zip(F, V, widths, strict=True))
        flash = np.array([contact.flash_rise(f, v, 1.0, width) for f, v, width in points])
        density = np.array([f * v / (width * pin.length) for f, v, width in points])
        pv, per_area = f"PV, {state}", f"power per {state} area"
        criteria |= {
            f"blok_{state}": by_friction(f"Blok, smooth, {state}", "°C", flash, 0.5),
            f"power_per_area_{state}": by_friction(per_area, "W/mm²", density, 1.0, 1e-6),
            f"pv_{state}": _Rival(pv, "GPa m/s", density, density, 1.0, 1e-9 * density),
        }
    n = load_speed_exponent(F.tolist(), V.tolist())
    constant = F * V**n
    name = f"F·Vⁿ, n = {n:.2f} fitted here"
    fitted = _Rival(name, "N (m/s)ⁿ", constant, constant, n, constant)
    return {**criteria, _FITTED: fitted}


def _constancy(criteria: Mapping[str, _Rival]) -> dict[str, Any]:
    """The most constant simple criterion, and those with smaller velocity errors than the model."""
    ours = criteria["ours"]
    simple_criteria = [
        criterion for name, criterion in criteria.items() if name not in ("ours", _FITTED)
    ]

    def nearer(error: str) -> str:
        """Names of criteria with a smaller error `error` of a velocity than the model."""
        errors = {criterion.name: getattr(criterion, error) for criterion in simple_criteria}
        limit = getattr(ours, error)
        texts = (f"{name} ({100 * off:.0f} %)" for name, off in errors.items() if off < limit)
        return ", ".join(texts) or "none"

    return {
        "best": min(simple_criteria, key=lambda criterion: criterion.spread),
        "nearer": nearer("worst"),
        "nearer_alike": nearer("worst_alike"),
    }


def _table(criteria: Mapping[str, _Rival], film: Array, conditions: Conditions) -> pd.DataFrame:
    rows = [
        (
            f"{its.name} [{its.unit}]",
            *cells(its.scaled, ".0f" if its.scaled.min() >= 10 else ".2f"),
            *cells((its.spread, its.worst, its.worst_alike), ".0f%"),
        )
        for its in criteria.values()
    ]
    label = f"film parameter Λ at {in_unit(conditions.bulk_temperature, '°C'):g} °C"
    columns = ("highest over lowest", "velocity off", f"at friction {conditions.friction:g}")
    return texts(
        ("", *map(label_of, TABLE_4), *columns),
        [*rows, (label, *cells(film, ".2f"), "", "", "")],
    )


_IN_FULL = {
    "ours": "this model: Θ₁₀ of the rough, worn contact",
    "power": "friction power",
    "blok_unworn": "Blok's flash temperature, smooth contact, unworn",
    "power_per_area_unworn": "friction power per area, unworn contact",
    "pv_unworn": "pressure × velocity, unworn contact",
    "blok_worn": "Blok's flash temperature, smooth contact, worn",
    "power_per_area_worn": "friction power per area, worn contact",
    "pv_worn": "pressure × velocity, worn contact",
    _FITTED: "load × velocityⁿ, n fitted to these tests",
}


@house_style
def _draw(criteria: Mapping[str, _Rival]) -> Figure:
    figure = Figure(figsize=(10.4, 5.2))
    axes = figure.subplots()
    abscissas = np.arange(len(TABLE_4))
    for number, (key, criterion) in enumerate(criteria.items()):
        is_ours = key == "ours"
        axes.plot(
            abscissas,
            criterion.values / _mean(criterion.values),
            marker="os^vDdPXp"[number % 9],
            color=_LOOKS[key.split("_")[0]],
            lw=2.4 if is_ours else 1.1,
            ls="-" if is_ours else ":" if key.endswith("_worn") else "--",
            zorder=3 if is_ours else 2,
            label=_IN_FULL[key],
        )
    axes.axhline(1, color=BLACK, lw=0.8)
    axes.set_xticks(abscissas, list(map(label_of, TABLE_4)))
    axes.set_xlim(-0.3, len(TABLE_4) - 0.9)
    axes.set_ylabel("criterion / its mean over the four tests")
    axes.set_title(
        "Which quantity is the same at every measured transition to severe wear?\n"
        "One that decides is 1.0 at all four; temperatures count above the bulk",
        fontsize=11,
    )
    label_ends(axes)
    return figure
