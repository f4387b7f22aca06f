"""Values of options, from the text that a user types."""

from __future__ import annotations

import functools
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
    """Read a quantity above 0 in SI, by the kind of which `like` is an example."""
    from pipeline.kinds import Quantity

    value: float = Quantity(like).value(text)
    return value


@_refusing
def count(text: str, minimum: int = 1) -> int:
    """Read a whole number of at least `minimum`."""
    if not text.isdecimal() or int(text) < minimum:
        raise ValueError(f'"{text}" is not a whole number of at least {minimum}')
    return int(text)


@_refusing
def condition(text: str, name: str) -> str:
    """Check the text of a condition, which is read at its use: by a scene, or by answers."""
    from pipeline.condition_kinds import CONDITIONS

    CONDITIONS[name].kind.value(text)
    return text


@_refusing
def accuracy(text: str) -> float:
    """Read the goal of a run, such as 2% or 0.02."""
    from pipeline.kinds import ACCURACY

    value: float = ACCURACY.value(text)
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
