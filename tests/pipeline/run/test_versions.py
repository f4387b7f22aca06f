"""Versions of workers (pipeline/run/work.py)."""

import shutil

import pytest

from pipeline.run.cluster import client_of
from pipeline.run.sweep import run_sweep
from pipeline.run.work import ExecutionError, hash_of_code, versions
from pipeline.store.progress import summary
from tests.helpers import tiny
from tests.pipeline.run.test_cluster import ROOT, Cluster


def test_a_worker_with_another_number_in_its_code_is_refused_and_computes_nothing(tmp_path):
    for package in "tribo", "pipeline":
        shutil.copytree(ROOT / package, tmp_path / package)
    shutil.copytree(ROOT / "tests" / "helpers", tmp_path / "tests" / "helpers")
    code = tmp_path / "tribo" / "thermal" / "factors.py"
    code.write_text(code.read_text().replace("0.5", "0.51"))
    theirs = hash_of_code(tmp_path / package for package in ("tribo", "pipeline"))
    cluster, out = Cluster(tmp_path, code=tmp_path), tmp_path / "out.zarr"
    try:
        refused = pytest.raises(
            ExecutionError, match=rf"tcp://127.*{theirs} .*{versions()['code']} "
        )
        with client_of(cluster.address) as client, refused:
            run_sweep(tiny.sweep(velocities=(1.0,)), out, client=client)
    finally:
        cluster.close()
    assert summary(out).done == 0
