"""The presets on the shipped scene, and what its boundary costs in each way."""

import pytest

import pipeline
from pipeline.tradeoff.choose import choose_fidelity
from pipeline.tradeoff.trade import trade
from tests.benchmarks.scene import SCENE


@pytest.fixture(scope="module")
def sweep():
    return pipeline.load_scene(SCENE)


def test_presets_against_the_reference(benchmark, sweep):
    options = {"base": None, "loads": sweep.plane.loads}
    table = benchmark.pedantic(trade, (sweep,), options, rounds=1)
    print(f"\n{table}")
    draft, standard, fine = table.choices[:3]
    assert draft.velocity_error > standard.velocity_error > fine.velocity_error > 0
    for choice, error, saving in ((draft, 0.05, 100), (standard, 0.03, 20), (fine, 0.01, 3)):
        assert choice.velocity_error <= error
        assert choice.saving >= saving


@pytest.mark.parametrize("accuracy", [0.05, 0.02, 0.01])
def test_choice_of_a_fidelity(benchmark, sweep, accuracy):
    selection = benchmark.pedantic(choose_fidelity, (sweep, accuracy), rounds=1)
    print(f"\n{selection}")
    assert selection.error <= accuracy
