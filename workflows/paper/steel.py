"""Conductivity of the steel: what it does to the transitions of both oils."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline import Sweep, boundary
from pipeline.figures.style import BLUE, GREEN, GREY, VERMILION, house_style
from pipeline.quantities import in_unit
from pipeline.sweep.case import known_critical_temperature
from tribo.simulation import add_temperature, contacts
from tribo.types import Array

from .labels import label_ends
from .publication import ROOM_CELSIUS, TABLE_4, TABLE_6
from .recomputed import Recomputation, agree, line, texts
from .study import Study
from .transitions import celsius_of, end_at, oil_a, white_oil

_SURFACES = 4
_CONDUCTIVITIES = (15.0, 21.0, 27.0, 33.0, 39.0, 45.0, 51.0, 60.0, 70.0)  # W/(m K)
_VELOCITIES = {"from": "0.2 m/s", "to": "5 m/s", "step": "0.2 m/s"}
_SOFT, _HARD = 45.0, 21.0  # W/(m K): of the paper's table; measured for through-hardened steel
_SAME_WITHIN = 30.0  # [K]; temperatures of oil A that differ less are one temperature


def steel(study: Study) -> Recomputation:
    """Report on critical velocities and temperatures with another thermal conductivity."""
    tests = {"white oil": white_oil(study), "oil A": oil_a(study)}
    names, by_oil = [], {}
    for oil, transitions in tests.items():
        bulks = [in_unit(sweep.conditions.bulk_temperature, "°C") for sweep, _ in transitions]
        names += [
            f"  {oil}, {row.normal_load:g} N, {bulk:g} °C"
            for (_, row), bulk in zip(transitions, bulks, strict=True)
        ]
        by_oil[oil] = np.stack([_critical(study, *transition) for transition in transitions])
    means = {
        oil: dict(zip(_CONDUCTIVITIES, its.mean(axis=1).T, strict=True))
        for oil, its in by_oil.items()
    }
    boundary = _boundary(study)
    white, of_a = means["white oil"], means["oil A"]
    conditions = tests["white oil"][0][0].conditions
    printed = float(in_unit(known_critical_temperature(conditions), "°C"))
    bulk = float(in_unit(conditions.bulk_temperature, "°C"))
    values: dict[str, Any] = {
        "soft": _SOFT,
        "hard": _HARD,
        "surfaces": len(study.seeds(_SURFACES)),
        "critical": printed,
        "white_soft": white[_SOFT],
        "white_hard": white[_HARD],
        "apart_soft": _apart(of_a[_SOFT]),
        "apart_hard": _apart(of_a[_HARD]),
        "changes": boundary["change"],
        "scatter": [float(np.std(np.log(white[K] - bulk), ddof=1)) for K in (_SOFT, _HARD)],
    }
    of_white_oil = by_oil["white oil"][:, :, _CONDUCTIVITIES.index(_SOFT)]
    return Recomputation.from_values(
        "steel",
        values,
        verdicts={
            "white_oil": agree(of_white_oil, len(of_white_oil) * [printed], bulk),
            "oil_a": float(np.ptp(of_a[_SOFT])) <= _SAME_WITHIN,
        },
        table=_table(names, means, boundary),
        data={"conductivity": _CONDUCTIVITIES, "critical_celsius": by_oil, "boundary": boundary},
        figure=_draw(by_oil, printed),
    )


def _critical(study: Study, sweep: Sweep, row: Any) -> Array:
    """Critical temperature [°C] from a transition, (surface, conductivity)."""
    temperatures = []
    for seed in study.seeds(_SURFACES):
        surface = sweep.take_surface(seed)
        *_, contact = contacts(surface.scene, row.normal_load, row.velocity)
        for conductivity in _CONDUCTIVITIES:
            other = _conducting(surface, conductivity)
            end = end_at(other, add_temperature(other.scene, contact, row.velocity), row.friction)
            temperatures.append(float(celsius_of(end, sweep.conditions.critical_area_fraction)))
    study.tell(f"{row.normal_load:g} N at {row.velocity:g} m/s")
    return np.reshape(temperatures, (-1, len(_CONDUCTIVITIES)))


def _conducting(sweep: Sweep, conductivity: float) -> Sweep:
    for name in {sweep.source.entries[body]["material"] for body in ("pin", "disk")}:
        path = f"materials.{name}.thermal_conductivity"
        sweep = sweep.changed(path, f"{conductivity!r} W/(m K)")
    return sweep


def _apart(of_oil_a: Array) -> float:
    """Difference of oil A's critical temperatures [K]: from cold bodies minus from hot ones."""
    return float(of_oil_a[:2].mean() - of_oil_a[2:].mean())


