"""The load as a function of time, cut into steps.

One ramp serves many loads. The steps that they share, the trunk, have a fixed increment of the
load. Each load leaves the trunk at the last of these steps below it, and is reached with one
shorter step. A load far below the reference load would then take few steps. So it has a trunk of
smaller increments, halved until the load takes at least a quarter of the steps that the reference
load takes. The trunk of a load depends on this load only, so that the result of a point does not
depend on which other loads are computed.

A hold at constant load is computed separately for each point. Its steps grow with the time since
loading began. Wear, conduction and warming depend on ratios of times or of impulses, ∫F dt, so that
every step changes them by a similar amount.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from tribo.constants import HOLD_GROWTH, LEAST_SHARE_OF_INCREMENTS
from tribo.errors import InputError, require_integer, require_number, require_positive

MOST_STEPS = 10_000
"""Most steps that a load may take; a scene that asks for more is refused as a mistake."""


@dataclass(frozen=True, slots=True)
class LoadStep:
    """A time of the loading at which the contact is solved: the end of a step.

    Attributes
    ----------
    normal_load : float
        Load on the whole pin [N].
    time : float
        Time since the loading began [s].
    on_trunk : bool
        True if higher loads pass through this load step too.
    index : int
        Number of steps from the unloaded state to this load step.
    impulse : float
        Integral of the load over the time since the loading began, ∫F dt [N s].
    holding : bool
        True if the load has been the same since the load step before.
    bounds_hold : bool
        True at the onset and at the end of a stage's hold, whose temperatures are always computed.
    part : int
        Number of parts of this step that were taken before, if the step is cut into parts.

    Examples
    --------
    >>> import tribo
    >>> ramp = tribo.Ramp(rate=150.0, reference_load=750.0)
    >>> *_, last = ramp.load_steps(100.0, increments=10)
    >>> last.normal_load, last.on_trunk
    (100.0, False)
    """

    normal_load: float
    time: float
    on_trunk: bool
    index: int
    impulse: float
    holding: bool = False
    bounds_hold: bool = False
    part: int = 0


@dataclass(frozen=True, slots=True)
class Ramp:
    """A load that grows at a constant rate and may then be held.

    Parameters
    ----------
    rate : float
        Growth of the load on the whole pin [N/s].
    reference_load : float
        Load that the shared ramp (trunk) reaches in the scene's number of increments [N].
    hold : float, optional
        Duration for which each point holds its load once it is reached [s].

    Examples
    --------
    >>> ramp = Ramp(rate=150.0, reference_load=750.0, hold=30.0)
    >>> for load_step in ramp.load_steps(200.0, increments=5):
    ...     print(f"{load_step.normal_load:g} N at {load_step.time:.4f} s")
    150 N at 1.0000 s
    200 N at 1.3333 s
    200 N at 5.1882 s
    200 N at 31.3333 s
    """

    rate: float
    reference_load: float
    hold: float = 0.0

    def __post_init__(self) -> None:
        require_positive(rate=self.rate, reference_load=self.reference_load)
        require_number(hold=self.hold)
        if not 0 <= self.hold < math.inf:
            raise InputError(f"hold is {self.hold!r} s; it must be finite and at least 0")

    def increment(self, normal_load: float, increments: int) -> float:
        """Load increment of each step on the shared ramp (trunk) that leads to `normal_load` [N].

        It is the reference load over `increments`, halved until `normal_load` takes at least a
        quarter of `increments` steps. Loads with the same increment share one such ramp.

        Examples
        --------
        >>> ramp = Ramp(rate=150.0, reference_load=800.0)
        >>> [ramp.increment(load, increments=100) for load in (800.0, 200.0, 199.0, 10.0)]
        [8.0, 8.0, 4.0, 0.25]
        """
        share = normal_load / self.reference_load * (1 + 1e-12)
        halvings = 0
        if 0 < share < LEAST_SHARE_OF_INCREMENTS:
            halvings = math.ceil(math.log2(LEAST_SHARE_OF_INCREMENTS) - math.log2(share))
        return math.ldexp(self.reference_load / increments, -halvings)

    def lowest(self, normal_load: float) -> float:
        """Lowest load [N], up to rounding, that shares one ramp with `normal_load` [N].

        Loads share a ramp if they have the same `increment`.

        Examples
        --------
        >>> ramp = Ramp(rate=150.0, reference_load=800.0)
        >>> [ramp.lowest(load) for load in (800.0, 200.0, 199.0)]
        [200.0, 200.0, 100.0]
        """
        return LEAST_SHARE_OF_INCREMENTS * self.increment(normal_load, increments=1)

    def load_steps(
        self, normal_load: float, increments: int, hold_increments: int = 0
    ) -> Iterator[LoadStep]:
        """Times at which the contact is solved, with their loads: of the ramp, then of the hold.

        The ramp ends at `normal_load` [N], the load of the hold. `increments` is the number of
        steps up to `reference_load`; small loads have smaller steps, see `increment`. Each step of
        the hold multiplies the impulse since the start (∫F dt) by at most exp(10/n). Here n is
        `hold_increments`, or `increments` if `hold_increments` is 0.
        """
        require_positive(normal_load=normal_load)
        require_integer(1, increments=increments)
        for load_step in self._ramp_steps(normal_load, increments):
            yield load_step  # `yield from` would not bind `load_step`
        hold_times = self._hold_times(load_step.time / 2, hold_increments or increments)
        for number, hold_time in enumerate(hold_times, 1):
            yield LoadStep(
                normal_load,
                load_step.time + hold_time,
                on_trunk=False,
                index=load_step.index + number,
                impulse=load_step.impulse + normal_load * hold_time,
                holding=True,
            )

    def _hold_times(self, equivalent_time: float, increments: int) -> Iterator[float]:
        """End times of the hold's steps [s], counted from the start of the hold.

        Each step multiplies ∫F dt by at most exp(10/`increments`). `equivalent_time` [s] is the
        time at the held load that has the impulse of the ramp.
        """
        if not self.hold:
            return
        # Above 0 even if the ramp takes no time.
        equivalent_time = max(equivalent_time, 1e-15 * self.hold)
        log_growth = math.log1p(self.hold / equivalent_time)
        steps = max(1, math.ceil(increments * log_growth / HOLD_GROWTH * (1 - 1e-12)))
        for step in range(1, steps):
            yield equivalent_time * math.expm1(log_growth * step / steps)
        yield self.hold

    def _ramp_steps(self, normal_load: float, increments: int) -> Iterator[LoadStep]:
        """Load steps at multiples of `Ramp.increment` below `normal_load` [N], and at this load."""
        increment = self.increment(normal_load, increments)
        count = _whole_steps(normal_load, increment)
        for index in range(1, count + 1):
            load = index * increment
            if math.isclose(load, normal_load, rel_tol=1e-12):
                yield self._step_at_load(normal_load, load == normal_load, index)
                return
            yield self._step_at_load(load, True, index)
        yield self._step_at_load(normal_load, False, count + 1)

    def _step_at_load(self, normal_load: float, on_trunk: bool, index: int) -> LoadStep:
        """Load step at the time at which the ramp reaches `normal_load` [N]."""
        time = normal_load / self.rate
        return LoadStep(normal_load, time, on_trunk, index, impulse=normal_load * time / 2)


def _whole_steps(load: float, step: float) -> int:
    """Number of whole steps of size `step` up to a load [N]; `InputError` above `MOST_STEPS`."""
    steps = load / step if step > 0 else math.inf
    if not steps <= MOST_STEPS:
        raise InputError(
            f"load is {load:g} N, which takes {steps:.3g} steps of {step:.3g} N; at most "
            f"{MOST_STEPS} are allowed. Choose fewer increments or a higher reference_load"
        )
    return math.floor(steps * (1 + 1e-12))
