"""Words on when wear is severe, by the conditions of a verdict."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from pipeline.quantities import display
from pipeline.sweep.conditions import PATHS, Conditions


def heating_words(conditions: Conditions, drawn: Collection[str] = ()) -> str:
    """Friction and bulk temperature in words, such as "friction 0.1, bulk 25 °C".

    Values of entries whose paths are in `drawn` are replaced by the words "of each sample".
    """
    bulk = f"bulk {display(conditions.bulk_temperature, '°C')}"
    if conditions.disk_temperature is not None:
        bulk += f" (pin) and {display(conditions.disk_temperature, '°C')} (disk)"
    if any(path.startswith(PATHS["bulk_temperature"]) for path in drawn):
        bulk = "bulk of each sample"
    friction = "of each sample" if PATHS["friction"] in drawn else f"{conditions.friction:g}"
    return f"friction {friction}, {bulk}"


def judged_by(several: Iterable[Conditions], drawn: Collection[str] = ()) -> str:
    """Say in one line when wear is severe: the limit, friction, bulk and corrections.

    `several` has the conditions of each scene; where these differ, all are named. Values of entries
    whose paths are in `drawn` are replaced by the words "of each sample".
    """
    each = [
        (
            severe_words(one, drawn),
            heating_words(one, drawn),
            one.corrections.text if one.corrections else "no correction",
        )
        for one in several
    ]
    parts = [" or ".join(dict.fromkeys(part)) for part in zip(*each, strict=True)]
    return f"severe wear: {'; '.join(part for part in parts if part != 'no correction')}"


def severe_words(conditions: Conditions, drawn: Collection[str] = ()) -> str:
    """Words on the limit of severe wear, such as "more than 10 % of the contact above 145 °C".

    `drawn` has the paths of entries that differ between samples. If they include the critical
    temperature or the share, its value is replaced by the words "of each sample".
    """
    severe = conditions.decisive.severe
    if PATHS["share"] in drawn:
        severe = "more than a share of the contact, drawn for each sample, above"
    critical = display(conditions.known_critical_temperature(), "°C")
    if conditions.critical_sd:
        critical = f"{critical} ± {display(conditions.critical_sd, 'K', 3)}"
    if PATHS["critical_temperature"] in drawn:
        critical = "the critical temperature of each sample"
    return f"{severe} {critical}"


def critical_in_words(value: float, sd: float | None) -> str:
    """Write a critical temperature [K] as text, with its standard deviation [K] if known."""
    doubt = f" ± {display(sd, 'K', 2)}, which is counted" if sd else ", taken as exact"
    return f"the critical temperature is {display(value, '°C', 4)}{doubt}"
