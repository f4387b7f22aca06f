"""Options in messages on tables, as they are written in a command, a scene file or Python."""

from __future__ import annotations

import re
from typing import Literal

Written = Literal["command", "scene", "Python"]
"""Where a user reads a table: by a command, from a scene file, or by a function."""
_ENTRIES = {"column": "columns", "word": "words"}
_PAIR = re.compile(r'--(column|given|where|skip|word) "([^"=]*)=((?:\\"|[^"])*)"')
_OF_FILE = re.compile(r"--(?!word)[a-z]+ \S")
_VALUE = re.compile(r"--(decimal|sheet) (names|[.,](?= or)|\S+?(?=[;,]? |$))")


def in_words_of(written: Written, message: str) -> str:
    """Rewrite the options in a message, such as ``--decimal ,``, as they are written elsewhere.

    Examples
    --------
    >>> in_words_of("scene", 'no load; name it by --column "load=HEADING", or --decimal ,')
    'no load; name it by columns = { load = "HEADING" }, or decimal = ",", in { path = "FILE" }'
    """
    if written == "command":
        return message
    pair = '{} = {{ {} = "{}" }}' if written == "scene" else '{}={{"{}": "{}"}}'
    one = '{} = "{}"' if written == "scene" else '{}="{}"'

    def pair_of(match: re.Match[str]) -> str:
        name, key, value = match.groups()
        is_bare = written != "scene" or re.fullmatch(r"\w+", key)
        return pair.format(_ENTRIES.get(name, name), key if is_bare else f'"{key}"', value)

    told = _VALUE.sub(
        lambda match: match[1] if match[2] == "names" else one.format(*match.groups()),
        _PAIR.sub(pair_of, message),
    )
    is_of_file = written == "scene" and bool(_OF_FILE.search(message))
    return told + ', in { path = "FILE" }' * is_of_file
