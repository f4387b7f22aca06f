"""Sweeps in jobs of a batch system (pipeline/run/batch.py, slurm.py and site.py).

With a stand-in for Slurm; `make cluster` does this with a real one.
"""

import os
import re
import signal
import stat
import time
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest

import pipeline
from pipeline.cli import main
from pipeline.run import slurm
from pipeline.run.site import SAMPLE, Site, site_of
from pipeline.run.source import ExecutionError
from pipeline.run.sweep import run_sweep
from tests.helpers import tiny
from tests.helpers.scenes import SCENE
from tests.helpers.slurm import COMMANDS, running, stand_in
from tests.pipeline.run.test_sweep import content
from tribo import InputError

ROOT = Path(__file__).parents[3]
LOOPBACK = Site(interface="lo")


@pytest.fixture
def scene(tmp_path, monkeypatch):
    (tmp_path / "small.toml").write_text(SCENE)
    monkeypatch.chdir(tmp_path)
    return "small.toml"


# Of five jobs before one that starts, and twelve after it: each is cancelled as its worker starts.
CANCELLED = """\
echo >>{folder}/submitted
count=$(wc -l <{folder}/submitted)
if [ "$count" -le 18 ] && [ "$count" -ne 6 ]; then
    log=$(sed -n 's/^#SBATCH -e //p' "$1" | sed "s/%J/$$/")
    echo "slurmstepd-n1: error: *** JOB $$ ON n1 CANCELLED AT 2030-01-31T12:00:00 ***" >"$log"
    echo "RuntimeError: Nanny failed to start." >>"$log"
    echo "Submitted batch job $$"
    exit 0
fi
"""


@pytest.mark.timeout(280)
def test_jobs_compute_the_same_and_lost_ones_are_replaced(tmp_path, monkeypatch, alone):
    sbatch = CANCELLED + COMMANDS["sbatch"]
    jobs, messages, counts = stand_in(tmp_path / "slurm", monkeypatch, sbatch=sbatch), [], []
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setattr(slurm, "_LOOK", 0.5)
    path, killed = tmp_path / "out.zarr", []

    def kill_one(report):
        counts.append(report.jobs)
        if report.done and not killed:
            (group,) = running(jobs)
            certificates = list(tmp_path.glob("out.zarr.jobs/.*/tls_*"))
            assert {stat.S_IMODE(file.stat().st_mode) for file in certificates} == {0o600}
            killed.append(group)
            os.killpg(group, signal.SIGKILL)

    sweep = tiny.full(loading=tiny.SlowRamp(150.0, 750.0))
    batch = pipeline.Batch("slurm", jobs=1, walltime="1 h", site=LOOPBACK)
    outcome = run_sweep(sweep, path, cluster=batch, progress=kill_one, tell=messages.append)
    assert (outcome.done, outcome.failed) == (9, ())
    assert content(path) == content(alone)
    logs = {file.name for file in tmp_path.glob("out.zarr.jobs/*.err")}
    assert len(logs) == 19
    words = r"a job has .* before its workers started: JOB \d+ ON n1 CANCELLED AT 2030-01-31T12:00"
    assert sum(bool(re.match(words, note)) for note in messages) == 17
    assert counts[-1].running == 1
    assert not list(tmp_path.glob("out.zarr.jobs/.*"))
    end = time.monotonic() + 30.0
    while running(jobs):
        assert time.monotonic() < end, "jobs go on after the run"
        time.sleep(0.1)


def test_a_refused_job_is_one_error_with_the_words_of_slurm(scene, monkeypatch, capsys, tmp_path):
    refusal = "echo 'sbatch: error: Invalid account' >&2; exit 1\n"
    stand_in(tmp_path / "slurm", monkeypatch, sbatch=refusal)
    (tmp_path / "site.toml").write_text('interface = "lo"\n')
    assert main(["run", scene, "--cluster", "slurm", "--site", "site.toml"]) == 2
    assert capsys.readouterr().err.splitlines()[1:] == [
        "irg: Slurm refuses the jobs: Invalid account"
    ]


