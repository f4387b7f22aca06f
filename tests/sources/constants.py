"""Table of the constants that campaigns found or judge: place, value, meaning and command.

A docstring below such a constant ends with "Found by" or "Judged by", and the command.
"""

import ast
import re
from itertools import pairwise

from tests.helpers.campaigns import table
from tests.sources.measure import ROOT

_COMMAND = re.compile(r"\b(Found|Judged) by `([^`]+)`\.")


def constants():
    """Yield place, name with value, meaning and finding command of each measured constant."""
    for path in sorted(ROOT.glob("tribo/**/*.py")) + sorted(ROOT.glob("pipeline/**/*.py")):
        body = ast.parse(path.read_text(encoding="utf-8")).body
        for constant, below in pairwise(body):
            text = getattr(getattr(below, "value", None), "value", None)
            if (
                isinstance(constant, ast.Assign | ast.AnnAssign)
                and isinstance(text, str)
                and (match := _COMMAND.search(text))
            ):
                meaning = re.split(r"\n\n| (?:Found|Judged) by", text.strip())[0].rstrip(".")
                yield (
                    f"{path.relative_to(ROOT)}:{constant.lineno}",
                    f"`{ast.unparse(constant)}`",
                    " ".join(meaning.split()),
                    f"{match[1].lower()} by `{match[2]}`",
                )


if __name__ == "__main__":
    print(table(("place", "constant", "meaning", "command"), constants()))
