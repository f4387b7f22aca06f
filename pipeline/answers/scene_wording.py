"""Texts on a scene: its conditions, its warnings, and values of its entries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.messages import listed
from pipeline.quantities import display
from pipeline.shipped import typed_name
from pipeline.sweep.case import PATHS, Conditions, known_critical_temperature
from pipeline.sweep.notes import SceneWarning, unusual_warning
from pipeline.sweep.sweep import Sweep
from pipeline.units import typeset, unusual
from tribo import SelfAffineRoughness
from tribo.simulation.usual_values import USUAL

if TYPE_CHECKING:
    import xarray as xr

_DEFAULT_FRACTION = 0.1  # critical area fraction that is not printed
_IN_ANSWERS = ("cold_tracks", "narrow_window")  # which answers state elsewhere
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


def verdict_conditions(conditions: Conditions, from_tests: bool = False) -> str:
    """Friction, bulk and critical temperature of a verdict, as text.

    The critical area fraction follows if it is not 10 %, and corrections if there are any.
    """
    critical = display(known_critical_temperature(conditions), "°C", 4 if from_tests else 6)
    parts = [heating_words(conditions), f"critical temperature {critical}"]
    if from_tests:
        parts[-1] = f"critical temperature {critical} (median, from tests)"
    if conditions.critical_area_fraction != _DEFAULT_FRACTION:
        parts.append(f"critical area fraction {100 * conditions.critical_area_fraction:g} %")
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


def warning_text(warning: SceneWarning) -> str:
    """A warning as text, after the path of its entry."""
    text = _describe_warning(warning)
    if warning.cases or warning.of_case:
        names = listed(warning.cases) or "all cases"
        of_case = f"; numbers are of case {warning.of_case}" if warning.of_case else ""
        text = f"{text} (in {names}{of_case})"
    return f"{warning.path}: {text}" if warning.path else text


def warning_lines(sweep: Sweep, max_count: int = 3, answered: bool = False) -> list[str]:
    """Lines with at most `max_count` warnings on a scene, and the number of further ones.

    An answer (`answered`) omits warnings that it states at the points that they concern.
    """
    lines = [
        f"warning: {warning_text(warning)}"
        for warning in sweep.all_warnings
        if not (answered and warning.code in _IN_ANSWERS)
    ]
    if (more := len(lines) - max_count) > 0:
        lines[max_count:] = [f"{more} more warnings: irg check {typed_name(sweep.name)}"]
    return lines


def unusual_condition_lines(sweep: Sweep, conditions: Mapping[str, Any]) -> Iterator[str]:
    """Yield a warning of each condition with an unusual value that is not the scene's.

    `conditions` has values or arrays [SI] by name; of an array, the first unusual value is named.
    """
    for name in [name for name in PATHS if name in USUAL and name in conditions]:
        usual, scene_value = USUAL[name], getattr(sweep.conditions, name)
        values = np.ravel(conditions[name]).tolist()
        warnings = [
            warning
            for value in values
            if value is not None and value != scene_value
            for warning in unusual_warning(PATHS[name], value, usual.ends, usual.unit)
        ]
        if warnings:
            yield f"warning: {warning_text(warnings[0])}"


def _describe_warning(warning: SceneWarning) -> str:
    values: Any = warning.values
    match warning.code:
        case "unusual":
            value, low, high, unit = values
            return unusual(value, (low, high), unit)
        case "unusual_values":
            unusual_count, count, value, low, high, unit = values
            return f"{unusual_count:g} of {count:g} values: {unusual(value, (low, high), unit)}"
        case "narrow_window":
            contact, side = (display(length, "µm", 3) for length in values)
            words = f"the contact may grow to {contact}, wider than the window ({side})"
            return f"{words}; increase window.pixels"
        case "lay_along_sliding":
            return (
                "the grooves run along the sliding direction; if the same grooves pass the pin "
                'again, pattern = "swept" makes the rise about 50 % too high: use pattern = '
                '"local"'
            )
        case "long_correlation":
            axis, length = values
            return (
                f"along {axis} it is {display(length, 'µm', 3)}, more than a third of the "
                "window, so that temperatures vary strongly between surface realizations: "
                "increase window.pixels, or simulate several (sweep.realizations)"
            )
        case "no_wear":
            return "there is no table [wear]; an unworn contact stays narrow and runs hotter"
        case "far_test":
            load, velocity = values
            point = f"{load:g} N at {velocity:g} m/s"
            return f"the test at {point} lies far outside the sweep: check its units"
        case "fresh_specimens":
            names, more = values
            further = f" and {more:g} more" if more else ""
            noun = "tests" if more or ", " in names else "test"
            return (
                f"{noun} {names}{further}: one specimen at several points, but each is simulated "
                "as a fresh specimen and thus too hot: give its load stages"
            )
        case "large_uncertainty":
            return (
                f"{100 * values[0]:.3g} % is more than {100 * values[1]:.3g} %, up to which the "
                "effect of inputs was found to be linear: compare values by sweep.over"
            )
        case "cold_tracks":
            lengths = dict(zip(values[::2], values[1::2], strict=True))
            tracks = " and ".join(
                f"the {body} (track of {display(length, 'mm', 3)})"
                if length != "unknown"
                else f"the {body} (length of its track unknown: set motion.{body}_track_length)"
                for body, length in lengths.items()
            )
            entries = " and ".join(f"{body}.diameter" for body in lengths)
            return (
                f"heat from earlier revolutions of {tracks} is not included; it warms the contact "
                f"further: set {entries} and width, or track_length, or enter the bulk "
                "temperature of the warm tracks"
            )


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
