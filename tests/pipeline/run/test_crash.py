"""A sweep may be killed at any time; `make crash` tries all that is tried here in part.

Each campaign is also made to fail, by breaking the rule that it tests.
"""

import json

import pytest

from tests.crash.power import kinds
from tests.helpers.processes import python

pytestmark = pytest.mark.timeout(900)
needs_disks = pytest.mark.skipif(not kinds(), reason="no disk can be made and mounted here")


def reported(folder, *campaigns, trials=1):
    words = "-m", "tests.crash", *campaigns, "--trials", trials
    # Stores are in this folder, too. It is in memory if that is large enough, where syncs are fast.
    done = python(*words, cwd=folder, variables={"TMPDIR": str(folder)}, timeout=800)
    assert (folder / "results/crash.md").read_text().endswith(done.stdout)
    reports = json.loads(done.stdout)
    assert done.returncode == any(report["faults"] for report in reports.values())
    return reports


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """Reports of one trial of each crash campaign."""
    return reported(tmp_path_factory.mktemp("crash"), "kills", "power")


@pytest.mark.parametrize(
    ("campaign", "least"),
    [
        ("kills", {"kills of everything": 1, "acknowledged": 1}),  # a fast sweep ends before others
        pytest.param("power", {"cuts of ext4": 2}, marks=needs_disks),
    ],
)
def test_kills_and_power_cuts_lose_nothing(reports, campaign, least):
    assert reports[campaign]["faults"] == []
    assert all(reports[campaign][name] >= count for name, count in least.items())


@pytest.mark.slow
@pytest.mark.parametrize(
    "campaign",
    [
        *("kills", "damage", "deadly"),
        pytest.param("power", marks=needs_disks),
    ],
)
def test_broken_rules_would_be_noticed(campaign, tmp_path):
    assert reported(tmp_path, campaign, "--mistake", trials=3)[campaign]["faults"]
