"""Texts as they are printed, kept below tests/wording; `make reference` writes them again."""

import os
import re
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from tribo import TriboError

FOLDER = Path(__file__).parents[1] / "wording"
_IS_WRITTEN = "IRG_WRITE_WORDING" in os.environ
_DIGEST = r"\b(?:0x)?(?=\d*[a-f])(?=[a-f]*\d)[0-9a-f]{7,}\b"
_CHANGING = re.compile(rf"{_DIGEST}|process \d+|\d+\.\d+\.\d+")
_NUMBER = re.compile(rf"{_DIGEST}|\d[\d.]*(?:e[+-]?\d+)?")
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


def names_and_units(ds: xr.Dataset) -> str:
    """Name, long name and unit of each variable of a dataset, in a line each."""
    return "\n".join(
        f"{name}: {variable.attrs.get('long_name', '')} [{variable.attrs.get('units', '')}]"
        for name, variable in ds.variables.items()
    )


def assert_as_kept(name: str, texts: dict[str, str], with_numbers: bool = False) -> None:
    """Compare texts with those of a file, in which each stands below its title, or write them.

    Digests, versions and numbers of processes count as equal, other numbers unless they are asked
    for, and any spaces and line breaks before them.
    """
    left_out = _CHANGING if with_numbers else _NUMBER
    plain = {title: _LAYOUT.sub(" ", left_out.sub("#", text)) for title, text in texts.items()}
    written = "".join(f"== {title}\n{text.strip()}\n" for title, text in plain.items())
    file = FOLDER / f"{name}.txt"
    if _IS_WRITTEN:
        file.parent.mkdir(exist_ok=True)
        file.write_text(written, encoding="utf-8")
    assert written == file.read_text(encoding="utf-8")
