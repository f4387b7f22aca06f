"""Stages of one specimen, between which the load or the velocity rises.

Wear accumulates over the stages. After three stages of 100 N and 60 s the worn contact is so wide
that the fourth stage is 41 K cooler than with a fresh pin (PHYSICS.md, 21).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from tribo.constants import STEPS_OF_HOLD, STEPS_OF_LATER_RAMP
from tribo.errors import InputError, require_integer, require_positive
from tribo.loading.ramp import MOST_STEPS, LoadStep

_LEVEL_ROUNDING = 1e-9  # relative difference up to which levels are equal


@dataclass(frozen=True, slots=True)
class Stages:
    """Stages of one specimen, each held; the load grows at a constant rate between them.

    Either the load rises from stage to stage, or the velocity does at one load.

    Parameters
    ----------
    loads : tuple of float
        Load of each stage on the whole pin [N], ascending. One load for stages of velocity.
    holds : tuple of float
        Time for which each stage is held [s].
    rate : float
        Growth of the load from 0 to the first stage, and from stage to stage [N/s].
    velocities : tuple of float, optional
        Sliding velocity of each stage [m/s], ascending, if the stages are of velocity.

    Examples
    --------
    >>> stages = Stages(loads=(100.0, 200.0), holds=(60.0, 60.0), rate=150.0)
    >>> for load_step in stages.load_steps(200.0, increments=2):
    ...     print(f"{load_step.normal_load:.0f} N at {load_step.time:.1f} s")
    50 N at 0.3 s
    100 N at 0.7 s
    100 N at 4.8 s
    100 N at 60.7 s
    133 N at 60.9 s
    167 N at 61.1 s
    200 N at 61.3 s
    200 N at 83.4 s
    200 N at 121.3 s
    """

    loads: tuple[float, ...]
    holds: tuple[float, ...]
    rate: float
    velocities: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        require_positive(rate=self.rate)
        for name in ("loads", "holds", "velocities"):
            for value in getattr(self, name):
                require_positive(**{name.removesuffix("s"): value})
        levels = self.velocities or self.loads
        load_count = 1 if self.velocities else len(levels)
        if not levels or len(self.holds) != len(levels) or len(self.loads) != load_count:
            raise InputError(
                f"{len(self.loads)} loads, {len(self.velocities)} velocities and "
                f"{len(self.holds)} holds are no stages; give each a load and a hold, or one load "
                "and to each a velocity and a hold"
            )
        for lower, higher in pairwise(levels):
            if not lower < higher:
                raise InputError(f"stages do not rise from {lower:g} to {higher:g}; let them rise")

    @property
    def text(self) -> str:
        """The levels of the stages in words, such as "100, 200 N"."""
        levels, unit = (self.velocities, "m/s") if self.velocities else (self.loads, "N")
        return f"{', '.join(f'{level:g}' for level in levels)} {unit}"

    def shares_stages(self, other: Stages) -> bool:
        """True if one of both sequences of stages is the beginning of the other.

        Examples
        --------
        >>> stages = Stages(loads=(100.0, 200.0), holds=(60.0, 60.0), rate=150.0)
        >>> stages.shares_stages(Stages(loads=(100.0,), holds=(60.0,), rate=150.0))
        True
        """
        count = min(len(self.holds), len(other.holds))
        histories = [(stages.rate, stages._levels(count)) for stages in (self, other)]
        return histories[0] == histories[1]

    def count(self, normal_load: float, velocity: float | None = None) -> int:
        """Number of stages up to the one at a load [N]; of stages of velocity at a velocity [m/s].

        Raises an `InputError` with the list of stages if there is no such stage.
        """
        require_positive(normal_load=normal_load)
        pairs = [("load", "N", normal_load, self.loads)]
        if self.velocities:
            target = self.velocities[-1] if velocity is None else velocity
            pairs.append(("velocity", "m/s", target, self.velocities))
        number = 0
        for name, unit, target, levels in pairs:
            matches = (
                n
                for n, x in enumerate(levels, 1)
                if math.isclose(x, target, rel_tol=_LEVEL_ROUNDING)
            )
            number = next(matches, 0)
            if not number:
                choices = ", ".join(f"{level:g}" for level in levels)
                raise InputError(
                    f"{name} is {target:g} {unit}, which is no stage; give one of {choices} {unit}"
                )
        return number

    @property
    def course(self) -> tuple[tuple[float, float], ...]:
        """Pairs (time since the loading began [s], load as a share of the last stage's).

        Examples
        --------
        >>> Stages(loads=(100.0, 200.0), holds=(60.0, 30.0), rate=100.0).course
        ((0.0, 0.0), (1.0, 0.5), (61.0, 0.5), (62.0, 1.0), (92.0, 1.0))
        """
        load_steps = self.load_steps(self.loads[-1], 1)
        corners = [
            (load_step.time, load_step.normal_load / self.loads[-1])
            for load_step in load_steps
            if load_step.is_shown
        ]
        return ((0.0, 0.0), *dict.fromkeys(corners))

    def worn_impulse(self, velocity: float) -> float:
        """Velocity times impulse, Σ V ∫F dt [N m], summed over all stages; it determines the wear.

        `velocity` [m/s] applies if the stages are of load, and so have no velocity.
        """
        total = last_load = 0.0
        for load, hold, stage_velocity in self._levels(len(self.holds)):
            ramp_impulse = (load**2 - last_load**2) / 2 / self.rate
            total += (abs(velocity) if stage_velocity is None else stage_velocity) * (
                ramp_impulse + load * hold
            )
            last_load = load
        return total

    def _levels(self, count: int) -> list[tuple[float, float, float | None]]:
        """Load [N], hold [s] and velocity [m/s], or None, of the first `count` stages."""
        total = len(self.holds)
        loads = self.loads * total if self.velocities else self.loads
        velocities = self.velocities or (None,) * total
        return [*zip(loads, self.holds, velocities, strict=True)][:count]

    def load_steps(
        self, normal_load: float, increments: int, velocity: float | None = None
    ) -> Iterator[LoadStep]:
        """Times at which the contact is solved, up to the end of the stage at `normal_load` [N].

        With stages of velocity it is the end of the stage at `velocity` [m/s]. The first ramp has
        `increments` steps, each later one 3, each hold 2, in which ln ∫F V dt grows equally. A
        stage of velocity has a step of no duration in place of its ramp.
        """
        require_integer(1, increments=increments)
        count = self.count(normal_load, velocity)
        if increments + count * (STEPS_OF_LATER_RAMP + STEPS_OF_HOLD) > MOST_STEPS:
            raise InputError(f"{count} stages take over {MOST_STEPS} steps; give fewer")
        load_step = LoadStep(0.0, 0.0, True, 0, 0.0)
        for number, (load, hold, stage_velocity) in enumerate(self._levels(count)):
            steps = STEPS_OF_LATER_RAMP if number else increments
            shares = [1.0] if load == load_step.normal_load else _shares(steps)
            for ramp_step in self._ramp_steps(load_step, load, shares, stage_velocity):
                load_step = ramp_step
                yield load_step
            for hold_step in _hold_steps(load_step, hold):
                load_step = hold_step
                yield load_step

    def _ramp_steps(
        self, begin: LoadStep, load: float, shares: list[float], velocity: float | None
    ) -> Iterator[LoadStep]:
        """Load steps of the ramp from `begin` to the onset of the next stage, at `load` [N]."""
        change = load - begin.normal_load
        for number, share in enumerate(shares, 1):
            partial_load, duration = begin.normal_load + share * change, share * change / self.rate
            yield _step_after(
                begin,
                number,
                load if share == 1 else partial_load,
                duration,
                velocity,
                share == 1,
                False,
            )


def _shares(steps: int) -> list[float]:
    return [number / steps for number in range(1, steps + 1)]


def _hold_steps(begin: LoadStep, hold: float) -> Iterator[LoadStep]:
    """Load steps of a hold of `hold` [s] that starts at the load step `begin`."""
    speed = begin.velocity or 1.0
    equivalent_time = begin.impulse if begin.worn is None else begin.worn / speed
    equivalent_time /= begin.normal_load  # time at this load for the same wear [s]
    log_growth = math.log1p(hold / equivalent_time)
    for number, share in enumerate(_shares(STEPS_OF_HOLD), 1):
        duration = hold if share == 1 else equivalent_time * math.expm1(log_growth * share)
        yield _step_after(
            begin, number, begin.normal_load, duration, begin.velocity, share == 1, True
        )


def _step_after(
    begin: LoadStep,
    number: int,
    load: float,
    duration: float,
    velocity: float | None,
    is_shown: bool,
    holding: bool,
) -> LoadStep:
    """Load step `number` steps and `duration` [s] after `begin`, at `load` [N]."""
    impulse = (begin.normal_load + load) / 2 * duration
    velocity_fields: dict[str, float] = {}
    if velocity is not None:
        velocity_fields["velocity"] = velocity
        velocity_fields["slid"] = (begin.slid or 0.0) + velocity * duration
        velocity_fields["worn"] = (begin.worn or 0.0) + velocity * impulse
    return LoadStep(
        load,
        begin.time + duration,
        True,
        begin.index + number,
        begin.impulse + impulse,
        holding,
        is_shown,
        **velocity_fields,
    )
