"""Lines below any answer: conditions, errors, effects not included, tests, points and notes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from pipeline.answers.attributes import SHARP_PERCENTS
from pipeline.answers.digits import rounded_error
from pipeline.answers.readable import attribute_texts, flag_names, row_labels
from pipeline.messages import listed, split_notes

_MAX_REASONS = 6
_MILD_BUT_FOR_ENDS = (
    "mild wear may be severe at the pin's sharp ends, which are not modelled and wear severely at "
    "{} to {} % lower velocity"
)


def common_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below any answer: outliers, tests without a result, missing points, notes."""
    yield from test_lines(answer)
    if missing := answer.attrs["missing_points"]:
        yield f"points that are pending or failed, and were not used: {missing}"
    yield from split_notes(attribute_texts(answer, "notes"))


def test_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on outliers, and on tests without a result."""
    yield from split_notes(attribute_texts(answer, "outliers"))
    yield from withheld_lines(answer)


def withheld_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on verdicts that are withheld because tests have no result, or one outcome only."""
    for reason in split_notes(attribute_texts(answer, "verdicts_withheld")):
        yield f"some verdicts are withheld: {reason}"


def conditions_lines(answer: xr.Dataset) -> list[str]:
    """Line with the conditions of an answer, of its first row if rows differ in them."""
    texts = attribute_texts(answer, "conditions")
    if len(texts) > 1:
        return [f"conditions: {texts[0]}; {len(texts) - 1} more"]
    return [f"conditions: {text}" for text in texts]


def model_error_line(answer: xr.Dataset) -> str:
    """Line on the model error of the first case, and the number of further cases."""
    first, *others = attribute_texts(answer, "model_error")
    return f"model error: {first}, and {len(others)} more" if others else f"model error: {first}"


def temperature_error_line(answer: xr.Dataset) -> str:
    """Line on the numerical error of the governing temperature at several points."""
    errors = answer["temperature_error"].values
    if not np.isfinite(errors).any():
        return "numerical error of the governing temperature: unknown"
    ends = dict.fromkeys(map(rounded_error, (np.nanmin(errors), np.nanmax(errors))))
    return f"numerical error (95 %): ± {' to '.join(ends)} K of the governing temperature"


def not_included_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on effects that are not included and may be unsafe."""
    texts = attribute_texts(answer, "not_included")
    if len(texts) < 2 or answer["not_included"].ndim != 1:
        yield from (f"not included: {text}" for text in texts)
        return
    column = answer["not_included"]
    pairs = [*zip(column.values.tolist(), row_labels(answer, str(column.dims[0])), strict=True)]
    for text in texts:
        rows = [label for row_text, label in pairs if row_text == text]
        yield f"not included ({listed(rows)}): {text}"


def reason_lines(answer: xr.Dataset) -> Iterator[str]:
    """Reasons for points without a verdict, each with its first point."""
    axes = [
        answer[name].broadcast_like(answer["reason"]).values.ravel()
        for name in ("load", "velocity")
    ]
    rows = dict[str, list[tuple[float, float]]]()
    for reason, *pair in zip(answer["reason"].values.ravel(), *axes, strict=True):
        rows.setdefault(reason, []).append((pair[0], pair[1]))
    rows.pop("", None)
    for reason, points in [*rows.items()][:_MAX_REASONS]:
        texts = [f"{load:g} N at {velocity:g} m/s" for load, velocity in points]
        yield f"{listed(texts, 1)}: {reason}"
    if rest := sum(map(len, [*rows.values()][_MAX_REASONS:])):
        yield f"further points without a verdict: {rest}; see the column reason of -o TABLE.csv"


def point_warnings(points: xr.Dataset) -> Iterator[str]:
    """Yield the limits of the answer on one point, or on several."""
    flags = points["warning_flags"]
    names = flag_names(flags, int(np.bitwise_or.reduce(flags.values.ravel())))
    if "contact_at_edge" in names:
        yield "the contact reaches the edge of the window nearby; increase window.pixels"
    if "sharp_ends" in names and flags.ndim:
        yield _MILD_BUT_FOR_ENDS.format(*SHARP_PERCENTS)


def row_warnings(points: xr.Dataset) -> Iterator[str]:
    """Warnings on several points, each once."""
    yield from (f"warning: at some points {text}" for text in point_warnings(points))
