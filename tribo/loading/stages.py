"""A load, or a velocity, that rises in stages, each of which is held: one specimen, worn on.

The wear of earlier stages counts. A pin worn by three stages of 100 N and 60 s meets the fourth
with a chord so wide that it is 41 K cooler than a fresh pin (PHYSICS.md, 21).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from tribo.constants import STEPS_OF_HOLD, STEPS_OF_LATER_RAMP
from tribo.errors import InputError, require_integer, require_positive
from tribo.loading.ramp import MOST_STEPS, LoadStep

_SAME = 1e-9  # relative rounding difference of one load


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
        fewest = 1 if self.velocities else len(levels)
        if not levels or len(self.holds) != len(levels) or len(self.loads) != fewest:
            raise InputError(
                f"{len(self.loads)} loads, {len(self.velocities)} velocities and "
                f"{len(self.holds)} holds are no stages; give each a load and a hold, or one load "
                "and to each a velocity and a hold"
            )
        for before, after in pairwise(levels):
            if not before < after:
                raise InputError(f"stages do not rise from {before:g} to {after:g}; let them rise")

    @property
    def text(self) -> str:
        """The levels of the stages in words, such as "100, 200 N"."""
        levels, unit = (self.velocities, "m/s") if self.velocities else (self.loads, "N")
        return f"{', '.join(f'{level:g}' for level in levels)} {unit}"

    def shares_stages(self, other: Stages) -> bool:
        """True if these stages are the first of the `other` ones, or the other way round.

        Examples
        --------
        >>> stages = Stages(loads=(100.0, 200.0), holds=(60.0, 60.0), rate=150.0)
        >>> stages.shares_stages(Stages(loads=(100.0,), holds=(60.0,), rate=150.0))
        True
        """
        count = min(len(self.holds), len(other.holds))
        pasts = [(one.rate, one._levels(count)) for one in (self, other)]
        return pasts[0] == pasts[1]

    def count(self, normal_load: float, velocity: float | None = None) -> int:
        """Number of stages up to the one at a load [N]; of stages of velocity at a velocity [m/s].

        Raises an `InputError` with the list of stages if there is no such stage.
        """
        require_positive(normal_load=normal_load)
        pairs = [("load", "N", normal_load, self.loads)]
        if self.velocities:
            wanted = self.velocities[-1] if velocity is None else velocity
            pairs.append(("velocity", "m/s", wanted, self.velocities))
        number = 0
        for name, unit, wanted, levels in pairs:
            same = (n for n, x in enumerate(levels, 1) if math.isclose(x, wanted, rel_tol=_SAME))
            number = next(same, 0)
            if not number:
                listed = ", ".join(f"{level:g}" for level in levels)
                raise InputError(
                    f"{name} is {wanted:g} {unit}, which is no stage; give one of {listed} {unit}"
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
        ends = self.load_steps(self.loads[-1], 1)
        shown = [(one.time, one.normal_load / self.loads[-1]) for one in ends if one.is_shown]
        return ((0.0, 0.0), *dict.fromkeys(shown))

    def worn_impulse(self, velocity: float) -> float:
        """Sum over all stages of velocity times impulse, Σ V ∫F dt [N m], by which a pin wears.

        `velocity` [m/s] is that of stages of load.
        """
        total = before = 0.0
        for load, hold, own in self._levels(len(self.holds)):
            ramp = (load**2 - before**2) / 2 / self.rate
            total += (abs(velocity) if own is None else own) * (ramp + load * hold)
            before = load
        return total

    def _levels(self, count: int) -> list[tuple[float, float, float | None]]:
        """Load [N], hold [s] and own velocity [m/s] of the first `count` stages."""
        number = len(self.holds)
        loads = self.loads * number if self.velocities else self.loads
        velocities = self.velocities or (None,) * number
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
        for number, (load, hold, own) in enumerate(self._levels(count)):
            steps = STEPS_OF_LATER_RAMP if number else increments
            shares = [1.0] if load == load_step.normal_load else _shares(steps)
            for loaded in self._ramp(load_step, load, shares, own):
                load_step = loaded
                yield load_step
            for held in _hold(load_step, hold):
                load_step = held
                yield load_step

    def _ramp(
        self, begin: LoadStep, load: float, shares: list[float], velocity: float | None
    ) -> Iterator[LoadStep]:
        """Steps from a load step to the onset of the next stage, at `load` [N]."""
        change = load - begin.normal_load
        for number, share in enumerate(shares, 1):
            now, duration = begin.normal_load + share * change, share * change / self.rate
            yield _after(
                begin, number, load if share == 1 else now, duration, velocity, share == 1, False
            )


def _shares(steps: int) -> list[float]:
    return [number / steps for number in range(1, steps + 1)]


def _hold(begin: LoadStep, hold: float) -> Iterator[LoadStep]:
    """Steps of a hold from the onset of its stage."""
    speed = begin.velocity or 1.0
    before = begin.impulse if begin.worn is None else begin.worn / speed
    before /= begin.normal_load  # time at this load that would have worn the pin as much [s]
    grown = math.log1p(hold / before)
    for number, share in enumerate(_shares(STEPS_OF_HOLD), 1):
        held = hold if share == 1 else before * math.expm1(grown * share)
        yield _after(begin, number, begin.normal_load, held, begin.velocity, share == 1, True)


def _after(
    begin: LoadStep,
    number: int,
    load: float,
    duration: float,
    velocity: float | None,
    is_shown: bool,
    holding: bool,
) -> LoadStep:
    """LoadStep `number` steps after another one, `duration` [s] later, at `load` [N]."""
    impulse = (begin.normal_load + load) / 2 * duration
    own: dict[str, float] = {}
    if velocity is not None:
        own["velocity"] = velocity
        own["slid"] = (begin.slid or 0.0) + velocity * duration
        own["worn"] = (begin.worn or 0.0) + velocity * impulse
    return LoadStep(
        load,
        begin.time + duration,
        True,
        begin.index + number,
        begin.impulse + impulse,
        holding,
        is_shown,
        **own,
    )
