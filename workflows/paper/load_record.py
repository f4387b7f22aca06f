"""Fig. 8: a recorded load in place of its linear fit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, celsius, heating, in_house_style
from pipeline.sweep.criterion import Conditions, contact_temperature
from pipeline.sweep.model import Sweep
from tribo import InputError, MeasuredLoad, Ramp, simulate
from tribo.types import Array
from workflows.paper.printed import LOADING_RATE
from workflows.paper.report import Finding, Report, Table
from workflows.paper.study import Study, summary_of

_RECORD, _FIT = "record", "its linear fit"
_SAME = 2.0  # K: within what a linear fit serves as well as the record


class _Run(NamedTuple):
    time: Array  # [s]
    temperature: Array  # exceeded on the failing share of the contact [°C]
    duration: float  # [s]
    distance: float  # [m]
    highest: float  # at the end [°C]
    exceeded: float  # at the end, on the failing share of the contact [°C]


@dataclass(frozen=True, slots=True)
class _Computed:
    """The same point through each loading, by its name."""

    record: MeasuredLoad
    rate: float  # of the linear fit [N/s]
    onset: float  # of the linear fit [s]
    load: float  # [N]
    velocity: float  # [m/s]
    conditions: Conditions
    runs: dict[str, _Run]

    @property
    def share(self) -> str:
        """Failing share in percent."""
        return f"{100 * self.conditions.failing_share:g} %"


def fig8(study: Study) -> Report:
    """The same point through a recorded load, its linear fit, and the stated rate."""
    found = _computed(study)
    return Report(
        name="fig8",
        title=f"a recorded load (synthetic) and its linear fit, {found.load:g} N at "
        f"{found.velocity:g} m/s",
        table=_table(found),
        findings=(_on_rate(found), _on_fit(found)),
        notes=(
            "The record is synthetic: the paper's is not published as numbers. It is made from "
            "the paper's description, and can be replaced by a measured one in the scene.",
            f"{heating(found.conditions)}; one surface, its correlation length our choice.",
        ),
        data={
            "fit": {"rate": found.rate, "onset": found.onset},
            "runs": {
                name: {
                    "duration": run.duration,
                    "sliding_distance": run.distance,
                    "max_celsius": run.highest,
                    "exceeded_celsius": run.exceeded,
                }
                for name, run in found.runs.items()
            },
        },
        figure=_draw(found),
    )


def _computed(study: Study) -> _Computed:
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
        for name in study.each(loadings)
    }
    return _Computed(record, rate, onset, load, velocity, sweep.conditions, runs)


def _run(scene: Sweep, load: float, velocity: float) -> _Run:
    conditions = scene.conditions
    times, temperatures = [0.0], [float(celsius(contact_temperature(0.0, conditions)))]
    for state in simulate(scene, load, velocity):
        if state.heat is not None:
            end = summary_of(scene, state)
            times.append(state.time)
            temperatures.append(end.exceeded(conditions))
    return _Run(
        np.array(times),
        np.array(temperatures),
        state.time,
        state.sliding_distance,
        end.highest(conditions),
        temperatures[-1],
    )


def _table(found: _Computed) -> Table:
    return Table(
        ("loading", "lasts [s]", "slides [m]", f"on {found.share} [°C]", "highest [°C]"),
        tuple(
            (
                name,
                f"{run.duration:.2f}",
                f"{run.distance:.2f}",
                f"{run.exceeded:.1f}",
                f"{run.highest:.1f}",
            )
            for name, run in found.runs.items()
        ),
    )


def _on_rate(found: _Computed) -> Finding:
    return Finding(
        f"the load grows at {LOADING_RATE:g} N/s",
        f"the fit between 10 and 90 % of the load gives {found.rate:.1f} N/s",
        abs(found.rate / LOADING_RATE - 1) < 0.02,
        "The record was made so.",
    )


def _on_fit(found: _Computed) -> Finding:
    recorded, fitted = found.runs[_RECORD], found.runs[_FIT]
    off = fitted.exceeded - recorded.exceeded
    return Finding(
        "a linear fit may stand for the record",
        f"at full load the fit is {off:+.2f} K off in the temperature exceeded on {found.share} "
        f"and {fitted.highest - recorded.highest:+.2f} K in the highest",
        abs(off) < _SAME,
        f"The record takes {recorded.duration - fitted.duration:.2f} s longer because of its "
        f"rounded ends, and slides {recorded.distance - fitted.distance:.2f} m farther.",
    )


@in_house_style
def _draw(found: _Computed) -> Figure:
    figure = Figure(figsize=(7.4, 6.0))
    upper, lower = figure.subplots(2, 1, sharex=True)
    _draw_loads(upper, found)
    _draw_temperatures(lower, found)
    upper.set_xlim(0, found.record.times[-1])
    return figure


def _draw_loads(axes: Axes, found: _Computed) -> None:
    times, loads = found.record.times, found.record.loads
    axes.plot(times, loads, color=BLACK, lw=1.2, label="record (synthetic)")
    reached = found.onset + found.load / found.rate
    axes.plot(
        [found.onset, reached, times[-1]], [0, found.load, found.load], color=VERMILION, ls="--",
        label=f"linear fit, {found.rate:.1f} N/s",
    )  # fmt: skip
    axes.set_ylabel("normal load [N]")
    axes.legend(loc="lower right")


def _draw_temperatures(axes: Axes, found: _Computed) -> None:
    for (name, run), (colour, style) in zip(
        found.runs.items(), ((BLACK, "-"), (VERMILION, "--"), (BLUE, ":")), strict=True
    ):
        begins = float(found.record.times[0]) if name == _RECORD else found.onset
        axes.plot(run.time + begins, run.temperature, color=colour, ls=style, label=name)
    critical = celsius(found.conditions.known_critical_temperature())
    axes.axhline(critical, color=GREY, ls=":", lw=1.2)
    axes.text(0.05, critical + 1, f"critical, {critical:g} °C", color=GREY, va="bottom")
    axes.set_ylabel(f"exceeded on {found.share}\nof the contact [°C]")
    axes.set_xlabel("time [s]")
    axes.set_ylim(None, critical + 12)
    axes.legend(loc="lower right", title=heating(found.conditions))
