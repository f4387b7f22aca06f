"""Table 4: the contact at the measured transitions, over an ensemble of surfaces."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

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
from pipeline.sweep.model import Measurement

_BAND = 10.0  # K: within which the paper's highest temperatures lie


@dataclass(frozen=True, slots=True)
class _Computed:
    """Quantities at each measured transition, over the surfaces, some by the kind of wear."""

    measured: Sequence[Measurement]
    conditions: Conditions
    mean_friction: float
    width: Values  # unworn, between the outermost elements in contact [µm]
    bearing: Values  # unworn, between the rows that bear load [µm]
    worn_width: Values  # with swept wear [µm]
    failed: dict[str, Values]  # share of the contact [%]
    level: Values  # the same with swept wear, at the mean friction [%]
    highest: dict[str, Values]  # [°C]
    exceeded: dict[str, Values]  # on the failing share [°C]

    @property
    def critical(self) -> float:
        """Critical temperature [°C]."""
        return float(celsius(self.conditions.known_critical_temperature()))


def table4(study: Study) -> Report:
    """Contact width, failed share and temperatures at the four measured transitions."""
    found = _computed(study)
    return Report(
        name="table4",
        title=f"the measured transitions, over {len(found.width[0])} surfaces (mean ± spread)",
        table=_table(found),
        findings=_findings(found),
        notes=(
            "Measured friction at each transition. Chosen by us: the lateral structure of the "
            "roughness (see sensitivity).",
            "The measured widths include sliding at full load, for a time that is not printed "
            "(see inverse).",
        ),
        data={
            "load": [entry.normal_load for entry in found.measured],
            "unworn_width_um": found.width,
            "bearing_width_um": found.bearing,
            "failed_percent": found.failed,
            "failed_percent_at_mean_friction": found.level,
            "max_celsius": found.highest,
            "exceeded_celsius": found.exceeded,
            "worn_width_um": found.worn_width,
        },
        figure=_draw(found),
    )


def _computed(study: Study) -> _Computed:
    sweep = study.scene("irg_transition")
    measured = matching(sweep, [row.normal_load for row in TABLE_4])
    kinds = {"unworn": replace(sweep, wear=None)}
    kinds |= {pattern: with_wear(sweep, pattern) for pattern in PATTERNS}
    ends: Variants = {
        name: over_surfaces(study, scene, measured, name) for name, scene in kinds.items()
    }
    own = [sweep.conditions.changed(friction=entry.friction) for entry in measured]
    mean_friction = sum(at.friction for at in own) / len(own)
    alike = sweep.conditions.changed(friction=mean_friction)

    def of(name: str, quantity: Callable[[End, Conditions], float]) -> Values:
        return [
            [quantity(end, at) for end in column]
            for at, column in zip(own, ends[name], strict=True)
        ]

    return _Computed(
        measured=measured,
        conditions=sweep.conditions,
        mean_friction=mean_friction,
        width=of("unworn", lambda end, _: 1e6 * end.contact_width),
        bearing=of("unworn", lambda end, _: 1e6 * end.bearing_width),
        worn_width=of("swept", lambda end, _: 1e6 * end.contact_width),
        failed={n: of(n, lambda end, at: 100 * end.failed_fraction(at)) for n in ends},
        level=of("swept", lambda end, _: 100 * end.failed_fraction(alike)),
        highest={name: of(name, End.highest) for name in ends},
        exceeded={name: of(name, End.exceeded) for name in ends},
    )


def _table(found: _Computed) -> Table:
    names = ("swept", "local", "unworn")

    def printed(values: Iterable[float], digits: int = 0) -> tuple[str, ...]:
        return ("  printed", *(f"{value:.{digits}f}" for value in values))

    def computed(name: str, values: Values, digits: int = 0) -> tuple[str, ...]:
        return (f"  {name}", *(mean_and_spread(column, digits) for column in values))

    return Table(
        ("", *(name_of(entry) for entry in found.measured)),
        (
            ("unworn contact width [µm]",),
            printed(1e6 * row.unworn_width for row in TABLE_4),
            computed("outermost elements in contact", found.width),
            computed("rows that bear 5 % of the most loaded", found.bearing),
            (f"share of the contact above {found.critical:g} °C [%]",),
            printed((100 * row.failed_share for row in TABLE_4), 1),
            *(computed(name, found.failed[name], 1) for name in names),
            computed(f"swept, friction {found.mean_friction:.3g} at each", found.level, 1),
            ("highest temperature [°C]",),
            printed(row.max_celsius for row in TABLE_4),
            *(computed(name, found.highest[name]) for name in names),
            (
                f"temperature exceeded on {100 * found.conditions.failing_share:g} % of the "
                "contact [°C]",
            ),
            *(computed(name, found.exceeded[name]) for name in names),
            ("contact width at the end of the ramp [µm]",),
            ("  printed, measured later", *(f"{1e6 * row.measured_width:.0f}" for row in TABLE_4)),
            computed("swept", found.worn_width),
        ),
    )


def _findings(found: _Computed) -> tuple[Finding, ...]:
    return (
        _on_width(found),
        _on_share(found),
        *_on_highest(found),
        _on_local_wear(found),
    )


def _on_width(found: _Computed) -> Finding:
    off, below = (
        [
            100 * (mean / (1e6 * row.unworn_width) - 1)
            for mean, row in zip(means(widths), TABLE_4, strict=True)
        ]
        for widths in (found.width, found.bearing)
    )
    return Finding(
        "unworn contact width of 186, 171, 153, 129 µm",
        f"{min(off):+.0f} to {max(off):+.0f} % between the outermost elements in contact, "
        f"{min(below):+.0f} to {max(below):+.0f} % between the rows that bear load",
        max(map(abs, off)) < 15,
        "The paper does not say how it takes the width"
        + ("; it lies between the two." if max(below) <= 0 <= min(off) else "."),
    )


def _on_share(found: _Computed) -> Finding:
    shares, tenths = means(found.failed["swept"]), means(found.exceeded["swept"])
    steep = (max(shares) - min(shares)) / max(max(tenths) - min(tenths), 1e-9)

    def inside(columns: Values) -> int:
        return sum(
            abs(statistics(column)[0] - 100 * row.failed_share) <= 2 * statistics(column)[1]
            for row, column in zip(TABLE_4, columns, strict=True)
        )

    return Finding(
        "a failed share of about 10 % at every transition, 8.7 to 12.1 %",
        f"{range_of(shares, 1)} % with swept wear, {sum(shares) / len(shares):.1f} % on "
        f"average; {inside(found.failed['swept'])} of {len(TABLE_4)} printed values lie within two "
        "spreads of ours",
        inside(found.failed["swept"]) == len(TABLE_4),
        f"It hangs on the single friction coefficients: with their mean, "
        f"{found.mean_friction:.3g}, at each transition it is "
        f"{', '.join(f'{value:.1f}' for value in means(found.level))} %, and "
        f"{inside(found.level)} of {len(TABLE_4)} printed values lie within two spreads. In "
        f"temperature the two are closer: exceeded on 10 % is {range_of(tenths)} °C, "
        f"on average {sum(tenths) / len(tenths) - found.critical:+.1f} K off "
        f"{found.critical:g} °C, and a kelvin there moves the share by {steep:.1f} points.",
    )


def _on_highest(found: _Computed) -> tuple[Finding, Finding]:
    maxima = means(found.highest["swept"])
    apart = [m - row.max_celsius for m, row in zip(maxima, TABLE_4, strict=True)]
    above = sum(maxima) / len(maxima) / found.critical - 1
    is_near = 0.05 < above < 0.15
    return (
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
            is_near,
            "Both are in the hands of a few elements."
            if is_near
            else "It goes with the highest temperature itself.",
        ),
    )


def _on_local_wear(found: _Computed) -> Finding:
    shares = means(found.failed["local"])
    return Finding(
        "wear by the local pressure, Eq. (26), gives these values",
        f"local wear leaves {range_of(means(found.highest['local']))} °C at the highest, and a "
        f"failed share of {max(shares):.1f} % at most",
        min(shares) > 5,
        "Taken point by point, the pin becomes the negative of one patch of the disk within "
        "the ramp, and the peaks are gone; but a disk that moves sweeps past. Explicit steps "
        "as large as the paper's do not resolve this (see fig6).",
    )


@in_house_style
def _draw(found: _Computed) -> Figure:
    critical = found.critical
    printed_shares = [100 * row.failed_share for row in TABLE_4]
    figure = Figure(figsize=(9.6, 7.0))
    (first, second), (third, fourth) = figure.subplots(2, 2)
    ticks = [f"{entry.normal_load:g} N\n{entry.velocity:g} m/s" for entry in found.measured]
    widths = [1e6 * row.unworn_width for row in TABLE_4]
    beside(first, ticks, widths, {"unworn": found.width}, "unworn contact width [µm]")
    title = f"share of the contact above {critical:g} °C [%]"
    beside(second, ticks, printed_shares, found.failed, title)
    maxima = [row.max_celsius for row in TABLE_4]
    beside(third, ticks, maxima, found.highest, "highest temperature [°C]")
    beside(fourth, ticks, None, found.exceeded, "temperature exceeded on 10 % [°C]")
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
