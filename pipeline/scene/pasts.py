"""The past of a test's specimen beside that of the plane's: stages, rate of the load, and hold."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeline.sweep.measurement import Measurement
from pipeline.sweep.model import Sweep
from pipeline.sweep.remarks import Remark
from tribo import MeasuredLoad, Ramp, Stages

Loading = Ramp | Stages | MeasuredLoad
_MANY = 3  # numbers of tests that are named


def notes_on_pasts(sweep: Sweep) -> tuple[Remark, ...]:
    """How the past of tests differs from the plane's, a line for each kind, with its effect.

    Each test is simulated with its own past; so places of the plane are not like it.
    """
    plane, found = sweep.scene.loading, dict[str, list[Measurement]]()
    for test in sweep.tests:
        if words := _difference(test.simulated.scene.loading, plane):
            found.setdefault(words, []).append(test)
    return tuple(Remark("", "note", f"{_named(tests)}: {words}") for words, tests in found.items())


def _difference(own: Loading, plane: Loading) -> str:
    """How one past differs from another, and what follows; empty if they are alike."""
    if isinstance(own, MeasuredLoad) or isinstance(plane, MeasuredLoad):
        return "" if own == plane else "another record of the load than the plane's"
    if isinstance(own, Stages) and isinstance(plane, Stages):
        is_begun_alike = own.shares_stages(plane)
        return (
            "" if is_begun_alike else "other stages than the plane's: longer ones wear and cool it"
        )
    if isinstance(own, Stages):
        return "in stages, and the plane by a ramp: worn by them, it is cooler than the plane"
    if isinstance(plane, Stages):
        return "by a ramp, and the plane in stages: a fresh specimen is hotter than the plane"
    if not math.isclose(own.rate, plane.rate):
        way = "slower, worn more, and cooler" if own.rate < plane.rate else "faster, and hotter"
        return f"its load grows {way} than the plane"
    if own.hold != plane.hold:
        way = "longer" if own.hold > plane.hold else "less long"
        return f"held {way} than the plane, which counts where a body keeps heat of earlier turns"
    return ""


def doubt_on_runs(sweep: Sweep) -> str:
    """Which tests of one specimen are simulated as fresh ones, in words; empty if none are.

    Those of one run at several loads or velocities had a past that no entry states.
    """
    runs = dict[str, list[Measurement]]()
    for test in sweep.tests:
        if test.run is not None and isinstance(test.simulated.scene.loading, Ramp):
            runs.setdefault(test.run, []).append(test)
    alike = [
        test
        for tests in runs.values()
        if len({place for test in tests for place in test.places}) > 1
        for test in tests
    ]
    if not alike:
        return ""
    return (
        f"{_named(alike)}: one specimen at several places, each simulated fresh, so too hot: give "
        "its stages"
    )


def _named(tests: Sequence[Measurement]) -> str:
    """Tests by their numbers, such as "tests 1, 2 and 5 more"."""
    names = [*dict.fromkeys(str(test.number) for test in tests)]
    more = f" and {len(names) - _MANY} more" * (len(names) > _MANY)
    return f"test{'s' * (len(names) > 1)} {', '.join(names[:_MANY])}{more}"
