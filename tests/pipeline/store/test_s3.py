"""Stores in an object store, on a server of this machine."""

import os

import boto3
import numpy as np
import pytest
import s3fs
import xarray as xr
from aiobotocore.endpoint import AioEndpoint

from pipeline import StoreError, StoreMismatchError, open_sweep, run_sweep, summary, verify_store
from pipeline.store.create import writing
from pipeline.store.location import Bucket
from pipeline.store.schema import FIELDS
from pipeline.store.transfer import copy_points
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import points
from tests.crash.driver import computing
from tests.helpers import tiny
from tests.helpers.reported import Heard
from tests.helpers.s3 import served
from tests.helpers.stores import Killed, assert_is_as_computed, commit, done_points, opened, record

SWEEP = tiny.full(loads=(150.0, 600.0), velocities=(1.0,))
POINT, OTHER = points(SWEEP)


@pytest.fixture(scope="module")
def server():
    with served():
        yield


@pytest.fixture
def address(server, tmp_path):
    return f"s3://irg/{tmp_path.name}_{os.getpid()}/tiny.zarr"


@pytest.fixture(scope="module")
def stored(server):
    """Address of a store with one of its two points done, which tests do not change."""
    address = f"s3://irg/made_{os.getpid()}/tiny.zarr"
    commit(address, SWEEP, [POINT])
    return address


def request(method, address, **more):
    """Answer of the object store to a request for an address in its bucket."""
    key = address.removeprefix("s3://irg/")
    object_name = {"Prefix": key} if method == "list_objects_v2" else {"Key": key}
    return getattr(boto3.client("s3"), method)(Bucket="irg", **object_name, **more)


def test_a_sweep_runs_resumes_and_is_verified_with_few_requests(address, monkeypatch, irg):
    """Each request is charged for, and takes a tenth of a second."""
    requests, send = [], AioEndpoint._send

    async def logged(self, request):
        requests.append(f"{request.method} {request.url}")
        return await send(self, request)

    monkeypatch.setattr(AioEndpoint, "_send", logged)
    assert run_sweep(SWEEP, address, workers=1).computed == 2
    assert_is_as_computed(address, [POINT, OTHER])
    with pytest.raises(StoreMismatchError):
        commit(address, tiny.full(increments=7), ())
    requests.clear()
    assert run_sweep(SWEEP, address, workers=1).computed == 0
    assert len(requests) <= 15
    requests.clear()
    open_sweep(address).load()
    assert len(requests) <= 50

    with writing(address, SWEEP) as store:
        store.forget([OTHER])
        requests.clear()
        store.commit([record(OTHER)])
        assert len(requests) <= 60
    request("put_object", f"{address}/fields/pressure/c.0.0.0.0", Body=b"\x28\xb5\x2f\xfd nonsense")
    request("put_object", f"{address}/load/c.0", Body=b"nonsense")
    assert open_sweep(address)["load"].values.tolist() == [150.0, 600.0]
    output = irg("verify", address, code=1)
    assert "150 N, 1 m/s: pressure cannot be read" in output
    assert "damaged: load\n" in output
    assert "write to another store" in output
    request("delete_object", f"{address}/mean_rise/c.0.0.0")
    with pytest.raises(StoreError, match=r"is missing at 150 N.* and at 1 more; irg"):
        open_sweep(address).load()


LATER = tiny.full(loads=(1500.0,), velocities=(1.0, 2.0))


def test_a_creation_that_is_killed_goes_on_and_a_plane_is_fixed(address, tmp_path, monkeypatch):
    left, synced = [1], Bucket.sync

    def killed(self):
        if left.pop() == 0:
            raise Killed
        left.append(0)
        synced(self)

    with monkeypatch.context() as patch:
        patch.setattr(Bucket, "sync", killed)
        with pytest.raises(Killed):
            commit(address, SWEEP, ())
    commit(address, SWEEP, [POINT])
    assert done_points(address) == [POINT]
    with pytest.raises(
        StoreError, match=r"a plane on an object store cannot grow; write .* -o NEW --from "
    ):
        commit(address, LATER, ())
    assert verify_store(address).is_clean
    with writing(tmp_path / "new.zarr", SWEEP) as store:
        assert copy_points(store, opened(address)) == 1


@pytest.mark.parametrize(
    "larger",
    [
        {"loads": (100.0,)},
        {"loads": (300.0,)},
        {"loads": (900.0,)},
        {"velocities": (2.0,)},
        {"case_table": surface_table((1, 2))},
    ],
)
def test_plain_xarray_reads_fields_before_and_after_a_refused_growth(stored, larger):
    before = xr.open_zarr(stored, group="fields")
    sweep = tiny.full(**{"loads": SWEEP.loads, "velocities": SWEEP.velocities} | larger)
    with pytest.raises(StoreError, match="a plane on an object store cannot grow"):
        commit(stored, sweep, ())
    for fields in (before, xr.open_zarr(stored, group="fields", chunks=None)):
        for name in FIELDS:
            field = fields[name].sel(load=POINT.load, velocity=POINT.velocity)
            np.testing.assert_array_equal(field, record(POINT).data[name])
            assert fields[name].sel(load=OTHER.load, velocity=OTHER.velocity).isnull().all()


def test_an_object_store_is_written_without_a_lock_and_told_in_a_line(stored):
    messages = Heard()
    with computing({}, pace=0.0), pytest.raises(KeyError):  # no record for the point not yet done
        run_sweep(SWEEP, stored, progress=messages.hear)
    assert messages == [f"{stored} cannot be locked: make sure that only one run writes to it"]
    with writing(stored, SWEEP):
        assert summary(stored).running is None


def test_a_server_that_is_gone_is_an_error_in_a_line(stored, monkeypatch):
    with writing(stored, SWEEP) as store:

        async def unreachable(*_, **__):
            raise ConnectionRefusedError(111, "Connect call failed")

        with monkeypatch.context() as patch:
            patch.setattr(s3fs.S3FileSystem, "_pipe_file", unreachable)
            with pytest.raises(StoreError, match="cannot be written: Connect call failed"):
                store.commit([record(OTHER)])
    assert set(done_points(stored)) == {POINT}
