"""Texts on a scene: its conditions, lines of its warnings, and values of its entries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.condition_kinds import CONDITIONS
from pipeline.quantities import display
from pipeline.shipped import typed_name
from pipeline.sweep.case import Conditions, known_critical_temperature
from pipeline.sweep.notes import unusual_warning
from pipeline.sweep.sweep import Sweep
from pipeline.units import typeset
from tribo import SelfAffineRoughness

if TYPE_CHECKING:
    import xarray as xr

_DISPLAY_UNITS = {"m": "mm", "K": "°C", "Pa": "GPa", "m s-1": "m/s"}
"""Usual units for columns that the user added, by SI unit."""


def heating_words(conditions: Conditions) -> str:
    """Friction and bulk temperature in words, such as "friction 0.1, bulk temperature 25 °C".

    An added rise follows, such as "rise +6 %".
    """
    bulk = f"bulk temperature {display(conditions.bulk_temperature, '°C')}"
    if not conditions.added_rise_fraction:
        return f"friction {conditions.friction:g}, {bulk}"
    added = signed_percent(conditions.added_rise_fraction)
    return f"friction {conditions.friction:g}, {bulk}, rise {added}"


def verdict_conditions(conditions: Conditions, from_tests: bool) -> str:
    """Friction, bulk and critical temperature of a verdict, as text.

    Other conditions follow if they do not have their defaults, and corrections if there are any.
    """
    critical = display(known_critical_temperature(conditions), "°C", 4 if from_tests else 6)
    parts = [heating_words(conditions), f"critical temperature {critical}"]
    if from_tests:
        parts[-1] = f"critical temperature {critical} (median, from tests)"
    defaults = Conditions(conditions.friction, conditions.bulk_temperature)
    for name in CONDITIONS:
        is_above = name in ("critical_temperature", "added_rise_fraction")
        if not is_above and (value := getattr(conditions, name)) != getattr(defaults, name):
            parts.append(f"{name.replace('_', ' ')} {CONDITIONS[name].kind.to_text(value)}")
    text = ", ".join(parts)
    return f"{text}; {conditions.corrections.text}" if conditions.corrections else text


def governing_words(share: float) -> str:
    """Description of the governing temperature, by the share of the contact that exceeds it."""
    return f"exceeded on {100 * share:g} % of the contact" if share else "maximum"


def added_rise_words(conditions: Conditions) -> str:
    """Line on the rise added for effects outside the model; empty if none is added."""
    if not conditions.added_rise_fraction:
        return ""
    added = signed_percent(conditions.added_rise_fraction)
    return f"{added} is added to the rise for effects outside the model (irg help physics)"


def signed_percent(share: float) -> str:
    """A share in percent with its sign, such as "+6 %"."""
    return f"{100 * share:+.4g} %".replace("-", "−")


def warning_lines(sweep: Sweep, max_count: int = 3, answered: bool = False) -> list[str]:
    """Lines with at most `max_count` warnings on a scene, and the number of further ones.

    An answer (`answered`) omits warnings that it states at the points that they concern.
    """
    lines = [
        f"warning: {warning.text}"
        for warning in sweep.all_warnings
        if not (answered and warning.is_in_answers)
    ]
    if (more := len(lines) - max_count) > 0:
        lines[max_count:] = [f"{more} more warnings: irg check {typed_name(sweep.name)}"]
    return lines


def unusual_condition_lines(sweep: Sweep, conditions: Mapping[str, Any]) -> Iterator[str]:
    """Yield a warning of each condition with an unusual value that is not the scene's.

    `conditions` has values or arrays [SI] by name; of an array, the first unusual value is named.
    """
    for name, (entry, kind, _) in CONDITIONS.items():
        scene_value = getattr(sweep.conditions, name)
        values = np.ravel(conditions.get(name, ())).tolist()
        warnings = [
            warning
            for value in values
            if value is not None and value != scene_value
            for warning in unusual_warning(entry, value, kind.usual, kind.unit)
        ]
        if warnings:
            yield f"warning: {warnings[0].text}"


def test_group_words(sweep: Sweep) -> str:
    """What the group of tests of a store has: points of tests, of sensitivities, or both."""
    words = ["tests"] if sweep.tests else []
    return " and ".join([*words, *(["sensitivities"] if sweep.variants else [])])


def model_words(sweep: Sweep) -> str:
    """Surface, wear pattern and preset of a scene, to which its critical temperature belongs."""
    surface, wear = sweep.scene.roughness, sweep.scene.wear
    kinds = {type(None): "a smooth surface", SelfAffineRoughness: "a random surface"}
    kind = kinds.get(type(surface), "a measured surface")
    pattern = f"wear pattern {wear.pattern}" if wear else "no wear"
    settings = f"preset {sweep.preset}" if sweep.preset else "custom numerical settings"
    return f"{kind}, {pattern}, {settings}"


def value_words(axis: xr.DataArray, value: float | str) -> str:
    """A value along the coordinate `axis` of a varied entry, as text with its usual unit."""
    if isinstance(value, str):
        return value
    return display(value, usual_unit(axis)).removesuffix(" 1").strip()


def named_value(coordinate: xr.DataArray) -> str:
    """A value of a varied entry or condition with its name, such as "pin radius 4 mm"."""
    return f"{str(coordinate.name).replace('_', ' ')} {value_words(coordinate, coordinate.item())}"


def usual_unit(axis: xr.DataArray) -> str:
    """Unit in which values of the coordinate `axis` are printed, such as "mm" for a radius."""
    unit, display_unit = str(axis.attrs.get("units", "")), str(axis.attrs.get("display_unit", ""))
    return typeset(display_unit) if display_unit and unit else _DISPLAY_UNITS.get(unit, unit)
