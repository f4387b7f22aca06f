"""Cases that might call severe wear mild, understate an error, or hide damage."""

import numpy as np
import xarray as xr

import pipeline
from pipeline import boundary
from tests.helpers import synthetic
from tests.helpers.answer_at import asked
from tests.helpers.entries import bare_test
from tests.helpers.stores import contents
from tribo import WarningKind


def test_commands_that_read_write_nothing_into_a_store(copy, irg, tmp_path):
    before = contents(copy.parent)
    for command in ("status", "boundary", "verify"):
        irg(command, copy)
    irg("margin", copy, "--load", "300 N", "--velocity", "1.1 m/s")
    assert contents(copy.parent) == before
    irg("plot", copy, "-o", tmp_path / "a.png")
    assert contents(copy) == {k.split("/", 1)[1]: v for k, v in before.items() if "/" in k}


TESTS = (bare_test(600.0, 1.5), bare_test(400.0, 1.2, outcome="severe"))


def test_a_velocity_of_0_in_a_sweep_changes_no_answer_from_the_lowest_moving_one_on():
    moving, rest = (
        synthetic.sweep(velocities=v, tests=TESTS, preset="standard")
        for v in ((1.0, 1.6, 2.5), (0.0, 1.0, 1.6, 2.5))
    )
    at = np.repeat([200.0, 310.0, 600.0], 3), np.tile([1.0, 1.3, 2.5], 3)
    xr.testing.assert_identical(*(pipeline.margin(ds, *at) for ds in (moving, rest)))
    both = [boundary(ds).drop_attrs() for ds in (moving, rest)]
    xr.testing.assert_identical(*both)


def test_an_error_that_one_realization_does_not_know_decides_nothing():
    ds = synthetic.sweep(tests=(), preset="standard")
    too_wide = ds.copy(deep=True)
    too_wide["warning_flags"][:] = int(WarningKind.BEYOND_SHAPE)
    assert asked(ds, 400.0, 0.75).verdict == "mild"
    for surfaces in ([ds, too_wide], [too_wide, ds]):
        both = xr.concat(surfaces, xr.Variable("realization", range(2)), combine_attrs="override")
        margin = asked(both, 400.0, 0.75)
        assert np.isnan(margin.temperature_error)
        assert margin.verdict == "undecided"
