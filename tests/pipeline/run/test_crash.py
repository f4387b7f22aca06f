"""A sweep survives kills at any time. `make crash` runs these campaigns in full.

Each campaign also has to fail when the rule that it tests is broken.
"""

import json

import pytest

from tests.crash.power import kinds
from tests.helpers.processes import python

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]
needs_disks = pytest.mark.skipif(not kinds(), reason="no disk can be made and mounted here")


def reported(folder, campaign, *options, trials=1):
    words = "-m", "tests.crash", campaign, *options, "--trials", trials
    # Stores are in this folder, too. It is in memory if that is large enough, where syncs are fast.
    done = python(*words, cwd=folder, variables={"TMPDIR": str(folder)}, timeout=800)
    assert (folder / "results/crash.md").read_text().endswith(done.stdout)
    report = json.loads(done.stdout)[campaign]
    assert done.returncode == bool(report["faults"])
    return report


def test_a_kill_or_a_power_cut_loses_nothing(tmp_path):
    campaign = "power" if kinds() else "kills"  # a power cut also kills the driver
    report = reported(tmp_path, campaign)
    assert report["faults"] == []
    assert report["acknowledged"] > 0
    assert any(report[name] > 0 for name in report if name.startswith(("cuts", "kills")))


def test_a_second_fault_before_the_first_is_repaired_loses_no_undamaged_point(tmp_path):
    assert reported(tmp_path, "pairs", trials=8)["faults"] == []


@pytest.mark.parametrize(
    "campaign", ["kills", "damage", "pairs", pytest.param("power", marks=needs_disks)]
)
def test_broken_rules_would_be_noticed(campaign, tmp_path):
    trials = 8 if campaign == "pairs" else 3  # half of the folders are of the copy that is not used
    assert reported(tmp_path, campaign, "--mistake", trials=trials)["faults"]
