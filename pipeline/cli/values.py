"""Values of the options of ``irg``, from text as a user types it."""

from __future__ import annotations

import argparse
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pipeline

_DECIMAL_POINT = re.compile(r"\s*[+-]?(\d+\.\d*|\.\d+)(e[+-]?\d+)?\s*", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+")


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
        hint = f": write {text.replace(',', '.')}" if _DECIMAL_COMMA.fullmatch(text) else ""
        raise argparse.ArgumentTypeError(f'"{text}": give a number such as 0.1{hint}') from None


def frictions(text: str) -> tuple[float, ...]:
    """Read a friction coefficient, or several with decimal points between commas.

    Examples
    --------
    >>> frictions("0.1"), frictions("0.09,0.103")
    ((0.1,), (0.09, 0.103))
    """
    parts = text.split(",")
    if len(parts) > 1 and not all(_DECIMAL_POINT.fullmatch(part) for part in parts):
        raise argparse.ArgumentTypeError(
            f'"{text}": the comma may stand for a decimal point; write one number as 0.12, several '
            "as --friction 0.09 --friction 0.103 or 0.09,0.103"
        )
    return tuple(friction(part) for part in parts)


class Several(argparse.Action):
    """Values of an option that may be repeated: the value if it is one, a tuple if more."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add values to those that are there."""
        before = getattr(namespace, self.dest)
        known = () if before is None else before if isinstance(before, tuple) else (before,)
        found = (*known, *values)
        setattr(namespace, self.dest, found if len(found) > 1 else found[0])


def share(text: str) -> float:
    """Read a share such as 2% or 0.02."""
    try:
        value = failing_share(text)
    except argparse.ArgumentTypeError:
        value = 0.0
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f'"{text}": give a share between 0 and 1, such as 2%')
    return value


def failing_share(text: str) -> float:
    """Read the share of the contact beyond which wear is severe, which may be 0.

    Examples
    --------
    >>> failing_share("10%"), failing_share("0.1"), failing_share("0")
    (0.1, 0.1, 0.0)
    """
    try:
        return float(text[:-1]) / 100 if text.endswith("%") else float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}": give a share such as 10% or 0.1') from None


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
