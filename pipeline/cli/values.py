"""Convert values of options from the text that a user types."""

from __future__ import annotations

import math
import tomllib
from argparse import ArgumentTypeError as Refused
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pipeline.paths import found_store, user_path

# Modules that import NumPy are imported inside functions, as --help does not need them.


def quantity(like: str, is_signed: bool = False) -> Callable[[str], float]:
    """Return a function that converts text such as `like`, a number with a unit, to SI.

    The function refuses values that are not above 0, unless `is_signed`. If `like` is in K, the
    text is a difference of temperatures.
    """

    def read(text: str) -> float:
        from pipeline.units import difference_in_si, to_si

        try:
            value: float = (difference_in_si if like.endswith(" K") else to_si)(text, like)
        except ValueError as error:
            raise Refused(f'{error}; example: "{like}"') from error
        if not (is_signed or 0 < value < math.inf):
            raise Refused(f'"{text}" must be above 0, such as "{like}"')
        return value

    return read


def store(text: str) -> Path | str:
    """Read the path or the URL of a store."""
    return text if "://" in text else user_path(text)


def stored(text: str) -> Path | str:
    """Read the path or the URL of a store to read, or the name of a scene whose store that is."""
    return store(str(found_store(text)))


def figure(text: str) -> Path:
    """Return the path of a figure to write; refuses another suffix, or one that cannot be."""
    from pipeline.frames import FIGURES

    return _writable(text, FIGURES)


def table(text: str, or_figure: bool = False) -> Path:
    """Return the path of a table to write; with `or_figure` it may also be that of a figure.

    The suffix tells them apart. Refuses another suffix, or a path that cannot be written.
    """
    from pipeline.frames import FIGURES, TABLES

    return _writable(text, (*FIGURES, *TABLES) if or_figure else TABLES)


def _writable(text: str, suffixes: Sequence[str]) -> Path:
    from pipeline.frames import writable_path

    try:
        return writable_path(text, suffixes)
    except ValueError as error:
        raise Refused(str(error)) from None


def count(text: str, least: int = 1) -> int:
    """Read a whole number of at least `least`."""
    with suppress(ValueError):
        if (number := int(text)) >= least:
            return number
    raise Refused(f'"{text}" is not a whole number of at least {least}')


def sides(text: str) -> tuple[float, float]:
    """Read the sides of a pixel [m] from ``DX,DY``, or from one length for a square pixel."""
    read = quantity("0.8 um")
    first, comma, second = text.partition(",")
    return read(first), read(second if comma else first)


def share(text: str) -> float:
    """Read a share between 0 and 1, such as 2% or 0.02."""
    from pipeline.units import share_of

    with suppress(ValueError):
        if 0 < (value := share_of(text)) < 1:
            return value
    raise Refused(f'"{text}" is not a fraction between 0 and 1; give one such as 2%')


def number(text: str) -> float:
    """Read a number without a unit, such as 0.12 or 12%."""
    from pipeline.units import share_of

    with suppress(ValueError):
        return float(share_of(text))
    raise Refused(f'"{text}" is not a number; give one such as 0.12 or 12%')


def setting(text: str) -> tuple[str, Any]:
    """Split ``KEY=VALUE`` into the pair (key, value).

    Both are written as in a scene file, but text needs no quotes.
    """
    key, value = pair(text, like="increments=50")
    if not {'"', "'"}.isdisjoint(key):
        key = _without_quotes(key)
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value
    except RecursionError:
        raise Refused(f"{key} is nested without an end; give a value") from None


def _without_quotes(key: str) -> str:
    """Path of an entry that is quoted as TOML needs it, such as ``over."pin.radius"``."""
    try:
        table, names = tomllib.loads(f"{key} = 0"), list[str]()
    except tomllib.TOMLDecodeError:
        raise Refused(f"{key} is no path of an entry; give one like pin.radius") from None
    while isinstance(table, dict):
        ((name, table),) = table.items()
        names.append(name)
    return ".".join(names)


def pair(text: str, like: str) -> tuple[str, str]:
    """Split ``NAME=TEXT`` into the pair (name, text); `like` is the example in error messages."""
    name, separator, value = map(str.strip, text.partition("="))
    if not (name and separator and value):
        raise Refused(f'"{text}" is not of the form KEY=VALUE, like {like}')
    return name, value
