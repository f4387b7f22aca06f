"""Values of options, from the text that a user types."""

from __future__ import annotations

import functools
import math
import tomllib
from argparse import ArgumentTypeError
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pipeline.paths import store_path_of, user_path, writable_path

# Modules that import NumPy are imported inside functions, as --help does not need them.

T = TypeVar("T")


def _refusing(read: Callable[..., T]) -> Callable[..., T]:
    """Decorator: let argparse print why a text has no value."""

    @functools.wraps(read)
    def read_or_refuse(*arguments: Any, **options: Any) -> T:
        try:
            return read(*arguments, **options)
        except ValueError as error:
            raise ArgumentTypeError(str(error)) from error

    return read_or_refuse


@_refusing
def quantity(text: str, like: str) -> float:
    """Convert text such as `like`, a quantity above 0, to SI."""
    from pipeline.units import to_si

    try:
        value = to_si(text, like)
    except ValueError as error:
        raise ValueError(f'{error}; example: "{like}"') from error
    if not 0 < value < math.inf:
        raise ValueError(f'"{text}" must be above 0, such as "{like}"')
    return value


def sides(text: str) -> tuple[float, float]:
    """Read the sides of a pixel [m] from ``DX,DY``, or from one length for a square pixel."""
    side_x, comma, side_y = text.partition(",")
    return quantity(side_x, "0.8 um"), quantity(side_y if comma else side_x, "0.8 um")


@_refusing
def count(text: str, minimum: int = 1) -> int:
    """Read a whole number of at least `minimum`."""
    if not text.isdecimal() or int(text) < minimum:
        raise ValueError(f'"{text}" is not a whole number of at least {minimum}')
    return int(text)


@_refusing
def number(text: str) -> float:
    """Read a number without a unit, such as 0.12 or 12%."""
    from pipeline.units import share_of

    return share_of(text)


@_refusing
def share(text: str) -> float:
    """Read a share between 0 and 1, such as 2% or 0.02."""
    if not 0 < (value := number(text)) < 1:
        raise ValueError(f'"{text}" is not a fraction between 0 and 1, such as 2%')
    return value


@_refusing
def pair(text: str, like: str) -> tuple[str, str]:
    """Split ``NAME=TEXT`` into the pair (name, text); `like` is the example in error messages."""
    name, _, value = map(str.strip, text.partition("="))
    if not (name and value):
        raise ValueError(f'"{text}" is not of the form KEY=VALUE, like {like}')
    return name, value


@_refusing
def setting(text: str) -> tuple[str, Any]:
    """Split ``KEY=VALUE`` into the pair (key, value).

    Both are written as in a scene file, but text needs no quotes.
    """
    key, value = pair(text, like="increments=50")
    key = key.replace('"', "").replace("'", "")  # such as over."pin.radius"
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value
    except RecursionError:
        raise ValueError(f"{key} is nested without an end; give a value") from None


def store(text: str) -> Path | str:
    """Read the path or the URL of a store."""
    return text if "://" in text else user_path(text)


def stored(text: str) -> Path | str:
    """Read the path or the URL of a store to read, or the name of a scene whose store that is."""
    return store(str(store_path_of(text)))


@_refusing
def writable(text: str, suffixes: Sequence[str]) -> Path:
    """Check the path of a file to write, which ends in one of `suffixes`, and return it."""
    return writable_path(text, suffixes)
