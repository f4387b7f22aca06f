"""Fig. 8: a recorded load in place of its linear fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, celsius, heating, in_house_style
from pipeline.sweep.model import Sweep
from tribo import InputError, MeasuredLoad, Ramp
from tribo.types import Array
from workflows.paper.publication import LOADING_RATE
from workflows.paper.report import Report, Table
from workflows.paper.study import Study
from workflows.paper.transitions import HIGHEST, Ends, history

_RECORD, _FIT = "record", "its linear fit"
_SAME = 2.0  # K: within what a linear fit serves as well as the record


class _Run(NamedTuple):
    time: Array  # [s]
    temperature: Array  # exceeded on the failing share of the contact [°C]
    duration: float  # [s]
    sliding_distance: float  # [m]
    max_celsius: float  # at the end
    exceeded_celsius: float  # at the end, on the failing share of the contact


def fig8(study: Study) -> Report:
    """The same point through a recorded load, its linear fit, and the stated rate."""
    sweep = study.scene_with_history("fig8")
    record = sweep.loading
    if not isinstance(record, MeasuredLoad):
        raise InputError(f"the scene {sweep.name} must have a record, `file` under [loading]")
    load, velocity = sweep.loads[-1], sweep.velocities[-1]
    rate, onset = record.linear_fit()
    loadings: dict[str, Ramp | MeasuredLoad] = {
        _RECORD: record,
        _FIT: record.ramp(),
        f"{LOADING_RATE:g} N/s": Ramp(LOADING_RATE, load),
    }
    runs = {
        name: _run(replace(sweep, loading=loadings[name]), load, velocity)
        for name in study.stages(loadings)
    }
    recorded, fitted = runs[_RECORD], runs[_FIT]
    values: dict[str, Any] = {
        "load": load,
        "velocity": velocity,
        "heating": heating(sweep.conditions),
        "share": sweep.conditions.failing_share,
        "printed_rate": LOADING_RATE,
        "rate": rate,
        "off": fitted.exceeded_celsius - recorded.exceeded_celsius,
        "highest_off": fitted.max_celsius - recorded.max_celsius,
        "longer": recorded.duration - fitted.duration,
        "farther": recorded.sliding_distance - fitted.sliding_distance,
    }
    return Report.of(
        "fig8",
        values,
        verdicts={
            "rate": abs(rate / LOADING_RATE - 1) < 0.02,
            "fit": abs(values["off"]) < _SAME,
        },
        table=Table(
            ("loading", "lasts [s]", "slides [m]", f"on {_share(sweep)} [°C]", "highest [°C]"),
            tuple(
                (
                    name,
                    *(f"{value:.2f}" for value in (run.duration, run.sliding_distance)),
                    *(f"{value:.1f}" for value in (run.exceeded_celsius, run.max_celsius)),
                )
                for name, run in runs.items()
            ),
        ),
        data={
            "fit": {"rate": rate, "onset": onset},
            "runs": {
                name: dict(zip(_Run._fields[2:], run[2:], strict=True))
                for name, run in runs.items()
            },
        },
        figure=_draw(sweep, record, runs),
    )


def _share(sweep: Sweep) -> str:
    return f"{100 * sweep.conditions.failing_share:g} %"


def _run(scene: Sweep, load: float, velocity: float) -> _Run:
    times, temperatures, end = history(scene, load, velocity, scene.conditions.decisive)
    highest = float(Ends.of(scene, end).celsius(HIGHEST))
    exceeded = float(temperatures[-1])
    return _Run(times, temperatures, end.time, end.sliding_distance, highest, exceeded)


@in_house_style
def _draw(sweep: Sweep, record: MeasuredLoad, runs: dict[str, _Run]) -> Figure:
    figure = Figure(figsize=(7.4, 6.0))
    upper, lower = figure.subplots(2, 1, sharex=True)
    _draw_loads(upper, record, sweep.loads[-1])
    _draw_temperatures(lower, sweep, record, runs)
    upper.set_xlim(0, record.times[-1])
    return figure


def _draw_loads(axes: Axes, record: MeasuredLoad, load: float) -> None:
    rate, onset = record.linear_fit()
    axes.plot(record.times, record.loads, color=BLACK, lw=1.2, label="record (synthetic)")
    axes.plot(
        [onset, onset + load / rate, record.times[-1]], [0, load, load], color=VERMILION, ls="--",
        label=f"linear fit, {rate:.1f} N/s",
    )  # fmt: skip
    axes.set_ylabel("normal load [N]")
    axes.legend(loc="lower right")


def _draw_temperatures(
    axes: Axes, sweep: Sweep, record: MeasuredLoad, runs: dict[str, _Run]
) -> None:
    _, onset = record.linear_fit()
    looks = ((BLACK, "-"), (VERMILION, "--"), (BLUE, ":"))
    for (name, run), (colour, style) in zip(runs.items(), looks, strict=True):
        begins = float(record.times[0]) if name == _RECORD else onset
        axes.plot(run.time + begins, run.temperature, color=colour, ls=style, label=name)
    critical = celsius(sweep.conditions.known_critical_temperature())
    axes.axhline(critical, color=GREY, ls=":", lw=1.2)
    axes.text(0.05, critical + 1, f"critical, {critical:g} °C", color=GREY, va="bottom")
    axes.set_ylabel(f"exceeded on {_share(sweep)}\nof the contact [°C]")
    axes.set_xlabel("time [s]")
    axes.set_ylim(None, critical + 12)
    axes.legend(loc="lower right", title=heating(sweep.conditions))
