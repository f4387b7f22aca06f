"""Bands of the emulator, held against a rise in closed form."""

import dataclasses
import math

import numpy as np

from pipeline.uncertain.unknown import drawn
from tests.helpers.samples import ensemble, rise
from tests.helpers.unknowns import ALL


def test_bands_hold_nine_of_ten_runs_at_the_loads_and_between_them_and_of_places_left_out():
    noise, chance = 0.01, np.random.default_rng(1)
    samples = ensemble(noise=noise)
    assert 0.85 <= samples.left_out.held <= 0.97
    inputs = drawn(ALL, 7, 400)
    for load in (200.0, 290.0, 750.0):
        excess = samples.excess(inputs, load, 1.7)
        runs = np.log(rise(inputs, load, 1.7)) - samples.log_limit(inputs)
        runs += noise * chance.standard_normal(400)
        held = np.mean(np.abs(excess.values - runs) < 1.645 * excess.error)
        assert 0.85 <= held <= 0.97


def test_bands_of_few_contacts_hold_waves_between_them_and_are_not_said_to_suffice():
    unknown, held = ALL[:3], []
    inputs, velocities = drawn(unknown, 7, 30), np.geomspace(0.6, 5.0, 30)
    for phase in range(3):

        def wave(rate, velocity, phase=phase):
            return 0.02 * np.sin(10 * np.log(rate * velocity / 1e-15) + phase)

        samples = ensemble(unknown, 16)
        waves = wave(samples.inputs[:, 0], samples.sample_velocities)
        samples = dataclasses.replace(samples, rises=samples.rises * np.exp(waves)[:, None])
        assert (samples.left_out.contacts, samples.left_out.is_right) == (8, False)
        for row, velocity in zip(inputs, velocities, strict=True):
            excess = samples.excess(row[None], 400.0, velocity)
            run = math.log(rise(row[None], 400.0, velocity, unknown)[0]) + wave(row[1], velocity)
            missed = excess.values[0] + samples.log_limit(row[None])[0] - run
            held.append(abs(missed) < 1.645 * excess.error[0])
    assert np.mean(held) > 0.82  # 0.74 if constants were fitted to all rows
