"""A sweep may be killed at any time; `make crash` tries all that is tried here in part.

Each campaign is also made to fail, by breaking the rule that it tests.
"""

import json

import pytest

from tests.crash.power import kinds
from tests.helpers.processes import python

needs_disks = pytest.mark.skipif(not kinds(), reason="no disk can be made and mounted here")


def reported(campaign, *options, trials=1):
    done = python("-m", "tests.crash", campaign, "--trials", trials, *options, timeout=300)
    report = json.loads(done.stdout)[campaign]
    assert done.returncode == bool(report["faults"])
    return report


def test_killed_at_random_nothing_is_lost_or_damaged():
    report = reported("kills")
    assert report["kills of everything"] > 1
    assert report["faults"] == []
    assert report["acknowledged"] > 0


@needs_disks
def test_when_the_power_fails_nothing_is_lost():
    report = reported("power")
    assert (report["cuts of ext4"], report["faults"]) == (4, [])


def test_damage_of_any_file_is_named_or_harmless_and_healed():
    report = reported("damage")
    assert report["faults"] == []


def test_a_reader_beside_a_driver_sees_whole_points_or_none():
    report = reported("readers")
    assert report["data"] > 0
    assert report["faults"] == []


def test_two_drivers_by_two_paths_lose_nothing():
    report = reported("drivers")
    assert report["drivers that gave way"] > 0
    assert report["faults"] == []


@pytest.mark.slow
@pytest.mark.parametrize("campaign", ["deadly", "objects"])
def test_workers_that_die_and_object_stores_lose_nothing(campaign):
    assert reported(campaign)["faults"] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "campaign",
    [
        *("kills", "damage", "readers", "drivers", "deadly", "objects"),
        pytest.param("power", marks=needs_disks),
    ],
)
def test_broken_rules_would_be_noticed(campaign):
    assert reported(campaign, "--mistake", trials=3)["faults"]
