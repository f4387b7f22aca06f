"""Lines below any answer: conditions, errors, notes, and what is not included."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import xarray as xr

from pipeline.answers.hottest_end import is_severe_at_end
from pipeline.answers.value_text import attribute_texts, flag_names, format_error
from pipeline.messages import listed
from pipeline.store.schema import PLANE

_MAX_REASONS = 6


def common_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below any answer: outliers, tests without a result, missing points, notes."""
    yield from attribute_texts(answer, "outliers")
    yield from withheld_lines(answer)
    if missing := answer.attrs["missing_points"]:
        yield f"points that are pending or failed, and were not used: {missing}"
    yield from attribute_texts(answer, "notes")


def withheld_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on verdicts that are withheld because tests have no result, or one outcome only."""
    for reason in attribute_texts(answer, "verdicts_withheld"):
        yield f"some verdicts are withheld: {reason}"


def conditions_lines(answer: xr.Dataset) -> list[str]:
    """Line with the conditions of an answer, of its first row if rows differ in them."""
    texts = attribute_texts(answer, "conditions")
    if len(texts) > 1:
        return [f"conditions: {texts[0]}; {len(texts) - 1} more"]
    return [f"conditions: {text}" for text in texts]


def model_error_line(answer: xr.Dataset) -> str:
    """Line on the model error of the first case, and the number of further cases."""
    first, *further_texts = attribute_texts(answer, "model_error")
    if further_texts:
        return f"model error: {first}, and {len(further_texts)} more"
    return f"model error: {first}"


def uncertain_inputs_lines(answer: xr.Dataset) -> Iterator[str]:
    """Line on the uncertain inputs of the first case, and the number of further cases."""
    texts = attribute_texts(answer, "uncertain_inputs")
    if texts:
        more = f", and {len(texts) - 1} more" if len(texts) > 1 else ""
        yield f"uncertain inputs: {texts[0]}{more}"


def not_included_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on effects that are not included and may be unsafe."""
    if "not_included" in answer.attrs:
        yield f"not included: {answer.attrs['not_included']}"
        return
    texts = answer["not_included"].values.ravel()
    for text, count in Counter(texts.tolist()).items():
        yield f"not included ({count} of {len(texts)} cases): {text}"


def reason_lines(answer: xr.Dataset) -> Iterator[str]:
    """Reasons for points without a verdict, each with its first point."""
    axes = (answer[name].broadcast_like(answer["reason"]).values.ravel() for name in PLANE)
    points = dict[str, list[str]]()
    for reason, load, velocity in zip(answer["reason"].values.ravel(), *axes, strict=True):
        points.setdefault(reason, []).append(f"{load:g} N at {velocity:g} m/s")
    points.pop("", None)
    for reason, texts in [*points.items()][:_MAX_REASONS]:
        yield f"{listed(texts, 1)}: {reason}"
    if rest := sum(map(len, [*points.values()][_MAX_REASONS:])):
        yield f"further points without a verdict: {rest}; see the column reason of -o TABLE.csv"


def contact_warnings(points: xr.Dataset) -> Iterator[str]:
    """Yield a warning if the contact of a point reaches an edge, or is severe at an end alone."""
    flags = points["warning_flags"]
    if "contact_at_edge" in flag_names(flags, int(np.bitwise_or.reduce(flags.values.ravel()))):
        at = "at some points, " if flags.ndim else ""
        yield (
            f"warning: {at}the contact reaches the edge of the window nearby; increase "
            "window.pixels"
        )
    if "end_temperature" in points and (is_severe_at_end(points)).any():
        at = "at some points, " if flags.ndim else ""
        yield (
            f"warning: {at}the hottest end of the pin is above the critical temperature, but the "
            "verdict on the whole pin is mild; relieve the ends, or let them wear"
        )


def temperature_error_line(answer: xr.Dataset) -> str:
    """Line on the numerical error of the governing temperature at several points."""
    errors = answer["temperature_error"].values
    if not np.isfinite(errors).any():
        return "numerical error of the governing temperature: unknown"
    ends = dict.fromkeys(map(format_error, (np.nanmin(errors), np.nanmax(errors))))
    return f"numerical error (95 %): ± {' to '.join(ends)} K of the governing temperature"
