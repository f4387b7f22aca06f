"""Table 6: temperatures at the transitions of oil A, over an ensemble of surfaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from matplotlib.figure import Figure

from pipeline.figures.style import celsius, in_house_style
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
from pipeline.paper.printed import ROOM_CELSIUS, TABLE_4, TABLE_6
from pipeline.paper.report import Finding, Report, Table, mean_and_spread
from pipeline.paper.study import End, Study
from pipeline.sweep.criterion import Conditions
from pipeline.sweep.model import Measurement


def table6(study: Study) -> Report:
    """Temperatures at the measured transitions of oil A, at two bulk temperatures."""
    places: list[tuple[Measurement, Conditions]] = []
    ends: Variants = {pattern: [] for pattern in PATTERNS}
    for name, bulk_celsius in (("oil_a", 25.0), ("oil_a_hot", 100.0)):
        sweep = study.scene(name)
        loads = [row.normal_load for row in TABLE_6 if row.bulk_celsius == bulk_celsius]
        measured = matching(sweep, loads)
        conditions = sweep.conditions
        places += [(entry, conditions.changed(friction=entry.friction)) for entry in measured]
        for pattern in PATTERNS:
            worn = with_wear(sweep, pattern)
            ends[pattern] += over_surfaces(study, worn, measured, f"{name}, {pattern}")
    share = conditions.failing_share

    def of(pattern: str, quantity: Callable[[End, Conditions], float]) -> Values:
        return [
            [quantity(end, at) for end in found]
            for (_, at), found in zip(places, ends[pattern], strict=True)
        ]

    highest, exceeded = ({n: of(n, what) for n in ends} for what in (End.highest, End.exceeded))
    width = [[1e6 * end.contact_width for end in found] for found in ends["swept"]]
    printed = [row.max_celsius for row in TABLE_6]
    table = Table(
        ("", *(f"{name_of(entry)}, {celsius(at.bulk_temperature):g} °C" for entry, at in places)),
        (
            ("highest temperature [°C]",),
            ("  printed", *(f"{value:.0f}" for value in printed)),
            *((f"  {n}", *(mean_and_spread(column) for column in highest[n])) for n in ends),
            (f"temperature exceeded on {100 * share:g} % of the contact [°C]",),
            *((f"  {n}", *(mean_and_spread(column) for column in exceeded[n])) for n in ends),
            ("contact width at the end of the ramp [µm]",),
            ("  printed, measured later", *(f"{1e6 * row.measured_width:.0f}" for row in TABLE_6)),
            ("  swept", *(mean_and_spread(column) for column in width)),
        ),
    )
    return Report(
        name="table6",
        title=f"the transitions of oil A, over {len(width[0])} surfaces (mean ± spread)",
        table=table,
        findings=_findings(printed, highest["swept"], exceeded["swept"], width, share),
        notes=(
            "Table 6 announces the temperature exceeded on 10 % as well, but prints one row of "
            "temperatures only, named the highest.",
            "The steel, the pin, the roughness and the wear rate are those of Table 4: the paper "
            "prints no others.",
        ),
        data={
            "load": [entry.normal_load for entry, _ in places],
            "velocity": [entry.velocity for entry, _ in places],
            "bulk_temperature": [at.bulk_temperature for _, at in places],
            "max_celsius": highest,
            "exceeded_celsius": exceeded,
            "width_um": width,
        },
        figure=_draw(
            [f"{name_of(entry)}\n{celsius(at.bulk_temperature):g} °C" for entry, at in places],
            printed,
            highest,
            exceeded,
            share,
        ),
    )


def _findings(
    printed: Sequence[float], highest: Values, exceeded: Values, width: Values, share: float
) -> tuple[Finding, ...]:
    maxima, tenths = means(highest), means(exceeded)
    apart = [m - p for m, p in zip(maxima, printed, strict=True)]
    below = [t - p for t, p in zip(tenths, printed, strict=True)]
    spread = max(tenths) - min(tenths)
    # The two tables at one velocity and nearly one load: the rise is proportional to friction.
    cold, hot = TABLE_4[0], TABLE_6[2]
    cold_rise = (cold.max_celsius - ROOM_CELSIUS) / cold.friction
    hot_rise = (hot.max_celsius - hot.bulk_celsius) / hot.friction
    wider = [
        f"{row.normal_load:g} N, {row.velocity:g} m/s"
        for row, mean in zip(TABLE_6, means(width), strict=True)
        if mean >= 0.995e6 * row.measured_width
    ]
    return (
        Finding(
            "highest temperatures of 210, 230, 208, 200 °C",
            f"{range_of(maxima)} °C, {min(apart):+.0f} to {max(apart):+.0f} K against them; those "
            f"exceeded on {100 * share:g} % are {min(below):+.0f} to {max(below):+.0f} K",
            max(map(abs, apart)) < 0.1 * min(printed),
            "The printed values do not follow from those of Table 4 either: the rise is "
            f"proportional to friction, but for each unit of it Table 4 has {cold_rise:.0f} K at "
            f"{cold.normal_load:g} N and {cold.velocity:g} m/s, Table 6 {hot_rise:.0f} K at "
            f"{hot.normal_load:g} N and the same velocity. More wear would cool the contact, but "
            "the measured widths do not show it"
            + (f": at {' and '.join(wider)} ours is already as wide or wider." if wider else "."),
        ),
        _reading(printed, tenths, share),
        Finding(
            f"the temperatures lie within a small interval, {max(printed) - min(printed):.0f} K, "
            "also at the elevated bulk temperature",
            f"those exceeded on {100 * share:g} % within {spread:.0f} K, the highest within "
            f"{max(maxima) - min(maxima):.0f} K",
            spread <= max(printed) - min(printed),
            f"Their mean is {sum(tenths) / len(tenths):.0f} °C: what oil A stands by this model.",
        ),
    )


def _reading(printed: Sequence[float], tenths: Sequence[float], share: float) -> Finding:
    """What the printed rises are of ours, and what would explain it."""
    of_ours: dict[float, list[float]] = {}
    for row, theirs, ours in zip(TABLE_6, printed, tenths, strict=True):
        ratio = (theirs - row.bulk_celsius) / (ours - row.bulk_celsius)
        of_ours.setdefault(row.bulk_celsius, []).append(ratio)
    cold, hot = of_ours.values()
    friction = TABLE_6[-1].friction
    explained = friction * (sum(hot) / len(hot)) / (sum(cold) / len(cold))
    parts = " and ".join(
        f"{', '.join(f'{ratio:.2f}' for ratio in ratios)} at {bulk:g} °C"
        for bulk, ratios in of_ours.items()
    )
    apart = max(max(ratios) / min(ratios) - 1 for ratios in of_ours.values())
    return Finding(
        f"the title: critical temperatures, exceeded on {100 * share:g} %",
        f"of our rises on {100 * share:g} % the printed ones are {parts}: within each pair the "
        f"same to {100 * apart:.1f} %",
        max(abs(ratio - 1) for ratios in of_ours.values() for ratio in ratios) < 0.1,
        f"So the row is likely this temperature, which the text announces. That the hot pair is "
        f"lower by a factor of its own would be explained by a friction of {explained:.3f} in its "
        f"calculation, near that of all other tests, in place of the printed {friction:g}. This "
        "is a guess that nothing but the numbers supports.",
    )


@in_house_style
def _draw(
    ticks: Sequence[str],
    printed: list[float],
    highest: dict[str, Values],
    exceeded: dict[str, Values],
    share: float,
) -> Figure:
    figure = Figure(figsize=(9.6, 4.6))
    left, right = figure.subplots(1, 2, sharey=True)
    beside(left, ticks, printed, highest, "highest temperature [°C]")
    beside(right, ticks, None, exceeded, f"temperature exceeded on {100 * share:g} % [°C]")
    for axes in (left, right):
        axes.tick_params(axis="x", labelsize=8)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure
