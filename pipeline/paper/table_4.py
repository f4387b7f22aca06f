"""Table 4: the contact at the measured transitions, over an ensemble of surfaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from pipeline.figures.style import GREY, celsius, in_house_style
from pipeline.paper.ensemble import (
    PATTERNS,
    Values,
    Variants,
    beside,
    matching,
    means,
    name_of,
    over_surfaces,
    range_of,
    with_wear,
)
from pipeline.paper.printed import TABLE_4
from pipeline.paper.report import Finding, Report, Table, mean_and_spread, statistics
from pipeline.paper.study import End, Study
from pipeline.sweep.criterion import Conditions
from pipeline.sweep.model import Measurement, Sweep

_BAND = 10.0  # K: within which the paper's highest temperatures lie


def table4(study: Study) -> Report:
    """Contact width, failed share and temperatures at the four measured transitions."""
    sweep = study.scene("irg_transition")
    measured = matching(sweep, [row.normal_load for row in TABLE_4])
    kinds = {"unworn": replace(sweep, wear=None)}
    kinds |= {pattern: with_wear(sweep, pattern) for pattern in PATTERNS}
    ends: Variants = {
        name: over_surfaces(study, scene, measured, name) for name, scene in kinds.items()
    }

    conditions = sweep.conditions
    critical, share = conditions.known_critical_temperature(), conditions.failing_share
    own = [conditions.changed(friction=entry.friction) for entry in measured]
    frictions = [at.friction for at in own]
    mean_friction = sum(frictions) / len(frictions)
    alike = conditions.changed(friction=mean_friction)

    def of(name: str, quantity: Callable[[End, Conditions], float]) -> Values:
        return [
            [quantity(end, at) for end in column]
            for at, column in zip(own, ends[name], strict=True)
        ]

    width = of("unworn", lambda end, _: 1e6 * end.contact_width)
    bearing = of("unworn", lambda end, _: 1e6 * end.bearing_width)
    failed = {n: of(n, lambda end, at: 100 * end.failed_fraction(at)) for n in ends}
    level = of("swept", lambda end, _: 100 * end.failed_fraction(alike))
    highest = {name: of(name, End.highest) for name in ends}
    exceeded = {name: of(name, End.exceeded) for name in ends}
    worn_width = of("swept", lambda end, _: 1e6 * end.contact_width)

    printed_width = [1e6 * row.unworn_width for row in TABLE_4]
    printed_share = [100 * row.failed_share for row in TABLE_4]
    printed_highest = [row.max_celsius for row in TABLE_4]
    names = ("swept", "local", "unworn")

    def printed(values: Sequence[float], digits: int = 0) -> tuple[str, ...]:
        return ("  printed", *(f"{value:.{digits}f}" for value in values))

    def computed(name: str, values: Values, digits: int = 0) -> tuple[str, ...]:
        return (f"  {name}", *(mean_and_spread(column, digits) for column in values))

    table = Table(
        ("", *(name_of(entry) for entry in measured)),
        (
            ("unworn contact width [µm]",),
            printed(printed_width),
            computed("outermost elements in contact", width),
            computed("rows that bear 5 % of the most loaded", bearing),
            (f"share of the contact above {celsius(critical):g} °C [%]",),
            printed(printed_share, 1),
            *(computed(name, failed[name], 1) for name in names),
            computed(f"swept, friction {mean_friction:.3g} at each", level, 1),
            ("highest temperature [°C]",),
            printed(printed_highest),
            *(computed(name, highest[name]) for name in names),
            (f"temperature exceeded on {100 * share:g} % of the contact [°C]",),
            *(computed(name, exceeded[name]) for name in names),
            ("contact width at the end of the ramp [µm]",),
            ("  printed, measured later", *(f"{1e6 * row.measured_width:.0f}" for row in TABLE_4)),
            computed("swept", worn_width),
        ),
    )
    return Report(
        name="table4",
        title=f"the measured transitions, over {len(ends['swept'][0])} surfaces (mean ± spread)",
        table=table,
        findings=_findings(
            sweep, width, bearing, failed, highest, exceeded, (mean_friction, level)
        ),
        notes=(
            "Measured friction at each transition. Chosen by us: the lateral structure of the "
            "roughness (see sensitivity).",
            "The measured widths include sliding at full load, for a time that is not printed "
            "(see inverse).",
        ),
        data={
            "load": [entry.normal_load for entry in measured],
            "unworn_width_um": width,
            "bearing_width_um": bearing,
            "failed_percent": failed,
            "failed_percent_at_mean_friction": level,
            "max_celsius": highest,
            "exceeded_celsius": exceeded,
            "worn_width_um": worn_width,
        },
        figure=_draw(
            measured,
            (printed_width, {"unworn": width}),
            (printed_share, failed),
            (printed_highest, highest),
            exceeded,
            float(celsius(critical)),
        ),
    )


def _findings(
    sweep: Sweep,
    width: Values,
    bearing: Values,
    failed: dict[str, Values],
    highest: dict[str, Values],
    exceeded: dict[str, Values],
    at_mean_friction: tuple[float, Values],
) -> tuple[Finding, ...]:
    critical = float(celsius(sweep.conditions.known_critical_temperature()))
    off = [
        100 * (mean / (1e6 * row.unworn_width) - 1)
        for mean, row in zip(means(width), TABLE_4, strict=True)
    ]
    below = [
        100 * (mean / (1e6 * row.unworn_width) - 1)
        for mean, row in zip(means(bearing), TABLE_4, strict=True)
    ]
    shares, maxima, tenths = (means(v["swept"]) for v in (failed, highest, exceeded))
    apart = [m - row.max_celsius for m, row in zip(maxima, TABLE_4, strict=True)]

    def inside(columns: Values) -> int:
        return sum(
            abs(statistics(column)[0] - 100 * row.failed_share) <= 2 * statistics(column)[1]
            for row, column in zip(TABLE_4, columns, strict=True)
        )

    friction, level = at_mean_friction
    local_highest = means(highest["local"])
    above = sum(maxima) / len(maxima) / critical - 1
    steep = (max(shares) - min(shares)) / max(max(tenths) - min(tenths), 1e-9)
    return (
        Finding(
            "unworn contact width of 186, 171, 153, 129 µm",
            f"{min(off):+.0f} to {max(off):+.0f} % between the outermost elements in contact, "
            f"{min(below):+.0f} to {max(below):+.0f} % between the rows that bear load",
            max(map(abs, off)) < 15,
            "The paper does not say how it takes the width"
            + ("; it lies between the two." if max(below) <= 0 <= min(off) else "."),
        ),
        Finding(
            "a failed share of about 10 % at every transition, 8.7 to 12.1 %",
            f"{range_of(shares, 1)} % with swept wear, {sum(shares) / len(shares):.1f} % on "
            f"average; {inside(failed['swept'])} of {len(TABLE_4)} printed values lie within two "
            "spreads of ours",
            inside(failed["swept"]) == len(TABLE_4),
            f"It hangs on the single friction coefficients: with their mean, {friction:.3g}, at "
            f"each transition it is {', '.join(f'{value:.1f}' for value in means(level))} %, and "
            f"{inside(level)} of {len(TABLE_4)} printed values lie within two spreads. In "
            f"temperature the two are closer: exceeded on 10 % is {range_of(tenths)} °C, "
            f"on average {sum(tenths) / len(tenths) - critical:+.1f} K off {critical:g} °C, and "
            f"a kelvin there moves the share by {steep:.1f} points.",
        ),
        Finding(
            "highest temperatures of 153 to 162 °C, all within 10 °C",
            f"{range_of(maxima)} °C with swept wear, {min(apart):+.0f} to {max(apart):+.0f} K "
            f"against the printed ones, {max(maxima) - min(maxima):.0f} K apart",
            max(map(abs, apart)) < _BAND and max(maxima) - min(maxima) <= _BAND,
            "The highest temperature is that of one element in the whole contact; it hangs on the "
            "short waves of the roughness, which the paper does not publish.",
        ),
        Finding(
            "the highest temperature is about 10 % above the critical one",
            f"{100 * above:.0f} % above, in °C",
            0.05 < above < 0.15,
            "Both are in the hands of a few elements."
            if 0.05 < above < 0.15
            else "It goes with the highest temperature itself.",
        ),
        Finding(
            "wear by the local pressure, Eq. (26), gives these values",
            f"local wear leaves {range_of(local_highest)} °C at the highest, and a failed share of "
            f"{max(means(failed['local'])):.1f} % at most",
            min(means(failed["local"])) > 5,
            "Taken point by point, the pin becomes the negative of one patch of the disk within "
            "the ramp, and the peaks are gone; but a disk that moves sweeps past. Explicit steps "
            "as large as the paper's do not resolve this (see fig6).",
        ),
    )


@in_house_style
def _draw(
    measured: Sequence[Measurement],
    widths: tuple[list[float], dict[str, Values]],
    shares: tuple[list[float], dict[str, Values]],
    maxima: tuple[list[float], dict[str, Values]],
    exceeded: dict[str, Values],
    critical: float,
) -> Figure:
    figure = Figure(figsize=(9.6, 7.0))
    (first, second), (third, fourth) = figure.subplots(2, 2)
    ticks = [f"{entry.normal_load:g} N\n{entry.velocity:g} m/s" for entry in measured]
    for axes, (printed, values), title in (
        (first, widths, "unworn contact width [µm]"),
        (second, shares, f"share of the contact above {critical:g} °C [%]"),
        (third, maxima, "highest temperature [°C]"),
    ):
        beside(axes, ticks, printed, values, title)
    beside(fourth, ticks, None, exceeded, "temperature exceeded on 10 % [°C]")
    first.set_ylim(0, None)
    for axes in (third, fourth):
        axes.axhline(critical, color=GREY, ls=":", lw=1.2)
    low = min(third.get_ylim()[0], fourth.get_ylim()[0])
    high = max(third.get_ylim()[1], fourth.get_ylim()[1])
    for axes in (third, fourth):
        axes.set_ylim(low, high)
    handles, labels = third.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure
