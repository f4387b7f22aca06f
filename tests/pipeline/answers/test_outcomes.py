"""Outcomes along lines of a boundary agree with the points that are done."""

import numpy as np
import pytest

import pipeline
from pipeline.store.schema import PENDING
from tests.helpers import synthetic
from tests.helpers.answer_at import named

LOADS, VELOCITIES = (150.0, 200, 300, 450, 600, 750), (0.5, 0.75, 1.0, 1.4, 1.8, 2.4, 3.0, 4.0)
DONE = {
    "all": lambda load, velocity: True,
    "slow ones, and one more": lambda load, velocity: (
        velocity < 1.6 or (load, velocity) == (750, 3)
    ),
    "fast ones": lambda load, velocity: velocity > 1.6,
    "low loads": lambda load, velocity: load < 500,
}
CONDITIONS = {"as tested": {}, "hot": {"friction": 0.3}, "cold": {"friction": 0.05}}


def test_contacts_without_heat_are_mild():
    cold = synthetic.sweep(rise=lambda *point: 0 * synthetic.rise(*point), tests=())
    assert named(pipeline.boundary(cold)["outcome_along_velocity"])[0] == "mild"


@pytest.mark.parametrize("done", DONE)
@pytest.mark.parametrize("conditions", CONDITIONS)
def test_no_outcome_is_contradicted_by_points_that_are_not_done(conditions, done):
    status = {(F, V): PENDING for F in LOADS for V in VELOCITIES if not DONE[done](F, V)}
    ds = synthetic.sweep(LOADS, VELOCITIES, rise=synthetic.uneven(0), status=status, tests=())
    boundary = pipeline.boundary(ds, **CONDITIONS[conditions])
    friction = CONDITIONS[conditions].get("friction", 0.1)
    hot = (
        synthetic.uneven(0)(np.array(LOADS)[:, None], np.array(VELOCITIES), 0.9) * friction / 120.0
    )
    is_done = ds["status"].values == 1
    for along, x, lines, known in (
        ("velocity", np.array(VELOCITIES), hot, is_done),
        ("load", np.array(LOADS), hot.T, is_done.T),
    ):
        outcomes = named(boundary[f"outcome_along_{along}"])
        critical = boundary[f"critical_{along}"].values
        for outcome, line, is_known, crossing in zip(outcomes, lines, known, critical, strict=True):
            context = (outcome, line, crossing)
            assert np.isfinite(crossing) == (outcome == "transition"), context
            if outcome == "transition":  # exact but for interpolation
                assert (line[x < 0.95 * crossing] < 1).all(), context
                assert (line[x > 1.05 * crossing] > 1).all(), context
            elif outcome == "mild":
                assert line.max() < 1.02, context
            elif outcome == "severe":
                assert line[0] > 1, context
            else:  # an end of the sweep is not known
                assert not is_known[[0, -1]].all(), context
