"""What stands in a sweep for the content of a file that was not stored with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tribo import InputError
from tribo.surface import UnknownHeights


class MissingError(InputError):
    """The content of a file that a scene names is needed, but was not stored with the scene."""


@dataclass(frozen=True)
class MissingSurface(UnknownHeights):
    """A measured surface whose heights are not known, since its file was not stored."""

    digest: str
    words: str

    def heights(self, pixels: Any) -> Any:
        """Raise a `MissingError`: the heights are not known."""
        raise MissingError(self.words)

    def __str__(self) -> str:
        return self.words
