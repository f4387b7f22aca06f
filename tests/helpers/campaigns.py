"""What a campaign found, as a table that says which code it speaks of."""

import shlex
import subprocess
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[2]


def git(*arguments):
    """What git says, without its last line break."""
    command = ["git", "-C", str(ROOT), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def commit():
    """Name of the working tree's commit."""
    return git("describe", "--always", "--dirty")


def write_table(name, columns, rows, notes=()):
    """Write and print ``results/NAME.md``: a table with its date, commit and command, and notes."""
    module = sys.modules["__main__"].__spec__.name.removesuffix(".__main__")
    called = shlex.join(["python", "-m", module, *sys.argv[1:]])
    lines = [f"`{called}`; {date.today():%m-%d}, {commit()}", ""]
    lines += ["| " + " | ".join(map(str, row)) + " |" for row in (columns, *rows)]
    lines.insert(3, "|" + "---|" * len(columns))
    lines += ["", *notes] if notes else []
    path = ROOT / "results" / f"{name}.md"
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(path.read_text(encoding="utf-8"), end="")
