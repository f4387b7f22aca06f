"""Fig. 6: the highest temperature by the number of elements and of increments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from pipeline import Sweep
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, house_style
from pipeline.quantities import in_unit
from tribo import Fidelity, Scene, simulate
from tribo.types import Array

from .explicit_loop import EXPLICIT_LIMIT, explicit_loop, highest_rise, stiffness
from .labels import label_ends
from .publication import TABLE_4
from .recomputed import Finding, Recomputation, judged, line, mean, spread, texts
from .study import Study
from .transitions import HIGHEST, WearPattern, celsius_of, end_at, on_surfaces, worn

_BLOCKS = (8, 6, 4, 3, 2, 1)  # pixels along a side of an element
_INCREMENTS = (20, 30, 40, 50, 75, 100, 150, 200)
_PUBLISHED = 100  # increments that the paper states
_PAPER = Fidelity(pixels_per_element=2, increments=_PUBLISHED)
"""The grid and the increments of the paper, on which each is varied alone."""
_SCHEMES: dict[str, tuple[WearPattern, bool]] = {  # wear pattern, and whether wear is explicit
    "implicit, swept": ("swept", False),
    "explicit, swept": ("swept", True),
    "implicit, local": ("local", False),
    "explicit, local (as published)": ("local", True),
}
_POINT = TABLE_4[0]
_DRAWN_ELEMENTS = 48  # elements of the pressure field that are drawn
_NO_EFFECT = 2.0  # K: what the text may mean by "little to no effect", 1 % in the figure

_Row = dict[int, list[float]]
"""Temperatures over the surfaces [°C], by the number of elements along a side or of increments."""


def fig6(study: Study) -> Recomputation:
    """Report on the highest temperature at 750 N, 1.25 m/s with other grids and time steps."""
    sweep = study.scene("table4")
    if study.preset is None:
        sweep = sweep.with_fidelity(_PAPER)
    seeds, deciding = study.seeds(1), sweep.conditions.critical_area_fraction
    blocks = [
        n for n in _BLOCKS if study.preset is None or n >= sweep.scene.fidelity.pixels_per_element
    ]
    sides = {sweep.scene.pixels.shape[0] // block: block for block in blocks}
    by_elements: dict[str, _Row] = {"maximum": {}, "10 %": {}, "one step": {}}
    for side in study.stages(sides, "{0} × {0} elements".format, weight=lambda side: side**2):
        elements = {"pixels_per_element": sides[side], "fewest_elements": 0}
        scene = _with(sweep, **elements)
        swept = on_surfaces([(scene, _POINT)], seeds)
        unworn = on_surfaces([(worn(scene, "unworn"), _POINT)], seeds)
        by_elements["maximum"][side] = celsius_of(swept, HIGHEST)[0].tolist()
        by_elements["10 %"][side] = celsius_of(swept, deciding)[0].tolist()
        by_elements["one step"][side] = celsius_of(unworn, HIGHEST)[0].tolist()
    counts = [n for n in _INCREMENTS if study.preset is None or n <= 50]
    drawn_count = max(count for count in counts if count <= _PUBLISHED)
    by_increments, unstable, fields = {}, {}, {}
    for name, (pattern, is_explicit) in _SCHEMES.items():
        scenes = [worn(sweep, pattern).take_surface(seed) for seed in seeds]
        stages = study.stages(counts, (name + ", {} increments").format, weight=float)
        by_increments[name], pressures = _with_steps(scenes, stages, is_explicit)
        unstable[name] = [
            count
            for count in counts
            if is_explicit and _is_unstable(_with(scenes[0], increments=count).scene)
        ]
        if pattern == "local" and drawn_count in pressures:
            fields[name] = pressures[drawn_count]
    neighbours = {name: neighbours_of(field) for name, field in fields.items()}
    values = {
        "load": _POINT.normal_load,
        "velocity": _POINT.velocity,
        "friction": _POINT.friction,
        "bulk": in_unit(sweep.conditions.bulk_temperature, "°C"),
    }
    return Recomputation.from_values(
        "fig6",
        values,
        verdicts={},
        findings=(
            _on_elements(by_elements),
            _on_increments(by_increments, unstable, counts),
        ),
        table=_table(by_elements, by_increments),
        data={
            "by_elements": by_elements,
            "by_increments": by_increments,
            "neighbours": neighbours,
            "unstable_increments": unstable,
        },
        figure=_draw(sweep, by_elements, by_increments, fields, drawn_count),
    )


def _with_steps(
    surfaces: Sequence[Sweep], counts: Iterable[int], is_explicit: bool
) -> tuple[_Row, dict[int, Array]]:
    """Highest temperatures [°C] and first pressures [Pa], by number of increments."""
    highest: _Row = {}
    pressures: dict[int, Array] = {}
    end_of = _explicit_end if is_explicit else _implicit_end
    for count in counts:
        ends = [end_of(_with(s, increments=count, fewest_elements=0)) for s in surfaces]
        highest[count] = [celsius for celsius, _ in ends]
        pressures[count] = ends[0][1]
    return highest, pressures


def _implicit_end(sweep: Sweep) -> tuple[float, Array]:
    """Highest temperature [°C] and pressure [Pa] at the end of the test, by `tribo.simulate`."""
    *_, state = simulate(sweep.scene, _POINT.normal_load, _POINT.velocity)
    end = end_at(sweep, state, _POINT.friction)
    return float(celsius_of(end, HIGHEST)), state.pressure


def _explicit_end(sweep: Sweep) -> tuple[float, Array]:
    """Highest temperature [°C] and pressure [Pa] at the end of the test, by the explicit loop."""
    load, velocity = _POINT.normal_load, _POINT.velocity
    pressure = explicit_loop(sweep.scene, load, velocity)
    *_, last = sweep.scene.all_load_steps(load)
    rise = highest_rise(sweep.scene, pressure, velocity, last.time)
    conditions = replace(sweep.conditions, friction=_POINT.friction)
    return float(in_unit(conditions.contact_temperature(rise), "°C")), pressure


def _is_unstable(scene: Scene) -> bool:
    """True if the increments of the test are too long for the explicit loop."""
    first = next(scene.all_load_steps(_POINT.normal_load))
    return stiffness(scene, scene.grid, _POINT.velocity * first.time) >= EXPLICIT_LIMIT


def _with(sweep: Sweep, **changes: Any) -> Sweep:
    return sweep.with_fidelity(replace(sweep.scene.fidelity, **changes))


def neighbours_of(pressure: Array) -> float:
    """Correlation of pressures of elements that are neighbours along x, where rows carry load."""
    rows = pressure[pressure.any(axis=1)]
    return float(np.corrcoef(rows[:-1].ravel(), rows[1:].ravel())[0, 1])


def _table(by_elements: Mapping[str, _Row], by_increments: Mapping[str, _Row]) -> pd.DataFrame:
    sides = list(by_elements["maximum"])
    counts = list(next(iter(by_increments.values())))
    width = max(len(sides), len(counts))

    def padded(name: str, cells: Iterable[Any]) -> tuple[str, ...]:
        texts = list(cells)
        return line(name, [*texts, *[""] * (width - len(texts))], ".1f")

    labels = {
        "maximum": "highest [°C]",
        "10 %": "exceeded on 10 % [°C]",
        "one step": "highest, unworn [°C]",
    }
    return texts(
        padded("a  elements", (f"{side}²" for side in sides)),
        (
            *(padded(text, (by_elements[n][side] for side in sides)) for n, text in labels.items()),
            padded("b  increments", map(str, counts)),
            *(
                padded(name, (row[count] for count in counts))
                for name, row in by_increments.items()
            ),
        ),
    )


def _on_elements(by_elements: Mapping[str, _Row]) -> Finding:
    *_, coarse, fine = by_elements["maximum"]
    change = {name: _difference(row, fine, coarse) for name, row in by_elements.items()}
    values = {"coarse": coarse, "fine": fine, "change": change}
    largest = max(abs(change["maximum"]), abs(change["10 %"]))
    return judged("fig6", "elements", largest < _NO_EFFECT, values)


def _on_increments(
    by_increments: Mapping[str, _Row], unstable: Mapping[str, list[int]], counts: Sequence[int]
) -> Finding:
    """Finding that tells if more increments than the published number change a temperature."""
    base, last = _PUBLISHED if _PUBLISHED in counts else counts[0], counts[-1]
    moved = {name: _difference(row, last, base) for name, row in by_increments.items()}
    values = {
        "base": base,
        "last": last,
        "moved": "; ".join(f"{_signed(kelvin)} K {name}" for name, kelvin in moved.items()),
        "unstable": "; ".join(name for name, numbers in unstable.items() if numbers) or "none",
    }
    is_still = max(map(abs, moved.values())) < _NO_EFFECT
    return judged("fig6", "increments", is_still, values)


def _difference(row: _Row, number: int, other: int) -> float:
    """Temperature difference [K] between two numbers of elements or increments in `row`."""
    return float(mean(row[number]) - mean(row[other]))


def _signed(value: float) -> str:
    """Number as text with one decimal and a sign; zero without a sign."""
    return f"{round(value, 1) + 0.0:+.1f}" if round(value, 1) else "0.0"


@house_style
def _draw(
    sweep: Sweep,
    by_elements: Mapping[str, _Row],
    by_increments: Mapping[str, _Row],
    fields: Mapping[str, Array],
    drawn_count: int,
) -> Figure:
    figure = Figure(figsize=(10.4, 8.2))
    halves: Any = figure.subfigures(2, 1, height_ratios=(1.15, 1))
    upper, lower = halves
    left, right = upper.subplots(1, 2, sharey=True)
    if fields:
        draw_fields(lower, sweep, fields, drawn_count, "cd")
    for name, label, colour, style in (
        ("one step", "unworn,\nhighest", BLACK, "--"),
        ("maximum", "swept wear,\nhighest", BLUE, "-"),
        ("10 %", "swept wear,\nexceeded\non 10 %", GREEN, "-"),
    ):
        _curve(left, by_elements[name], label, colour, style)
    left.set_xlabel("elements along each side")
    left.set_ylabel("contact temperature [°C]")
    left.set_xticks([60, 120, 240, 480])
    looks = ((BLUE, "-"), (BLUE, ":"), (VERMILION, "-"), (VERMILION, ":"))
    for (name, row), look in zip(by_increments.items(), looks, strict=True):
        _curve(right, row, name, *look)
    right.set_xlabel("increments of the ramp")
    right.axvline(_PUBLISHED, color=GREY, lw=0.9)
    if fields:
        right.annotate(
            " as in c and d", (_PUBLISHED, 1.0), (0, -3), xycoords=("data", "axes fraction"),
            textcoords="offset points", va="top", color=GREY, fontsize=9, annotation_clip=True,
        )  # fmt: skip
    for words, axes in (("a  with smaller elements", left), ("b  with shorter steps", right)):
        axes.set_title(words, loc="left")
        axes.set_xlim(right=1.02 * axes.lines[0].get_xdata()[-1])
        label_ends(axes)
    return figure


def _curve(axes: Axes, row: _Row, name: str, colour: str, style: str) -> None:
    numbers = sorted(row)
    values = [row[n] for n in numbers]
    bars = spread(values) if len(values[0]) > 1 else None
    axes.errorbar(
        numbers, mean(values), bars, color=colour, ls=style, marker="o", ms=3.5, capsize=2,
        label=name,
    )  # fmt: skip


def draw_fields(
    figure: FigureBase, sweep: Sweep, fields: Mapping[str, Array], increments: int, letters: str
) -> None:
    """Draw fields in the middle of the contact, after explicit and implicit steps, on one scale."""
    fields = dict(sorted(fields.items()))  # explicit first
    row = np.atleast_1d(figure.subplots(1, len(fields), sharey=True))
    dx, dy = (
        1e6 * side * sweep.scene.fidelity.pixels_per_element for side in sweep.scene.pixels.spacing
    )
    parts = []
    for pressure in fields.values():
        (nx, ny), gigapascal = pressure.shape, pressure / 1e9
        i, j = min(_DRAWN_ELEMENTS, nx), min(_DRAWN_ELEMENTS, ny)
        parts.append(gigapascal[(nx - i) // 2 : (nx + i) // 2, (ny - j) // 2 : (ny + j) // 2])
    highest = max(float(part.max()) for part in parts)
    for letter, axes, name, part in zip(letters, row, fields, parts, strict=False):
        image = axes.imshow(
            np.ma.masked_equal(part.T, 0.0), origin="lower", cmap="viridis_r", vmin=0,
            vmax=highest, aspect="auto", interpolation="nearest",
            extent=(0, dx * part.shape[0], 0, dy * part.shape[1]),
        )  # fmt: skip
        axes.set_title(f"{letter}  {name}, {increments} increments", loc="left")
        axes.set_xlabel("x, along sliding [µm]")
        axes.grid(visible=False)
    row[0].set_ylabel("y [µm], a part of the contact")
    figure.colorbar(image, ax=list(row), label="pressure [GPa]", pad=0.02)
