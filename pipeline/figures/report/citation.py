"""References of ``CITATION.cff``, as text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any

import yaml

_FILE = "CITATION.cff"


def citation() -> Iterator[str]:
    """References to the program and to the works that it builds on, a line each.

    Examples
    --------
    >>> next(citation())  # doctest: +ELLIPSIS
    'The irg-transition developers: irg-transition (version ...). BSD-3-Clause.'
    """
    package = resources.files("pipeline")
    file = package / _FILE  # in a wheel; in a checkout it is beside the package
    if not file.is_file():
        file = package / ".." / _FILE
    entry = yaml.safe_load(file.read_text(encoding="utf-8"))
    yield _line(entry)
    yield from map(_line, entry.get("references", []))


def _line(entry: Mapping[str, Any]) -> str:
    """One reference."""
    names = [author.get("name") or author.get("family-names") for author in entry["authors"]]
    people = " and ".join(", ".join(names).rsplit(", ", 1)) if len(names) > 1 else names[0]
    version = f" (version {entry['version']})" if "version" in entry else ""
    details = [f"{entry[key]}" for key in ("journal", "volume", "year", "doi", "url", "license")
               if key in entry]  # fmt: skip
    return ". ".join([f"{people}: {entry['title']}{version}", *details]) + "."