def test_workers_that_do_not_start_are_an_error_in_their_own_words(tmp_path, monkeypatch):
    stand_in(tmp_path / "slurm", monkeypatch)
    site = Site(interface="lo", prologue=["echo No module named pipeline >&2; exit 1"])
    with pytest.raises(ExecutionError, match=r"do not start .*: No module named pipeline \(.*err"):
        run_sweep(
            tiny.sweep(), tmp_path / "out.zarr", cluster=pipeline.Batch("slurm", 1, site=site)
        )


def test_the_script_of_a_job_is_shown_and_none_is_submitted(scene, irg, tmp_path):
    (tmp_path / "site.toml").write_text(
        'queue = "long"\ncores = 4\nmemory = "8 GiB"\nprologue = ["module load python"]\n'
    )
    options = ["--cluster", "slurm", "--walltime", "90min", "--site", "site.toml", "--dry-run"]
    script = irg("run", scene, "-o", "out.zarr", *options)
    for words in (
        *("#SBATCH -p long\n", "#SBATCH --cpus-per-task=4\n", "#SBATCH --mem=8G\n"),
        *("#SBATCH -t 01:30:00\n", f"#SBATCH -e {tmp_path}/out.zarr.jobs/", "module load python\n"),
        *("--nworkers 4", "--lifetime 4560s", "--lifetime-stagger 540s"),
    ):
        assert words in script
    assert sorted(file.name for file in tmp_path.iterdir()) == ["site.toml", "small.toml"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--jobs", "3"], "--jobs is an option of jobs: give --cluster slurm, too"),
        (["--dry-run"], "--dry-run is an option of jobs"),
        (["--cluster", "slurm", "--walltime", "2 s"], "walltime is 2 s; it must be at least 1 min"),
        (["--cluster", "slurm", "-o", "a b.zarr"], "give another folder in --site"),
        (["--cluster", "slurm", "-o", "s3://a/b.zarr"], "has no folder beside it"),
    ],
)
def test_what_jobs_cannot_have_is_told(scene, irg, options, words):
    assert words in irg(
        "run", scene, *options, *([] if "--dry-run" in options else ["--dry-run"]), code=2
    )


def test_the_walltime_of_jobs_is_a_time_in_seconds_or_with_its_unit(tmp_path):
    (tmp_path / "site.toml").write_text("cores = 4\n")
    for walltime in ("2 h", 7200, 7200.0):
        batch = pipeline.Batch(jobs=3, walltime=walltime, site=tmp_path / "site.toml")
        assert repr(batch) == repr(pipeline.Batch("slurm", 3, 7200.0, Site(cores=4)))
    for walltime, words in (("2 kg", 'give one such as "2 h"'), (59.0, "at least 1 min")):
        with pytest.raises(InputError, match=words):
            pipeline.Batch(walltime=walltime)


def test_the_sample_names_every_option_of_a_site(tmp_path):
    file = tmp_path / "site.toml"
    assert main(["new", "--site", str(file)]) == 0
    assert site_of(file) == Site()
    entries = [line.removeprefix("# ") for line in SAMPLE.splitlines() if " = " in line]
    file.write_text("\n".join(entries))
    assert set(tomllib.loads(file.read_text())) == {field.name for field in fields(Site)}
    assert site_of(file).cores == 8


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("qeue = 'a'", "site.toml has qeue; it may have queue, account"),
        ("cores = 0", "site.toml: cores is 0; give a whole number above 0"),
        ("queue = 'a b'", "queue is 'a b'; a job script takes letters"),
        ("prologue = 'ls'", "prologue is 'ls'; give a list of texts"),
        ("queue = ", "site.toml cannot be read as TOML"),
    ],
)
def test_faults_of_a_site_are_told(tmp_path, text, words):
    file = tmp_path / "site.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=words):
        site_of(file)
