"""Kinds of warnings that a point may carry."""

from __future__ import annotations

from enum import IntFlag
from typing import NamedTuple

__all__ = ["PointWarning", "WarningKind"]


class WarningKind(IntFlag):
    """Kinds of warnings; each is a bit, so that a number holds those of a point.

    Examples
    --------
    >>> [kind.label for kind in WarningKind(3)]
    ['unstable wear', 'contact at edge']
    """

    UNSTABLE_WEAR = 1
    CONTACT_AT_EDGE = 2
    FEW_NODES = 4
    FEW_STEPS = 8

    @property
    def label(self) -> str:
        """The kind in words."""
        return (self.name or "").lower().replace("_", " ")


class PointWarning(NamedTuple):
    """What a user should know about a point before relying on it.

    Attributes
    ----------
    kind : WarningKind
        What it is about.
    text : str
        What is wrong, by how much, and what to do.
    """

    kind: WarningKind
    text: str

    def __str__(self) -> str:
        return self.text
