"""Versions of workers (pipeline/run/work.py and cluster.py)."""

import shutil
from types import SimpleNamespace

import pytest

from pipeline.run.cluster import Connection, client_of, threads_of
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


class Answering:
    """A client whose workers answer with versions, or die before they do."""

    def __init__(self, **answers):
        self.answers, self.asked = answers, []

    def nthreads(self, **_):
        return dict.fromkeys(self.answers, 1)

    def sync(self, function, *arguments, callback_timeout, **options):
        return function(*arguments, **options)

    def run(self, function, workers, on_error):
        self.asked += workers
        return {worker: self.answers[worker] for worker in workers}


def test_other_packages_are_told_once_and_each_worker_is_asked_once():
    here, other = dict(versions()), {**versions(), "numpy": "1.0", "python": "3.2.1"}
    messages, client = [], Answering(a=here, b=other, c=other, d=OSError("died"))
    link = Connection(client, tell=messages.append)
    threads_of(link)
    client.answers["e"] = other
    assert set(threads_of(link)) == set("abcde")
    assert len(messages) == 1
    assert "b has python 3.2.1 (here " in messages[0]
    assert "numpy 1.0 (here " in messages[0]
    assert client.asked == list("abcde")


def test_a_worker_without_this_program_is_refused():
    client = Answering(a=ModuleNotFoundError("No module named 'pipeline'"))
    with pytest.raises(ExecutionError, match="a cannot run this program: No module named"):
        threads_of(Connection(client))


def test_one_that_does_not_answer_holds_nobody_up():
    client = Answering(a=SimpleNamespace())

    def late(*_, **__):
        raise TimeoutError

    client.run = late
    assert set(threads_of(Connection(client))) == {"a"}
