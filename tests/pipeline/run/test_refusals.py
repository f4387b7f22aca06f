"""Refusals of runs that need no cluster: what causes each; tests/kept has what it says."""

from dataclasses import replace
from pathlib import Path

from distributed import Client

import pipeline
from pipeline.run.cluster import client_of
from pipeline.store.create import writing
from tests.helpers import tiny
from tests.helpers.entries import changed, rows
from tests.helpers.refusals import refusal_tests

SWEEP = tiny.sweep()
COLD = changed(SWEEP, conditions=replace(SWEEP.conditions, friction=0.0))


class Closed(Client):
    """A Dask client that is closed."""

    asynchronous, scheduler = False, None

    def __init__(self):
        pass

    def __repr__(self):
        return "closed"


def no_file():
    Path("scheduler.json").write_text("{}")
    return client_of(file=Path("scheduler.json"))


def measured_again():
    Path("trade.zarr").mkdir()
    return pipeline.trade("first_try", "trade.zarr")


def searched(sweep, accuracy=0.02):
    return lambda: pipeline.run_sweep(sweep, "a.zarr", workers=1, accuracy=accuracy)


def of_a_custom_store():
    coarse = tiny.sweep(preset=None)
    with writing("a.zarr", coarse):
        pass
    return searched(coarse)()


ROWS = tiny.sweep(
    case_table=rows("row", {"a": {}, "b": {}}, load=[200.0, 300.0], velocity=[1.0, 2.0])
)

FRICTIONLESS_CASE = {"sweep.over": {"friction.coefficient": [0.1, 0]}, "without": "friction.band"}
VARIED = pipeline.load_scene("first_try", overrides={"sweep.over": {"fidelity.increments": [6, 8]}})

REFUSALS = {
    "accuracy": searched(SWEEP, 1.0),
    "too small": searched(SWEEP, "0.5%"),
    "not smaller": searched(SWEEP, 0.0065),
    "fidelity": searched(VARIED),
    "rows": searched(ROWS),
    "at rest": searched(tiny.sweep(velocities=(0.0,))),
    "frictionless": searched(COLD),
    "a frictionless case": searched(pipeline.load_scene("first_try", overrides=FRICTIONLESS_CASE)),
    "custom store": of_a_custom_store,
    "client": lambda: pipeline.run_sweep(SWEEP, "a.zarr", client="tcp://a:1"),
    "closed": lambda: pipeline.run_sweep(SWEEP, "a.zarr", client=Closed()),
    "workers": lambda: pipeline.run_sweep(SWEEP, "a.zarr", workers=1.5),
    "patience": lambda: pipeline.run_sweep(SWEEP, "a.zarr", patience=-1.0),
    "file": no_file,
    "trade": measured_again,
    "no load": lambda: pipeline.sensitivity(SWEEP, velocity=2.0),
    "scheduler": lambda: client_of("nonsense", patience=1.0),
}  # fmt: skip

ELSEWHERE = {
    "run_sweep._require_cluster SystemExit": "test_sweep.py, by an unguarded script",
    "cluster.processes ExecutionError": "test_cluster.py",
    "drive.ended ExecutionError": "test_cluster.py",
    "sensitivity._critical_velocity InputError": "test_sensitivity.py",
    "sensitivity._row_at InputError": "test_sensitivity.py",
    "cluster._wait_for_worker ExecutionError": "test_cluster.py",
    "cluster._check ExecutionError": "test_cluster.py",
    "cluster._check_scheduler ExecutionError": "test_cluster.py",
    "cluster.require_program ExecutionError": "test_cluster.py",
    "cluster.reached ExecutionError": "test_cluster.py",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "run", REFUSALS, ELSEWHERE
)
