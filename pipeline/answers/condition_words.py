"""Words on when wear is severe, by the conditions of a verdict."""

from __future__ import annotations

import math
from collections.abc import Iterable

from pipeline.quantities import display
from pipeline.sweep.case import SpecimenTest
from pipeline.sweep.conditions import Conditions, known_critical_temperature

USUAL_SHARE = 0.1
"""Failing share that verdicts leave unsaid."""
_SAME = 1e-6  # relative rounding difference of equal frictions


def heating_words(conditions: Conditions, tests: Iterable[SpecimenTest] = ()) -> str:
    """Friction and bulk temperature in words, such as "friction 0.1, bulk temperature 25 °C".

    Frictions of `tests` are named if one of them had another. A rise beside the model is added,
    such as "rise +6 %".
    """
    bulk = f"bulk temperature {display(conditions.bulk_temperature, '°C')}"
    friction = f"friction {conditions.friction:.4g}{_test_frictions(conditions, tests)}"
    added = f", rise {signed_percent(conditions.added_rise_fraction)}"
    return f"{friction}, {bulk}{added * bool(conditions.added_rise_fraction)}"


def _test_frictions(conditions: Conditions, tests: Iterable[SpecimenTest]) -> str:
    """Range of the frictions of tests, such as " (tests 0.09 to 0.103)"; empty if all are equal."""
    used = {test.velocity: test.case.conditions.friction_at(test.velocity) for test in tests}
    same = (
        math.isclose(one, conditions.friction_at(velocity), rel_tol=_SAME)
        for velocity, one in used.items()
    )
    if all(same):
        return ""
    ends = dict.fromkeys(f"{one:.3g}" for one in (min(used.values()), max(used.values())))
    return f" (tests {' to '.join(ends)})"


def verdict_conditions(
    conditions: Conditions, tests: Iterable[SpecimenTest] = (), from_tests: bool = False
) -> str:
    """Friction, bulk and critical temperature that a verdict holds for, as `heating_words`.

    The critical area fraction follows if it is not a tenth, and corrections if there are some.
    """
    critical = display(known_critical_temperature(conditions), "°C", 5)
    said = f"{heating_words(conditions, tests)}, critical temperature {critical}"
    said += " (median, from tests)" * from_tests
    share = conditions.critical_area_fraction
    said += "" if share == USUAL_SHARE else f", critical area fraction {100 * share:.4g} %"
    return f"{said}; {conditions.corrections.text}" if conditions.corrections else said


def governing_words(share: float) -> str:
    """Words that name the temperature which a share of the contact exceeds."""
    return f"exceeded on {100 * share:g} % of the contact" if share else "maximum"


def added_rise_words(conditions: Conditions) -> str:
    """Line on the rise that is added for what acts beside the model; empty if none is added."""
    if not conditions.added_rise_fraction:
        return ""
    added = signed_percent(conditions.added_rise_fraction)
    return f"{added} is added to the rise for effects outside the model (irg help physics)"


def signed_percent(share: float) -> str:
    """A share in percent with its sign, such as "+6 %"."""
    return f"{100 * share:+.4g} %".replace("-", "−")
