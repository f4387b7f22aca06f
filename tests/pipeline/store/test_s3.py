"""Stores in an object store (pipeline/store/remote.py, files.py and lock.py)."""

import logging
import os
import subprocess
import sys

import boto3
import pipeline.store.shape as shape_module
import pytest
import xarray as xr
from moto.server import ThreadedMotoServer
from pipeline.store.files import files_in
from pipeline.store.folder import folder_of
from pipeline.store.variables import COLUMNS, FIELDS

from pipeline.analysis.dataset import open_sweep
from pipeline.cli import main
from pipeline.run.sweep import run_sweep
from pipeline.store import StoreError, folder, locked, prepare, summary, verify_store
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny

SWEEP = tiny.full(loads=(150.0, 600.0), velocities=(1.0,))
POINT = Point(600.0, 1.0)


@pytest.fixture(scope="module")
def server():
    """An S3 server on this machine, and the environment to find it in."""
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_ENDPOINT_URL", "http://{}:{}".format(*server.get_host_and_port()))
        patch.setenv("AWS_ACCESS_KEY_ID", "nobody")
        patch.setenv("AWS_SECRET_ACCESS_KEY", "secret")
        patch.setenv("AWS_DEFAULT_REGION", "us-east-1")
        boto3.client("s3").create_bucket(Bucket="irg")
        yield server
    server.stop()


@pytest.fixture
def address(server, request):
    """One that no other run of these tests has: the lock of an address holds on the machine."""
    return f"s3://irg/{request.node.name}_{os.getpid()}/tiny.zarr"


def put(address, content):
    bucket, key = address.removeprefix("s3://").split("/", 1)
    boto3.client("s3").put_object(Bucket=bucket, Key=key, Body=content)


def keys(address):
    bucket, key = address.removeprefix("s3://").split("/", 1)
    found = boto3.client("s3").list_objects_v2(Bucket=bucket, Prefix=key)
    return [entry["Key"] for entry in found.get("Contents", [])]


def assert_is_as_computed(address, asked):
    with xr.open_zarr(address, chunks=None) as ds:
        for point in asked:
            stored, result = (
                ds.sel(load=point.load, velocity=point.velocity),
                run_point(SWEEP, *point),
            )
            assert stored["status"] == 1
            for name, values in (result.columns | result.fields).items():
                assert stored[name].values[: len(values)].tobytes() == values.tobytes()


def test_a_sweep_runs_resumes_and_grows(address):
    first = tiny.full(loads=(150.0,), velocities=(1.0,))
    prepare(address, first)  # and killed before the first point
    assert run_sweep(first, address, workers=1).computed == 1
    assert run_sweep(SWEEP, address, workers=1).computed == 1
    assert run_sweep(SWEEP, address, workers=1).computed == 0
    assert_is_as_computed(address, points(SWEEP))
    assert verify_store(address).is_clean
    with open_sweep(address) as ds:
        assert ds["max_rise"].sel(load=600).notnull().any()


def test_objects_are_removed_by_how_their_keys_begin(address):
    files = files_in(folder_of(address))
    files.put_all([(key, b"1") for key in ("time/c.0.0", "time/c.0.1", "time/c/0/0", "rise/c.0.0")])
    files.remove_all("time/c.")
    left = [key.partition("tiny.zarr/")[2] for key in keys(address)]
    assert left == ["rise/c.0.0", "time/c/0/0"]


def test_the_status_is_written_last_and_everything_else_is_there_by_then(address, monkeypatch):
    store = prepare(address, SWEEP)
    log, written = [], type(store._files)._put

    async def logged(self, key, content):
        await written(self, key, content)
        log.append(key.split("/")[0])

    monkeypatch.setattr(type(store._files), "_put", logged)
    store.commit(run_point(SWEEP, *POINT))
    assert log[-1] == "status"
    assert set(log[:-1]) >= {*COLUMNS, *FIELDS, "message", "checksum"}
    assert summary(address).done == 1


def test_a_creation_and_a_growth_cut_short_go_on(address, monkeypatch):
    def cut(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(shape_module, "commit_metadata", cut)
        with pytest.raises(KeyboardInterrupt):
            prepare(address, SWEEP)
        with pytest.raises(StoreError, match="not created completely; run the sweep again"):
            summary(address)
    prepare(address, SWEEP).commit(run_point(SWEEP, *POINT))
    with monkeypatch.context() as patch:
        patch.setattr(shape_module, "commit_metadata", cut)
        with pytest.raises(KeyboardInterrupt):
            prepare(address, tiny.full(loads=(900.0,), velocities=(2.0,)))
    assert_is_as_computed(address, [POINT])
    assert verify_store(address).is_clean


def test_damage_is_named_and_repaired(address, capsys):
    prepare(address, SWEEP).commit(run_point(SWEEP, *POINT))
    put(f"{address}/time/c.1.0.0", b"\x28\xb5\x2f\xfd nonsense")
    put(f"{address}/load/c.0", b"nonsense")
    assert main(["verify", address, "--repair"]) == 1
    assert "600 N, 1 m/s: time cannot be read" in capsys.readouterr().out
    assert main(["verify", address]) == 0
    assert main(["status", address]) == 0
    assert "0 done, 0 failed, 2 pending" in capsys.readouterr().out


def test_one_driver_at_a_time(address):
    with locked(address):
        assert keys(f"{address}.lock")
        assert folder.user(address).startswith(f"process {os.getpid()} on ")
        with pytest.raises(StoreError, match=f"in use by process {os.getpid()} on"):
            locked(address).__enter__()
    assert keys(f"{address}.lock") == []


def test_a_driver_that_was_killed_does_not_count_and_one_elsewhere_does(address):
    killed = """if True:
        import os, sys
        from pipeline.store import locked
        held = locked(sys.argv[1])
        held.__enter__()
        os._exit(1)
    """
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run(
        [sys.executable, "-c", killed, address], env=environment, check=False, timeout=120
    )
    assert keys(f"{address}.lock")
    assert folder.user(address) is None
    with locked(address):
        pass
    put(f"{address}.lock", b"process 7 on elsewhere\n")
    assert folder.user(address) == "process 7 on elsewhere"
    with pytest.raises(StoreError, match=r"process 7 on elsewhere \(if that has ended, delete s3:"):
        locked(address).__enter__()


def test_what_is_no_store_is_refused(address):
    with pytest.raises(StoreError, match="does not exist"):
        summary(address)
    put(f"{address}/thesis.tex", b"years of work")
    with pytest.raises(StoreError, match="is not a store"):
        prepare(address, SWEEP)
    with pytest.raises(StoreError, match=r"cannot be (read|written)"):
        prepare("s3://no-such-bucket/tiny.zarr", SWEEP)


def test_without_s3fs_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(folder, "find_spec", lambda name: None)
    assert main(["status", "s3://irg/tiny.zarr"]) == 2
    assert "pip install 'irg-transition[s3]'" in capsys.readouterr().err
