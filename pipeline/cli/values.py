"""Values of the options of ``irg``, from text as a user types it."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pipeline


def quantity(like: str) -> Callable[[str], float]:
    """Return a reader of quantities with a unit, such as `like`."""

    def read(text: str) -> float:
        try:
            return pipeline.to_si(text, like)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f'{error}; give one like "{like}"') from error

    return read


def store(text: str) -> Path | str:
    """Read the folder or the address of a store."""
    return text if "://" in text else Path(text)


def count(text: str, least: int = 1) -> int:
    """Read a whole number."""
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if number < least:
        raise argparse.ArgumentTypeError(f'"{text}": give a whole number of at least {least}')
    return number


def seed(text: str) -> int:
    """Read the seed of a random surface."""
    return count(text, least=0)


def friction(text: str) -> float:
    """Read a friction coefficient."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}": give a number such as 0.1') from None


def frictions(text: str) -> float | tuple[float, ...]:
    """Read a friction coefficient, or several between commas."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'"{text}": give a number such as 0.1, or several such as 0.09,0.103'
        ) from None
    return values if len(values) > 1 else values[0]


def share(text: str) -> float:
    """Read a share such as 2% or 0.02."""
    try:
        value = float(text[:-1]) / 100 if text.endswith("%") else float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f'"{text}": give a share between 0 and 1, such as 2%')
    return value


def setting(text: str) -> tuple[str, Any]:
    """Read ``KEY=VALUE``, the value as in a scene file; text needs no quotes.

    Examples
    --------
    >>> setting("increments=50"), setting("wear.pattern=local")
    (('increments', 50), ('wear.pattern', 'local'))
    """
    key, separator, value = text.partition("=")
    if not (separator and key and value):
        raise argparse.ArgumentTypeError(f'"{text}" is not a setting; give one like increments=50')
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value
