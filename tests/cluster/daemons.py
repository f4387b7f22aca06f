"""A Slurm of two nodes on loopback, by the distribution's packages; its files are in one folder."""

import os
import secrets
import shutil
import socket
import subprocess
import time
from contextlib import ExitStack

_NODES = ("n1", "n2")
_PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol")
_CORES = 8  # cores that each node claims to have
_CONFIGURATION = """\
ClusterName=trial
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2
ReturnToService=2
KillWait=5
MinJobAge=30
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
{nodes}
PartitionName=work Nodes=ALL Default=YES MaxTime=INFINITE OverTimeLimit=0 State=UP
"""


def missing_programs():
    """Names of Slurm's programs that are not installed."""
    return [name for name in _PROGRAMS if shutil.which(name) is None]


class Slurm:
    """A controller and a daemon for each node of Slurm, as child processes."""

    def __init__(self, folder):
        self._folder, self._daemons = folder, {}
        host = socket.gethostname()
        (folder / "state").mkdir()
        key = folder / "munge.key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(1024))
        ports = _free_ports(1 + len(_NODES))
        nodes = "\n".join(
            f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={_CORES} "
            "RealMemory=16000"
            for node, port in zip(_NODES, ports[1:], strict=True)
        )
        configuration = folder / "slurm.conf"
        configuration.write_text(
            _CONFIGURATION.format(folder=folder, host=host, ports=ports, nodes=nodes)
        )
        os.environ["SLURM_CONF"] = str(configuration)
        munge = {"socket": "socket", "key-file": "key", "pid-file": "pid", "seed-file": "seed"}
        options = [f"--{option}={folder}/munge.{name}" for option, name in munge.items()]
        self._start("munged", "--foreground", "--force", f"--log-file={folder}/munge.log", *options)
        self._start("slurmctld", "-D")
        for node in _NODES:
            self._start("slurmd", "-D", "-N", node)
        end = time.monotonic() + 60.0
        while self.ask("sinfo", "--noheader", "--format=%T", "--states=idle").strip() != "idle":
            assert time.monotonic() < end, f"Slurm does not start; its logs are in {folder}"
            time.sleep(0.5)

    def _start(self, program, *options):
        with (self._folder / f"{program}.out").open("a") as out:
            command = [shutil.which(program), *options]
            self._daemons[program, options] = subprocess.Popen(command, stdout=out, stderr=out)

    def restart_controller(self, pause):
        """Kill the controller, and start it again after `pause` seconds."""
        controller = self._daemons.pop(("slurmctld", ("-D",)))
        controller.kill()
        controller.wait()
        time.sleep(pause)
        self._start("slurmctld", "-D")

    def ask(self, *command):
        """Output of a command; empty if it fails."""
        return subprocess.run(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False
        ).stdout

    def jobs(self, state="all"):
        """Numbers of the jobs in a state, as texts."""
        return self.ask("squeue", "--noheader", "--format=%A", f"--states={state}").split()

    def close(self):
        self.ask("scancel", "--user=root")
        end = time.monotonic() + 30.0
        while self.jobs("running") and time.monotonic() < end:
            time.sleep(0.5)
        for daemon in reversed(self._daemons.values()):
            daemon.terminate()
            try:
                daemon.wait(30)
            except subprocess.TimeoutExpired:
                daemon.kill()


def _free_ports(number):
    """Numbers of free ports of this machine."""
    with ExitStack() as stack:
        sockets = [
            stack.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(number)
        ]
        return [listener.getsockname()[1] for listener in sockets]
