"""How much too warm a contact is if the present friction heat is taken to act since the start.

    python -m tests.promises.past_heat

`first_try` at 400 N and 1 m/s, after ramps of different durations, compared with the rise by all
heat so far.
"""

import sys

import pipeline
from tests.helpers.campaigns import conclude
from tests.promises.duhamel import rises

LOAD, VELOCITY = 400.0, 1.0
DURATIONS = {"5.3 s": 5.33, "0.1 s": 0.1, "10 ms": 1e-2, "1 ms": 1e-3}


def excess(duration):
    """Relative excess of Θ₁₀ above the bulk after a ramp of this duration [s]."""
    overrides = {
        "loading.rate": f"{LOAD / duration} N/s",
        "loading.reference_load": f"{LOAD} N",
    }
    sweep = pipeline.load_scene("first_try", "standard", overrides)
    present, by_all = rises(sweep.scene, LOAD, VELOCITY)
    return present / by_all - 1


def main():
    excesses = {name: excess(duration) for name, duration in DURATIONS.items()}
    words = ", ".join(
        f"{100 * excess:.2g} % after a ramp of {name}" for name, excess in excesses.items()
    )
    return conclude("past_heat", words, all(excess >= -0.01 for excess in excesses.values()))


if __name__ == "__main__":
    sys.exit(main())
