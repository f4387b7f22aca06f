"""How much too warm a contact is if the present friction heat is taken to act since the start.

    python -m tests.promises.past_heat

`first_try` at 400 N and 1 m/s, by the heat models "elapsed" and "history", over ramps of different
durations.
"""

import sys

import pipeline
from tests.helpers.campaigns import conclude

LOAD, VELOCITY = 400.0, 1.0
DURATIONS = {"5.3 s": 5.33, "0.1 s": 0.1, "10 ms": 1e-2, "1 ms": 1e-3}


def rise(duration, model):
    """Θ₁₀ above the bulk [K] after a ramp of this duration [s], by a heat model."""
    overrides = {
        "loading.rate": f"{LOAD / duration} N/s",
        "loading.reference_load": f"{LOAD} N",
        "fidelity.heat_model": model,
    }
    sweep = pipeline.load_scene("first_try", "standard", overrides)
    verdict = pipeline.run_point(sweep, LOAD, VELOCITY).verdict(sweep.conditions)
    return verdict.governing_temperature - sweep.conditions.bulk_temperature


def main():
    excesses = {name: rise(s, "elapsed") / rise(s, "history") - 1 for name, s in DURATIONS.items()}
    words = ", ".join(
        f"{100 * excess:.2g} % after a ramp of {name}" for name, excess in excesses.items()
    )
    return conclude("past_heat", words, all(excess >= -0.01 for excess in excesses.values()))


if __name__ == "__main__":
    sys.exit(main())
