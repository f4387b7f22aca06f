"""Who may talk to a cluster (pipeline/run/certificate.py and cluster.py)."""

import urllib.error
import urllib.request

import dask
import pytest
from distributed import Client

from pipeline.run.certificate import private_security
from pipeline.run.cluster import ExecutionError, connected
from pipeline.run.sweep import run_sweep
from tests.helpers import tiny
from tests.pipeline.run.test_cluster import Cluster

SWEEP = tiny.sweep(velocities=(1.0,))


def test_a_local_cluster_talks_to_its_own_driver_only():
    with connected(1, None, 30.0) as client:
        address = client.scheduler.address
        info = client.scheduler_info(n_workers=-1)
        (worker,) = info["workers"].items()
        for at in (address, worker[0], worker[1]["nanny"]):
            assert at.startswith("tls://127.0.0.1:")
        with pytest.raises(OSError, match="certificate does not match"):
            Client(address, security=private_security(), set_as_default=False, timeout=5)
        for services in (info["services"], worker[1]["services"]):
            for page in ("json/identity.json", "api/v1/retire_workers", "metrics"):
                with pytest.raises(urllib.error.HTTPError, match="404"):
                    urllib.request.urlopen(f"http://127.0.0.1:{services['dashboard']}/{page}")


def test_a_scheduler_with_certificates_is_used_by_whoever_has_them(tmp_path):
    security, tls = private_security(), "distributed.comm.tls"
    for name in ("ca_file", "client_cert", "client_key"):
        (tmp_path / name).write_text(getattr(security, f"tls_{name}"))
    configured = {f"{tls}.ca-file": str(tmp_path / "ca_file")}
    for role in ("client", "scheduler", "worker"):
        configured[f"{tls}.{role}.cert"] = str(tmp_path / "client_cert")
        configured[f"{tls}.{role}.key"] = str(tmp_path / "client_key")
    variables = {
        f"DASK_{key}".replace(".", "__").replace("-", "_").upper(): file
        for key, file in configured.items()
    }
    cluster = Cluster(tmp_path, "tls", variables, security)
    try:
        with pytest.raises(ExecutionError, match=r"needs certificates: .* distributed\.comm\.tls"):
            run_sweep(SWEEP, tmp_path / "out.zarr", scheduler=cluster.address)
        with dask.config.set(configured):
            assert run_sweep(SWEEP, tmp_path / "out.zarr", scheduler=cluster.address).done == 3
    finally:
        cluster.close()
