"""Warnings on a scene as text, from their codes and values."""

from __future__ import annotations

from typing import Any

from pipeline.quantities import display
from pipeline.shipped import typed_name
from pipeline.sweep.notes import SceneWarning
from pipeline.sweep.sweep import Sweep
from pipeline.units import unusual

_MOST_NAMED = 6  # cases of one warning
_IN_ANSWERS = ("sharp_ends", "cold_tracks", "narrow_window")  # which answers say in their places


def warning_text(warning: SceneWarning) -> str:
    """A warning as text, after the path of its entry."""
    words = _words(warning) + _cases_text(warning)
    return f"{warning.place}: {words}" if warning.place else words


def warning_lines(sweep: Sweep, most: int = 3, answered: bool = False) -> list[str]:
    """Lines with the gravest warnings on a scene, `most` of them, and the number of the others.

    In an answer (`answered`) those are left out that it says at the points that they limit.
    """
    lines = [
        f"warning: {warning_text(one)}"
        for one in sweep.all_warnings
        if not (answered and one.code in _IN_ANSWERS)
    ]
    if (more := len(lines) - most) > 0:
        lines[most:] = [f"{more} more warnings: irg check {typed_name(sweep.name)}"]
    return lines


def _words(warning: SceneWarning) -> str:
    values: Any = warning.values
    match warning.code:
        case "unusual":
            value, low, high, unit = values
            return unusual(value, (low, high), unit)
        case "unusual_values":
            odd, known, value, low, high, unit = values
            return f"{odd:g} of {known:g} values: {unusual(value, (low, high), unit)}"
        case "narrow_window":
            contact, side = (display(one, "µm", 3) for one in values)
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
            return "none is given; an unworn contact stays narrow and gets hotter"
        case "far_test":
            load, velocity = values
            place = f"{load:g} N at {velocity:g} m/s"
            return f"the test at {place} lies far outside the sweep: check its units"
        case "fresh_specimens":
            names, more = values
            tests = f"test{'s' * (', ' in names)} {names}" + f" and {more:g} more" * (more > 0)
            return (
                f"{tests}: one specimen at several points, but each is simulated as a fresh "
                "specimen and thus too hot: give its load stages"
            )
        case "cold_tracks":
            length, bodies = values
            names = bodies.split()
            entries = " and ".join(f"{body}.diameter" for body in names)
            return (
                f"heat from earlier revolutions of the {' and the '.join(names)} is not included; "
                f"on tracks of {display(length, 'mm', 3)} it warms the contact further: set "
                f"{entries} and width, or track_length, or enter the bulk temperature of the warm "
                "tracks"
            )
        case "sharp_ends":
            return (
                "the pin's sharp ends are not modelled; severe wear starts there at 9–23 % lower "
                "velocity (irg help physics)"
            )


def _cases_text(warning: SceneWarning) -> str:
    """Which cases have a warning; empty if all have the same."""
    if not (warning.cases or warning.of_case):
        return ""
    more = len(warning.cases) - _MOST_NAMED
    named = ", ".join(warning.cases[:_MOST_NAMED]) + f" and {more} more" * (more > 0)
    alike = f"; numbers are of case {warning.of_case}" * bool(warning.of_case)
    return f" (in {named or 'all cases'}{alike})"
