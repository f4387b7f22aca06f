"""Words on when wear is severe, by the conditions of a verdict."""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.quantities import display
from pipeline.sweep.conditions import Conditions, known_critical_temperature


def heating_words(conditions: Conditions) -> str:
    """Friction and bulk temperature in words, such as "friction 0.1, bulk 25 °C".

    A rise beside the model is added, such as "rise +6 %".
    """
    bulk = f"bulk {display(conditions.bulk_temperature, '°C')}"
    if conditions.disk_temperature is not None:
        bulk += f" (pin) and {display(conditions.disk_temperature, '°C')} (disk)"
    added = f", rise {signed_percent(conditions.unmodelled_rise)}"
    return f"friction {conditions.friction:g}, {bulk}{added * bool(conditions.unmodelled_rise)}"


def unmodelled_rise_words(conditions: Conditions) -> str:
    """Line on the rise that is added for what acts beside the model; empty if none is added."""
    if not conditions.unmodelled_rise:
        return ""
    added = signed_percent(conditions.unmodelled_rise)
    return f"{added} of the rise is added for what acts beside the model (irg help physics)"


def signed_percent(share: float) -> str:
    """A share in percent with its sign, such as "+6 %"."""
    return f"{100 * share:+.4g} %".replace("-", "−")


def judged_by(several: Iterable[Conditions]) -> str:
    """Say in one line when wear is severe: the limit, friction, bulk and corrections.

    `several` has the conditions of each scene; where these differ, all are named.
    """
    each = [
        (
            f"{one.criterion.severe} {display(known_critical_temperature(one), '°C')}",
            heating_words(one),
            one.corrections.text if one.corrections else "no correction",
        )
        for one in several
    ]
    parts = [" or ".join(dict.fromkeys(part)) for part in zip(*each, strict=True)]
    return f"severe wear: {'; '.join(part for part in parts if part != 'no correction')}"
