"""A Ceph object gateway on loopback, by the distribution's packages; its files are in one folder.

It has one monitor and one object store daemon, which keeps its data in memory.
"""

import subprocess
import time
import uuid
from contextlib import contextmanager

import boto3
from botocore.exceptions import BotoCoreError, ClientError

from tests.cluster.daemons import Daemons, free_ports

CEPH = ("ceph-mon", "ceph-osd", "radosgw", "radosgw-admin", "ceph", "ceph-authtool", "monmaptool")
_BUCKET, _KEY, _SECRET = "irg", "nobody", "secret"
_START = 120.0  # [s]
_CONFIGURATION = """\
[global]
fsid = {cluster}
mon_host = {monitor}
mon_initial_members = a
auth_cluster_required = cephx
auth_service_required = cephx
auth_client_required = cephx
auth_allow_insecure_global_id_reclaim = false
public_addr = 127.0.0.1
public_network = 127.0.0.0/8
cluster_network = 127.0.0.0/8
keyring = {folder}/keyring
run_dir = {folder}
crash_dir = {folder}
log_file = {folder}/$name.log
admin_socket = {folder}/$name.socket
pid_file = {folder}/$name.pid
mon_data = {folder}/mon
osd_data = {folder}/osd
rgw_data = {folder}/rgw
osd_objectstore = memstore
memstore_device_bytes = 2147483648
osd_crush_chooseleaf_type = 0
osd_pool_default_size = 1
osd_pool_default_min_size = 1
osd_pool_default_pg_num = 8
osd_pool_default_pg_autoscale_mode = off
rgw_rados_pool_pg_num_min = 8
mon_allow_pool_size_one = true
mon_max_pg_per_osd = 1000
mon_data_avail_crit = 1

[client.rgw]
rgw_frontends = beast endpoint=127.0.0.1:{port}
"""


class Gateway(Daemons):
    """Daemons that run in the foreground, as children of this process."""

    def __init__(self, folder):
        super().__init__(folder)
        self._configuration = folder / "ceph.conf"
        monitor_port, port = free_ports(2)
        cluster, monitor = uuid.uuid4(), f"v2:127.0.0.1:{monitor_port}/0"
        self._configuration.write_text(
            _CONFIGURATION.format(cluster=cluster, monitor=monitor, folder=folder, port=port)
        )
        self.environment = {
            "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}",
            "AWS_ACCESS_KEY_ID": _KEY,
            "AWS_SECRET_ACCESS_KEY": _SECRET,
            "AWS_DEFAULT_REGION": "us-east-1",
        }
        for name in ("mon", "osd", "rgw"):
            (folder / name).mkdir()
        self._make_keys()
        self._start_monitor(cluster, monitor_port)
        self._start_store()
        words = ["--uid=irg", "--display-name=irg", f"--access-key={_KEY}", f"--secret={_SECRET}"]
        self._do("radosgw-admin", "--name=client.rgw", "user", "create", *words)
        self.start("radosgw", "--foreground", "--name=client.rgw", *self._conf)
        self._make_bucket()

    @property
    def _conf(self):
        return ("--conf", str(self._configuration))

    def _do(self, program, *options, conf=True):
        """Run a command; an error with its words if it fails."""
        command = [program, *(self._conf if conf else ()), *map(str, options)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=_START)
        assert done.returncode == 0, f"{' '.join(command)}: {done.stderr}"

    def _make_keys(self):
        ring = self.folder / "keyring"
        for create, name, daemons in (
            (["--create-keyring"], "mon.", ["mon"]),
            ([], "client.admin", ["mon", "osd", "mgr"]),
            ([], "client.rgw", ["mon", "osd"]),
            ([], "osd.0", ["mon", "osd"]),
        ):
            allowed = [word for daemon in daemons for word in ("--cap", daemon, "allow *")]
            options = [*create, ring, "--gen-key", "-n", name, *allowed]
            self._do("ceph-authtool", *options, conf=False)

    def _start_monitor(self, cluster, port):
        where = self.folder / "monmap"
        options = ["--create", "--fsid", cluster, "--addv", "a", f"[v2:127.0.0.1:{port}]", where]
        self._do("monmaptool", *options, conf=False)
        ring = self.folder / "keyring"
        self._do("ceph-mon", "--mkfs", "-i", "a", "--monmap", where, "--keyring", ring)
        self.start("ceph-mon", "--foreground", "-i", "a", *self._conf)
        self._do("ceph", "--connect-timeout", "60", "auth", "import", "-i", ring)

    def _start_store(self):
        name = uuid.uuid4()
        self._do("ceph", "osd", "new", name)
        self._do("ceph-osd", "-i", "0", "--mkfs", "--osd-uuid", name)
        self.start("ceph-osd", "--foreground", "-i", "0", *self._conf)

    def _make_bucket(self):
        end = time.monotonic() + _START
        while True:
            try:
                client = boto3.client(
                    "s3",
                    endpoint_url=self.environment["AWS_ENDPOINT_URL"],
                    aws_access_key_id=_KEY,
                    aws_secret_access_key=_SECRET,
                    region_name="us-east-1",
                )
                client.create_bucket(Bucket=_BUCKET)
            except (BotoCoreError, ClientError) as error:
                words = f"the gateway does not start ({error}); its logs are in {self.folder}"
                assert time.monotonic() < end, words
                time.sleep(1.0)
            else:
                return


@contextmanager
def gateway(folder):
    """Run a gateway in a folder."""
    running = Gateway(folder)
    try:
        yield running
    finally:
        running.close()
