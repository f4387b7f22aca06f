"""Texts and numbers as they were, below tests/kept; `make reference` writes them again."""

import math
import os
import re
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from tribo import TriboError

FOLDER = Path(__file__).parents[1] / "kept"
_IS_WRITTEN = "IRG_WRITE_KEPT" in os.environ
_CHANGING = re.compile(
    r"(?<!\.)\b(?:0x)?(?=\d*[a-f])(?=[a-f]*\d)[0-9a-f]{7,}\b"  # digests
    r"|process \d+|\d+\.\d+\.\d+"  # and versions
)
_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_SHOWN = 12  # most values of an array
_TOLERANCE = 1e-4  # largest relative difference of numbers between libraries and machines
_LEAST_DIGITS = 3  # of a number that may differ by its last decimal
_LAYOUT = re.compile(r"\n? {2,}")


def relative(text: str, *folders: Path) -> str:
    """Text with the paths of folders relative to them, and without the name of this machine."""
    for folder in folders:
        text = text.replace(f"{folder}/", "").replace(str(folder), ".")
    return text.replace(f" on {socket.gethostname()}", " on this machine")


def refusal(function: Callable[..., Any], *arguments: Any) -> str:
    """Message of the error that a function raises."""
    with pytest.raises(TriboError) as caught:
        function(*arguments)
    return str(caught.value)


def variables(ds: xr.Dataset) -> str:
    """Name, long name, unit and values of each variable of a dataset, in a line each."""
    return "\n".join(
        f"{name}: {variable.attrs.get('long_name', '')} [{variable.attrs.get('units', '')}] "
        f"{some(variable.values)}"
        for name, variable in ds.variables.items()
    )


def some(values: Any) -> str:
    """Values of an array, evenly spread over it if there are many, numbers to five digits."""
    flat = np.ravel(values)
    spread = flat[np.linspace(0, flat.size - 1, min(flat.size, _SHOWN)).astype(int)]
    return ", ".join(
        f"{value:#.5g}" if isinstance(value, float) else str(value) for value in spread
    )


def assert_as_kept(name: str, texts: dict[str, str]) -> None:
    """Compare texts with those of a file, in which each stands below its title, or write them.

    Digests, versions and numbers of processes count as equal, any spaces and line breaks before
    them, and numbers of as many decimals that differ by at most `_TOLERANCE`, or, if they have
    at least `_LEAST_DIGITS`, by their last decimal.
    """
    plain = {title: _LAYOUT.sub(" ", _CHANGING.sub("#", text)) for title, text in texts.items()}
    written = "".join(f"== {title}\n{text.strip()}\n" for title, text in plain.items())
    file = FOLDER / f"{name}.txt"
    if _IS_WRITTEN:
        file.parent.mkdir(exist_ok=True)
        file.write_text(written, encoding="utf-8")
    kept = file.read_text(encoding="utf-8")
    numbers = iter(_NUMBER.findall(kept))
    assert _NUMBER.sub(lambda found: _kept_if_close(found[0], next(numbers, "")), written) == kept


def _kept_if_close(number: str, kept: str) -> str:
    """The kept number where another one is close to it, else the other one."""
    decimals, kept_decimals = (text.partition(".")[2] for text in (number, kept))
    if not kept or len(decimals) != len(kept_decimals):
        return number
    # A last decimal is a small part of a number only if this has enough digits.
    has_digits = len(number.replace(".", "").lstrip("0")) >= _LEAST_DIGITS
    last = 1.01 * 10.0 ** -len(decimals) if decimals.isdigit() and has_digits else 0.0
    is_close = math.isclose(float(number), float(kept), rel_tol=_TOLERANCE, abs_tol=last)
    return kept if is_close else number
