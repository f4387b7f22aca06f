"""Remarks beside a result, in lines: notes and warnings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

Grade = Literal["note", "warning"]


def remarks(grade: Grade, *words: str | None) -> Iterator[str]:
    """Lines of one grade, a line for each of the words that are not empty."""
    return (f"{grade}: {one}" for one in words if one)
