"""Words of messages: values as in a scene file, and the nearest of known names."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Sequence

_UNPRINTABLE = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def is_unprintable(text: str) -> bool:
    """True if a text has line breaks, controls, or marks that reverse the text that follows."""
    return bool(_UNPRINTABLE.search(text))


def quoted(value: object) -> str:
    """Write a value on one line, roughly as in the scene file."""
    if isinstance(value, dict):
        text = "a table"
    elif isinstance(value, list):
        text = f"[{', '.join(map(quoted, value[:4]))}{', ...' if len(value) > 4 else ''}]"
    elif isinstance(value, str):
        text = json.dumps(value, ensure_ascii=not value.isprintable())
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, int) and abs(value) > 10**30:  # Python writes 4300 digits at most
        text = "a number above 10^30"
    else:
        text = str(value)
    return text if len(text) <= 100 else f"{text[:96]} ..."


def fault_lines(name: str, faults: Sequence[str]) -> str:
    """Join faults to a message that names the file; several have a line each, 20 at most."""
    if len(faults) == 1:
        return f"{name}: {faults[0]}"
    lines = [f"{name}: {len(faults)} faults", *faults[:18]]
    if len(faults) > 18:
        lines.append(f"and {len(faults) - 18} more")
    return "\n  ".join(lines)


def did_you_mean(word: str, words: Iterable[str]) -> str:
    """Question such as "did you mean X?" for the most similar of `words`; else empty."""
    typed, known = word[:80].lower(), {name.lower(): name for name in words}
    with_ending = [name for name in known if name.endswith(f".{typed}")]
    longer = [name for name in known if len(typed) > 2 and name.startswith(typed)]
    anagrams = [name for name in known if sorted(name) == sorted(typed)]
    matches = with_ending or longer or anagrams
    matches = matches or difflib.get_close_matches(typed, known, n=1, cutoff=0.66)
    return f' (did you mean "{known[matches[0]]}"?)' if matches else ""


def key_path(table: str, key: str) -> str:
    """Path of a key within the table at path `table`, quoted as TOML needs it."""
    bare = key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)
    return f"{table}.{bare}" if table else bare


def listed(names: Sequence[str], max_count: int = 6) -> str:
    """List at most `max_count` names, and the number of further ones.

    Examples
    --------
    >>> listed(["nose", "base", "flank"], 2)
    'nose, base and 1 more'
    """
    if len(names) > max_count:
        return f"{', '.join(names[:max_count])} and {len(names) - max_count} more"
    return ", ".join(names)


def pluralized(number: int, singular: str, plural: str) -> str:
    """Number with its noun in the `singular` or `plural`, such as "1 load" or "3 loads"."""
    return f"{number} {singular if number == 1 else plural}"
