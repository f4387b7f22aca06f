"""A sweep may be killed at any time; `make crash` tries all that is tried here in part."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.crash.power import can_cut

ROOT = Path(__file__).parents[3]


def reported(module, *options):
    done = subprocess.run(
        [sys.executable, "-m", f"tests.{module}", *options],
        cwd=ROOT,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        text=True,
        check=False,
        timeout=300,
    )
    return json.loads(done.stdout)


def test_killed_before_any_change_a_store_opens_keeps_its_points_and_resumes():
    found = reported("crash", "--every", "349")
    assert found["crashes"] > 5
    assert found["faults"] == {}


def test_a_status_written_before_its_data_would_be_noticed():
    found = reported("crash", "--every", "83", "--status-first", "--until-fault")
    assert any("differs" in fault for faults in found["faults"].values() for fault in faults)


def test_killed_at_random_nothing_is_lost_damaged_or_wrongly_marked_failed():
    found = reported("crash.kills", "--kills", "2")
    assert found["kills"] == {"worker": 1, "everything": 1}
    assert found["sweeps"] >= 1
    assert found["faults"] == []


def test_many_points_are_stored_through_kills_and_read_as_they_were_computed():
    """As `make many` shows it of a hundred thousand."""
    found = reported("crash.many", "--points", "600", "--kills", "1", "--every", "0", "0")
    assert found["killed"] == ["everything"]
    assert found["starts"] == 2
    assert found["faults"] == []
    assert (found["resumed"]["code"], found["resumed"]["computed"]) == (0, 0)


def test_processes_that_write_to_the_same_chunks_lose_nothing_when_killed_or_stopped():
    found = reported("crash.writers", "--rounds", "2")
    assert (found["rounds"], found["faults"]) == (2, [])
    assert sum(found["did"].values()) > 0


def test_shared_chunks_that_are_written_without_a_lock_would_be_noticed():
    assert reported("crash.writers", "--rounds", "20", "--unlocked")["faults"]


def test_sweeps_whose_workers_die_end_with_every_point_that_can_be_computed():
    found = reported("crash.workers", "--sweeps", "1", "--velocities", "6", "--busy")
    assert found == {"sweeps": 2, "kills": found["kills"], "hung": 0, "faults": []}
    assert found["kills"] >= 1


def test_when_the_power_fails_nothing_is_lost_by_the_rules_of_any_file_system():
    found = reported("crash.replay", "--every", "331")
    assert found["cuts"] == dict.fromkeys(("ext4", "xfs", "posix"), found["cuts"]["ext4"])
    assert found["cuts"]["ext4"] >= 8
    assert found["faults"] == []


def test_a_name_given_before_its_content_is_synced_would_be_noticed():
    assert reported("crash.replay", "--every", "331", "--rename-first")["lost"] > 0


needs_disks = pytest.mark.skipif(not can_cut(), reason="no disk can be made and mounted here")


@needs_disks
def test_when_the_power_of_a_disk_fails_nothing_is_lost():
    found = reported("crash.power", "--cuts", "3")
    assert (found["cuts"], found["faults"]) == (3, [])
    assert found["acknowledged"] > 0


@needs_disks
def test_content_that_is_not_synced_would_be_noticed():
    assert reported("crash.power", "--cuts", "2", "--unsynced")["faults"]


def test_damage_to_any_file_is_named_or_harmless_and_healed():
    found = reported("crash.damage", "--every", "211")
    assert sum(found["tried"].values()) > 3
    assert found["faults"] == []
