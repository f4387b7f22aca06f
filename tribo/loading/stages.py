"""Load stages of one specimen, each held before the load rises to the next.

Wear accumulates over the stages. After three stages of 100 N and 60 s the worn contact is so wide
that the fourth stage is 41 K cooler than with a fresh pin (PHYSICS.md, 21).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from tribo.constants import (
    HOLD_SHARE,
    LATER_RAMP_SHARE,
    STEPS_OF_HOLD,
    STEPS_OF_LATER_RAMP,
)
from tribo.errors import InputError, require_integer, require_positive
from tribo.loading.ramp import MOST_STEPS, LoadStep

_LOAD_ROUNDING = 1e-9  # relative difference up to which loads are equal


@dataclass(frozen=True, slots=True)
class Stages:
    """Load stages of one specimen, each held; the load grows at a constant rate between them.

    Parameters
    ----------
    loads : tuple of float
        Load of each stage on the whole pin [N], ascending.
    hold_times : tuple of float
        Time for which each stage is held [s].
    rate : float
        Growth of the load from 0 to the first stage, and from stage to stage [N/s].

    Examples
    --------
    >>> stages = Stages(loads=(100.0, 200.0), hold_times=(60.0, 60.0), rate=150.0)
    >>> for load_step in stages.load_steps(200.0, increments=2):
    ...     if load_step.bounds_hold:
    ...         print(f"{load_step.normal_load:.0f} N at {load_step.time:.1f} s")
    100 N at 0.7 s
    100 N at 60.7 s
    200 N at 61.3 s
    200 N at 121.3 s
    """

    loads: tuple[float, ...]
    hold_times: tuple[float, ...]
    rate: float

    def __post_init__(self) -> None:
        require_positive(rate=self.rate)
        for name, values in (("loads", self.loads), ("hold_times", self.hold_times)):
            if not isinstance(values, tuple):
                raise InputError(f"{name} are {f'{values!r}'[:100]}; give a tuple of numbers")
            for value in values:
                require_positive(**{name: value})
        if not self.loads or len(self.hold_times) != len(self.loads):
            raise InputError(
                f"{len(self.loads)} loads and {len(self.hold_times)} holds are not load stages; "
                "each stage has one load and one hold"
            )
        for lower, higher in pairwise(self.loads):
            if not lower < higher:
                raise InputError(
                    f"a stage of {lower:g} is followed by {higher:g}; give loads that rise"
                )

    @property
    def text(self) -> str:
        """The loads of the stages in words, such as "100, 200 N"."""
        return f"{', '.join(f'{load:g}' for load in self.loads)} N"

    def shares_stages(self, other: Stages) -> bool:
        """True if one of both sequences of stages is the beginning of the other.

        Examples
        --------
        >>> stages = Stages(loads=(100.0, 200.0), hold_times=(60.0, 60.0), rate=150.0)
        >>> stages.shares_stages(Stages(loads=(100.0,), hold_times=(60.0,), rate=150.0))
        True
        """
        count = min(len(self.hold_times), len(other.hold_times))
        histories = [
            (stages.rate, stages.loads[:count], stages.hold_times[:count])
            for stages in (self, other)
        ]
        return histories[0] == histories[1]

    def count(self, normal_load: float) -> int:
        """Number of stages up to the one at a load [N].

        Raises an `InputError` with the list of stages if there is no such stage.
        """
        require_positive(normal_load=normal_load)
        for number, load in enumerate(self.loads, 1):
            if math.isclose(load, normal_load, rel_tol=_LOAD_ROUNDING):
                return number
        raise InputError(
            f"load is {normal_load:g} N, which is not a load stage; choose from {self.text}"
        )

    @property
    def course(self) -> tuple[tuple[float, float], ...]:
        """Pairs (time since the loading began [s], load as a share of the last stage's).

        Examples
        --------
        >>> Stages(loads=(100.0, 200.0), hold_times=(60.0, 30.0), rate=100.0).course
        ((0.0, 0.0), (1.0, 0.5), (61.0, 0.5), (62.0, 1.0), (92.0, 1.0))
        """
        load_steps = self.load_steps(self.loads[-1], 1)
        corners = [
            (load_step.time, load_step.normal_load / self.loads[-1])
            for load_step in load_steps
            if load_step.bounds_hold
        ]
        return ((0.0, 0.0), *dict.fromkeys(corners))

    def worn_impulse(self, velocity: float) -> float:
        """Velocity times impulse, V ∫F dt [N m], of all stages at a velocity [m/s].

        It determines the wear.
        """
        total = last_load = 0.0
        for load, hold in zip(self.loads, self.hold_times, strict=True):
            ramp_impulse = (load**2 - last_load**2) / 2 / self.rate
            total += abs(velocity) * (ramp_impulse + load * hold)
            last_load = load
        return total

    def load_steps(self, normal_load: float, increments: int) -> Iterator[LoadStep]:
        """Times at which the contact is solved, up to the end of the stage at `normal_load` [N].

        The first ramp has `increments` steps, each later one a quarter of them, but at least 6. A
        hold has a sixth of them, but at least 4; in each, ln ∫F dt grows equally.
        """
        require_integer(1, increments=increments)
        count = self.count(normal_load)
        ramp_steps = max(STEPS_OF_LATER_RAMP, math.ceil(LATER_RAMP_SHARE * increments))
        hold_steps = max(STEPS_OF_HOLD, math.ceil(HOLD_SHARE * increments))
        if increments + count * (ramp_steps + hold_steps) > MOST_STEPS:
            raise InputError(f"{count} stages take over {MOST_STEPS} steps; give fewer")
        load_step = LoadStep(0.0, 0.0, True, 0, 0.0)
        for number, (load, hold) in enumerate(
            zip(self.loads[:count], self.hold_times[:count], strict=True)
        ):
            steps = ramp_steps if number else increments
            for ramp_step in self._ramp_steps(load_step, load, steps):
                load_step = ramp_step
                yield load_step
            for hold_step in _hold_steps(load_step, hold, hold_steps):
                load_step = hold_step
                yield load_step

    def _ramp_steps(self, begin: LoadStep, load: float, steps: int) -> Iterator[LoadStep]:
        """Load steps of the ramp from `begin` to the onset of the next stage, at `load` [N]."""
        change = load - begin.normal_load
        for number, share in enumerate(_shares(steps), 1):
            partial_load, duration = begin.normal_load + share * change, share * change / self.rate
            is_onset = share == 1
            yield _step_after(
                begin, number, load if is_onset else partial_load, duration, is_onset, False
            )


def _shares(steps: int) -> list[float]:
    return [number / steps for number in range(1, steps + 1)]


def _hold_steps(begin: LoadStep, hold: float, steps: int) -> Iterator[LoadStep]:
    """Load steps of a hold of `hold` [s] that starts at the load step `begin`."""
    equivalent_time = begin.impulse / begin.normal_load  # time at this load for the same wear [s]
    log_growth = math.log1p(hold / equivalent_time)
    for number, share in enumerate(_shares(steps), 1):
        duration = hold if share == 1 else equivalent_time * math.expm1(log_growth * share)
        yield _step_after(begin, number, begin.normal_load, duration, share == 1, True)


def _step_after(
    begin: LoadStep, number: int, load: float, duration: float, bounds_hold: bool, holding: bool
) -> LoadStep:
    """Load step `number` steps and `duration` [s] after `begin`, at `load` [N]."""
    return LoadStep(
        load,
        begin.time + duration,
        True,
        begin.index + number,
        begin.impulse + (begin.normal_load + load) / 2 * duration,
        holding,
        bounds_hold,
    )
