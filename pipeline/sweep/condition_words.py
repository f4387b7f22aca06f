"""Words on when wear is severe, by the conditions of a verdict."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from pipeline.quantities import display
from pipeline.sweep.conditions import PATHS, Conditions
from pipeline.sweep.shown import Line


def condition_rows(conditions: Conditions, drawn: Collection[str] = ()) -> Iterator[Line]:
    """Yield pairs (subject, text) that say when wear is severe, for a table.

    For entries whose paths are in `drawn` the text is "of each sample".
    """
    bulk = f"bulk {display(conditions.bulk_temperature, '°C')}"
    if conditions.disk_temperature is not None:
        bulk += f" (pin) and {display(conditions.disk_temperature, '°C')} (disk)"
    if any(path.startswith(PATHS["bulk_temperature"]) for path in drawn):
        bulk = "bulk of each sample"
    friction = f"{conditions.friction:g}"
    yield "friction", f"{'of each sample' if PATHS['friction'] in drawn else friction}, {bulk}"
    if conditions.corrections:
        yield "corrections", conditions.corrections.text
    if conditions.critical_temperature is not None:
        yield "severe", severe_words(conditions, drawn)


def judged_by(several: Iterable[Conditions], drawn: Collection[str] = ()) -> str:
    """Say in one line when wear is severe under several conditions, without repeats.

    For entries whose paths are in `drawn` the text is "of each sample".
    """
    each = [
        (
            severe_words(one, drawn),
            " ".join(next(condition_rows(one, drawn))),
            one.corrections.text if one.corrections else "no correction",
        )
        for one in several
    ]
    parts = [" or ".join(dict.fromkeys(part)) for part in zip(*each, strict=True)]
    return f"severe wear: {'; '.join(part for part in parts if part != 'no correction')}"


def severe_words(conditions: Conditions, drawn: Collection[str] = ()) -> str:
    """Say above which temperature wear is severe: "of each sample" if its path is in `drawn`."""
    severe = conditions.decisive.severe
    if PATHS["share"] in drawn:
        severe = "more than the share of each sample of its contact above"
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