def _boundary(study: Study) -> dict[str, Any]:
    """Critical velocities by load, with both thermal conductivities, at friction 0.1."""
    changes: Mapping[str, Any] = {
        "sweep.loads": ["200 N", "400 N", "600 N", "750 N"],
        "sweep.velocities": _VELOCITIES,
    }
    sweep = study.scene("irg_transition", changes)
    answers = {
        K: boundary(study.sweep(_conducting(sweep, K), f"steel_{K:g}")[1]) for K in (_SOFT, _HARD)
    }
    soft, hard = (answers[K]["critical_velocity"].values for K in (_SOFT, _HARD))
    return {
        "load": answers[_SOFT]["load"].values.tolist(),
        "soft": soft.tolist(),
        "hard": hard.tolist(),
        "change": (hard / soft - 1).tolist(),
    }


def _table(
    names: list[str], means: Mapping[str, Mapping[float, Array]], boundary: Mapping[str, Any]
) -> pd.DataFrame:
    velocities = zip(boundary["load"], boundary["soft"], boundary["hard"], strict=True)
    soft, hard = (np.concatenate([its[K] for its in means.values()]) for K in (_SOFT, _HARD))
    return texts(
        ("", f"K {_SOFT:g} W/(m K)", f"K {_HARD:g} W/(m K)"),
        (
            ("critical velocity at friction 0.1 [m/s]",),
            *(line(f"  {load:g} N", pair, ".2f") for load, *pair in velocities),
            ("critical temperature from each transition [°C]",),
            *(line(name, pair) for name, *pair in zip(names, soft, hard, strict=True)),
        ),
    )


@house_style
def _draw(by_oil: Mapping[str, Array], printed: float) -> Figure:
    figure = Figure(figsize=(8.4, 4.4))
    axes = figure.subplots()
    for oil, colour in (("white oil", BLUE), ("oil A", VERMILION)):
        for number, curve in enumerate(by_oil[oil].mean(axis=1)):
            test = (TABLE_4 if oil == "white oil" else TABLE_6)[number]
            bulk = getattr(test, "bulk_celsius", ROOM_CELSIUS)
            axes.plot(
                _CONDUCTIVITIES, curve, color=colour, ls="-" if bulk == ROOM_CELSIUS else "--",
                label=f"{oil}, {test.normal_load:g} N, bulk {bulk:g} °C",
            )  # fmt: skip
    axes.axhline(printed, color=GREEN, lw=1.2, label=f"white oil on the rig: {printed:g} °C")
    for K, text in ((_SOFT, "taken, as annealed"), (_HARD, "measured, hardened")):
        axes.axvline(K, color=GREY, ls=":", lw=1.2)
        axes.annotate(
            text, (K, 1.0), (3, -3), xycoords=("data", "axes fraction"), va="top", fontsize=8,
            textcoords="offset points", color=GREY,
        )  # fmt: skip
    axes.set(xlabel="conductivity of the steel [W/(m K)]", ylabel="critical temperature [°C]")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.12 * (top - bottom))  # room for the words at the lines
    axes.set_xlim(_CONDUCTIVITIES[0], _CONDUCTIVITIES[-1])
    axes.set_title("from each measured transition", loc="left")
    label_ends(axes)
    return figure
