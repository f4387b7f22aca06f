"""Criteria of severe adhesive wear (scuffing): which contact temperature has a limit.

Wear is severe where the criterion's temperature exceeds its limit, the critical temperature. The
criterion's temperature is that which a share of the contact area exceeds (Bosman & de Rooij), the
highest (Blok), or the mean. To add a criterion, add an entry to `CRITERIA`.

Temperatures follow from rises per unit friction coefficient. This module alone knows which rise a
criterion uses.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tribo.errors import InputError, InvariantError, law_errors
from tribo.thermal.quantiles import QUANTILES, require_share, rise_exceeded
from tribo.types import Array

Columns = Mapping[str, Any]
"""Temperature rises by name [K]; arrays have axes for points and steps in front, if any."""


@dataclass(frozen=True, slots=True)
class Rule:
    """Kind of criterion: how its temperature rise is found, and the words for the criterion.

    Wear is severe if the criterion's rise exceeds the rise to the critical temperature.

    Attributes
    ----------
    column : str
        Column of rises that the criterion uses, ``"rise_quantile"`` or ``"mean_rise"``.
    rise : callable
        Called with the values of this column [K], the share of the contact, and the probabilities
        of the quantiles; returns the criterion's rise [K].
    temperature, severe : str
        Words that name the criterion's temperature, and words for when wear is severe. They may
        contain ``{share:g}``, the share of the contact [%].

    Examples
    --------
    >>> mean = Rule("mean_rise", lambda rises, *_: rises, "mean", "the mean above")
    >>> mean.column
    'mean_rise'
    """

    column: str
    rise: Callable[[Array, float, Array], Array]
    temperature: str
    severe: str


CRITERIA: dict[str, Rule] = {
    "share": Rule(
        "rise_quantile",
        rise_exceeded,
        "exceeded on {share:g} % of the contact",
        "more than {share:g} % of the contact above",
    ),
    "highest": Rule(
        "rise_quantile",
        lambda rises, _, quantiles: rise_exceeded(rises, 0.0, quantiles),
        "maximum",
        "any of the contact above",
    ),
    "mean": Rule(
        "mean_rise",
        lambda rises, *_: rises,
        "mean of the contact",
        "the mean of the contact above",
    ),
}
"""Kinds of criteria by name."""


@dataclass(frozen=True, slots=True)
class Criterion:
    """A criterion of severe wear: which temperature of the contact must exceed the critical one.

    The temperature that a share s of the contact area exceeds is the quantile 1 − s of the
    temperature over this area.

    Attributes
    ----------
    name : str
        One of `CRITERIA`, or the name of `rule`.
    share : float
        Wear is severe if more than this share of the contact area is above the critical
        temperature. The share is at least 0 (the highest temperature counts) and below 1. The
        criteria "highest" and "mean" do not use it.
    rule : Rule or None
        A rule of the user, which replaces the rule of `CRITERIA`.

    Examples
    --------
    >>> columns = {"rise_quantile": np.linspace(0, 100, len(QUANTILES)), "mean_rise": 40.0}
    >>> Criterion("mean").rise(columns)
    40.0
    >>> float(Criterion("highest").rise(columns)) == float(Criterion(share=0.0).rise(columns))
    True
    >>> Criterion(share=0.1).temperature
    'exceeded on 10 % of the contact'
    >>> Criterion(share=0.1).severe
    'more than 10 % of the contact above'
    """

    name: str = "share"
    share: float = 0.1
    rule: Rule | None = None

    def __post_init__(self) -> None:
        if self.rule is None and self.name not in CRITERIA:
            raise InputError(f"criterion is {self.name!r}; allowed are {', '.join(CRITERIA)}")
        require_share(self.share)

    @property
    def _rule(self) -> Rule:
        if self.rule is not None:
            return self.rule
        return CRITERIA["highest" if self.is_highest else self.name]

    @property
    def is_highest(self) -> bool:
        """True if the highest temperature decides."""
        return self.rule is None and (
            self.name == "highest" or (self.name == "share" and self.share == 0)
        )

    @property
    def column(self) -> str:
        """Column of rises that the criterion uses, ``"rise_quantile"`` or ``"mean_rise"``."""
        return self._rule.column

    @property
    def temperature(self) -> str:
        """Words that name the criterion's temperature, such as "mean of the contact"."""
        return self._rule.temperature.format(share=100 * self.share)

    @property
    def severe(self) -> str:
        """Words for when wear is severe, such as "any of the contact above".

        The caller writes the critical temperature after these words.
        """
        return self._rule.severe.format(share=100 * self.share)

    @staticmethod
    def is_severe(rise: Any, limit: Any) -> Any:
        """True where the criterion's `rise` [K] is above its `limit` [K]; False where it is NaN."""
        return rise > limit

    def rise(self, columns: Columns) -> Any:
        """Rise that the criterion compares with its limit [K], (...), from columns of rises.

        Parameters
        ----------
        columns : mapping
            Arrays by name: the criterion's `column`, ``rise_quantile`` (..., n_quantile) or
            ``mean_rise`` (...) [K], and ``quantile`` (n_quantile,), the probabilities of the
            quantiles; `tribo.QUANTILES` if left out.
        """
        quantiles = columns.get("quantile", np.array(QUANTILES))
        with law_errors(f"criterion {self.name}"):
            rise = self._rule.rise(columns[self.column], self.share, quantiles)
        if self.rule is not None and self.column == "rise_quantile":
            _require_within(self.name, rise, columns[self.column])
        return rise


def _require_within(name: str, rise: Any, quantiles: Array) -> None:
    """Raise an `InvariantError` if a user's `rise` is not within `quantiles`, or of other shape."""
    expected = np.shape(quantiles)[:-1]
    if np.shape(rise) != expected:
        raise InvariantError(
            f"criterion {name}: its rises have the shape {np.shape(rise)}; they must have "
            f"{expected}, one for each row of quantiles"
        )
    low, high = quantiles[..., 0], quantiles[..., -1]
    room = 1e-9 * np.abs(high)
    if np.any((rise < low - room) | (rise > high + room)) or np.any(np.isnan(rise) & (low <= high)):
        raise InvariantError(
            f"criterion {name}: a rise lies beyond the lowest and highest of its contact, or is "
            "not a number"
        )
