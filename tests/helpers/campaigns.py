"""Results of campaigns, with the code that they speak of."""

import shlex
import subprocess
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[2]


def git(*arguments, root=ROOT):
    """Output of a git command, without its last line break; empty if it fails."""
    command = ["git", "-C", str(root), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def commit():
    """Short name of the checked-out commit, with "-dirty" if files differ."""
    return git("describe", "--always", "--dirty") or "unknown commit"


def table(columns, rows):
    """A Markdown table as text."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (columns, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(columns), *lines[1:]])


def save(name, found, is_right):
    """Write what a campaign found so far to ``results``, with its command, date and commit."""
    module = sys.modules["__main__"].__spec__.name.removesuffix(".__main__")
    command = shlex.join(["python", "-m", module, *sys.argv[1:]])
    verdict = "right" if is_right else "not right"
    path = Path("results", f"{name}.md")
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"`{command}`: {verdict}; {date.today():%m-%d}, {commit()}\n\n{found}\n")


def conclude(name, found, is_right):
    """Print and save what a campaign found; return the exit code, 0 if `is_right`."""
    save(name, found, is_right)
    print(found)
    return 0 if is_right else 1
