"""How answers show themselves: a line for each value, and in a notebook a table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields
from html import escape
from textwrap import shorten
from typing import Any, TypeVar

import numpy as np

Line = tuple[str, str]

T = TypeVar("T")
_WIDEST = 76  # letters of a value, at most
_MOST = 6  # values that are listed, at most


def shown(cls: type[T]) -> type[T]:
    """Class decorator: print a dataclass as one line for each field or row of ``description()``.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @shown
    ... @dataclass
    ... class Answer:
    ...     velocity: float
    ...     loads: tuple[float, ...]
    >>> Answer(2.0, (200.0, 400.0))
    Answer
      velocity  2
      loads     200, 400
    """
    for name, method in (("__repr__", _text), ("_repr_html_", _html)):
        setattr(cls, name, method)
    return cls


def _text(answer: Any) -> str:
    title, rows = _titled_rows(answer)
    width = max((len(name) for name, _ in rows), default=0)
    return "\n".join([title, *(f"  {name:{width}}  {text}" for name, text in rows)])


def _html(answer: Any) -> str:
    """HTML table of an answer's values, followed by its data frames."""
    title, rows = _titled_rows(answer)
    cells = "".join(
        f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in rows
    )
    values = {**dict(_values(answer)), "table": getattr(answer, "table", None)}
    frames = [value for value in values.values() if hasattr(value, "to_html")]
    tables = "".join(frame.to_html(index=False) for frame in frames)
    return f"<table><caption>{escape(title)}</caption>{cells}</table>{tables}"


def _titled_rows(answer: Any) -> tuple[str, list[Line]]:
    """Title of an answer, and its rows of name and text."""
    headline = getattr(answer, "sentence", "") or getattr(answer, "title", "")
    title = ": ".join(filter(None, (type(answer).__name__, headline)))
    values = _values(answer)
    if hasattr(answer, "description"):
        title, tables = answer.description()
        values = iter(tables.items())
    texts = ((name, _value_text(value)) for name, value in values if name != "title")
    return title, [(name, text) for name, text in texts if text]


def _values(answer: Any) -> Iterator[tuple[str, Any]]:
    for one in fields(answer):
        if one.repr:
            yield one.name, getattr(answer, one.name)


def _value_text(value: Any) -> str:
    """Write a value on one line; empty for None and empty tables."""
    if isinstance(value, float | np.floating):
        return "not known" if math.isnan(value) else f"{value:.4g}"
    if hasattr(value, "to_html"):
        return f"{len(value)} row{'s' * (len(value) > 1)}" if len(value) else ""
    if isinstance(value, np.ndarray) and value.size > _MOST:
        ends = " to ".join(_value_text(end(value)) for end in (np.nanmin, np.nanmax))
        return f"array of shape {value.shape}, {ends}"
    if isinstance(value, Mapping):
        value = [f"{name}: {_value_text(one)}" for name, one in value.items()]
    if isinstance(value, tuple | list | np.ndarray):
        texts = [_value_text(one) for one in value[:_MOST]]
        more = f" and {len(value) - _MOST} more" * (len(value) > _MOST)
        return shorten(", ".join(texts), _WIDEST - len(more), placeholder=" …") + more
    if value is None:
        return ""
    return shorten(str(value).partition("\n")[0], _WIDEST, placeholder=" …")
