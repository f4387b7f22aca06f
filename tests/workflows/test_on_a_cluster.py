"""The recipe for a batch system (workflows/on_a_cluster.py)."""

import subprocess
import sys
from pathlib import Path

RECIPE = Path(__file__).parents[2] / "workflows" / "on_a_cluster.py"


def test_a_job_bears_blanks_in_paths_and_a_walltime_as_slurm_writes_it(tmp_path):
    (folder := tmp_path / "a b").mkdir()
    command = [sys.executable, RECIPE, "first_try", "my results/s.zarr", "--dry-run"]
    done = subprocess.run(
        [*command, "--walltime", "02:00:00"], cwd=folder, capture_output=True, text=True, check=True
    )
    lines = done.stdout.splitlines()
    assert "#SBATCH -t 120:00" in lines
    lines.remove(f"cd '{folder}/my results/s.zarr.jobs'")
    assert "a b" not in "\n".join(lines)
    said = subprocess.run([*command, "--walltime", "1:00"], cwd=folder, capture_output=True)
    assert said.stderr == b'on_a_cluster.py: "1:00" is not a number with a unit\n'
