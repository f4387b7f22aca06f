"""All campaigns, the one after the other: what a user is promised, tried until it breaks.

    python -m tests.crash                                  # all of them, whole
    python -m tests.crash power kills --trials 3           # some of them, in part
    python -m tests.crash power --trials 3 --mistake       # made to fail

Prints a JSON document with what each has done and the faults that it has seen.
"""

import argparse
import json
import random
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.crash import damage, kills, pairs, power
from tests.crash.loop import Report, Run
from tests.helpers.campaigns import conclude

CAMPAIGNS = {"kills": kills, "power": power, "damage": damage, "pairs": pairs}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("campaigns", nargs="*", metavar="CAMPAIGN", help=", ".join(CAMPAIGNS))
    parser.add_argument("--trials", type=int, help="of each")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--mistake", action="store_true", help="break the rule that is tested")
    options = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    document = {}
    for name in options.campaigns or CAMPAIGNS:
        module, report, began = CAMPAIGNS[name], Report(), time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            run = Run(
                name,
                Path(folder),
                module.TRIALS if options.trials is None else options.trials,
                random.Random(f"{name} {options.seed}"),
                report,
                module.MISTAKE if options.mistake else None,
            )
            module.campaign(run)
        report.counts["seconds"] = round(time.monotonic() - began)
        document[name] = report.as_dict()
        print(f"{name}: {json.dumps(document[name])[:300]}", file=sys.stderr)
    is_right = not any(report["faults"] for report in document.values())
    return conclude("crash", json.dumps(document, indent=1), is_right)


if __name__ == "__main__":
    sys.exit(main())
