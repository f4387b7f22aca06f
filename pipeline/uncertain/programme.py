"""A programme: tests in their order until a target is known well enough, or they help no more.

Then the programme looks for other measurements that help.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.uncertain.next_tests import Candidate, Plan
from pipeline.uncertain.posterior import Posterior
from tribo import InputError

MOST = 40
"""Tests of a programme."""
_LITTLE, _IN_A_ROW = 0.02, 3  # of the spread: what so many tests in a row at least take away
_HELPS = 0.1  # of the spread, that another measurement takes away at least


@dataclass(frozen=True, slots=True)
class Programme:
    """Tests that lead to a goal, as far as they do.

    Attributes
    ----------
    until : float
        Standard deviation of the target that is sought; see `Candidate.spread`.
    before : float
        That of today.
    tests : tuple of Candidate
        Tests, each with the spread that it leaves.
    is_reached : bool
        True if they reach it.
    others : tuple of Candidate
        Other measurements beside the tests, and what they leave, the best first; none where the
        tests suffice.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> planned = programme(pipeline.posterior(ensemble), until=0.5)
    >>> planned.is_reached, planned.tests
    (True, ())
    """

    until: float
    before: float
    tests: tuple[Candidate, ...]
    is_reached: bool
    others: tuple[Candidate, ...]

    @property
    def is_stuck(self) -> bool:
        """True if further tests help little."""
        return bool(not self.is_reached and _is_stuck(self.before, self.tests))


def programme(
    posterior: Posterior,
    until: float,
    target: str | None = None,
    bulk_temperatures: Sequence[float | str] = (),
    most: int = MOST,
) -> Programme:
    """Plan tests until the target has a given standard deviation, or further tests do not help.

    Parameters
    ----------
    posterior : Posterior
        State of knowledge today.
    until : float
        Standard deviation that is sought; see `Candidate.spread`.
    target, bulk_temperatures : optional
        See `pipeline.candidates`.
    most : int
        Most tests.
    """
    if not until > 0:
        raise InputError(f"until is {until:g}; give a spread above 0, such as 0.05")
    plan = Plan(posterior, target, bulk_temperatures)
    measurements = list(plan.measurements())
    kinds = [one for one in measurements if one.test]
    tests: list[Candidate] = []
    while plan.spread > until and len(tests) < most and not _is_stuck(plan.before, tests):
        best = min(kinds, key=plan.left)
        plan.learn(best)
        tests.append(plan.candidate(best))
    is_reached, others = plan.spread <= until, tuple[Candidate, ...]()
    if not is_reached:
        ranked = [plan.candidate(one, plan.left(one)) for one in measurements if not one.test]
        helpful = (
            one for one in [*ranked, *plan.lists()] if one.spread < (1 - _HELPS) * plan.spread
        )
        others = tuple(sorted(helpful, key=lambda one: one.spread))
    return Programme(until, plan.before, tuple(tests), is_reached, others)


def _is_stuck(before: float, tests: Sequence[Candidate]) -> bool:
    """True if the last tests took away little each."""
    if len(tests) < _IN_A_ROW:
        return False
    earlier = tests[-_IN_A_ROW - 1].spread if len(tests) > _IN_A_ROW else before
    return tests[-1].spread > (1 - _LITTLE) ** _IN_A_ROW * earlier
