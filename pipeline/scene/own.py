"""Laws of one's own that a scene names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.sweep.own import Own
from tribo import InputError


def own_of(path: str, table: Mapping[str, Any]) -> Own:
    """The law that a table with ``law`` and ``parameters`` names.

    Parameters
    ----------
    path : str
        Path of the table in the scene.
    table : mapping
        Its sound entries.

    Raises
    ------
    InputError
        If there is no such law, or it cannot be made.
    """
    try:
        return Own.named(table["law"], table["parameters"])
    except InputError as error:
        raise InputError(f"{path}.law: {error}") from error
