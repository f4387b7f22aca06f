"""Entries of a scene file: their key paths, and how a message shows them."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any


def quoted(value: object) -> str:
    """Show a value on one line, about as it stands in the file."""
    if isinstance(value, dict):
        text = "a table"
    elif isinstance(value, list):
        text = f"[{', '.join(map(quoted, value[:4]))}{', ...' if len(value) > 4 else ''}]"
    elif isinstance(value, str):
        text = json.dumps(value, ensure_ascii=not value.isprintable())
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, int) and abs(value) > 10**30:
        text = "a number above 10^30"
    else:
        text = str(value)
    return text if len(text) <= 100 else f"{text[:96]} ..."


def did_you_mean(word: str, words: Iterable[str]) -> str:
    """Ask whether the nearest known word was meant; empty if none is near.

    Examples
    --------
    >>> did_you_mean("swetp", ["local", "swept"]), did_you_mean("hurst", ["hurst_exponent"])
    (' (did you mean "swept"?)', ' (did you mean "hurst_exponent"?)')
    >>> did_you_mean("loads", ["sweep.loads"])
    ' (did you mean "sweep.loads"?)'
    """
    word, words = word[:80].lower(), list(words)
    ends = [other for other in words if other.endswith(f".{word}")]
    longer = [other for other in words if len(word) > 2 and other.startswith(word)]
    near = ends or longer or difflib.get_close_matches(word, words, n=1)
    return f' (did you mean "{near[0]}"?)' if near else ""


def entry_at(tables: Mapping[str, Any], path: str) -> Any:
    """Look up a path; None where it, or a table on the way to it, is missing or faulty."""
    entry: Any = tables
    for key in path.split("."):
        entry = None if entry is None else entry.get(key)
    return entry


def joined(place: str, key: str) -> str:
    """Path of a key of the table `place`, as TOML writes it."""
    bare = key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)
    return f"{place}.{bare}" if place else bare
