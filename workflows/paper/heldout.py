"""Each measured transition, predicted from the other three of its oil."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator

from pipeline.answers.posterior import Outcome, Prior, update
from pipeline.answers.results import cases_of
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, house_style
from pipeline.sweep.case import known_critical_temperature
from tribo.types import Array

from .labels import label_ends
from .publication import TABLE_4, TABLE_6
from .recomputed import Recomputation, cells, texts
from .smooth import SmoothContact
from .study import Study
from .transitions import Tested, oil_a, white_oil

_SURFACES = 8
_LENGTHS = {"white oil": (3.0, 4.0, 5.0, 6.0), "oil A": (4.0,)}  # µm
_FACTORS = (-0.4, -0.2, 0.0, 0.2, 0.4)  # ln(velocity / measured) that are computed
_STORES = {"white oil": "irg_transition", "oil A": "oil_a"}
_STEP_TOLERANCE, _MAX_STEPS = 1e-6, 50  # of ln(critical − bulk)
_BLOK_EXPONENT = 0.5  # d ln(rise)/d ln(velocity) of Blok's flash temperature
_GOOD = 0.1  # relative error that agrees, as in report.agree
_LAWS = {
    "model": "this model",
    "friction_load": "(µF)·Vⁿ",
    "load": "F·Vⁿ",
    "blok": "Blok",
}
_COLOURS = {"model": BLUE, "friction_load": GREEN, "load": GREY, "blok": VERMILION}


@dataclass(frozen=True)
class _MeasuredTransition:
    """A measured transition, and ln(rise) at friction 1 over ln(velocity), by length [µm]."""

    velocity: float
    friction: float
    bulk: float  # [K]
    curves: Mapping[float, tuple[Array, Array]]

    def y(self, critical: float, length: float) -> float:
        """ln(rise/limit) at the measured velocity."""
        x, rises = self.curves[length]
        return float(PchipInterpolator(x, rises)(math.log(self.velocity))) - self._limit(critical)

    def log_velocity(self, level: float, critical: float, length: float) -> float:
        """ln(velocity) at which y has a level."""
        x, rises = self.curves[length]
        return float(PchipInterpolator(rises - self._limit(critical), x)(level))

    def _limit(self, critical: float) -> float:
        return math.log((critical - self.bulk) / self.friction)


@dataclass(frozen=True)
class _Prediction:
    """Predicted ln(velocity): where severe wear is 50 % likely, and where y is 0."""

    median: float
    computed: float
    constant: float  # correlation length [µm], or critical temperature [°C]


def heldout(study: Study) -> Recomputation:
    """Report on what the model predicts for the transitions that it has not seen."""
    tests = {"white oil": white_oil(study), "oil A": oil_a(study)}
    held_out, in_sample_predictions = list[_Prediction](), list[_Prediction]()
    for oil, transitions in tests.items():
        transitions_of_oil = _computed_transitions(study, oil, transitions)
        critical = known_critical_temperature(transitions[0][0].conditions)
        predict = functools.partial(_by_length if oil == "white oil" else _by_tests, critical)
        held_out += [
            predict(_all_but(transitions_of_oil, k), transition)
            for k, transition in enumerate(transitions_of_oil)
        ]
        in_sample_predictions += [
            predict(transitions_of_oil, transition) for transition in transitions_of_oil
        ]
    measured = np.concatenate([TABLE_4.velocity, TABLE_6.velocity])
    predicted = np.exp([prediction.median for prediction in held_out])
    laws = _simple_laws(tests)
    errors = {"model": np.log(predicted / measured).tolist(), **laws}
    in_sample = np.log(
        np.exp([prediction.median for prediction in in_sample_predictions]) / measured
    )
    data = {
        "measured [m/s]": measured,
        "predicted [m/s]": predicted,
        "by y = 0 [m/s]": np.exp([prediction.computed for prediction in held_out]),
        "chosen": [prediction.constant for prediction in held_out],
        "in sample [m/s]": measured * np.exp(in_sample),
        "held out, ln(predicted/measured)": errors,
    }
    rms = {
        name: [_rms(law_errors[:4]), _rms(law_errors[4:])] for name, law_errors in errors.items()
    }
    values = {
        "surfaces": len(study.seeds(_SURFACES)),
        "white": np.expm1(errors["model"][:4]),
        "oil_a": np.expm1(errors["model"][4:]),
        "rms": rms,
        "all": {name: _rms(law_errors) for name, law_errors in errors.items()},
        "all_in_sample": _rms(in_sample),
        "lengths": [prediction.constant for prediction in held_out[:4]],
        "temperatures": [prediction.constant for prediction in held_out[4:]],
    }
    rows = [(oil, *test) for oil, tested in tests.items() for test in tested]
    return Recomputation.from_values(
        "heldout",
        values,
        verdicts={
            "white_oil": np.abs(values["white"]).max() < _GOOD,
            "oil_a": np.abs(values["oil_a"]).max() < _GOOD,
            "simple": all(_rms(errors["model"]) < _rms(law_errors) for law_errors in laws.values()),
        },
        table=_table(rows, data, held_out),
        data=data,
        figure=_draw(rows, errors),
    )


def _computed_transitions(
    study: Study, oil: str, transitions: Sequence[Tested]
) -> list[_MeasuredTransition]:
    """The transitions of an oil with their curves, computed, or read from their store."""
    lengths = _LENGTHS[oil]
    table = [
        {
            "load": f"{float(row.normal_load)!r} N",
            "velocity": f"{float(row.velocity) * math.exp(factor)!r} m/s",
            "disk.roughness.correlation_length": f"{length!r} um",
            "wear.specific_wear_rate": scene.source.entries["wear"]["specific_wear_rate"],
        }
        for scene, row in transitions
        for length in lengths
        for factor in _FACTORS
    ]
    left_out = ["sweep.loads", "sweep.velocities", "sweep.fields", "tests"]
    changes = {"without": left_out, "sweep.along": table}
    changes["sweep.realizations"] = len(study.seeds(_SURFACES))
    scene = study.scene(_STORES[oil], changes)
    preset = "" if study.preset is None else f"_{study.preset}"
    _, ds = study.sweep(scene, f"heldout_{_STORES[oil]}{preset}")
    log_rises = [case.log_rises(case.sweep.conditions) for case in cases_of(ds)]
    rises = np.reshape(log_rises, (*map(len, (transitions, lengths, _FACTORS)), -1))
    # The surfaces belong to one specimen, whose rise is the mean of their logarithms.
    means = rises.mean(axis=-1)
    return [
        _MeasuredTransition(
            row.velocity,
            row.friction,
            scene.conditions.bulk_temperature,
            {
                length: (math.log(row.velocity) + np.array(_FACTORS), curve)
                for length, curve in zip(lengths, curves_by_length, strict=True)
            },
        )
        for (scene, row), curves_by_length in zip(transitions, means, strict=True)
    ]


def _all_but(transitions: Sequence[_MeasuredTransition], number: int) -> list[_MeasuredTransition]:
    return [*transitions[:number], *transitions[number + 1 :]]


def _outcomes(
    critical: float, length: float, tests: Sequence[_MeasuredTransition]
) -> tuple[Outcome, ...]:
    """The transitions, with what is computed there."""
    computed = (test.y(critical, length) for test in tests)
    return tuple(Outcome(y, y) for y in computed)


def _by_length(
    critical: float, tests: Sequence[_MeasuredTransition], transition: _MeasuredTransition
) -> _Prediction:
    """Predict a transition; the length has the least squares of ln(velocity) of the `tests`."""

    def misfit(length: float) -> float:
        velocities = [test.log_velocity(0.0, critical, length) for test in tests]
        return _rms(velocities - np.log([test.velocity for test in tests]))

    length = min(transition.curves, key=misfit)
    belief = update(_outcomes(critical, length, tests), Prior())
    return _predicted(transition, belief.level(0.5), critical, length, constant=length)


def _by_tests(
    critical: float, tests: Sequence[_MeasuredTransition], transition: _MeasuredTransition
) -> _Prediction:
    """Predict a transition, with the critical temperature from the `tests`, as ``irg infer``."""
    (length,), bulk = transition.curves, min(test.bulk for test in tests)
    fitted_critical = critical
    for _ in range(_MAX_STEPS):
        belief = update(_outcomes(fitted_critical, length, tests), Prior(bias=1.0))  # as in `infer`
        step = -float(belief.bias @ belief.weights)
        fitted_critical = bulk + (fitted_critical - bulk) * math.exp(step)
        if abs(step) < _STEP_TOLERANCE:
            break
    level = belief.level(0.5)
    return _predicted(transition, level, fitted_critical, length, constant=fitted_critical - 273.15)


def _predicted(
    transition: _MeasuredTransition, level: float, critical: float, length: float, constant: float
) -> _Prediction:
    """Predict a transition, where y has the `level` at which severe wear is 50 % likely."""
    median, computed = (transition.log_velocity(y, critical, length) for y in (level, 0.0))
    return _Prediction(median, computed, constant)


def _simple_laws(tests: Mapping[str, Sequence[Tested]]) -> dict[str, list[float]]:
    """ln(predicted/measured velocity) of simple laws, each fitted to other transitions."""
    laws: dict[str, list[float]] = {name: [] for name in list(_LAWS)[1:]}
    exponents = dict.fromkeys(("friction_load", "load"), math.nan)
    for oil, transitions in tests.items():
        contact = SmoothContact(transitions[0][0].scene.pin, transitions[0][0].scene.disk)  # type: ignore[arg-type]
        rows = [
            (row.normal_load, row.velocity, row.friction, scene.conditions.bulk_temperature)
            for scene, row in transitions
        ]
        F, V, mu, bulk = map(np.array, zip(*rows, strict=True))
        rises = np.array([contact.flash_rise(*row[:3]) for row in rows])
        for name, loads in (("friction_load", np.log(mu * F)), ("load", np.log(F))):
            if oil == "white oil":
                laws[name] += [_by_power(loads, np.log(V), k) for k in range(len(V))]
                exponents[name] = np.polyfit(loads, np.log(V), 1)[0]
            else:  # no law has the bulk temperature: the other transition at the same one
                level = np.log(V) - exponents[name] * loads
                pairs = [(k, np.flatnonzero(bulk == bulk[k])) for k in range(len(V))]
                laws[name] += [
                    float(level[[j for j in same if j != k]].mean() - level[k]) for k, same in pairs
                ]
        limits = [np.delete(bulk + rises, k).mean() - bulk[k] for k in range(len(V))]
        laws["blok"] += (np.log(limits / rises) / _BLOK_EXPONENT).tolist()
    return laws


def _by_power(loads: Array, velocities: Array, k: int) -> float:
    """Error of ln(velocity) k, by a straight line over ln(load) through the others."""
    slope, offset = np.polyfit(np.delete(loads, k), np.delete(velocities, k), 1)
    return float(offset + slope * loads[k] - velocities[k])


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _table(
    rows: Sequence[Any], data: dict[str, Any], held_out: Sequence[_Prediction]
) -> pd.DataFrame:
    errors = data["held out, ln(predicted/measured)"]
    lines = []
    for k, (oil, scene, row) in enumerate(rows):
        hot = row.normal_load, scene.conditions.bulk_temperature - 273.15
        label = f"{oil.removesuffix(' oil')}, {hot[0]:g} N, {hot[1]:g} °C"
        constant = f"{held_out[k].constant:.0f} {'µm' if oil == 'white oil' else '°C'}"
        velocities = [data[name][k] for name in ("predicted [m/s]", "by y = 0 [m/s]")]
        off = [math.expm1(law_errors[k]) for law_errors in errors.values()]
        sample = data["in sample [m/s]"][k] / row.velocity - 1
        measured = f"{row.velocity:g}"
        lines.append(
            (label, measured, constant, *cells(velocities, ".2f"), *cells([*off, sample], "+.0f%"))
        )
    sample = np.log(data["in sample [m/s]"] / data["measured [m/s]"])
    spreads = [_rms(law_errors) for law_errors in (*errors.values(), sample)]
    lines.append(("rms of ln V", "", "", "", "", *cells(spreads, ".3f")))
    return texts(
        ("oil, load, bulk", "measured [m/s]", "chosen", "predicted", "by y = 0", "off",
         *[*_LAWS.values()][1:], "in sample"),
        lines,
    )  # fmt: skip


@house_style
def _draw(rows: Sequence[Any], errors: Mapping[str, Sequence[float]]) -> Figure:
    figure = Figure(figsize=(10.4, 4.8))
    axes = figure.subplots()
    abscissas = np.arange(len(rows))
    markers = ("o", "●"), ("s", "■"), ("^", "▲"), ("D", "◆")
    for (name, law_errors), (marker, sign) in zip(errors.items(), markers, strict=True):
        for part in (slice(0, 4), slice(4, 8)):
            axes.plot(
                abscissas[part], 100 * np.expm1(law_errors[part]), color=_COLOURS[name],
                marker=marker,
                lw=2.4 if name == "model" else 1.1, ls="-" if name == "model" else "--",
                label=f"{sign} {_LAWS[name]}" if part.start else None,
            )  # fmt: skip
    axes.axhline(0, color=BLACK, lw=0.8)
    ticks = [
        f"{oil}\n{row.normal_load:g} N\n{scene.conditions.bulk_temperature - 273.15:g} °C"
        for oil, scene, row in rows
    ]
    axes.set_xticks(abscissas, ticks, fontsize=8)
    axes.set(xlim=(-0.5, len(rows) - 0.5), ylabel="predicted − measured velocity [%]")
    axes.set_title("Each transition, predicted from the other three of its oil", loc="left")
    label_ends(axes)
    return figure
