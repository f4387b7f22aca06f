"""A stand-in for Slurm: its commands, as scripts that run jobs as processes of this machine."""

import os

COMMANDS = {
    "sbatch": """\
number=$$
cp "$1" {folder}/$number.sh
log=$(sed -n 's/^#SBATCH -e //p' "$1" | sed "s/%J/$number/")
setsid sh {folder}/$number.sh >/dev/null 2>"$log" &
echo $! >{folder}/$number.pid
echo "Submitted batch job $number"
""",
    "squeue": """\
for file in {folder}/*.pid; do
    [ -e "$file" ] && kill -0 "$(cat "$file")" 2>/dev/null &&
        echo "$(basename "$file" .pid) RUNNING None"
done
exit 0
""",
    "scancel": """\
for number in "$@"; do kill -TERM -- "-$(cat {folder}/$number.pid)"; done
""",
}


def stand_in(folder, monkeypatch, **commands):
    """Put the commands into a folder and at the front of the path; some of them may be others."""
    write_commands(folder, **commands)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    return folder


def write_commands(folder, **commands):
    """Write the commands into a new folder; some of them may be others."""
    folder.mkdir()
    for name, script in (COMMANDS | commands).items():
        file = folder / name
        file.write_text("#!/bin/sh\n" + script.replace("{folder}", str(folder)))
        file.chmod(0o700)


def running(folder):
    """Process groups of the jobs that run."""
    groups = [int(file.read_text()) for file in folder.glob("*.pid")]
    return [group for group in groups if _is_alive(group)]


def _is_alive(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
