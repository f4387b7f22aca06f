"""The recipe for a batch system (workflows/on_a_cluster.py)."""

import gc

import pytest

from tribo import TriboError
from workflows import on_a_cluster


@pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")
def test_a_job_bears_blanks_in_paths_and_a_walltime_as_slurm_writes_it(
    tmp_path, monkeypatch, capsys
):
    (folder := tmp_path / "a b").mkdir()
    monkeypatch.chdir(folder)  # the recipe changes it, and this brings it back
    options = ["first_try", "my results/s.zarr", "--dry-run", "--walltime", "02:00:00"]
    on_a_cluster.main(on_a_cluster.parser.parse_args(options))
    gc.collect()  # a job leaves its key files open, and deletes them, as long as they are there
    lines = capsys.readouterr().out.splitlines()
    assert "#SBATCH -t 120:00" in lines
    lines.remove(f"cd '{folder}/my results/s.zarr.jobs'")
    assert "a b" not in "\n".join(lines)
    with pytest.raises(TriboError, match='"1:00" is not a number with a unit'):
        on_a_cluster.seconds_of("1:00")
